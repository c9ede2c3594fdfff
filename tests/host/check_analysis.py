#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares what `ra2d analyze OUT.h5 --json` said with numpy's and scipy's answer from the same
file.

    check_analysis.py OUT.h5 SAID.json
"""
import json
import sys
import tomllib

import h5py
import numpy as np

try:
    import scipy.signal
    import scipy.stats
except ImportError:  # the spectrum is then compared with numpy alone
    scipy = None


def expect(right, *what):
    if not right:
        sys.exit("check_analysis: " + " ".join(str(w) for w in what))


def near(found, expected, what, relative=1e-9):
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    expect(found.shape == expected.shape, what, "has the shape", found.shape, "not", expected.shape)
    scale = np.max(np.abs(expected), initial=0)
    off = np.max(np.abs(found - expected), initial=0)
    expect(off <= relative * scale, what, "is off by", off, "of", scale)


def welch(signal, rate, segment):
    if scipy:
        return scipy.signal.welch(signal, rate, "hann", segment, segment // 2,
                                  detrend=False, axis=0)[1]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(segment) / segment)
    powers = [np.abs(np.fft.rfft(window[:, None] * signal[j:j + segment], axis=0)) ** 2
              for j in range(0, len(signal) - segment + 1, segment // 2)]
    density = 2 * np.mean(powers, axis=0) / (rate * np.sum(window**2))
    density[0] /= 2
    if segment % 2 == 0:
        density[-1] /= 2
    return density


def quick_length(least):
    def rest(n):
        for prime in (2, 3, 5, 7):
            while n % prime == 0:
                n //= prime
        return n
    return next(n for n in range(least, 2 * least) if rest(n) == 1)


def third_octaves(signal, weights, rate, centres):
    """Levels by a filter of its own: a Butterworth bandpass of order 6 by its poles, not by its
    formula."""
    length = quick_length(len(signal))
    power = 2 * np.abs(np.fft.rfft(signal, length, axis=0)) ** 2 @ weights / (len(signal) * length)
    if length % 2 == 0:
        power[-1] /= 2
    frequency = np.fft.rfftfreq(length, 1 / rate)
    poles = np.exp(1j * np.pi * (np.arange(6) + 3.5) / 6)  # of the lowpass
    half = 10**0.05
    quality = (np.pi / 12) / np.sin(np.pi / 12) / (half - 1 / half)
    levels = []
    for centre in centres:
        s = 1j * quality * (frequency[1:] / centre - centre / frequency[1:])
        share = np.abs(np.prod(1 / (s[:, None] - poles), axis=1)) ** 2
        levels.append(10 * np.log10(np.sum(power[1:] * share) / 1e-18))
    return levels


def check_spectrum(file, said, rows, rate):
    spectrum = said["spectrum"]
    segment = round(rate / spectrum["resolution"])
    near(spectrum["frequency"], np.fft.rfftfreq(segment, 1 / rate), "frequency")
    modal = file["resonator/velocity"][rows]
    weights = file["resonator/mean_square"][()]
    near(spectrum["psd_mean"], welch(modal, rate, segment) @ weights, "psd_mean")
    probes = file["probes/velocity"][rows]
    near(np.transpose(spectrum["psd_probe"]), welch(probes, rate, segment), "psd_probe")
    force = file["contact/force"][rows]
    near(spectrum["psd_force"], welch((force - force.mean())[:, None], rate, segment)[:, 0],
         "psd_force")
    if scipy:
        nu = spectrum["degrees_of_freedom"]
        low, high = scipy.stats.chi2.ppf([0.975, 0.025], nu)
        near([spectrum["confidence"]["low"], spectrum["confidence"]["high"]], [nu / low, nu / high],
             "confidence")
    # the mean over the resonator is that over its places
    elastic = file["resonator/frequency"][()] > 0
    v = modal[::97, elastic] @ file["resonator/shape"][elastic]
    near(modal[::97] ** 2 @ weights, np.mean(v**2, axis=1), "mean over places", 0.05)

    bands = said["bands"]
    near(bands["level"], third_octaves(modal, weights, rate, bands["centre"]), "bands")
    near(bands["level_probe"][0], third_octaves(probes[:, :1], np.ones(1), rate, bands["centre"]),
         "bands of a probe")
    if "level_a" in bands:
        expect(said["lv_a"] < said["lv"] + 1.3, "lv_a is", said["lv_a"])


def check_shocks(file, said):
    begin, end = said["from"], said["to"]
    start = file["shocks/start"][()]
    counted = (start >= begin) & (start <= end)
    shocks = said["shocks"]
    expect(shocks["count"] == counted.sum() > 100, "shocks", shocks["count"])
    near(shocks["rate"], counted.sum() / (end - begin), "rate")
    for name in ("duration", "peak_force", "impulse"):
        values = file["shocks"][name][counted]
        near([shocks[name][key] for key in ("median", "p10", "p90", "mean")],
             [*np.quantile(values, [0.5, 0.1, 0.9]), values.mean()], name)
        bins = shocks["histograms"][name]
        positive = values[values > 0]
        expect(np.array_equal(np.histogram(positive, bins["edges"])[0], bins["counts"]),
               "histogram of", name)
    ends = start + file["shocks/duration"][()]
    times = np.sort(np.concatenate([start[(start >= begin) & (start < end)], [begin]]))
    most = max(np.count_nonzero((start <= t) & (ends > t)) for t in times)
    expect(shocks["simultaneous"]["max"] == most, "at once", shocks["simultaneous"]["max"],
           "not", most)
    overlap = np.clip(np.minimum(ends, end) - np.maximum(start, begin), 0, None).sum()
    near(shocks["simultaneous"]["mean"], overlap / (end - begin), "at once")


def check(path, said):
    with h5py.File(path) as file:
        scene = tomllib.loads(file.attrs["scene"])
        time = file["time"][()]
        rate = scene["output"]["rate"]
        first, last = round(said["from"] * rate), round(said["to"] * rate)
        rows = slice(first, last + 1)
        expect(said["samples"] == last + 1 - first, "samples", said["samples"])
        whole = said["from"] == scene["output"]["from"] and said["to"] == scene["scene"]["duration"]
        weights = file["resonator/mean_square"][()]
        v_rms = file["level/v_rms"][()] if whole else np.sqrt(
            np.mean(file["resonator/velocity"][rows] ** 2 @ weights))
        near(said["v_rms"], v_rms, "v_rms")
        near(said["lv"], 20 * np.log10(v_rms / 1e-9), "lv")
        if whole:
            near(said["shocks"]["rate"], file["summary/shock_rate"][()], "rate of the summary")
        check_spectrum(file, said, rows, rate)
        check_shocks(file, said)
        seconds = time[rows][-1] - time[rows][0]
        for key, name in (("sliding_power", "sliding_work"), ("damping_power", "damping_loss"),
                          ("load_power", "load_work")):
            energy = file["energy"][name][rows]
            near(said["energy"][key], (energy[-1] - energy[0]) / seconds, key)
        elastic = file["resonator/frequency"][()]
        near(said["natural_frequencies"], elastic[elastic > 0], "natural_frequencies")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[2]) as text:
        check(sys.argv[1], json.load(text))
