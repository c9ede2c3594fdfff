# SPDX-License-Identifier: BSD-3-Clause
"""One shock: the force, and the probes around it."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from . import maps, style
from .errors import RequestError
from .style import BLUE, GREY, RUST, SKY, Picture, quantity, scale

if TYPE_CHECKING:
    import pandas as pd

    from .results import Result

NO_SHOCKS = "there were no shocks: nothing touched"
ENOUGH = 10         # samples, that show a shock's shape
DURATIONS = 4       # of the shock, before and after it
LONGEST = 1e-3      # s before and after it, or half of a longer shock
LEAST_SAMPLES = 12  # before and after it
MOST_PROBES = 6


def choose(shocks: pd.DataFrame, number: int | None) -> int:
    """The shock of this number, or the strongest."""
    if number is None:
        return int(shocks["peak_force"].idxmax())
    if isinstance(number, bool) or not isinstance(number,
                                                  int | np.integer) or number not in shocks.index:
        raise RequestError(
            f"shock is {number!r}: the shocks here have the numbers {shocks.index[0]} to "
            f"{shocks.index[-1]}; the strongest is shown without a number")
    return int(number)


def _window(result: Result, shock: pd.Series[float]) -> slice:
    """Times around a shock [s]."""
    more = max(min(DURATIONS * shock["duration"], LONGEST), shock["duration"] / 2,
               LEAST_SAMPLES / result.rate)
    return slice(shock["start"] - more, shock["start"] + shock["duration"] + more)


def _draw_samples(axes: Any, place: Any, values: xr.DataArray, one: float, number: int,
                  label: str | None) -> None:
    axes.plot(place(values.time.values), values.values / one, color=style.SERIES[number],
              ls=style.LINES[number], lw=1.1,
              marker=style.MARKS[number], ms=3.5 if values.size < 120 else 0, label=label, zorder=3)


def _shade(axes: Any, place: Any, near: pd.DataFrame, number: int) -> None:
    """The time of the shock, and of others."""
    for other, row in near.iterrows():
        axes.axvspan(place(row["start"]), place(row["start"] + row["duration"]),
                     color=SKY if other == number else GREY,
                     alpha=0.35 if other == number else 0.12, lw=0, zorder=1)


def _draw_force(axes: Any, place: Any, force: xr.DataArray, shock: pd.Series[float],
                near: pd.DataFrame) -> None:
    unit, one = scale("N", force.values, shock["peak_force"])
    _draw_samples(axes, place, force, one, 0, "total contact force, samples")
    span = place(np.array([shock["start"], shock["start"] + shock["duration"]]))
    axes.plot(span, [shock["peak_force"] / one] * 2, color=RUST, lw=1.8, zorder=4,
              label=f"peak of this shock, of all steps: {quantity(shock['peak_force'], 'N')}")
    axes.set_ylabel(f"force [{unit}]")
    axes.set_ylim(0, None)
    style.room_above(axes, 0.25)
    axes.legend(loc="upper right", ncol=2)
    others = len(near) - 1
    axes.set_title("Contact force; shaded: the shock"
                   + (f", and in grey {others} other{'s' if others != 1 else ''}"
                      if others else ""))


def _draw_probes(axes: Any, place: Any, lines: list[tuple[str, xr.DataArray]], what: str,
                 unit_name: str, left: int) -> None:
    unit, one = scale(unit_name, *(values.values for _, values in lines))
    for number, (label, values) in enumerate(lines):
        _draw_samples(axes, place, values, one, number, label)
    axes.set_ylabel(f"{what} [{unit}]")
    axes.set_title(f"{what.capitalize()} of probes" + (f" ({left} more are not drawn)"
                                                       if left else ""))
    style.room_above(axes, 0.2)
    axes.legend(loc="upper right", ncol=3)


def _heads(result: Result, number: int, samples: int) -> list[tuple[str, float, str, str]]:
    shocks = result.shocks
    shock = shocks.loc[number]
    rank = int((shocks["peak_force"] > shock["peak_force"]).sum()) + 1
    which = "the strongest" if rank == 1 else f"number {rank} by peak force"
    lines = [(f"Shock {number}, {which} of {len(shocks)}: begins at "
              f"{quantity(shock['start'], 's', 9)}, lasts "
              f"{quantity(shock['duration'], 's')}, impulse {quantity(shock['impulse'], 'N s')}, "
              "at "
              + ", ".join(f"{1e3 * shock[name]:.5g}" for name in ("position", "y") if name in shock)
              + " mm on the resonator", 9.5, "normal", style.BLACK)]
    if samples < ENOUGH:
        fell = (f"{samples} sample{'s' if samples != 1 else ''} fall{'s' if samples == 1 else ''}"
                if samples else "No sample falls")
        lines.append((f"{fell} into it: too few for its shape. 'ra2d run --zoom' samples a shock "
                      "at 1 to 10 MHz.", 9.5,
                      "bold", RUST))
    else:
        lines.append((f"{samples} samples fall into it.", 9.5, "normal", style.BLACK))
    return lines


def picture(result: Result, number: int | None, head: list[tuple[str, float, str, str]]) -> Picture:
    """The picture of one shock: force, displacement and velocity of the probes around it. `head`:
    lines at the top."""
    shocks = result.shocks
    if not len(shocks) or result.samples < 2:
        if number is not None and len(shocks) == 0:
            raise RequestError(f"shock is {number!r}: there were none")
        figure, body = style.page(10, 4, head)
        style.say_empty(body.subplots(), NO_SHOCKS if not len(shocks)
                        else "there are fewer than two samples", "One shock")
        return figure
    number = choose(shocks, number)
    shock = shocks.loc[number]
    window = _window(result, shock)
    force = result.contact.force.sel(time=window).load()
    ends = shocks["start"] + shocks["duration"]
    near = shocks[(shocks["start"] < window.stop) & (ends > window.start)]
    within = (force.time >= shock["start"]) & (force.time <= shock["start"] + shock["duration"])
    series = {what: [(f"{body} at {place}", one)
                     for body, probes in (("resonator", result.probes),
                                          ("slider", result.slider_probes))
                     for place, one in style.at_probes(probes[what])]
              for what in ("displacement", "velocity")}
    panels = 3 if series["velocity"] else 1
    patch = 5.4 if result.is_areal else 0.0
    figure, body = style.page(10, 3.1 * panels + patch,
                              [*head[:1], *_heads(result, number, int(within.sum())), *head[2:]])
    if result.is_areal:
        body, below = body.subfigures(2, 1, height_ratios=[3.1 * panels, patch])
        maps.patch(below.subplots(), result, shock)
    all_axes = body.subplots(panels, 1, sharex=True, squeeze=False)[:, 0]
    ends_of = np.array([max(window.start, 0.0), min(window.stop, float(result.duration))])
    place = style.time_axis(all_axes[-1], ends_of)
    _draw_force(all_axes[0], place, force, shock, near)
    for axes, (what, unit) in zip(all_axes[1:], (("displacement", "m"), ("velocity", "m/s"))):
        lines = [(label, values.sel(time=window).load())
                 for label, values in series[what][:MOST_PROBES]]
        _draw_probes(axes, place, lines, what, unit, max(0, len(series[what]) - MOST_PROBES))
    for axes in all_axes:
        _shade(axes, place, near, number)
        if not math.isnan(shock["duration"]):
            axes.margins(x=0)
    return figure
