# SPDX-License-Identifier: BSD-3-Clause
"""The spectrum of the noise over time."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from . import style
from .style import Array, quantity

if TYPE_CHECKING:
    from .results import Result

TITLE = "Velocity spectrum of the resonator in time"
MOST_COLUMNS = 400
WINDOWS = 40            # one after another, in the run
LEAST, MOST = 16, 8192  # samples of a window
DECADES = 7             # that the colours span
_AT_ONCE = 64           # windows that are read at once


def window_length(samples: int) -> int:
    """Samples of a window: a power of two, of which some forty fit; 0 where none does.

    >>> window_length(100_001), window_length(100)
    (2048, 16)
    """
    length = int(2 ** math.floor(math.log2(max(samples / WINDOWS, LEAST))))
    return min(length, MOST) if samples >= 4 * LEAST else 0


def densities(result: Result) -> tuple[Array, Array, Array, int]:
    """Middles of the windows [s], frequencies [Hz], one-sided power spectral density of the
    velocity, mean over the resonator [(m/s)^2/Hz], over (frequency, time), and the samples of a
    window. Hann windows a quarter apart; of long runs several neighbours are put together.

    S(f) = sum over the modes of <psi^2> times the periodogram of the mode's velocity, as in
    docs/analysis.md.
    """
    modes = result.modes("resonator")
    samples, rate = modes.sizes["time"], result.rate
    length = window_length(samples)
    if not length:
        return np.empty(0), np.empty(0), np.empty((0, 0)), 0
    hop = length // 4
    count = (samples - length) // hop + 1
    per_column = math.ceil(count / MOST_COLUMNS)
    count -= count % per_column
    weight = modes.mean_square.values
    audible = np.flatnonzero(weight)
    window = np.hanning(length + 1)[:-1]
    factor = np.full(length // 2 + 1, 2 / (rate * float((window ** 2).sum())))
    factor[[0, -1]] /= 2
    found = np.zeros((length // 2 + 1, count // per_column))
    step = max(_AT_ONCE // per_column, 1) * per_column
    for first in range(0, count, step):
        last = min(first + step, count)
        rows = modes.velocity[first * hop:(last - 1) * hop + length].values
        at = hop * np.arange(last - first)[:, None] + np.arange(length)
        power = np.zeros((last - first, length // 2 + 1))
        for k in audible:
            power += weight[k] * np.abs(np.fft.rfft(rows[at, k] * window)) ** 2
        mean = power.reshape(-1, per_column, power.shape[1]).mean(axis=1)
        found[:, first // per_column:last // per_column] = (mean * factor).T
    begin = float(modes.time[0])
    middles = begin + (hop * (np.arange(count // per_column) * per_column + (per_column - 1) / 2)
                       + length / 2) / rate
    return middles, np.fft.rfftfreq(length, 1 / rate), found, length


def draw(figure: Any, axes: Any, result: Result) -> None:
    """Frequency over time; the colour is the level."""
    time, frequency, density, length = densities(result)
    if time.size < 2 or not density[1:].any():
        style.say_empty(axes,
                        f"the run is too short for a spectrogram: fewer than {4 * LEAST} samples"
                        if time.size < 2 else "the resonator is at rest: it did not vibrate", TITLE)
        return
    with np.errstate(divide="ignore"):
        levels = 10 * np.log10(density[1:]) + 180  # re 1 (nm/s)^2/Hz
    high = 5 * math.ceil(float(levels.max()) / 5)
    levels = np.maximum(levels, high - 10 * DECADES)
    half = (time[1] - time[0]) / 2
    place = style.time_axis(axes, np.array([time[0] - half, time[-1] + half]),
                            f"  (windows of {quantity(length / result.rate, 's')}, Hann; a line "
                            "every "
                            f"{quantity(float(frequency[1]), 'Hz')})")
    edges = np.append(time - half, time[-1] + half)
    between = np.sqrt(frequency[1:-1] * frequency[2:])
    borders = np.concatenate([[frequency[1] ** 2 / between[0]], between, [frequency[-1]]])
    colours = axes.pcolormesh(place(edges), borders, levels, cmap="viridis",
                              vmin=high - 10 * DECADES, vmax=high,
                              rasterized=True)
    axes.grid(False)
    axes.set_yscale("log")
    axes.set_ylim(borders[0], borders[-1])
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: style.plain_number(value)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel("frequency [Hz]")
    figure.colorbar(colours, ax=axes, label="PSD of velocity [dB re 1 (nm/s)\u00b2/Hz]",
                    extend="min", pad=0.01)
    tone = result.analysis()["mesh_tone"]
    if tone["in_spectrum"] and borders[0] < tone["frequency"] < borders[-1]:
        axes.axhline(tone["frequency"], color="white", lw=0.8, ls=(0, (2, 4)))
        axes.annotate("mesh", (1, tone["frequency"]), (-4, 3), xycoords=axes.get_yaxis_transform(),
                      textcoords="offset points", color="white", fontsize=8, ha="right")
    axes.set_title(TITLE)
