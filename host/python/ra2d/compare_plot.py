# SPDX-License-Identifier: BSD-3-Clause
"""Several results over one another."""
from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.lines import Line2D

from . import plots, stretch, style
from .errors import RequestError
from .results import Result
from .style import BLACK, DECIBEL, GREY, LINES, MARKS, RUST, SERIES, Picture, literal, scale

MOST = len(SERIES)
PRESSURE = "sound pressure [dB re 20 \u00b5Pa]"


def _marker(i: int) -> dict[str, Any]:
    return {"color": SERIES[i], "ls": LINES[i]}


def _spectra(axes: Any, shown: list[tuple[int, Result]]) -> None:
    spectra = [result.spectrum() for _, result in shown]
    for (i, _), spectrum in zip(shown, spectra):
        style.draw_series(axes, spectrum.frequency.values[1:], spectrum.density.values[1:],
                          SERIES[i], LINES[i],
                          log=True, fill=0.12, width=1.1)
    plots.set_decades(axes, np.concatenate([spectrum.density.values[1:] for spectrum in spectra]))
    style.frequency_axis(axes, min(float(s.frequency[1]) for s in spectra),
                         max(float(s.frequency[-1]) for s in spectra))
    axes.set_ylabel("PSD of velocity [(m/s)\u00b2/Hz]")


def _bands(axes: Any, shown: list[tuple[int, Result]]) -> None:
    bands = [result.bands() for _, result in shown]
    centres = sorted({float(centre) for one in bands for centre in one.frequency.values})
    names = {float(centre): str(name) for one in bands
             for centre, name in zip(one.frequency.values, one.nominal.values)}
    for (i, _), one in zip(shown, bands):
        place = np.array([centres.index(centre) for centre in one.frequency.values])
        above = one.above_last_mode.values
        axes.plot(place, one.level.values, marker=MARKS[i], ms=5, lw=1.2, **_marker(i))
        axes.plot(place[above], one.level.values[above], ls="none", marker=MARKS[i], ms=5,
                  mfc="white", mec=SERIES[i])
    plots.band_axis(axes, [names[centre] for centre in centres])
    if any(one.above_last_mode.any() for one in bands):
        axes.set_xlabel("midband frequency [Hz]  (hollow: above the last mode that was kept, no "
                        "information)")
    _level_limits(axes, np.concatenate([one.level.values for one in bands]), 3)


def _heard(result: Result) -> dict[str, Any] | None:
    """The first microphone that hears something."""
    heard: dict[str, Any] | None = next(iter(plots.heard_by(result)), None)
    return heard


def _bands_heard(axes: Any, shown: list[tuple[int, Result]]) -> None:
    bands = [(i, heard["bands"]) for i, result in shown if (heard := _heard(result))]
    names = dict(sorted((centre, name) for _, one in bands
                        for centre, name in zip(one["centre"], one["nominal"])))
    centres = list(names)
    drawn = []
    for i, one in bands:
        place = np.array([centres.index(centre) for centre in one["centre"]])
        levels = np.array(one["level"], dtype=float)  # None: silence
        above = np.array(one["above_last_mode"], dtype=bool)
        axes.plot(place, levels, marker=MARKS[i], ms=5, lw=1.2, **_marker(i))
        axes.plot(place[above], levels[above], ls="none", marker=MARKS[i], ms=5, mfc="white",
                  mec=SERIES[i])
        drawn.append(levels)
    plots.band_axis(axes, list(names.values()))
    _level_limits(axes, np.concatenate(drawn), 3, PRESSURE)


def _levels_heard(axes: Any, shown: list[tuple[int, Result]]) -> None:
    heard = [(i, one) for i, result in shown if (one := _heard(result))]
    place = style.time_axis(axes,
                            np.array([min(one["from"] for _, one in heard),
                                      max(one["to"] for _, one in heard)]))
    drawn = []
    for i, one in heard:
        time, levels = plots.heard_in_time(one, place)
        axes.plot(time, levels, lw=1.2, marker=MARKS[i], ms=4, markevery=8, **_marker(i))
        drawn.append(levels)
    _level_limits(axes, np.concatenate(drawn), 1, PRESSURE)


def _levels(axes: Any, shown: list[tuple[int, Result]]) -> None:
    found = [plots.level_in_time(result) for _, result in shown]
    place = style.time_axis(axes, np.array([min(stretch.first_time(result) for _, result in shown),
                                            max(result.duration for _, result in shown)]))
    for (i, _), (time, levels) in zip(shown, found):
        axes.plot(place(time), levels, lw=1.2, marker=MARKS[i], ms=4, markevery=8, **_marker(i))
    _level_limits(axes, np.concatenate([levels for _, levels in found]), 1)


def _level_limits(axes: Any, levels: style.Array, margin: float,
                  label: str = f"level [{DECIBEL}]") -> None:
    finite = levels[np.isfinite(levels)]
    axes.set_ylim(max(finite.min(), finite.max() - 80) - margin, finite.max() + margin)
    axes.set_ylabel(label)


PANELS: dict[str, tuple[str, Callable[[Any, list[tuple[int, Result]]], None]]] = {
    "spectrum": ("Velocity spectra of the resonators", _spectra),
    "bands": ("Third octaves of the resonators' velocities", _bands),
    "level": ("Levels in time", _levels)}
# what follows such a panel, where a result has a microphone
HEARD: dict[str, tuple[str, Callable[[Any, list[tuple[int, Result]]], None]]] = {
    "bands": ("Third octaves of the sound pressure at the first microphone", _bands_heard),
    "level": ("Sound pressure in time, at the first microphone", _levels_heard)}


def _names(results: Sequence[Result]) -> list[str]:
    """File names; numbers before those that are the same."""
    names = [literal(result.path.stem) for result in results]
    return [f"{i + 1}: {name}" if names.count(name) > 1 else name for i, name in enumerate(names)]


def _key(results: Sequence[Result], names: list[str]) -> list[Line2D]:
    texts = [f"{name}: " + (f"{result.level:.2f} {DECIBEL}" if math.isfinite(result.level) else
                            "at rest" if result.analysis()["v_rms"] == 0 else "no level")
             + (f"; at {plots.microphone_words(heard)}" if (heard := _heard(result)) else "")
             for name, result in zip(names, results)]
    return [Line2D([], [], marker=MARKS[i], ms=5, lw=1.4, label=text, **_marker(i))
            for i, text in enumerate(texts)]


def _why_empty(result: Result, kind: str) -> str:
    """Why a result is not in this panel; empty where it is."""
    if not kind.startswith("heard "):
        return plots.why_empty(result, kind)
    heard = _heard(result)
    if heard is None:
        return "no microphone that hears it"
    drawn = heard["bands"]["centre"] if kind == "heard bands" else heard["history"]["mean_square"]
    return "" if drawn else "the sound is too short"


def plot(results: Result | Sequence[Result], what: str = "overview", *, start: float | None = None,
         stop: float | None = None) -> Picture:
    """Several results over one another, as a matplotlib Figure: "spectrum", "bands", "level", or
    "overview", which has all three. The first eight are drawn. Results with a microphone
    (`Result.with_microphones`, or the scene's) also have the sound pressure at the first one, in
    "bands" and "level". `start`, `stop` [s]: of this stretch of the runs alone.

    >>> import ra2d
    >>> slow, fast = [ra2d.run("dang2012", speed=v, duration=0.02, tolerance=1e-6)
    ...               for v in (0.1, 0.2)]
    >>> len(ra2d.plot([slow, fast]).axes)
    3
    """
    results = [results] if isinstance(results, Result) else list(results)
    if not results or not all(isinstance(result, Result) for result in results):
        raise RequestError("a picture takes one or more results of ra2d.run or ra2d.load")
    if what not in ("overview", *PANELS):
        raise RequestError(
            f"there is no picture {what!r} of several results. There are: overview, "
            f"{', '.join(PANELS)}")
    drawn = [stretch.of(result, start, stop) for result in results[:MOST]]
    names = _names(drawn)
    panels, hears = [], any(map(_heard, drawn))
    for kind in PANELS if what == "overview" else [what]:
        panels.append((kind, *PANELS[kind]))
        if hears and kind in HEARD:
            panels.append((f"heard {kind}", *HEARD[kind]))
    head = f"{len(results)} results" + (f", the first {MOST} of them"
                                        if len(results) > MOST else "")
    head += stretch.words(drawn[0])
    lines = [(head, 13.0, "bold", BLACK)]
    lines += [(f"{name}: {literal(plots.doubts(result))}", 9.5, "normal", RUST)
              for name, result in zip(names, drawn) if plots.doubts(result)]
    handles = _key(drawn, names)
    columns = 2 if max(len(handle.get_label()) for handle in handles) < 62 else 1
    key = 0.2 * math.ceil(len(drawn) / columns) + 0.1
    with matplotlib.rc_context(style.RC):
        figure, body = style.page(10, 4 * len(panels) + key, lines)
        upper, lower = body.subfigures(2, 1, height_ratios=[key, 4 * len(panels)])
        upper.legend(handles=handles, loc="upper left", ncol=columns, handlelength=4.5,
                     frameon=False)
        for cell, (kind, title,
                   draw) in zip(np.atleast_1d(lower.subfigures(len(panels), 1)), panels):
            axes = cell.subplots()
            without = {name: why for name, result in zip(names, drawn)
                       if (why := _why_empty(result, kind))}
            shown = [(i, result) for i, (name, result) in enumerate(zip(names, drawn))
                     if name not in without]
            words = "; ".join(f"{name}: {why}" for name, why in without.items())
            if not shown:
                style.say_empty(axes, words, title)
                continue
            draw(axes, shown)
            axes.set_title(title)
            if without:
                axes.text(0.01, 0.04, f"not drawn: {words}", transform=axes.transAxes,
                          color=GREY, fontsize=8)
        return figure
