# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of a result (docs/pictures.md says how to read them)."""
from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from . import maps, shock_plot, spectrogram, stretch, style
from .errors import RequestError
from .results import MOTIONS
from .stretch import Stretch
from .style import (BLACK, BLUE, DECIBEL, GREEN, GREY, PLUM, RUST, SKY, Array, Picture, literal,
                    quantity, scale)

if TYPE_CHECKING:
    from .results import Result

NO_PROBES = "the scene names no probes (output.probes, output.slider_probes)"
NO_SHOCKS = "there were no shocks: nothing touched"
FEW_SAMPLES = "fewer than two samples: the run ended before, or output.rate is too low"
SHORT_SPECTRUM = "the run is too short for a spectrum"
MOST_LINES = 6   # that a panel keeps apart
MOST_DOTS = 2000
PLACES = 120     # bins along the track
WINDOWS = 100    # of the level in time
_OF_PRESSURE = (RUST, BLACK, GREY)  # colours
CLOSE = 400      # samples of a close-up


# ---- faces ---------------------------------------------------------------------------------------

def _start(result: Result) -> float | None:
    """Where the slider starts [m]; None of a scene that another version wrote."""
    try:
        return float(result.scene["start"])
    except (KeyError, ValueError, TypeError):
        return None


def _gap(result: Result, resonator: xr.DataArray, slider: xr.DataArray, start: float) -> float:
    """Distance of the mean lines at t = 0: the scene's, or that at which the first nodes touch."""
    gap = result.scene["gap"]
    if isinstance(gap, float):
        return gap
    under = resonator.sel(position=start + slider.position, method="nearest").values
    return float((slider.values + under).max())


def track(result: Result) -> tuple[float, float]:
    """The places that the slider passes, with some more on either side [m]."""
    start, length = _start(result), float(result.profile("resonator").position[-1])
    if start is None:
        return 0.0, length
    speed = float(result.scene["speed"])
    end = start + float(result.scene["slider.length"]) + speed * result.duration
    start += speed * stretch.first_time(result)
    more = 0.04 * (end - start)
    low, high = max(0.0, start - more), min(length, end + more)
    return (low, high) if low < high else (0.0, length)  # of a scene that is no such one


def _draw_faces(axes: Any, result: Result) -> None:
    start, (low, high) = None if stretch.first_time(result) else _start(result), track(result)
    resonator, slider = result.profile("resonator").load(), result.profile("slider").load()
    title = "Faces at the start, where the slider passes (heights much enlarged)"
    if stretch.first_time(result):
        title = "Face of the resonator where the slider passes (heights much enlarged)"
    gap = _gap(result, resonator, slider, start) if start is not None else 0.0
    drawn = [resonator.sel(position=slice(low, high)).values]
    if start is not None:
        drawn.append(gap - slider.values)
        title += f"; mean lines {quantity(gap, 'm')} apart"
    unit, one = scale("m", *drawn)
    style.draw_series(axes, resonator.sel(position=slice(low, high)).position.values * 1e3,
                      drawn[0] / one, BLUE,
                      label="resonator", mean=False, fill=0.9)
    if start is not None:
        style.draw_series(axes, (start + slider.position.values) * 1e3, drawn[1] / one, RUST,
                          mean=False, fill=0.9,
                          label="slider at t = 0, face down")
    axes.set_title(title)
    axes.set_ylabel(f"height [{unit}]")
    axes.set_xlim(low * 1e3, high * 1e3)
    style.room_above(axes, 0.22)
    axes.legend(loc="upper right", ncol=2)


def _draw_places(axes: Any, result: Result) -> None:
    position = result.shocks["position"].to_numpy()
    if not position.size:
        style.say_empty(axes, NO_SHOCKS, "Places of contact", keep_x=True)
        return
    low, high = track(result)
    counts, edges = np.histogram(position * 1e3, bins=PLACES, range=(low * 1e3, high * 1e3))
    axes.stairs(counts, edges, fill=True, color=PLUM, alpha=0.85)
    axes.set_title(f"Places of contact: {position.size} shock{'s' if position.size != 1 else ''}")
    axes.set_ylabel(f"shocks per\n{edges[1] - edges[0]:.2g} mm")
    axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    axes.set_ylim(0, 1.1 * max(counts.max(), 1))


def _draw_strongest(axes: Any, result: Result) -> None:
    shocks = result.shocks
    if not len(shocks):
        style.say_empty(axes, NO_SHOCKS, "Peak forces", keep_x=True)
        return
    shown = shocks.nlargest(MOST_DOTS, "peak_force")
    unit, one = scale("N", shown["peak_force"])
    cloud = axes.scatter(shown["position"] * 1e3, shown["peak_force"] / one, c=shown["start"], s=9,
                         cmap="viridis",
                         lw=0, rasterized=len(shown) > 500)
    axes.figure.colorbar(cloud, ax=axes, label="begins at [s]", pad=0.01, aspect=14)
    axes.set_title("Peak forces: every shock" if len(shown) == len(shocks) else
                   f"Peak forces: the {len(shown)} strongest of {len(shocks)} shocks")
    axes.set_ylabel(f"peak force [{unit}]")
    axes.set_ylim(0, None)


def _heights(result: Result) -> tuple[float, float]:
    """Of the panels of an areal scene's faces on a page [inches]: across it, across half of it."""
    width = float(result.scene["slider.width"])
    start, end = track(result)
    return (maps.height(end - start, width, 9.4),
            maps.height(float(result.scene["slider.length"]), width, 3.8))


def _profiles(figure: Any, result: Result, alone: bool) -> None:
    if result.is_areal:
        maps.faces(figure.subplots(2, 1, height_ratios=_heights(result)), result, track(result))
        return
    draw = [_draw_faces, _draw_places] + [_draw_strongest] * alone
    panels = figure.subplots(len(draw), 1, sharex=True, height_ratios=[1.5, 1, 1][:len(draw)])
    for axes, one in zip(panels, draw):
        one(axes, result)
    panels[-1].set_xlabel("place on the resonator [mm]")


# ---- in time -------------------------------------------------------------------------------------

def _draw_lines(axes: Any, lines: list[tuple[str | None, xr.DataArray]], name: str, unit_name: str,
                title: str) -> None:
    """Series over one time; each with its colour and line."""
    time = lines[0][1].time.values
    unit, one = scale(unit_name, *(values.values for _, values in lines))
    place = style.time_axis(axes, time)
    per_point = max(style.draw_series(axes, place(time), values.values / one, style.SERIES[i],
                                      style.LINES[i], label)
                   for i, (label, values) in enumerate(lines))
    if per_point > 1:
        style.time_axis(axes, time, f"  (band: extremes of {per_point} samples, line: mean)")
    axes.set_ylabel(f"{name} [{unit}]")
    axes.set_title(title)
    if lines[0][0]:
        style.room_above(axes, 0.2)
        axes.legend(loc="upper right", ncol=3)


def _around_largest(force: xr.DataArray) -> slice:
    """Samples around the largest force."""
    first = max(0, min(int(np.argmax(force.values)) - CLOSE // 2, force.size - CLOSE))
    return slice(first, first + CLOSE)


def _force(figure: Any, result: Result, alone: bool) -> None:
    force = result.contact.force.load()
    if not force.any():
        why = ("the bodies never touched: no contact force" if not len(result.shocks) else
               "no sample fell into a contact: the shocks are shorter than the time from sample to "
               "sample")
        style.say_empty(figure.subplots(), why, "Contact force")
        return
    panels = figure.subplots(2 if alone else 1, 1, squeeze=False)[:, 0]
    _draw_lines(panels[0], [(None, force)], "force", "N", "Contact force")
    if alone:
        _draw_lines(panels[1], [(None, force.isel(time=_around_largest(force)))], "force", "N",
                    "Around the largest sample, every sample")
    for axes in panels:
        axes.set_ylim(0, None)


def _probe_lines(result: Result, what: str) -> list[tuple[str | None, xr.DataArray]]:
    """A series for each probe of both bodies, with its name."""
    return [(f"{body} at {place}", one)
            for body, probes in (("resonator", result.probes), ("slider", result.slider_probes))
            for place, one in style.at_probes(probes[what])]


def _displacement(figure: Any, result: Result, alone: bool) -> None:
    title = "Displacement of probes"
    lines = _probe_lines(result, "displacement")
    if not lines:
        style.say_empty(figure.subplots(), NO_PROBES, title)
        return
    more = f" ({len(lines) - MOST_LINES} more are not drawn)" if len(lines) > MOST_LINES else ""
    lines = [(label, values.load()) for label, values in lines[:MOST_LINES]]
    panels = figure.subplots(2 if alone else 1, 1, squeeze=False)[:, 0]
    _draw_lines(panels[0], lines, "displacement", "m", title + more)
    if alone:
        close = _around_largest(result.contact.force.load())
        _draw_lines(panels[1], [(label, values.isel(time=close)) for label, values in lines],
                    "displacement", "m",
                    "Around the largest force, every sample")


def level_in_time(result: Result) -> tuple[Array, Array]:
    """Middles [s] of a hundred windows, and the level [dB re 1 nm/s] in each: Σ <ψ²> V² over the
    modes, by the formula of docs/analysis.md."""
    modes = result.modes("resonator")
    weight = modes.mean_square.values
    edges = np.linspace(0, modes.sizes["time"],
                        min(WINDOWS, modes.sizes["time"] // 2) + 1).astype(int)
    square = [float((modes.velocity[a:b].values ** 2 @ weight).mean())
              for a, b in zip(edges, edges[1:])]
    with np.errstate(divide="ignore"):
        levels = 10 * np.log10(np.array(square)) + 180
    return modes.time.values[(edges[:-1] + edges[1:]) // 2], levels


def why_empty(result: Result, what: str) -> str:
    """Why there is no noise to show as "spectrum", "bands" or "level"; empty where there is."""
    if result.samples < 2:
        return FEW_SAMPLES
    if "velocity" not in result.modes("resonator"):
        return "the file has no motion of the modes (output.modes)"
    if not result.modes("resonator").mean_square.any():
        return "the resonator has no elastic modes: it makes no noise"
    if not result.analysis()["v_rms"]:
        return "the resonator is at rest: it did not vibrate"
    if what == "spectrum" and result.spectrum().sizes["frequency"] <= 2:
        return SHORT_SPECTRUM
    if what == "bands" and not np.isfinite(result.bands().level).any():
        return "the run is too short for third octaves"
    return ""


def _level(figure: Any, result: Result, _: bool) -> None:
    axes, title = figure.subplots(), "Level of the resonator's noise in time"
    if why := why_empty(result, "level"):
        style.say_empty(axes, why, title)
        return
    time, levels = level_in_time(result)
    first = stretch.first_time(result)
    place = style.time_axis(axes, np.array([first, result.duration]))
    axes.plot(place(time), levels, color=BLUE, lw=1.2, marker="o", ms=2.5)
    found = result.level
    begin = result.analysis()["from"]
    since = "of these" if first else f"from {quantity(begin, 's')} on" if begin else "whole"
    span = [place(begin), place(result.analysis()["to"])]
    if math.isfinite(found):
        axes.plot(span, [found, found], color=PLUM, ls="--", lw=1.2, zorder=4,
                  label=f"{since}: {found:.2f} dB")
    if math.isfinite(found.low):
        axes.fill_between(span, found.low, found.high, color=PLUM, alpha=0.12, lw=0,
                          label="its 95 % interval")
    finite = levels[np.isfinite(levels)]
    high = max([*finite, found if math.isfinite(found) else -math.inf])
    low = max(finite.min(), high - 80)
    margin = max(1.0, 0.08 * (high - low))
    axes.set_ylim(low - 2.5 * margin, high + margin)
    axes.legend(loc="lower right", ncol=2)
    _draw_pressures(axes, result, lambda microphone: heard_in_time(microphone, place), 2)
    axes.set_ylabel(f"level [{DECIBEL}]")
    axes.set_title(f"{title}, over {quantity((result.duration - first) / len(levels), 's')} each")


# what, its name, colour, line and width: where lines lie upon one another, the wider ones show
FLOWS = [("load_work", "put in by loads", SKY, "-", 4.5),
         ("sliding_work", "put in by sliding", BLUE, "-", 2.2),
         ("damping_loss", "lost to damping", RUST, "--", 1.7),
         ("stored", "stored since the start", GREEN, ":", 2),
         ("missing", "missing", BLACK, (0, (1, 2)), 1.3)]
STORES = [("kinetic", "kinetic", BLUE, "-", 1.6), ("elastic", "elastic", RUST, "--", 1.6),
          ("contact", "in contacts", GREEN, ":", 1.8)]


def _draw_energies(axes: Any, energy: xr.Dataset, kinds: list[Any], title: str) -> None:
    time = energy.time.values
    unit, one = scale("J", *(energy[key].values for key, *_ in kinds))
    place = style.time_axis(axes, time)
    per_point = [style.draw_series(axes, place(time), energy[key].values / one, colour, line, name,
                                   width, fill=0.25)
                for key, name, colour, line, width in kinds]
    if per_point[0] > 1:
        style.time_axis(axes, time, f"  (band: extremes of {per_point[0]} samples, line: mean)")
    axes.set_ylabel(f"energy [{unit}]")
    axes.set_title(title)
    style.room_above(axes, 0.42 if len(kinds) > 3 else 0.2)
    axes.legend(loc="upper left", handlelength=3, ncol=2 if len(kinds) > 3 else 3)


def _energy(figure: Any, result: Result, alone: bool) -> None:
    title = "Energy: what went in and where it went"
    energy = result.energy.load()
    if not any(values.any() for values in energy.data_vars.values()):
        style.say_empty(figure.subplots(),
                        "no energy went through: nothing moved and nothing touched", title)
        return
    total = energy.kinetic + energy.elastic + energy.contact
    energy["stored"] = total - total[0]
    energy["missing"] = energy.stored + energy.damping_loss - energy.sliding_work - energy.load_work
    panels = figure.subplots(2 if alone else 1, 1, squeeze=False)[:, 0]
    _draw_energies(panels[0], energy, FLOWS, title)
    if alone:
        _draw_energies(panels[1], energy, STORES, "Energy that is there")


# ---- frequencies
# -----------------------------------------------------------------------------------

def set_decades(axes: Any, values: Array, most: float = 9) -> None:
    """Limits of a density's axis: what lies more decades below its peak says nothing of the
    noise."""
    axes.set_yscale("log")
    positive = values[np.isfinite(values) & (values > 0)]
    if positive.size:
        low, high = max(positive.min(), positive.max() * 10.0 ** -most), positive.max()
        axes.set_ylim(low / 2, high * 10 ** (0.1 * math.log10(high / low) + 0.5))


def _mark_frequencies(axes: Any, result: Result, colour: str) -> None:
    """Natural frequencies as ticks at the top, the tone of the mesh as a line."""
    low, high = axes.get_xlim()
    natural = [f for f in result.analysis()["natural_frequencies"] if low <= f <= high]
    if natural:
        axes.vlines(natural, 0.955, 1, transform=axes.get_xaxis_transform(), color=colour, lw=1.1,
                    label="natural frequencies, free resonator")
    tone = result.analysis()["mesh_tone"]
    if tone["in_spectrum"]:
        axes.axvline(tone["frequency"], ls=(0, (4, 2)), color=BLACK, lw=0.9,
                     label=f"mesh, speed/spacing: {quantity(tone['frequency'], 'Hz')}")


def _draw_confidence(axes: Any, low: float | None, high: float | None) -> None:
    """A bar as high as 95 % of chance."""
    if low is None or high is None:
        return
    bottom, top = axes.get_ylim()
    middle, across = bottom * (top / bottom) ** 0.86, axes.get_yaxis_transform()
    axes.errorbar([0.975], [middle], yerr=[[middle * (1 - low)], [middle * (high - 1)]], color=GREY,
                  capsize=3, lw=1.2,
                  transform=across, zorder=5)
    axes.text(0.96, middle, "95 %", transform=across, ha="right", va="center",
              color=GREY, fontsize=8)


def _draw_densities(axes: Any, result: Result, lines: list[tuple[str | None, Array]],
                    title: str) -> None:
    spectrum = result.spectrum()
    at = spectrum.frequency.values[1:]
    for i, (label, density) in enumerate(lines):
        style.draw_series(axes, at, density[1:], style.SERIES[i], style.LINES[i], label, log=True)
    set_decades(axes, np.concatenate([density[1:] for _, density in lines]))
    style.frequency_axis(axes, at[0], at[-1])
    _mark_frequencies(axes, result, GREY if lines[0][0] else RUST)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left")
    axes.set_ylabel("PSD of velocity [(m/s)\u00b2/Hz]")
    axes.set_title(title)
    axes.set_xlabel(f"frequency [Hz]  (a line every {spectrum.resolution:.3g} Hz; "
                    f"{spectrum.segments} segments)")
    if aliased := result.analysis()["aliased_modes"]:
        axes.text(0.02, 0.9, f"{aliased} modes lie above half the rate of the samples:\n"
                  "their power stands at frequencies not theirs", transform=axes.transAxes,
                  va="top", color=RUST,
                  fontsize=8, weight="bold")
    _draw_confidence(axes, spectrum.low, spectrum.high)


def _spectrum(figure: Any, result: Result, _: bool) -> None:
    axes, title = figure.subplots(), "Velocity spectrum, mean over the resonator"
    if why := why_empty(result, "spectrum"):
        style.say_empty(axes, why, title)
    else:
        _draw_densities(axes, result, [(None, result.spectrum().density.values)], title)


def _probe_spectra(figure: Any, result: Result, _: bool) -> None:
    axes, title = figure.subplots(), "Velocity spectra of probes"
    if result.spectrum().sizes["frequency"] <= 2:
        style.say_empty(axes, SHORT_SPECTRUM, title)
        return
    s = result.analysis()["spectrum"]
    densities = [np.array(row, dtype=float) for row in (*s["psd_probe"], *s["psd_slider_probe"])]
    names = [label for label, _ in _probe_lines(result, "velocity")]
    lines = list(zip(names, densities))[:MOST_LINES]
    if not lines:
        style.say_empty(axes, NO_PROBES, title)
        return
    more = f" ({len(names) - MOST_LINES} more are not drawn)" if len(names) > MOST_LINES else ""
    _draw_densities(axes, result, lines, title + more)


def band_axis(axes: Any, names: list[str]) -> None:
    """An axis of bands: all their names, or every other one."""
    step = max(1, math.ceil(len(names) / 32))
    axes.set_xticks(range(0, len(names), step), names[::step],
                    rotation=60 if len(names) > 12 else 0)
    axes.grid(False, axis="x")
    axes.set_xlim(-0.7, len(names) - 0.3)
    axes.set_xlabel("midband frequency [Hz]")


def heard_by(result: Result) -> list[dict[str, Any]]:
    """The microphones that a picture shows: the first few that hear something."""
    heard = [one for one in result.analysis().get("microphones", []) if one["lp"] is not None]
    return heard[:len(_OF_PRESSURE)]


def microphone_words(microphone: dict[str, Any]) -> str:
    """Its place and its level."""
    place = ", ".join(f"{x:g}" for x in microphone["position"])
    weighted = "" if microphone["lpa"] is None else f", {microphone['lpa']:.1f} dB(A)"
    return f"{place} m: {microphone['lp']:.1f} dB{weighted}"


def _draw_pressures(axes: Any, result: Result, line: Callable[[dict[str, Any]], tuple[Any, Any]],
                    size: float = 4, bars: Mapping[str, Any] | None = None) -> None:
    """A line for each microphone over what shows the velocity, on an axis of its own. `bars`, by
    their names: they stand in one legend with the lines, so that no legend covers another."""
    heard, bars = heard_by(result), bars or {}
    if not heard:
        if bars:
            axes.legend(bars.values(), bars.keys(), loc="upper right")
        return
    right_axes = axes.twinx()
    for i, microphone in enumerate(heard):
        right_axes.plot(*line(microphone), color=_OF_PRESSURE[i], marker=style.MARKS[i], ms=size,
                        lw=1, alpha=0.85,
                    label=f"pressure at {microphone_words(microphone)}")
    right_axes.grid(False)
    right_axes.set_ylabel("sound pressure [dB re 20 \u00b5Pa]")
    for one in (axes, right_axes):  # above all lines for this legend, below for the other one
        style.room_above(one, 0.14 + 0.08 * (len(heard) + len(bars)))
    low, high = right_axes.get_ylim()
    right_axes.set_ylim(low - 0.12 * (high - low), high)
    lines, names = right_axes.get_legend_handles_labels()
    right_axes.legend([*lines, *bars.values()], [*names, *bars], loc="upper left")


def _band_line(microphone: dict[str, Any], names: list[str]) -> tuple[Any, Any]:
    its = microphone["bands"]
    shown = [(names.index(name), level) for name, level in zip(its["nominal"], its["level"])
             if name in names
             and level is not None]
    return [at for at, _ in shown], [level for _, level in shown]


def heard_in_time(microphone: dict[str, Any], place: Callable[[Any], Any]) -> tuple[Any, Any]:
    """Its level in time: places on an axis, levels [dB re 20 uPa]."""
    its = microphone["history"]
    square = np.array(its["mean_square"], dtype=float)
    merged = max(1, square.size // WINDOWS)
    square = square[:square.size // merged * merged].reshape(-1, merged).mean(axis=1)
    middles = its["from"] + (np.arange(square.size) + 0.5) * merged * its["part_seconds"]
    with np.errstate(divide="ignore"):
        levels = 10 * np.log10(square / 20e-6 ** 2)
    shown = levels > levels.max(initial=-math.inf) - 80  # the first sounds are still on their way
    return place(middles[shown]), levels[shown]


def _bands(figure: Any, result: Result, alone: bool) -> None:
    axes, title = figure.subplots(), "Third octaves of the resonator's velocity"
    if why := why_empty(result, "bands"):
        style.say_empty(axes, why, title)
        return
    bands = result.bands()
    levels = bands.level.values
    finite = levels[np.isfinite(levels)]
    bottom = 5 * math.floor((max(finite.min(), finite.max() - 80) - 5) / 5)
    bars = axes.bar(np.arange(levels.size), np.maximum(levels - bottom, 0), 0.85, bottom=bottom,
                    color=SKY, ec=BLUE,
                    lw=0.8, yerr=bands.spread.values,
                    error_kw={"ecolor": BLACK, "capsize": 2, "lw": 0.9})
    above = [bar for bar, is_above in zip(bars, bands.above_last_mode.values) if is_above]
    for bar in above:
        bar.set(facecolor="white", hatch="////")
    band_axis(axes, bands.nominal.values.tolist())
    axes.set_ylim(bottom, finite.max() + (6 if alone else 14))
    names = bands.nominal.values.tolist()
    _draw_pressures(axes, result, lambda microphone: _band_line(microphone, names),
                    bars={"above the last mode that was kept, at "
                          f"{quantity(bands.last_mode, 'Hz')}: no information": bar
                          for bar in above[:1]})
    axes.set_ylabel(f"level [{DECIBEL}]")
    axes.set_title(f"{title}; in all {result.level:.1f} dB"
                   + ("; bars: by the finite length alone" if alone else ""))


def _spectrogram(figure: Any, result: Result, _: bool) -> None:
    axes = figure.subplots()
    if why := why_empty(result, "spectrogram"):
        style.say_empty(axes, why, spectrogram.TITLE)
    else:
        spectrogram.draw(figure, axes, result)


# ---- shocks
# ----------------------------------------------------------------------------------------

KINDS = [("duration", "s", "duration"), ("peak_force", "N", "peak force"),
         ("impulse", "N s", "impulse"),
         ("interval", "s", "time from start to start")]


def draw_histogram(axes: Any, shocks: dict[str, Any], key: str, unit_name: str, what: str) -> None:
    """Shares of the shocks in bins of equal ratio, with the median and what nine of ten do not
    exceed."""
    found, spread = shocks["histograms"][key], shocks[key]
    edges, counts = np.array(found["edges"], dtype=float), np.array(found["counts"], dtype=float)
    if not counts.size:
        style.say_empty(axes, f"no shock has a {what} above 0", what.capitalize())
        return
    unit, one = scale(unit_name, spread["median"])
    share = 100 * counts / shocks["count"]
    axes.stairs(share, edges / one, fill=True, color=SKY, ec=BLUE, lw=0.8)
    axes.set_xscale("log")
    low, high = edges[0] / one, edges[-1] / one
    axes.set_xlim(low / 1.15, high * 1.15)
    if high / low < 50:
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"{what} [{unit}]")
    axes.set_ylabel("share of shocks [%]")
    axes.set_ylim(0, 1.45 * share.max())
    for name, line, text in (("median", "-", "median"), ("p90", "--", "90 % up to")):
        value = spread[name]
        axes.axvline(value / one, ls=line, color=BLACK, lw=1,
                     label=f"{text} {quantity(value, unit_name)}")
    axes.legend(loc="upper right", handlelength=1.6, fontsize=8)


def _shocks(figure: Any, result: Result, alone: bool) -> None:
    shocks = result.analysis()["shocks"]
    if not shocks["count"]:
        why = "no shock began at or after output.from" if len(result.shocks) else NO_SHOCKS
        style.say_empty(figure.subplots(), why, "Shocks")
        return
    kinds = KINDS if alone else KINDS[:2]
    for axes, kind in zip(figure.subplots(len(kinds) // 2, 2, squeeze=False).flat, kinds):
        draw_histogram(axes, shocks, *kind)
    begin = 0 if isinstance(result, Stretch) else result.analysis()["from"]
    figure.axes[0].set_title(f"{shocks['count']} shock{'s' if shocks['count'] != 1 else ''}"
                             + (f" from {quantity(begin, 's')} on" if begin else "")
                             + (", bins of equal ratio, ten to a decade" if alone else ""))


# ---- pages
# ------------------------------------------------------------------------------------------

PANELS: dict[str, tuple[Callable[[Any, Any, bool], None], float]] = {
    "profiles": (_profiles, 7.5), "force": (_force, 6), "displacement": (_displacement, 6),
    "spectrum": (_spectrum, 5),
    "probe-spectra": (_probe_spectra, 5.6), "shocks": (_shocks, 6), "level": (_level, 4.2),
    "energy": (_energy, 7),
    "bands": (_bands, 4.6), "spectrogram": (_spectrogram, 5.2)}
SAME = {"waterfall": "spectrogram"}  # another word for a panel
SHOCK, MOTION = "shock", "motion"
NEED_SAMPLES = ("force", "displacement", "spectrum", "probe-spectra", "level", "energy", "bands",
                "spectrogram")


def facts(result: Result) -> str:
    """The figures of the report, in a line."""
    found, level = result.analysis(), result.level
    parts = []
    if math.isfinite(level):
        parts.append(f"level {level:.2f} {DECIBEL}"
                     + (f" (95 %: {level.low:.1f} to {level.high:.1f})"
                        if math.isfinite(level.low) else ""))
    elif found["v_rms"] == 0:
        parts.append("the resonator is at rest")
    if rate := found["shocks"]["rate"]:
        parts.append(f"{rate:.0f} shocks a second" if rate >= 1000
                     else f"{rate:.3g} shocks a second")
    if found["contact_share"] is not None:
        parts.append(f"in contact {100 * found['contact_share']:.3g} % of the time")
    if found["energy"]["closure"] is not None:
        parts.append(f"energy balance off by {found['energy']['closure']:.1e}")
    return "  \u00b7  ".join(parts)


def doubts(result: Result) -> str:
    """Warnings that stand in the head of a picture."""
    found = []
    if not result.complete:
        found.append("The run was cut short after "
                     f"{quantity(stretch.whole_duration(result), 's')}: "
                     f"{result.attrs['ended']}.")
    if "beyond_limit" in result.attrs:
        found.append("A step beyond the limit of stability was forced.")
    return " ".join(found)


def _head(result: Result) -> list[tuple[str, float, str, str]]:
    words = f"{result.title}  \u2013  {result.path.name}{stretch.words(result)}"
    lines = [(literal(words), 13.0, "bold", BLACK),
             (facts(result), 9.5, "normal", BLACK)]
    if heard := heard_by(result):
        lines.append(("sound at " + "  \u00b7  ".join(map(microphone_words, heard)), 9.5,
                      "normal", BLACK))
    return lines + ([(literal(doubts(result)), 9.5, "bold", RUST)] if doubts(result) else [])


def _motion(result: Result, time: float | None,
            lines: list[tuple[str, float, str, str]]) -> Picture:
    """The resonator's displacement and velocity at a time: maps, or lines along a beam."""
    modes = result.modes("resonator")
    figure, body = style.page(10, 11 if result.is_areal else 6, lines)
    if why := FEW_SAMPLES if not result.samples else "" if "velocity" in modes else \
            "the file has no motion of the modes (output.modes)":
        style.say_empty(body.subplots(), why, "Motion of the resonator")
        return figure
    if time is None:
        force = result.contact.force.load()
        time = float(force.time[int(np.argmax(force.values))])
    panels = body.subplots(2, 1, sharex=True)
    if result.is_areal:
        maps.motion(panels, result, time)
        return figure
    for axes, name, unit_name, colour in zip(panels, MOTIONS, ("m", "m/s"), (BLUE, RUST)):
        field = result.field(time, what=name)
        unit, one = scale(unit_name, field.values)
        axes.plot(field.position * 1e3, field.values / one, color=colour)
        start = _start(result)
        if start is not None:
            begin = start + float(result.scene["speed"]) * float(field.time)
            axes.axvspan(1e3 * begin, 1e3 * (begin + float(result.scene["slider.length"])),
                         color=GREY, alpha=0.15, lw=0)
        axes.set_title(f"{name.capitalize()} of the resonator at "
                       f"{quantity(float(field.time), 's', 7)}; grey: the slider")
        axes.set_ylabel(f"{name} [{unit}]")
    panels[-1].set_xlabel("place on the resonator [mm]")
    return figure


def _draw(name: str, cell: Any, result: Result, alone: bool) -> None:
    if name in NEED_SAMPLES and result.samples < 2:
        style.say_empty(cell.subplots(), FEW_SAMPLES, name)
    else:
        PANELS[name][0](cell, result, alone)


def _overview(result: Result, lines: list[tuple[str, float, str, str]]) -> Picture:
    """A page: the faces across it, below them two panels a row; of an areal scene the slider's map
    is one of these."""
    pairs = [("force", "displacement"), ("spectrum", "level"), ("shocks", "energy")]
    heights = [4.5, 3.1, 3.27, 3.1]
    if result.is_areal:
        pairs = [("slider", "level"), ("force", "displacement"), ("spectrum", "bands"),
                 ("shocks", "energy")]
        heights = [*_heights(result), *heights[1:]]
    figure, body = style.page(11, sum(heights), lines)
    rows = body.subfigures(len(heights), 1, height_ratios=heights)
    if result.is_areal:
        maps.resonator_face(rows[0].subplots(), result, track(result))
    else:
        _draw("profiles", rows[0], result, False)
    for row, names in zip(rows[1:], pairs):
        for cell, name in zip(row.subfigures(1, 2), names):
            if name == "slider":
                maps.slider_face(cell.subplots(), result)
            else:
                _draw(name, cell, result, False)
    return figure


def views() -> list[str]:
    """All that can be asked of one result."""
    return ["overview", *PANELS, *SAME, SHOCK, MOTION]


def result(of: Result, what: str = "overview", start: float | None = None,
           stop: float | None = None,
           shock: int | None = None, time: float | None = None) -> Picture:
    """The picture of a result: "overview", or one panel. `start`, `stop` [s]: of a stretch alone;
    `shock`: which one is shown as "shock", the strongest without it; `time` [s] of "motion", that
    of the largest contact force without it."""
    what = SAME.get(what, what)
    if what not in views():
        raise RequestError(f"there is no picture {what!r}. There are: {', '.join(views())}")
    if shock is not None and what != SHOCK:
        raise RequestError(f"a shock is chosen for the picture 'shock', not for {what!r}")
    if time is not None and what != MOTION:
        raise RequestError(f"a time is chosen for the picture 'motion', not for {what!r}")
    of = stretch.of(of, start, stop)
    lines = _head(of)
    with matplotlib.rc_context(style.RC):
        if what == SHOCK:
            return shock_plot.picture(of, shock, lines)
        if what == MOTION:
            return _motion(of, time, lines)
        if what != "overview":
            high = sum(_heights(of)) if of.is_areal and what == "profiles" else PANELS[what][1]
            figure, body = style.page(10, high, lines)
            _draw(what, body, of, True)
            return figure
        return _overview(of, lines)
