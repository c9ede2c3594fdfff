#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""plot_profile.py DATA PICTURE KIND: the picture of `ra2d plot` of a measured profile.

DATA is what the command hands over (host/plot/profile_picture.cpp), KIND is png, svg or pdf. Ends with status 9 when
there is no matplotlib.
"""
import math
import sys

import picture_style as style
from picture_style import BLACK, BLUE, GREY, RUST, SKY, literal, number, numbers, quantity, scale, series
import numpy as np

WITHOUT_UNIT = ("Rsk", "Rku", "Rdq")
SHARES = ("Mr1", "Mr2")
NO_PARAMETERS = "points are missing: no parameters (--fill puts straight lines through gaps)"


def length_axis(axes, drawn, metres):
    """In the unit that suits the whole profile; limits are those of what is drawn."""
    unit, one = scale("m", np.array([metres]))
    axes.set_xlim(drawn["x"][0] / one, drawn["x"][-1] / one)
    band = f"  (band: extremes of {drawn['together']} points)" if drawn["together"] > 1 else ""
    axes.set_xlabel(f"x [{unit}]{band}")
    return one


def draw_heights(axes, drawn, length, title, line=None, line_is=None):
    one = length_axis(axes, drawn, length)
    unit, high = scale("m", style.extremes(drawn))
    series(axes, drawn, BLUE, one, high, mean=False, fill=0.8, label="profile")
    if line:
        series(axes, line, RUST, one, high, line="--", width=1.6, mean=True, fill=0, label=line_is)
        axes.legend(loc="upper right", ncol=2)
    low, top = axes.get_ylim()
    axes.set_ylim(low, top + 0.15 * (top - low))  # for the legends
    axes.set_ylabel(f"height [{unit}]")
    axes.set_title(title)
    return unit, high


def roughness_title(data):
    n = data["sampling_lengths"]
    lengths = f"{n} sampling length{'s' if n != 1 else ''} of {quantity(data['sampling_length'], 'm')}"
    if data["filtered_before"]:
        return f"Roughness, filtered before: the first {lengths}"
    if data["filtered"]:
        return f"Roughness, cut-off {quantity(data['cutoff'], 'm')}: the first {lengths}"
    return f"Primary profile, no filter: {lengths}"


def draw_distribution(axes, data, unit, one):
    """Lies beside the roughness and shares its axis of heights."""
    title = "Height distribution"
    heights = data["heights"]
    if "empty" in heights:
        axes.set_title(title)
        axes.text(0.5, 0.5, heights["empty"], transform=axes.transAxes, ha="center", va="center", color=GREY)
        axes.set_xticks([])
        return
    edges, shares = numbers(heights["edges"]) / one, 100 * numbers(heights["shares"])
    axes.stairs(shares, edges, orientation="horizontal", fill=True, color=SKY, ec=BLUE, lw=0.8)
    rms = number(heights["rms"]) / one
    z = np.linspace(edges[0], edges[-1], 200)
    normal = 100 * (edges[1] - edges[0]) / (rms * math.sqrt(2 * math.pi)) * np.exp(-0.5 * (z / rms) ** 2)
    axes.plot(normal, z, color=BLACK, ls="--", lw=1.1, label="normal, as wide")
    axes.set_xlim(0, 1.12 * max(shares.max(), normal.max()))
    axes.set_xlabel(f"share per {edges[1] - edges[0]:.2g} {unit} [%]")
    axes.set_title(title)
    axes.legend(loc="upper right", fontsize=8)


def write_parameters(axes, data):
    axes.axis("off")
    axes.set_title(data["standard"])
    lines = []
    for name, value in data["parameters"].items():
        value = number(value)
        shown = name if data["filtered"] or name in SHARES else "P" + name[1:]
        if not math.isfinite(value):
            text = "not defined"
        elif name in SHARES:
            text = f"{100 * value:.4g} %"
        else:
            text = f"{value:.4g}" if name in WITHOUT_UNIT else quantity(value, "m", 4)
        lines.append((shown, text))
    for i, (name, text) in enumerate(lines):
        y = 0.98 - i / len(lines)
        axes.text(0.02, y, name, transform=axes.transAxes, va="top", weight="bold", fontsize=9.5)
        axes.text(0.42, y, text, transform=axes.transAxes, va="top", fontsize=9.5)


def facts(data):
    found = [f"{data['nodes']} points, {quantity(data['spacing'], 'm')} apart: {quantity(data['length'], 'm', 4)}"]
    if data["missing"]:
        filled = " and filled by straight lines" if "parameters" in data else ""
        found.append(f"{data['missing']} of them missing{filled}")
    return "  \u00b7  ".join(found)


def main(file, picture, kind):
    data = style.read(file)
    figure, body = style.page(11, 7, [(literal(f"profile  \u2013  {data['file']}"), 13, "bold", BLACK),
                                      (facts(data), 9.5, "normal", BLACK)])
    upper, lower = body.subfigures(2, 1)
    draw_heights(upper.subplots(), data["profile"], data["length"], "As measured, from its mean",
                 data.get("line"), data.get("line_is"))
    if "parameters" not in data:
        style.say_empty(lower.subplots(), f"{data['missing']} {NO_PARAMETERS}", "Roughness")
    else:
        panels = lower.subplots(1, 3, width_ratios=[3, 1.1, 0.75])
        panels[1].sharey(panels[0])
        unit, one = draw_heights(panels[0], data["roughness"], data["length"], roughness_title(data))
        draw_distribution(panels[1], data, unit, one)
        panels[1].tick_params(labelleft=False)
        write_parameters(panels[2], data)
    style.save(figure, picture, kind)


if __name__ == "__main__":
    main(*sys.argv[1:])
