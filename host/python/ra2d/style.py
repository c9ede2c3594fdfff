# SPDX-License-Identifier: BSD-3-Clause
"""The style of all pictures: colours, units with prefixes, axes, pages."""
from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

Array = npt.NDArray[np.float64]

# Eight colours that stay apart, also for eyes that lack one kind of cones (tests/colours.py
# measures it), each with a line and a mark of its own, so that nothing hangs on colour alone.
BLUE, RUST, PLUM, SKY, BLACK, GREEN, AMBER, MOSS = SERIES = (
    "#2b45c8", "#bb560f", "#6b1170", "#6fb5f2", "#000000", "#056545", "#f0ac00", "#b2be80")
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)), (0, (8, 2)),
         (0, (3, 1, 1, 1, 1, 1)),
         (0, (12, 1, 1, 1)), (0, (2, 2)))
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
GREY = "#555555"
DECIBEL = "dB re 1 nm/s"
DPI = 130  # of pictures in files

RC = {
    "font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9, "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5, "legend.framealpha": 0.9, "axes.grid": True, "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "axes.titlelocation": "left", "axes.formatter.useoffset": False, "axes.axisbelow": True,
    "figure.constrained_layout.w_pad": 0.08, "figure.dpi": 110,
    "svg.fonttype": "none", "pdf.fonttype": 42,  # text stays text
    "svg.hashsalt": "ra2d"}                      # the same picture has the same bytes

# of the charts: matplotlib's own style
CHART_RC = {name: RC[name] for name in ("svg.fonttype", "pdf.fonttype", "svg.hashsalt")}

PREFIXES = {-12: "p", -9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


class Picture(Figure):  # type: ignore[misc]
    """A matplotlib Figure that a notebook shows, whatever backend is chosen there."""

    def __init__(self, *sizes: Any, **more: Any) -> None:
        super().__init__(*sizes, **more)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        return self.drawn("png")

    def drawn(self, kind: str, dpi: int = 110) -> bytes:
        """The picture as "png", "svg" or "pdf"."""
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
        out = io.BytesIO()
        with matplotlib.rc_context(RC):
            self.savefig(out, format=kind, dpi=dpi, metadata=dates)
        return out.getvalue()


def literal(text: object) -> str:
    """A text from outside, which is no formula to matplotlib."""
    return str(text).encode("utf-8", "replace").decode().replace("$", r"\$")


def scale(unit: str, *arrays: npt.ArrayLike, up: float = 1.3) -> tuple[str, float]:
    """The unit with the prefix that suits the largest of all values, and what one of it is. `up`:
    how much below one of a unit that may be: an axis to 0.9 s is none in ms."""
    finite = [np.abs(a[np.isfinite(a)]) for a in map(np.asarray, arrays)]
    largest = max((float(a.max()) for a in finite if a.size), default=0.0)
    if not largest:
        return unit, 1.0
    power = 3 * math.floor(math.log10(largest * up) / 3)
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return PREFIXES[power] + unit, 10.0 ** power


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value with the prefix that suits it.

    >>> quantity(2.5e-5, "s")
    '25 \u00b5s'
    """
    if not math.isfinite(value):
        return "not defined"
    name, one = scale(unit, value, up=1.0001)
    return f"{value / one:.{digits}g} {name}".rstrip()


def unit_text(udunits: str) -> str:
    """A unit as an axis shows it: m/s for "m s-1"; empty for "1".

    >>> unit_text("m s-1"), unit_text("kg m-3"), unit_text("1")
    ('m/s', 'kg/m\u00b3', '')
    """
    powers = str.maketrans("23", "\u00b2\u00b3")
    above: list[str] = []
    below: list[str] = []
    for part in udunits.split():
        name, _, power = part.partition("-")
        (below if power else above).append(name.translate(powers) + (power if power != "1"
                                                                     else "").translate(powers))
    top = " ".join(above)
    return "" if udunits == "1" else top + "".join(f"/{name}" for name in below)


def envelope(x: Array, y: Array, ends: Array) -> tuple[Array, Array, Array, Array]:
    """Neighbours put together: the middle of their places, lowest, mean and highest value."""
    begins = np.unique(ends[:-1].astype(int))
    counts = np.diff(np.append(begins, len(y)))
    return (np.add.reduceat(x, begins) / counts, np.minimum.reduceat(y, begins),
            np.add.reduceat(y, begins) / counts, np.maximum.reduceat(y, begins))


def draw_series(axes: Any, x: Array, y: Array, colour: str, line: Any = "-",
                label: str | None = None,
                width: float = 1.0, most: int = 1200, log: bool = False, fill: float = 0.45,
                mean: bool = True) -> int:
    """A line; of long series the band from lowest to highest of neighbours, and their mean. Returns
    how many are put together. `log`: groups of equal ratio."""
    if len(y) <= 2 * most:
        axes.plot(x, y, ls=line, color=colour, lw=width, label=label, zorder=3)
        return 1
    ends = np.geomspace(1, len(y), most) - 1 if log else np.linspace(0, len(y), most)
    at, low, middle, high = envelope(x, y, ends)
    axes.fill_between(at, low, high, color=colour, alpha=fill, lw=0.4, zorder=2,
                      label=None if mean else label)
    if mean:
        axes.plot(at, middle, ls=line, color=colour, lw=width, label=label, zorder=3)
    return math.ceil(len(y) / most)


def plain_number(value: float) -> str:
    """For axes in decades: 100, 1k, 10k."""
    return f"{value / 1000:g}k" if value >= 1000 else f"{value:g}"


def frequency_axis(axes: Any, low: float, high: float) -> None:
    """In decades; of a narrow range, with numbers between them."""
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    if high / low < 100:
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain_number(value)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("frequency [Hz]")


def clock(time: Array) -> tuple[float, float, str]:
    """What an axis over these times counts from [s], what one of its units is [s], and its label. A
    short stretch of a long run counts from a round time before it: the numbers stay short.

    >>> clock(np.array([0.0, 0.02]))
    (0.0, 0.001, 'time [ms]')
    >>> clock(np.array([0.123456, 0.123656]))
    (0.1234, 1e-06, 'time after 123.4 ms [µs]')
    """
    first, last = float(time[0]), float(time[-1])
    if first <= 0 or last - first > 0.05 * last or not last > first:
        unit, one = scale("s", time[-1:])
        return 0.0, one, f"time [{unit}]"
    step = 10.0 ** math.floor(math.log10(last - first))
    begin = round(math.floor(first / step + 1e-6) * step, 15)
    unit, one = scale("s", last - begin)
    return begin, one, f"time after {quantity(begin, 's', 12)} [{unit}]"


def time_axis(axes: Any, time: Array, note: str = "") -> Callable[[Any], Any]:
    """Sets limits and label; returns what makes times [s] to places on the axis."""
    begin, one, label = clock(time)
    axes.set_xlim((time[0] - begin) / one, (time[-1] - begin) / one)
    axes.set_xlabel(f"{label}{note}")
    return lambda at: (at - begin) / one


def at_probes(motion: xr.DataArray) -> list[tuple[str, xr.DataArray]]:
    """The series of each probe, with its place."""
    one_by_one = [motion.isel({motion.dims[1]: i}) for i in range(motion.shape[1])]
    return [(", ".join(f"{1e3 * float(one[name]):.6g}" for name in ("position", "y")
                       if name in one.coords) + " mm", one)
            for one in one_by_one]


def room_above(axes: Any, share: float) -> None:
    """Room for a legend."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + share * (high - low))


def say_empty(axes: Any, why: str, title: str, keep_x: bool = False) -> None:
    """Why there is nothing to see. `keep_x`: the axis is shared with a panel that has something."""
    axes.set_title(title)
    axes.set_yticks([])
    if not keep_x:
        axes.set_xticks([])
    axes.grid(False)
    for side in axes.spines.values():
        side.set_color("#bbbbbb")
    axes.text(0.5, 0.5, textwrap.fill(why, 44), transform=axes.transAxes, ha="center", va="center",
              fontsize=10,
              color=GREY)


def _text_width(text: str, size: float, weight: str) -> float:
    """How wide a line is [inches]."""
    path = TextPath((0, 0), text, size=size, prop=FontProperties(weight=weight))
    return float(path.get_extents().x1) / 72 if len(path.vertices) else 0.0


def _wrapped(text: str, size: float, weight: str, room: float) -> list[str]:
    """The text in three lines at most, none wider than the room [inches]."""
    most = int(132 * room / size)  # characters, of a common text
    while True:
        lines = textwrap.wrap(text, most, max_lines=3, break_on_hyphens=False,
                              placeholder=" \u2026") or [""]
        widest = max(_text_width(line, size, weight) for line in lines)
        if widest <= room or most <= 10:
            return lines
        most = max(10, min(most - 1, int(most * room / widest)))


def page(width: float, height: float,
         lines: Sequence[tuple[str, float, str, str]]) -> tuple[Picture, Any]:
    """A figure with lines of text at its top (text, size, weight, colour), each wrapped to three
    at most, and the subfigure below."""
    edge = 0.12
    lines = [(part, size, weight, colour) for text, size, weight, colour in lines
             for part in _wrapped(text, size, weight, width - 2 * edge)]
    top = (0.18 + sum(size * 1.5 / 72 for _, size, _, _ in lines)) if lines else 0.01
    figure = Picture(figsize=(width, height + top), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=[top, height])
    y = top - 0.1
    for text, size, weight, colour in lines:
        upper.text(edge / width, y / top, text, fontsize=size, weight=weight, color=colour,
                   va="top", in_layout=False)
        y -= size * 1.5 / 72
    return figure, lower
