# SPDX-License-Identifier: BSD-3-Clause
"""What the pictures of `ra2d plot` have in common. Ends with status 9 when there is no matplotlib."""
import json
import math
import sys
import textwrap
import warnings

import chart_style
import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

literal, save = chart_style.literal, chart_style.save
warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in letters that the font has not

# Eight colours that stay apart, also for eyes that lack one kind of cones (tests/plot/colours.py), each with a line
# and a mark of its own, so that nothing hangs on colour alone.
BLUE, RUST, PLUM, SKY, BLACK, GREEN, AMBER, MOSS = SERIES = (
    "#2b45c8", "#bb560f", "#6b1170", "#6fb5f2", "#000000", "#056545", "#f0ac00", "#b2be80")
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)), (0, (8, 2)), (0, (3, 1, 1, 1, 1, 1)),
         (0, (12, 1, 1, 1)), (0, (2, 2)))
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
GREY = "#555555"

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9, "xtick.labelsize": 8.5, "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5, "legend.framealpha": 0.9, "axes.grid": True, "grid.alpha": 0.25, "grid.linewidth": 0.6,
    "axes.titlelocation": "left",
    "axes.formatter.useoffset": False, "figure.constrained_layout.w_pad": 0.08, "axes.axisbelow": True})

PREFIXES = {-12: "p", -9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def read(file):
    """What is to be drawn; null is NaN."""
    with open(file, encoding="utf-8") as text:
        return json.load(text)


def numbers(values):
    """An array; null is NaN."""
    return np.array([math.nan if value is None else value for value in values], dtype=float)


def number(value):
    return math.nan if value is None else value


def scale(unit, *arrays, up=1.3):
    """The unit with the prefix that suits the largest of all values, and what one of it is. `up`: how much below one
    of a unit that may be: an axis to 0.9 s is none in ms."""
    finite = [np.abs(a[np.isfinite(a)]) for a in map(np.asarray, arrays)]
    largest = max((float(a.max()) for a in finite if a.size), default=0)
    if not largest:
        return unit, 1.0
    power = 3 * math.floor(math.log10(largest * up) / 3)
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return PREFIXES[power] + unit, 10.0 ** power


def quantity(value, unit, digits=3):
    """A value with the prefix that suits it."""
    if not math.isfinite(value):
        return "not defined"
    name, one = scale(unit, np.array([value]), up=1.0001)
    return f"{value / one:.{digits}g} {name}".rstrip()


def plain_number(value):
    """For axes in decades: 100, 1k, 10k."""
    return f"{value / 1000:g}k" if value >= 1000 else f"{value:g}"


def decades(axis):
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain_number(value)))
    axis.set_minor_formatter(NullFormatter())


def frequency_axis(axes, low, high):
    """In decades; of a narrow range, with numbers between them."""
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    if high / low < 100:
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    decades(axes.xaxis)
    axes.set_xlabel("frequency [Hz]")


def series(axes, drawn, colour, x_unit=1.0, y_unit=1.0, line="-", label=None, width=1.0, fill=0.45, mean=True):
    """A line; of values that were put together, the band from their lowest to their highest, and their mean."""
    x = numbers(drawn["x"]) / x_unit
    middle = numbers(drawn["mean"]) / y_unit
    if drawn["together"] > 1:
        low, high = numbers(drawn["low"]) / y_unit, numbers(drawn["high"]) / y_unit
        axes.fill_between(x, low, high, color=colour, alpha=fill, lw=0.4, zorder=2, label=None if mean else label)
    if drawn["together"] <= 1 or mean:
        axes.plot(x, middle, ls=line, color=colour, lw=width, label=label, zorder=3)


def extremes(*drawn):
    """All values of series, for their unit."""
    parts = [numbers(one[key]) for one in drawn for key in ("mean", "low", "high") if key in one]
    return np.concatenate(parts) if parts else np.array([])


def say_empty(axes, why, title, keep_x=False):
    """Why there is nothing to see. `keep_x`: the axis is shared with a panel that has something."""
    axes.set_title(title)
    axes.set_yticks([])
    if not keep_x:
        axes.set_xticks([])
    axes.grid(False)
    for side in axes.spines.values():
        side.set_color("#bbbbbb")
    axes.text(0.5, 0.5, textwrap.fill(why, 44), transform=axes.transAxes, ha="center", va="center", fontsize=10,
              color=GREY)


def page(width, height, lines):
    """A figure with lines of text at its top, and the subfigure below them."""
    top = 0.18 + sum(size * 1.5 / 72 for _, size, _, _ in lines)
    figure = plt.figure(figsize=(width, height + top), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=[top, height])
    y = top - 0.1
    for text, size, weight, colour in lines:
        text = text if len(text) * size < 115 * width else text[:int(115 * width / size)] + "\u2026"
        upper.text(0.12 / width, y / top, text, fontsize=size, weight=weight, color=colour, va="top", in_layout=False)
        y -= size * 1.5 / 72
    return figure, lower
