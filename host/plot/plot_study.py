#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""plot_study.py DATA PICTURE KIND: the picture of `ra2d plot` of a study: its level against what was varied, and the
fitted law.

DATA is what `ra2d analyze DIR --json` prints, with a title. KIND is png, svg or pdf. Ends with status 9 when there is
no matplotlib.
"""
import itertools
import math
import sys

import picture_style as style
from picture_style import GREY, LINES, MARKS, SERIES, literal, number
import numpy as np

MOST_SERIES = 6  # that a panel keeps apart
MOST_PANELS = 6
COLOURS = [colour for colour in SERIES if colour not in (style.SKY, style.MOSS)]


def word(value):
    return f"{value:g}" if isinstance(value, float) else str(value)


def is_number(values):
    return all(isinstance(value, float) for value in values)


def some(things, most):
    """All, or so many of them, evenly spread from the first to the last."""
    if len(things) <= most:
        return things
    return [things[round(i * (len(things) - 1) / (most - 1))] for i in range(most)]


def law_at(law, point):
    """Level by the law [dB]."""
    return law["constant_db"] + sum(20 * e["value"] * math.log10(point[name]) for name, e in law["exponents"].items())


def by_name(point, names):
    return tuple(point[name] for name in names)


def draw_panel(axes, data, name, others):
    """The level against one dimension, a series for each combination of the others."""
    values, law = data["dimensions"][name], data["law"]
    numeric = is_number(values)
    order = sorted(range(len(values)), key=lambda i: values[i]) if numeric else list(range(len(values)))
    places = {values[i]: (values[i] if numeric else float(at)) for at, i in enumerate(order)}
    groups = {}
    for point in data["points"]:
        groups.setdefault(by_name(point, others), []).append(point)
    chosen = some(list(groups), MOST_SERIES)
    for k, group in enumerate(chosen):
        points = sorted((p for p in groups[group] if p["lv"]["mean"] is not None), key=lambda p: places[p[name]])
        if not points:
            continue
        x = np.array([places[p[name]] for p in points])
        aside = 0.008 * (k - (len(chosen) - 1) / 2) * (1 if len(chosen) > 1 else 0)  # so that bars stand apart
        log = numeric and min(values) > 0
        marks = x * (max(values) / min(values)) ** aside if log else x + aside * (np.ptp(list(places.values())) or 1)
        y = np.array([p["lv"]["mean"] for p in points])
        label = ", ".join(f"{n} = {word(v)}" for n, v in zip(others, group)) or None
        low, high = (np.array([number(p["lv"][side]) for p in points]) for side in ("low", "high"))
        axes.errorbar(marks, y, yerr=[np.where(np.isfinite(low), y - low, 0), np.where(np.isfinite(high), high - y, 0)],
                      fmt=MARKS[k], ms=4.5, color=COLOURS[k], ecolor=COLOURS[k], elinewidth=0.8, capsize=2.5,
                      label=label and literal(label), zorder=3)
        if law and name in law["exponents"] and len(points) > 1:
            line = np.geomspace(x[0], x[-1], 40)
            axes.plot(line, [law_at(law, points[0] | {name: at}) for at in line], ls=LINES[k], lw=1.1,
                      color=COLOURS[k], zorder=2)
    if numeric and min(values) > 0:
        axes.set_xscale("log")
    shown = sorted(places.values())
    axes.set_xticks(some(shown, 8), [word(v) if numeric else literal(style.textwrap.shorten(str(v), 16))
                                     for v in some([values[i] for i in order], 8)])
    axes.xaxis.set_minor_formatter(style.NullFormatter())
    unit = data["units"][name].replace(" s-1", "/s")
    axes.set_xlabel(literal(name if unit == "1" else f"{name} [{unit}]"))
    axes.set_ylabel("Lv [dB re 1 nm/s]")
    axes.margins(x=0.06)
    title = f"against {name}"
    if len(groups) > len(chosen):
        title += f" ({len(chosen)} of {len(groups)} combinations)"
    axes.set_title(literal(title))
    if others:
        axes.legend(fontsize=7.5, ncol=1 if len(chosen) < 4 else 2)


def set_levels(panels, data):
    """The same limits in all: those of the means. What intervals reach beyond is cut."""
    means = [p["lv"]["mean"] for p in data["points"] if p["lv"]["mean"] is not None]
    room = max(2.0, 0.15 * (max(means) - min(means)))
    for axes in panels:
        axes.set_ylim(min(means) - room, max(means) + 1.6 * room)


def law_lines(data):
    law = data["law"]
    if not law:
        return [data["why_no_law"]]
    parts = []
    for name, e in law["exponents"].items():
        interval = "" if e["low"] is None else f" ({e['low']:.3f} to {e['high']:.3f})"
        parts.append(f"{name}^{e['value']:.3f}{interval}")
    text = "v_rms ~ " + "  ".join(parts) + f";  R\u00b2 = {law['r_squared']:.4f}, {law['runs']} runs"
    if law["deviation_db"] is not None:
        text += f", {law['deviation_db']:.2f} dB from the law to a run"
    shape = [f"A straight line does not fit (p = {law['straight_line']['p']:.2g}): see ra2d analyze"] \
        if law["straight_line"]["fits"] is False else []
    return [text] + shape + [f"All values of {name} are taken together in the law." for name in law["pooled"]]


def main():
    source, target, kind = sys.argv[1:4]
    data = style.read(source)
    names = [name for name, values in data["dimensions"].items() if name != "seed"]
    varied = [name for name in names if len(data["dimensions"][name]) > 1]
    counts = ", ".join(f"{data[what]} {what}" for what in ("done", "failed", "missing") if data[what] or what == "done")
    lines = [(literal(data["title"]), 12, "bold", "black"),
             (literal(f"{data['runs']} runs: {counts}. Means over the seeds, with 95 % intervals (cut at the panels' "
                      "ends). Lines: the law"), 8.5, "normal", GREY),
             *((literal(line), 9, "normal", "black") for line in law_lines(data))]
    panels = varied[:MOST_PANELS]
    columns = 1 if len(panels) <= 1 else 2
    rows = max(1, math.ceil(len(panels) / columns))
    figure, lower = style.page(5.2 * columns + (1.5 if columns == 1 else 0), 3.6 * rows, lines)
    grid = np.atleast_1d(lower.subplots(rows, columns, squeeze=False)).ravel()
    has_levels = any(p["lv"]["mean"] is not None for p in data["points"])
    drawn = []
    for axes, name in itertools.zip_longest(grid, panels):
        if name is None and axes is not grid[0]:
            axes.set_visible(False)
        elif name is None:
            style.say_empty(axes, "nothing but the seeds was varied", "Level")
        elif not has_levels:
            style.say_empty(axes, "the table has no levels: none was kept, or no run is done", f"Level against {name}")
        else:
            draw_panel(axes, data, name, [other for other in varied if other != name])
            drawn.append(axes)
    if drawn:
        set_levels(drawn, data)
    style.save(figure, target, kind)


if __name__ == "__main__":
    main()
