# SPDX-License-Identifier: BSD-3-Clause
"""The picture of `ra2d chart stability`, from its tables PREFIX.csv, PREFIX-regions.csv and
PREFIX-modes.csv."""
from __future__ import annotations

import math
import pathlib
from collections.abc import Callable
from typing import Any

import matplotlib
from matplotlib.lines import Line2D

from .chart_tables import NAMES, Row, read, read_context
from .style import CHART_RC, Picture, literal

Rows = list[Row]
Point = tuple[float, float]
Place = Callable[[float, float], Point]  # of a damping ratio and the size of a step

OPEN, CLOSED = "black", "#ff69b4"


def _curve(regions: Rows, key: tuple[str, str], contact: str) -> list[Point]:
    rows = [r for r in regions if (r["scheme"], r["contact_force"]) == key
            and r["contact"] == contact]
    return [(float(r["zeta"]), float(r["limit"])) for r in rows]


def _eigenvalues(modes: Rows, contact: str) -> list[complex]:
    rows = [r for r in modes if r["contact"] == contact]
    z = [complex(float(r["re"]), float(r["im"])) for r in rows]
    return [v for v in z if abs(v) > 0]


def _draw_curves(axes: Any, regions: Rows, place: Place) -> None:
    """Limits by theory: solid of free modes, dashed of the contact spring where free modes have
    none."""
    for key, (_, colour) in NAMES.items():
        for contact, style in (("open", "-"), ("closed", "--")):
            points = [p for p in _curve(regions, key, contact) if 0 < p[1] < math.inf]
            bound = any(0 < x < math.inf for _, x in _curve(regions, key, "open"))
            # or the spring is bound like any mode
            if points and not (contact == "closed" and bound):
                axes.plot(*zip(*[place(*p) for p in points]), style, color=colour, lw=1.8, zorder=2)


def _draw_measured(axes: Any, limits: Rows, place: Place) -> None:
    """Limits that the march itself showed: circles of free modes, squares in contact."""
    for row in limits:
        low, high = float(row["measured_low"]), float(row["measured_high"])
        if 0 < low and high < math.inf:
            colour = NAMES[row["scheme"], row["contact_force"]][1]
            axes.plot(*place(float(row["motion_zeta"]), (low + high) / 2),
                      "o" if row["contact"] == "open" else "s", ms=5.5, mfc="white",
                      mec=colour, mew=1.3,
                      zorder=3, clip_on=False)


def _draw_modes(axes: Any, modes: Rows, place: Callable[[complex], Point], size: float) -> None:
    for contact, marker, face in (("open", "o", OPEN), ("closed", "D", CLOSED)):
        z = _eigenvalues(modes, contact)
        axes.plot([place(v)[0] for v in z], [place(v)[1] for v in z], marker, ms=size, mfc=face,
                  mec="black",
                  mew=0.4, ls="none", zorder=4)


def _label(axes: Any, text: str, x: float, y: float, key: tuple[str, str], **more: Any) -> None:
    axes.annotate(text, (x, y), color=NAMES[key][1], fontsize=9.5, zorder=5, **more)


def _draw_limits(axes: Any, limits: Rows, regions: Rows, modes: Rows) -> None:
    """The size of a step, x = |lambda| tau, against the damping ratio; on its log axis, the left
    edge is 0."""
    edge = 1e-4

    def place(zeta: float, x: float) -> Point:
        return (zeta if zeta > 2 * edge else edge if zeta == 0 else math.nan, x)

    _draw_curves(axes, regions, place)
    _draw_measured(axes, limits, place)
    _draw_modes(axes, modes, lambda z: (max(-z.real / abs(z), edge), abs(z)), 4)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(edge, 1)
    sizes = [abs(z) for z in _eigenvalues(modes, "open") + _eigenvalues(modes, "closed")]
    axes.set_ylim(10 ** math.floor(math.log10(min(sizes + [3e-5])) - 0.2), 20)
    axes.set_xticks([edge, 1e-3, 1e-2, 0.1, 1], ["0", "0.001", "0.01", "0.1", "1"])
    axes.text(1.45 * edge, 0, "//", transform=axes.get_xaxis_transform(), ha="center", va="center",
              fontsize=13)
    axes.set_xlabel(r"damping ratio $\zeta$ of the motion, free or in contact")
    axes.set_ylabel(r"$x = |\lambda|\,\tau$, frequency times step")
    axes.grid(True, which="major", alpha=0.25)
    axes.set_title("Largest stable step, and the scene's motions", fontsize=11)
    _label(axes, "RK8, RK4", 1.1e-4, 3.9, ("rk8", "old"))
    _label(axes, "midpoint", 2.6e-2, 1.25, ("midpoint", "old"))
    _label(axes, "backward Euler, old force, in contact", 1.1e-4, 1.2, ("backward-euler", "old"))
    _label(axes, "Heun", 1.5e-3, 0.3, ("heun", "old"), rotation=15)
    _label(axes, "exact, in contact", 1.5e-3, 0.011, ("exact", "old"), rotation=36)
    _label(axes, "explicit Euler", 3.6e-2, 0.026, ("explicit-euler", "old"), rotation=36)
    axes.text(1.15 * edge, 2.2e-4, "at 0, none:\nexplicit Euler, Heun,\nexact in contact",
              fontsize=8.5,
              color="#444444", va="top")
    marks = [Line2D([], [], color="#444444", lw=1.8, label="theory"),
             Line2D([], [], color="#444444", lw=1.8, ls="--",
                    label="theory, in contact, stable when free"),
             Line2D([], [], marker="o", ls="none", mfc="white", mec="#444444",
                    label="measured, a free mode"),
             Line2D([], [], marker="s", ls="none", mfc="white", mec="#444444",
                    label="measured, in contact"),
             Line2D([], [], marker="o", ls="none", ms=4, mfc=OPEN, mec="black",
                    label="the scene's modes, free")]
    if _eigenvalues(modes, "closed"):
        marks.append(Line2D([], [], marker="D", ls="none", ms=4, mfc=CLOSED, mec="black", mew=0.4,
                            label="the same with one node in contact"))
    axes.legend(handles=marks, loc="lower right", fontsize=8.5, framealpha=0.95)


def _draw_regions(axes: Any, limits: Rows, regions: Rows, modes: Rows) -> None:
    """The classical view: z = lambda tau in the upper left quarter of its plane."""
    def place(zeta: float, x: float) -> Point:
        return (-x * zeta, x * math.sqrt(1 - zeta * zeta))

    _draw_curves(axes, regions, place)
    _draw_measured(axes, limits, place)
    axes.set_xlim(-5.2, 0)
    axes.set_ylim(0, 5.2)
    axes.set_aspect("equal")
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    axes.set_xlabel(r"Re $\lambda\tau$")
    axes.set_ylabel(r"Im $\lambda\tau$")
    axes.grid(True, alpha=0.25)
    axes.set_title(r"Regions of stability: towards the origin from each curve", fontsize=11)
    _label(axes, "RK8", -2.5, 2.2, ("rk8", "old"), ha="right")
    _label(axes, "RK4", -2.6, 0.35, ("rk4", "old"), ha="left")
    _label(axes, "midpoint", -0.66, 2.07, ("midpoint", "old"))
    _label(axes, "Heun", -1.85, 1.32, ("heun", "old"), ha="right")
    _label(axes, "explicit\nEuler", -1.25, 0.55, ("explicit-euler", "old"))
    _label(axes, "backward Euler,\nold force,\nin contact", -4.25, 0.95, ("backward-euler", "old"))
    _label(axes, "exact, in contact", -4.3, 2.75, ("exact", "old"), rotation=33)
    axes.text(-5.1, 5.1,
              "backward Euler and exact:\nfree modes, everywhere;\nbackward Euler, new force,\nin "
              "contact, too",
              fontsize=8.5, color="#444444", va="top")
    z = _eigenvalues(modes, "open") + _eigenvalues(modes, "closed")
    if not z:
        return
    inset = axes.inset_axes([0.50, 0.71, 0.40, 0.22])
    _draw_curves(inset, regions, place)
    _draw_modes(inset, modes, lambda v: (v.real, v.imag), 3.5)
    inset.set_xlim(1.3 * min(v.real for v in z) or -1e-3, 0)
    inset.set_ylim(0, 1.15 * max(v.imag for v in z) or 1e-3)
    inset.ticklabel_format(style="sci", scilimits=(-2, 3), useMathText=True)
    inset.tick_params(labelsize=7)
    inset.xaxis.offsetText.set_fontsize(7)
    inset.yaxis.offsetText.set_fontsize(7)
    inset.locator_params(nbins=4)
    inset.set_title("the scene's motions, at the origin", fontsize=8.5)


def _title_of(context: Row) -> str:
    """Tables of earlier versions name no scene."""
    scene = ", step ".join(context[what] for what in ("scene", "step") if what in context)
    return "Stability of the time schemes." + (f" Scene: {literal(scene)}" if scene else "")


def picture(limits: pathlib.Path, regions: pathlib.Path, modes: pathlib.Path) -> Picture:
    """Largest stable steps over the damping ratio, and the regions in the complex plane."""
    title = _title_of(read_context(modes))
    tables = read(limits), read(regions), read(modes)
    with matplotlib.rc_context(CHART_RC):
        figure = Picture(figsize=(14, 6.6), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=[1.25, 1])
        _draw_limits(left, *tables)
        _draw_regions(right, *tables)
        figure.suptitle(title, fontsize=12)
    return figure
