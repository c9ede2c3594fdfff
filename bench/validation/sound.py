#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The sound of the paper's scene: its exponents over roughness and speed beside those of the
vibration, and both by third octave.

The pressure of one run is compared with Rayleigh's integral by another way: numpy, in the frequency
domain, by the midpoint rule over a grid of the plate, from the modal velocities in the file and the
shapes in closed form.
"""
import json

import h5py
import numpy as np

import common
from law import HIGH, NUMERICS, DISTANCE, mean, shown
from plate import LENGTH, shapes

RQ, SPEEDS, SEEDS = (2e-6, 8e-6, 20e-6), (0.02, 0.1, 0.5), 3
WIDTH = 0.2                     # m
AT = (0.15, 0.1, 0.5)           # m, half a metre above the plate's middle
AIR, SOUND = 1.2041, 343.232    # kg/m^3, m/s
# the program's low pass: samples, of half the rate, of Kaiser's window
FILTER_HALF_LENGTH, EDGE, SHARPNESS = 133, 0.955, 18.88


def run(case, name, **sets):
    """A run of the paper's scene, and what `ra2d analyze` hears of it."""
    file = case.scratch / f"{name}.h5"
    words = [word for key, value in sets.items()
             for word in ("--set", f"{key}={common.to_toml(value)}")]
    case.call(case.program, "run", common.ROOT / "scenes" / "dang2012.toml", "-o", file,
              "--quiet", *words)
    return file, json.loads(case.call(case.program, "analyze", file, "--json", "--power", "--at",
                                      ",".join(map(str, AT))))


def by_numpy(file, begin, end, cells=(300, 150)):
    """Mean squared pressure at AT from `begin` to `end`: lines of the whole record, each with its
    own sum over the plate."""
    with h5py.File(file) as content:
        velocity, time = content["resonator/velocity"][()], content["time"][()]
    count, rate = len(time), (len(time) - 1) / time[-1]
    length = 2 * count
    lines = np.fft.rfft(velocity, length, axis=0)
    frequency = np.fft.rfftfreq(length, 1 / rate)
    kept = np.zeros(length)
    kept[np.arange(-FILTER_HALF_LENGTH, FILTER_HALF_LENGTH + 1)] = EDGE * np.sinc(EDGE * np.arange(
        -FILTER_HALF_LENGTH, FILTER_HALF_LENGTH + 1)) * np.kaiser(2 * FILTER_HALF_LENGTH
                                                                  + 1, SHARPNESS)
    kept = np.fft.rfft(kept).real
    x = (np.arange(cells[0]) + 0.5) / cells[0] * LENGTH
    y = (np.arange(cells[1]) + 0.5) / cells[1] * WIDTH
    distance = np.sqrt((x[:, None] - AT[0])**2 + (y - AT[1])**2 + AT[2]**2)
    psi = np.array([shapes(velocity.shape[1], place) for place in x])  # (cell, mode)
    pressure = np.zeros(len(frequency), complex)
    for j, f in enumerate(frequency):
        if kept[j] > 1e-6:
            wave = (np.exp(-2j * np.pi * f / SOUND * distance) / distance).sum(axis=1)
            pressure[j] = 2j * np.pi * f * AIR / (2 * np.pi) * kept[j] * (wave @ psi @ lines[j])
    pressure *= LENGTH / cells[0] * WIDTH / cells[1]
    heard = np.fft.irfft(pressure, length)[round(begin * rate):round(end * rate) + 1]
    return (heard**2).mean()


def check_numpy(case):
    file, found = run(case, "numpy", **{**NUMERICS, "scene.duration": 0.05,
                                        "resonator.max_frequency": 2e3, "output.rate": 2e4})
    microphone = found["microphones"][0]
    level = 10 * np.log10(by_numpy(file, microphone["from"], microphone["to"]) / 20e-6**2)
    case.check("level at the microphone beside numpy's sum over the plate, dB",
               abs(microphone["lp"] - level),
               0.01, "the midpoint rule over 1 mm and 1.3 mm, at 9 kHz 1e-3 of an amplitude")


def of_file(found):
    """{quantity: its logarithm}, of things like v_rms."""
    microphone = found["microphones"][0]
    return {"vibration, v_rms": np.log10(found["v_rms"]), "pressure": microphone["lp"] / 20,
            "pressure, A-weighted": microphone["lpa"] / 20,
            "square root of the power": found["power"]["lw"] / 20}


def compare(case):
    check_numpy(case)
    if case.short:
        return
    logs, bands = {}, {}
    for seed in range(SEEDS):
        for rq in RQ:
            for speed in SPEEDS:
                sets = {**NUMERICS, "output.rate": 1e5, "scene.speed": speed,
                        "scene.duration": min(1.0, DISTANCE / speed),
                        "resonator.surface.rq": rq, "slider.surface.rq": rq,
                        "resonator.surface.seed": 1000 + 2 * seed,
                        "slider.surface.seed": 1001 + 2 * seed}
                file, found = run(case, "run", **sets)
                file.unlink()
                for key, value in of_file(found).items():
                    logs.setdefault(key, []).append(value)
                if rq == RQ[1]:
                    bands.setdefault(speed, []).append(found)
    report(case, logs, bands)


def exponents(logs):
    """(n, m) of each quantity, each (mean, half), over all speeds and up to 0.1 m/s."""
    grids = [grid.ravel() for grid in np.meshgrid(np.log10(RQ), np.log10(SPEEDS), indexing="ij")]
    found = {}
    for key, values in logs.items():
        each = np.reshape(values, (SEEDS, -1))
        both = []
        for some in (np.ones(len(grids[1]), bool), grids[1] < -0.9):
            matrix = np.stack([np.ones(some.sum()), grids[0][some], grids[1][some]], axis=1)
            fit = np.array([np.linalg.lstsq(matrix, one[some], rcond=None)[0] for one in each])
            both += [mean(fit[:, 1]), mean(fit[:, 2])]
        found[key] = both
    return found


def ratio(found):
    """{band: Lp - Lv [dB]} of one run, up to its last mode."""
    of_velocity = dict(zip(found["bands"]["nominal"], found["bands"]["level"]))
    heard = found["microphones"][0]["bands"]
    return {centre: level - of_velocity[name] for centre, name, level, above in
            zip(heard["centre"], heard["nominal"], heard["level"], heard["above_last_mode"])
            if name in of_velocity and not above and centre > 45}


def report(case, logs, bands):
    found = exponents(logs)
    case.text("seeds", f"{SEEDS}")
    case.text("runs", f"{SEEDS * len(RQ) * len(SPEEDS)}")
    case.text("exponents", common.markdown(("", "n", "m", "V <= 0.1 m/s: n", "m"),
                                           [(key, *(shown(*each) for each in four))
                                            for key, four in found.items()]))
    for key, name in (("pressure", "p"), ("pressure, A-weighted", "pa"), ("vibration, v_rms", "v")):
        case.text(f"n-{name}", shown(*found[key][0]))
        case.text(f"m-{name}", shown(*found[key][1]))
    middle = bands[0.1]
    levels = {kind: mean([one["microphones"][0][kind] for one in middle]) for kind in ("lp", "lpa")}
    for kind, (value, half) in levels.items():
        case.text(kind, f"{value:.1f} ± {half:.1f}")
    case.text("efficiency", common.shown(np.mean([one["power"]["efficiency"] for one in middle])))
    share = max(one["power"]["share_of_damping"] for some in bands.values() for one in some)
    case.text("share", f"{100 * share:.1f}")
    case.check("sound power of both sides over what damping takes, at the most", share, 0.1,
               "above it the air would have to be in the model")
    ratios = {speed: [ratio(one) for one in some] for speed, some in bands.items()}
    centres = sorted(set.intersection(*(set(one) for some in ratios.values() for one in some)))
    case.table(("band, Hz", *(f"Lp - Lv at {speed:g} m/s, dB" for speed in ratios)),
               [(f"{centre:.4g}",
                 *(f"{np.mean([one[centre] for one in some]):.2f}" for some in ratios.values()))
                for centre in centres])
    low, high = ([np.mean([one[centre] for one in ratios[0.1]]) for centre in centres
                  if (centre > HIGH) == above]
                 for above in (False, True))
    case.text("low", f"{np.mean(low):.0f}")
    case.text("high", f"{np.mean(high):.0f}")
    plt, style = common.pyplot()
    figure, axes = plt.subplots(figsize=(7.2, 3.2), layout="constrained")
    for (speed, some), colour, mark in zip(ratios.items(), style.SERIES, style.MARKS):
        mid, half = np.array([mean([one[centre] for one in some]) for centre in centres]).T
        axes.errorbar(centres, mid, half, color=colour, marker=mark, ms=4, lw=1, capsize=2,
                      label=f"{speed:g} m/s")
    axes.set(xscale="log", xlabel="frequency [Hz]", ylabel="Lp - Lv [dB re 20 µPa, 1 nm/s]")
    axes.legend(title="speed")
    case.figure(figure)


if __name__ == "__main__":
    common.main("sound", compare)
