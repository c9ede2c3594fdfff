# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of areal scenes: faces, motion and gap as maps."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap

from . import style
from .errors import RequestError
from .results import MOTIONS
from .style import BLACK, RUST, Array, quantity, scale

if TYPE_CHECKING:
    import pandas as pd

    from .results import Result

MOST_POINTS = 1600    # of a map that is drawn, along each axis
MOST_DOTS = 3000
LONGEST_TRUE = 9      # length over width up to which a map is drawn true to scale
PATCH = 24            # nodes on each side of a shock
POINTS = 8            # drawn of a spacing of smooth faces


def thinned(face: xr.DataArray, most: int = MOST_POINTS) -> xr.DataArray:
    """A map of at most so many points along each axis."""
    return face.isel({name: slice(None, None, math.ceil(face.sizes[name] / most))
                      for name in face.dims}).load()


def _edges(places: Array) -> tuple[float, float]:
    """Ends of an axis whose places stand in the middles of strips [mm]."""
    half = (places[-1] - places[0]) / (2 * (len(places) - 1)) if len(places) > 1 else 0.5e-3
    return 1e3 * (places[0] - half), 1e3 * (places[-1] + half)


def _is_true_to_scale(length: float, width: float) -> bool:
    return length <= LONGEST_TRUE * width and width <= 1.5 * length


def height(length: float, width: float, inches: float) -> float:
    """Of a map's panel so many inches wide, with its title and labels."""
    return 1.0 + inches * (width / length if _is_true_to_scale(length, width) else 0.25)


def draw(axes: Any, values: xr.DataArray, colours: str, bar: str = "", unit: str = "m",
         middle: bool = False) -> Any:
    """A map over (y, position), places in mm; with `bar` a colour bar of that name. `middle`:
    colours are symmetric about 0."""
    name, one = scale(unit, values.values)
    x, y = _edges(values.position.values), _edges(values.y.values)
    most = float(np.abs(values.values).max()) / one or 1.0
    limits = {"vmin": -most, "vmax": most} if middle else {}
    true_to_scale = _is_true_to_scale(x[1] - x[0], y[1] - y[0])
    image = axes.imshow(values.values / one, origin="lower", extent=(*x, *y), cmap=colours,
                        interpolation="none",
                        aspect="equal" if true_to_scale else "auto", **limits)
    axes.grid(False)
    axes.set_ylabel("y [mm]")
    axes.set_anchor("W")
    if bar:  # next to the map, wherever its own proportions put it
        wide = 0.05 / min(max((x[1] - x[0]) / (y[1] - y[0]), 0.7), 5.0) if true_to_scale else 0.012
        inset = axes.inset_axes((1 + 0.5 * wide, 0, wide, 1))
        axes.figure.colorbar(image, cax=inset, label=f"{bar} [{name}]")
    return image


def dots(axes: Any, shocks: pd.DataFrame) -> int:
    """The places of shocks on a map, the strongest of many. Returns how many are drawn."""
    shown = shocks.nlargest(MOST_DOTS, "peak_force") if len(shocks) > MOST_DOTS else shocks
    size = min(9.0, max(1.5, 300 / max(1.0, len(shown)) ** 0.5))
    axes.scatter(shown["position"] * 1e3, shown["y"] * 1e3, s=size, color="white", edgecolors=BLACK,
                 linewidths=0.3,
                 rasterized=len(shown) > 500, zorder=3)
    return len(shown)


def resonator_face(axes: Any, result: Result, track: tuple[float, float], bars: bool = True,
                   most: int = MOST_POINTS) -> None:
    """The resonator's face where the slider comes, with the places of the shocks."""
    under = thinned(result.profile("resonator").sel(position=slice(*track)), most)
    shocks = result.shocks
    draw(axes, under, "viridis", "height" if bars else "")
    limits = axes.get_xlim(), axes.get_ylim()
    count = dots(axes, shocks)
    axes.set(xlim=limits[0], ylim=limits[1])
    of = f"the {count} strongest of " if count < len(shocks) else ""
    axes.set_title("Resonator under the slider's path" + (f"; dots: {of}{len(shocks)} shocks"
                                                          if len(shocks) else
                                                          "; there were no shocks"))
    axes.set_xlabel("x on the resonator [mm]")


def slider_face(axes: Any, result: Result, bars: bool = True, most: int = MOST_POINTS) -> None:
    """The slider's face as it lies on the resonator's."""
    draw(axes, thinned(result.profile("slider"), most), "viridis", "height" if bars else "")
    axes.set_title("Slider, seen through it from above; heights towards the resonator")
    axes.set_xlabel("x on the slider [mm]")


def faces(panels: Any, result: Result, track: tuple[float, float], bars: bool = True,
          most: int = MOST_POINTS) -> None:
    """Both under each other."""
    resonator_face(panels[0], result, track, bars, most)
    slider_face(panels[1], result, bars, most)


# ---- motion
# ----------------------------------------------------------------------------------------

def _block_at(result: Result, time: float) -> tuple[float, float, float, float]:
    """The slider on the resonator: x, y of its corner, its length and width [m]."""
    scene = result.scene
    rows = result.profile("resonator").y.values
    step = rows[1] - rows[0] if len(rows) > 1 else 0.0
    return (float(scene["start"]) + float(scene["speed"]) * time, float(rows[0] - step / 2),
            float(scene["slider.length"]), float(scene["slider.width"]))


def _draw_slider(axes: Any, result: Result, time: float) -> None:
    x, y, length, width = (1e3 * number for number in _block_at(result, time))
    axes.plot([x, x + length, x + length, x, x], [y, y, y + width, y + width, y], color=BLACK, lw=1)


def motion(panels: Any, result: Result, time: float) -> None:
    """The resonator's displacement and velocity at a time, as maps; its slider as a frame."""
    for axes, what, unit in zip(panels, MOTIONS, ("m", "m/s")):
        field = result.field(time, what=what)
        draw(axes, field, "RdBu_r", what, unit, middle=True)
        _draw_slider(axes, result, float(field.time))
        axes.set_title(f"{what.capitalize()} of the resonator at "
                       f"{quantity(float(field.time), 's', 7)}; frame: the slider")
    panels[-1].set_xlabel("x on the resonator [mm]")


# ---- gap
# -------------------------------------------------------------------------------------------

def _is_smooth(result: Result) -> bool:
    return bool(result.scene["faces"] == "smooth")


def _along(result: Result, face: xr.DataArray, places: Array) -> Array:
    """Heights of rows of a face at places along them [m]: straight between nodes, or their
    splines."""
    nodes = face.position.values
    if not _is_smooth(result):
        return np.array([np.interp(places, nodes, row) for row in face.values])
    from scipy.interpolate import CubicSpline
    return np.asarray(CubicSpline(nodes, face.values, axis=1)(places))


def _under(result: Result, places: Array, rows: slice) -> Array:
    """Heights of the resonator's face under places of rows [m]."""
    face = result.profile("resonator").isel(y=rows)
    spacing = float(result.scene["spacing"])
    margin = 30 if _is_smooth(result) else 1  # nodes beyond which a spline feels nothing
    first = max(0, math.floor(places[0] / spacing) - margin)
    near = face.isel(position=slice(first, math.ceil(places[-1] / spacing) + 1 + margin)).load()
    return _along(result, near, places)


def _distance(result: Result) -> float:
    """Distance of the mean planes [m]: the scene's, or that at which the faces first touch at t =
    0."""
    gap = result.scene["gap"]
    if isinstance(gap, int | float):
        return float(gap)
    slider = result.profile("slider").load()
    start, spacing = float(result.scene["start"]), float(result.scene["spacing"])
    nodes = slider.position.values
    both = slider.values + _under(result, start + nodes, slice(None))
    highest = float(both.max())
    if not _is_smooth(result):
        return highest
    # between nodes they may be higher by an eighth of the curvature there
    rise = np.abs(np.diff(both, 2, axis=1)).max(initial=0.0)
    for row, node in np.argwhere(both >= highest - 0.25 * rise):
        places = np.linspace(max(nodes[0], nodes[node] - spacing),
                             min(nodes[-1], nodes[node] + spacing), 257)
        one = slice(row, row + 1)
        sums = _along(result, slider.isel(y=one), places) + _under(result, start + places, one)
        highest = max(highest, float(sums.max()))
    return highest


def gap(result: Result, time: float, nodes: slice = slice(None),
        rows: slice = slice(None), points: int = 1) -> xr.DataArray:
    """The gap [m] between the faces at the sample nearest to a time [s], at nodes of the slider
    along x and y, over their places (y, position) on the resonator; of smooth faces at so many
    `points` a spacing along x. Negative where they are in contact."""
    modes, block = result.modes("resonator"), result.modes("slider")
    if "displacement" not in modes:
        raise RequestError(
            f"{str(result.path)!r} has no motion of the modes, of which the gap is made: its scene "
            "has "
                           'output.modes = "none"')
    u = modes.displacement.sel(time=time, method="nearest").load()
    face = result.profile("slider").isel(y=rows).load()
    places = face.position.values[nodes]
    if _is_smooth(result) and points > 1:
        places = np.linspace(places[0], places[-1], points * (len(places) - 1) + 1)
    along = float(result.scene["start"]) + float(result.scene["speed"]) * float(u.time) + places
    across = result.profile("resonator").y.values[rows]
    length, width = float(result.scene["resonator.length"]), float(result.scene["resonator.width"])
    plate = np.zeros((len(across), len(places)))
    if modes.sizes["mode"]:
        of_y = np.sin(np.pi / width * np.outer(across, modes.mode_y.values)) * u.values
        plate = 2 / math.sqrt(length * width) * of_y @ np.sin(np.pi / length
                                                              * np.outer(modes.mode_x.values,
                                                                         along))
    rigid = np.zeros(plate.shape)
    if block.sizes["mode"]:  # straight lines: two places have them
        straight = block.isel(position=[0, -1], y=[0, -1]).load().sel(time=u.time)
        of_x, of_y = (np.array([np.interp(places, straight[name], shape)
                                for shape in straight[f"shape_{axis}"].values])
                      for axis, name, places in (("x", "position", places),
                                                 ("y", "y", face.y.values)))
        rigid = (of_y * straight.displacement.values[:, None]).T @ of_x
    values = (_distance(result) - _along(result, face, places) - rigid
              - _under(result, along, rows) - plate)
    return xr.DataArray(values, {"y": across, "position": along, "time": float(u.time)},
                        ("y", "position"), "gap",
                        {"units": "m", "long_name": "gap between the faces"})


def _time_to_show(result: Result, shock: pd.Series[float]) -> float:
    """The sample of the largest force within a shock; its middle where none falls into it [s]."""
    within = result.contact.force.sel(time=slice(shock["start"],
                                                 shock["start"] + shock["duration"])).load()
    return float(within.time[int(np.argmax(within.values))]) if within.size else float(
        shock["start"] + shock["duration"] / 2)


def patch(axes: Any, result: Result, shock: pd.Series[float]) -> None:
    """The gap around a shock, and what is in contact."""
    if "displacement" not in result.modes("resonator"):
        style.say_empty(axes, "the file has no motion of the modes (output.modes)",
                        "Gap around the shock")
        return
    time = _time_to_show(result, shock)
    x, y, _, _ = _block_at(result, time)
    face = result.profile("slider")
    nodes, rows = (slice(max(0, middle - PATCH), middle + PATCH + 1) for middle in (
        int(np.abs(face.position.values - (shock["position"] - x)).argmin()),
        int(np.abs(face.y.values - (shock["y"] - y)).argmin())))
    found = gap(result, time, nodes, rows, POINTS)
    draw(axes, found, "viridis", "gap")
    touching = int((found <= 0).sum())
    if touching:
        closed = np.where(found.values <= 0, 1.0, np.nan)
        axes.imshow(closed, origin="lower", extent=axes.images[0].get_extent(),
                    cmap=ListedColormap([RUST]),
                    interpolation="none", aspect=axes.get_aspect())
    axes.plot(shock["position"] * 1e3, shock["y"] * 1e3, marker="+", color="white", ms=9, mew=1.6)
    axes.set_xlabel("x on the resonator [mm]")
    axes.set_title(f"Gap around the shock (+) at {quantity(float(found.time), 's', 7)}; "
                   + ("nothing is in contact at this sample" if not touching
                      else "brown: in contact" if _is_smooth(result)
                      else f"brown: {touching} node{'s' if touching != 1 else ''} in contact"))
