# SPDX-License-Identifier: BSD-3-Clause
"""The picture of `ra2d chart accuracy`, from its tables PREFIX.csv and PREFIX-long.csv."""
from __future__ import annotations

import math
import pathlib
from typing import Any

import matplotlib
from matplotlib.lines import Line2D

from . import style
from .chart_tables import NAMES, Row, read, read_context
from .style import CHART_RC, Picture, literal

MARKS = {"explicit-euler": "v", "midpoint": "o", "backward-euler": "s", "heun": "^",
         "rk4": "D", "rk8": "P",
         "exact": "X", "gautschi": "h", "adaptive": "*"}
REFERENCE_MARGIN = 2  # errors below so many times the reference's own cannot be measured
PEERS = {"cvode-adams": ("CVODE Adams", "#e377c2", "<"), "cvode-bdf": ("CVODE BDF", "#bcbd22", ">"),
         "dopri5": ("DOPRI5", "#444444", "x")}


def _style(row: Row) -> tuple[str, str, str, str]:
    """Name, colour, mark and line of a row's method."""
    scheme, force = row["scheme"], row["contact_force"]
    if row["program"] != "ra2d":
        name, colour, mark = PEERS.get(scheme, (scheme, "#999999", "x"))
        every = row["nodes"] == "all"
        return name + (", every node" if every else ""), colour, mark, ":" if every else "-"
    multiplier = row["law"] == "multiplier"
    name, colour = NAMES.get((scheme, "old" if multiplier else force), (scheme, "black"))
    if multiplier:
        name = name.split(",")[0] + ", multiplier"
    mark = "d" if force == "new" and not multiplier else MARKS.get(scheme, "*")
    return name, colour, mark, "--" if multiplier else "-"


def _number(row: Row, column: str) -> float:
    return float(row[column]) if row[column] else math.nan


def _size(row: Row) -> float:
    return _number(row, "step") if row["step"] else _number(row, "tolerance")


def _is_whole_decade(row: Row) -> bool:
    return abs(math.log10(_size(row)) - round(math.log10(_size(row)))) < 0.01


def _draw_unknown(axes: Any, wall: float, most: float, colour: str) -> None:
    """A run that is nearer to the reference than the reference is to the truth: an arrow from the
    most it may err."""
    axes.annotate("", (wall, most / 12), (wall, most), zorder=3,
                  arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.4, "shrinkA": 0,
                              "shrinkB": 0})
    axes.plot(wall, most, "_", color=colour, ms=10, mew=1.6, zorder=3)


def _draw_errors(axes: Any, rows: list[Row], kind: str, title: str, reference: float,
                 seen: dict[str, Line2D]) -> None:
    """Error over cost; every other step of the ladder is a power of ten and drawn larger."""
    curves: dict[tuple[str, str, str, str], list[Row]] = {}
    for row in rows:
        if kind == "energy" and row["law"] != "penalty":
            continue  # what impacts take there is no error
        if row["kind"] == kind and row["error"] and _number(row,
                                                            "error") > 0 and row["wall_median"]:
            curves.setdefault(_style(row), []).append(row)
    if not curves:
        style.say_empty(axes, "no scheme was measured here", title)
        return
    for (name, colour, mark, line), points in curves.items():
        points.sort(key=_size, reverse=True)
        for row in points:  # no further off than this, and nobody knows how far
            if _number(row, "error") <= REFERENCE_MARGIN * reference:
                _draw_unknown(axes, _number(row, "wall_median"),
                              REFERENCE_MARGIN * reference, colour)
        points = [row
                  for row in points if not _number(row, "error") <= REFERENCE_MARGIN * reference]
        wall = [_number(row, "wall_median") for row in points]
        error = [_number(row, "error") for row in points]
        hollow = {"mfc": "white"} if line == "--" else {}
        axes.plot(wall, error, line, color=colour, lw=1.3, alpha=0.9, zorder=2)
        for row, x, y in zip(points, wall, error):
            axes.plot(x, y, mark, color=colour, mec=colour, ms=7 if _is_whole_decade(row) else 4,
                      zorder=3, **hollow)
        seen.setdefault(name, Line2D([], [], color=colour, marker=mark, ls=line, lw=1.3, ms=6,
                                     label=name, **hollow))
    axes.set_xscale("log")
    axes.set_yscale("log")
    if reference > 0:
        low, high = axes.get_ylim()
        low, top = min(low, 0.02 * reference), REFERENCE_MARGIN * reference
        axes.axhspan(low, top, color="#dddddd", zorder=0)
        axes.set_ylim(low, high)
        axes.text(0.98, math.sqrt(low * top),
                  f"not known: below {REFERENCE_MARGIN} times the reference's own error ",
                  fontsize=8, color="#333333",
                  transform=axes.get_yaxis_transform(), ha="right", va="center")
    axes.set_xlabel("wall time per simulated second [s]")
    axes.grid(True, which="major", alpha=0.3)
    axes.set_title(title, fontsize=10.5)


def _size_text(row: Row) -> str:
    return f"{_number(row, 'step'):g} s" if row["step"] else f"tol {_number(row, 'tolerance'):g}"


def _plain(value: float, digits: int) -> str:
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.{digits}g}"


def _draw_statistics(axes: Any, rows: list[Row], quantity: str, label: str, unit: float) -> None:
    """Mean over the surfaces with its standard error, thin; thick, how far from the reference on
    the same ones.

    Multipliers, another model, do not widen the axis: what lies beyond it is written at its
    edge."""
    rows = [row for row in rows if row["quantity"] == quantity]

    def value(row: Row, column: str) -> float:
        return _number(row, column) / unit

    def half_interval(row: Row) -> float:
        return 0 if math.isnan(_number(row, "standard_error")) else 1.3 * value(row,
                                                                                "standard_error")

    shown = [row for row in rows if row["mean"]
             and row["law"] == "penalty"] or [row for row in rows if row["mean"]]
    if shown:
        low = min(value(row, "mean") - half_interval(row) for row in shown)
        high = max(value(row, "mean") + half_interval(row) for row in shown)
        margin = 0.25 * (high - low) or 0.1 * abs(high) or 1
        axes.set_xlim(low - margin, high + margin)
        axes.axvline(value(rows[0], "mean"), color="#555555", lw=0.9, ls=":", zorder=1)
    for i, row in enumerate(rows):
        _, colour, mark, line = _style(row)
        if not row["mean"]:
            axes.text(0.5, i, row["how"] or "none", transform=axes.get_yaxis_transform(),
                      ha="center", va="center",
                      fontsize=8)
            continue
        mean, spread = value(row, "mean"), value(row, "standard_error")
        low, high = axes.get_xlim()
        if not low < mean < high:
            many = "" if math.isnan(spread) else f" \u00b1 {_plain(spread, 2)}"
            axes.annotate(f"{_plain(mean, 4)}{many}", (0.01 if mean < low else 0.99, i),
                          (12 if mean < low else -12, 0),
                          xycoords=axes.get_yaxis_transform(), textcoords="offset points",
                          color=colour, fontsize=9,
                          ha="left" if mean < low else "right", va="center",
                          arrowprops={"arrowstyle": "->", "color": colour})
            continue
        axes.errorbar(mean, i, xerr=None if math.isnan(spread) else spread, fmt=mark, ms=7,
                      color=colour, lw=1,
                      capsize=3, zorder=3, **({"mfc": "white"} if line == "--" else {}))
        if row["difference"] and row["difference_error"]:
            middle, apart = value(rows[0], "mean") + value(row,
                                                           "difference"), value(row,
                                                                                "difference_error")
            axes.plot([middle - apart, middle + apart], [i, i], color=colour, lw=7, alpha=0.35,
                      solid_capstyle="butt", zorder=2)
    axes.locator_params(axis="x", nbins=6)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(range(len(rows)),
                    [f"{_style(row)[0]}, {_size_text(row)}\n{_number(row, 'wall'):.3g} s/s"
                     for row in rows], fontsize=8)
    axes.set_xlabel(label)
    axes.grid(True, axis="x", alpha=0.3)


def _wrap(text: str, most: int = 215) -> str:
    lines = [""]
    for word in text.split(" "):
        if len(lines[-1]) + len(word) > most:
            lines.append("")
        lines[-1] += word + " "
    return "\n".join(line.rstrip() for line in lines)


def picture(points: pathlib.Path, long_runs: pathlib.Path) -> Picture:
    """Error over cost, and statistics of long runs with each method."""
    with matplotlib.rc_context(CHART_RC):
        return _draw(points, long_runs)


def _draw(points: pathlib.Path, long_runs: pathlib.Path) -> Picture:
    context = read_context(points)
    rows, long_rows = read(points), read(long_runs)
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    quantities = [("level", "level [dB re 1 nm/s]", 1), ("shock-rate", "shocks a second", 1),
                  ("shock-duration", "median duration of a shock [\u00b5s]", 1e-6)]
    figure = Picture(figsize=(16, 11.2), layout="constrained")
    upper, middle, lower = figure.subfigures(3, 1, height_ratios=[1.5, 0.22, 1])
    seen: dict[str, Line2D] = {}
    for axes, kind in zip(upper.subplots(1, len(kinds), squeeze=False)[0], kinds):
        energy = kind == "energy"
        title = "closure of the energy (penalty)" if energy else context.get(kind, kind)
        reference = 0 if energy else float(context.get(f"{kind} of the reference") or "nan")
        _draw_errors(axes, rows, kind, title, reference, seen)
        axes.set_ylabel("relative to its largest term" if energy
                        else "relative error in the norm of the energy")
    middle.legend(handles=list(seen.values()), loc="center", ncol=6, fontsize=9, frameon=False)
    if long_rows:
        panels = lower.subplots(1, 3, sharey=True)
        for axes, (quantity, label, unit) in zip(panels, quantities):
            _draw_statistics(axes, long_rows, quantity, label, unit)
        first = long_rows[0]
        many = int(first["seeds"]) > 1
        lower.suptitle(f"Over {float(first['duration']):.3g} s of sliding"
                       + (f", {first['seeds']} surfaces: mean and standard error (thin); "
                          "difference from the first "
                          "line's on the same surfaces (thick)" if many else ", one run of each"),
                       fontsize=10.5)
    else:
        lower.text(0.5, 0.5, "no long runs: 'ra2d chart accuracy' prints why", ha="center",
                   fontsize=10, color=style.GREY)
    figure.suptitle(f"Speed against accuracy. Scene: {literal(context.get('scene', ''))}",
                    fontsize=12)
    stretches = [_number(row, "stretch") for row in rows if row["stretch"]
                 and row["program"] == "ra2d"] or [math.nan]
    figure.supxlabel(_wrap(
        f"Timed, and the energy followed, over {min(stretches):.2g} s (the finest) to "
        f"{max(stretches):.2g} s. "
        f"States of penalty against {context.get('reference', '')}; "
        f"{context.get('confirmed', '')}. Of multipliers, "
        "dashed, against each scheme's own finest run at the same time. Large marks: powers of ten "
        "of the step or the "
        "tolerance. Arrows: nearer to the reference than it is known itself.") + "\n"
                     + _wrap("; ".join(f"{what} {context[what]}" for what in
                                             ("ra2d", "compiler", "processor", "backend", "date")
                                       if what in context)),
        fontsize=8, color="#444444")
    return figure
