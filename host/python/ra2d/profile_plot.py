# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a measured profile and its roughness. The program hands over the numbers
(host/surface/profile_series.hpp); null is NaN, and long series come as the extremes of
neighbours."""
from __future__ import annotations

import math
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt

from . import style
from .style import BLACK, BLUE, GREY, RUST, SKY, Array, Picture, literal, quantity, scale

Data = dict[str, Any]

WITHOUT_UNIT = ("Rsk", "Rku", "Rdq")
SHARES = ("Mr1", "Mr2")
NO_PARAMETERS = "points are missing: no parameters (--fill puts straight lines through gaps)"


def _numbers(values: list[float | None]) -> Array:
    return np.array(values, dtype=float)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _draw(axes: Any, drawn: Data, colour: str, x_unit: float, y_unit: float, line: Any = "-",
          label: str | None = None,
          width: float = 1.0, fill: float = 0.45, mean: bool = True) -> None:
    """A line; of values that were put together, the band from their lowest to their highest, and
    their mean."""
    x, middle = _numbers(drawn["x"]) / x_unit, _numbers(drawn["mean"]) / y_unit
    if drawn["together"] > 1:
        low, high = _numbers(drawn["low"]) / y_unit, _numbers(drawn["high"]) / y_unit
        axes.fill_between(x, low, high, color=colour, alpha=fill, lw=0.4, zorder=2,
                          label=None if mean else label)
    if drawn["together"] <= 1 or mean:
        axes.plot(x, middle, ls=line, color=colour, lw=width, label=label, zorder=3)


def _length_axis(axes: Any, drawn: Data, metres: float) -> float:
    """In the unit that suits the whole profile; limits are those of what is drawn."""
    unit, one = scale("m", np.array([metres]))
    axes.set_xlim(drawn["x"][0] / one, drawn["x"][-1] / one)
    band = f"  (band: extremes of {drawn['together']} points)" if drawn["together"] > 1 else ""
    axes.set_xlabel(f"x [{unit}]{band}")
    return one


def _draw_heights(axes: Any, drawn: Data, length: float, title: str, line: Data | None = None,
                  line_is: str | None = None) -> tuple[str, float]:
    one = _length_axis(axes, drawn, length)
    unit, high = scale("m",
                       *(_numbers(drawn[key]) for key in ("mean", "low", "high") if key in drawn))
    _draw(axes, drawn, BLUE, one, high, mean=False, fill=0.8, label="profile")
    if line:
        _draw(axes, line, RUST, one, high, line="--", width=1.6, mean=True, fill=0, label=line_is)
        axes.legend(loc="upper right", ncol=2)
    low, top = axes.get_ylim()
    axes.set_ylim(low, top + 0.15 * (top - low))  # for the legends
    axes.set_ylabel(f"height [{unit}]")
    axes.set_title(title)
    return unit, high


def _roughness_title(data: Data) -> str:
    n = data["sampling_lengths"]
    lengths = (f"{n} sampling length{'s' if n != 1 else ''} of "
               f"{quantity(data['sampling_length'], 'm')}")
    if data["filtered_before"]:
        return f"Roughness, filtered before: the first {lengths}"
    if data["filtered"]:
        return f"Roughness, cut-off {quantity(data['cutoff'], 'm')}: the first {lengths}"
    return f"Primary profile, no filter: {lengths}"


def _draw_distribution(axes: Any, data: Data, unit: str, one: float) -> None:
    """Lies beside the roughness and shares its axis of heights."""
    title = "Height distribution"
    heights = data["heights"]
    if "empty" in heights:
        axes.set_title(title)
        axes.text(0.5, 0.5, heights["empty"], transform=axes.transAxes, ha="center",
                  va="center", color=GREY)
        axes.set_xticks([])
        return
    edges, shares = _numbers(heights["edges"]) / one, 100 * _numbers(heights["shares"])
    axes.stairs(shares, edges, orientation="horizontal", fill=True, color=SKY, ec=BLUE, lw=0.8)
    rms = _number(heights["rms"]) / one
    z = np.linspace(edges[0], edges[-1], 200)
    normal = 100 * (edges[1]
                    - edges[0]) / (rms * math.sqrt(2 * math.pi)) * np.exp(-0.5 * (z / rms) ** 2)
    axes.plot(normal, z, color=BLACK, ls="--", lw=1.1, label="normal, same Rq")
    axes.set_xlim(0, 1.12 * max(shares.max(), normal.max()))
    axes.set_xlabel(f"share per {edges[1] - edges[0]:.2g} {unit} [%]")
    axes.set_title(title)
    axes.legend(loc="upper right", fontsize=8)


def _write_parameters(axes: Any, data: Data) -> None:
    axes.axis("off")
    axes.set_title(data["standard"])
    lines = []
    for name, value in data["parameters"].items():
        value = _number(value)
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


def _facts(data: Data) -> str:
    found = [f"{data['nodes']} points, {quantity(data['spacing'], 'm')} apart: "
             f"{quantity(data['length'], 'm', 4)}"]
    if data["missing"]:
        filled = " and filled by straight lines" if "parameters" in data else ""
        found.append(f"{data['missing']} of them missing{filled}")
    return "  \u00b7  ".join(found)


def picture(data: Data) -> Picture:
    """As measured, above; below, what is left of it, with its heights and parameters."""
    with matplotlib.rc_context(style.RC):
        figure, body = style.page(11, 7,
                                  [(literal(f"profile  \u2013  {data['file']}"), 13, "bold", BLACK),
                                   (_facts(data), 9.5, "normal", BLACK)])
        upper, lower = body.subfigures(2, 1)
        _draw_heights(upper.subplots(), data["profile"], data["length"],
                      "As measured, from its mean",
                      data.get("line"), data.get("line_is"))
        if "parameters" not in data:
            style.say_empty(lower.subplots(), f"{data['missing']} {NO_PARAMETERS}", "Roughness")
            return figure
        panels = lower.subplots(1, 3, width_ratios=[3, 1.1, 0.75])
        panels[1].sharey(panels[0])
        unit, one = _draw_heights(panels[0], data["roughness"], data["length"],
                                  _roughness_title(data))
        _draw_distribution(panels[1], data, unit, one)
        panels[1].tick_params(labelleft=False)
        _write_parameters(panels[2], data)
        return figure
