# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of a page: small ones, each with a text below that says how to read it."""
from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from markupsafe import Markup

from . import maps, page_svg, plots, style, study_plot
from .page_words import html, number, spread
from .style import DECIBEL, MARKS, Picture, quantity

if TYPE_CHECKING:
    from .results import Result
    from .studies import Law, Study

WIDTH, HEIGHT = 3.6, 2.7  # inches: its letters are as large as the page's on a telephone
MOST_PIXELS = 300         # of a map, along each axis
# the marks as letters
LETTERS = dict(zip(MARKS, "\u25cf\u25a0\u25b2\u25c6\u25bc\u271a\u2716\u2605"))


@dataclasses.dataclass(frozen=True)
class Figure:
    """A picture and the text below it."""

    svg: Markup
    caption: Markup


def _small(draw: Callable[[Any], None], height: float = HEIGHT) -> Picture:
    """A small picture without head, titles and legends: the page says in words what they say."""
    with matplotlib.rc_context(style.RC):
        figure, body = style.page(WIDTH, height, [])
        draw(body)
        for axes in figure.axes:
            axes.set_title("")
            if axes.get_legend():
                axes.get_legend().remove()
    return figure


def _svg(figure: Picture, sheet: page_svg.Sheet, about: str) -> Markup:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a browser has the letters
        return page_svg.drawn(figure, sheet, about)


# ---- results
# ---------------------------------------------------------------------------------------

def _spectrum(result: Result) -> tuple[Picture, str, Markup]:
    spectrum, tone = result.spectrum(), result.analysis()["mesh_tone"]
    figure = _small(lambda body: plots.PANELS["spectrum"][0](body, result, False))
    for axes in figure.axes:
        axes.set_xlabel("frequency [Hz]")
        for text in axes.texts:  # which the doubts say
            text.set_visible(text.get_text() == "95 %")
            text.set_x(0.94)
    caption = html("<b>Velocity spectrum</b>, mean over the resonator, a line every {} Hz ({} "
                   "segments). Ticks at the "
                   "top: natural frequencies of the free resonator.", number(spectrum.resolution),
                   spectrum.segments)
    if tone["in_spectrum"]:
        caption += html(" Dashed: speed/spacing, {}{}.", quantity(tone["frequency"], "Hz"),
                        ", the mesh's own tone, not the surface's" if tone["stands_out"] else "")
    if spectrum.low and spectrum.high:
        caption += html(" The bar marked 95 %: where the true density lies around each line, {} to "
                        "{} dB, were the "
                        "noise stationary and Gaussian.", *(number(10 * math.log10(end), 2)
                                                            for end in (spectrum.low,
                                                                        spectrum.high)))
    return figure, "Velocity spectrum of the resonator", caption


def _pressures(result: Result) -> Markup:
    """The lines of microphones in a picture of the vibration, in words."""
    heard = plots.heard_by(result)
    if not heard:
        return Markup("")
    each = "; ".join(f"{LETTERS[MARKS[i]]} at {plots.microphone_words(one)}"
                     for i, one in enumerate(heard))
    return html(" Lines, axis on the right: sound pressure in dB re 20 \u00b5Pa, {}.", each)


def _bands(result: Result) -> tuple[Picture, str, Markup]:
    bands = result.bands()
    names = bands.nominal.values.tolist()
    figure = _small(lambda body: plots.PANELS["bands"][0](body, result, False))
    axes = figure.axes[0]
    step = 6 if len(names) > 18 else 3
    named = [i for i, centre in enumerate(bands.frequency.values)
             if round(10 * math.log10(centre)) % step == 3 % step]
    axes.set_xticks(named, [style.plain_number(float(names[i])) for i in named], rotation=0)
    axes.set_xlabel("midband frequency [Hz]")
    caption = html("<b>Third octaves</b> (IEC 61260-1), mean over the resonator. Bars with ends: "
                   "one standard "
                   "deviation over runs, were the noise stationary and Gaussian.")
    if bands.above_last_mode.any():
        caption += html(" Hollow: above the last mode that was kept, at {}: no information.",
                        quantity(bands.last_mode, "Hz", 4))
    return figure, "Levels in third octaves", caption + _pressures(result)


def _level(result: Result) -> tuple[Picture, str, Markup]:
    figure = _small(lambda body: plots.PANELS["level"][0](body, result, False))
    windows = min(plots.WINDOWS, result.samples // 2)
    caption = html("<b>Level in time</b>, over {} each.", quantity(result.duration / windows, "s"))
    level = result.level
    if math.isfinite(level):
        begin = result.analysis()["from"]
        caption += html(" Dashed: {}, {} dB", f"from {quantity(begin, 's')} on" if begin
                        else "the whole run",
                        f"{level:.1f}")
        caption += html("; shaded: its 95 % interval." if math.isfinite(level.low) else ".")
    return figure, "Level over the time of the run", caption + _pressures(result)


def _histogram(result: Result, kind: tuple[str, str, str],
               heading: str) -> tuple[Picture, str, Markup]:
    key, unit, _ = kind
    shocks = result.analysis()["shocks"]
    name, one = style.scale(unit, shocks[key]["median"])
    figure = _small(lambda body: plots.draw_histogram(body.subplots(), shocks, *kind))
    axes = figure.axes[0]
    axes.set_ylim(0, axes.get_ylim()[1] / 1.3)  # no legend
    caption = html("<b>Shocks: {}.</b> Line: {}. Dashed: nine of ten are below. Ten bins to a "
                   "decade.", heading,
                   spread(shocks[key], one, name))
    return figure, f"Histogram of shocks: {heading}", caption


def _maps(result: Result) -> tuple[Picture, str, Markup]:
    figure = _small(lambda body: maps.faces(body.subplots(2, 1), result, plots.track(result), False,
                                            MOST_PIXELS),
                    1.6 * HEIGHT)
    caption = html("<b>Faces</b>, dark: low, light: high. Above the resonator's under the slider's "
                   "path{}; below the "
                   "slider's, seen through it from above",
                   f", with the places of {len(result.shocks)} shocks"
                   if len(result.shocks) else "")
    return figure, "Faces as maps, and places of contact", caption + html(".")


def _faces(result: Result) -> tuple[Picture, str, Markup]:
    if result.is_areal:
        return _maps(result)
    figure = _small(lambda body: plots.PANELS["profiles"][0](body, result, False), 1.2 * HEIGHT)
    caption = html("<b>Faces</b>, heights much enlarged: the resonator's (blue), where the slider "
                   "passes")
    if "start" in result.scene.content().get("scene", {}):  # not of other versions' scenes
        caption += html(", and above it the slider's at the start, face down (brown)")
    if count := len(result.shocks):
        caption += html(". Below: where the {} shocks fell on the resonator", count)
    return figure, "Faces at the start, and places of contact", caption + html(".")


def _drawn(result: Result) -> Iterator[tuple[Picture, str, Markup]]:
    """Pictures of what there is."""
    shocks = result.analysis()["shocks"]
    for what, draw in (("spectrum", _spectrum), ("bands", _bands), ("level", _level)):
        if not plots.why_empty(result, what):
            yield draw(result)
    for kind, heading in zip(plots.KINDS, ("how long they last", "their peak force")):
        if shocks["count"] and shocks["histograms"][kind[0]]["counts"]:
            yield _histogram(result, kind, heading)
    yield _faces(result)


def of_result(result: Result, sheet: page_svg.Sheet) -> list[Figure]:
    """The pictures of a result that has something to show in them."""
    return [Figure(_svg(figure, sheet, about), caption)
            for figure, about, caption in _drawn(result)]


# ---- studies
# ---------------------------------------------------------------------------------------

def _key(axes: Any, sheet: page_svg.Sheet) -> Markup:
    """The legend in words: each name with its colour or mark."""
    legend = axes.get_legend()
    text = Markup("")
    if not legend:
        return text
    handles = getattr(legend, "legend_handles", None) or legend.legendHandles
    for handle, label in zip(handles, legend.get_texts()):
        name = label.get_text().replace(r"\$", "$")
        mark = handle.get_marker()
        if handle.get_linestyle() != "None":
            text += html(' <span class="name"><b style="color:{}">\u25ac</b> {}</span>',
                         sheet.colour(handle.get_color()), name)
        elif mark in LETTERS:
            text += html(' <span class="name">{} {}</span>', LETTERS[mark], name)
        else:
            text += html("<br>{}:", name)
    legend.remove()
    return text


def _against(study: Study, law: Law | None, name: str, sheet: page_svg.Sheet) -> Figure:
    figure = study_plot.panel(study, law, name, WIDTH, HEIGHT)
    caption = html("<b>Level against {}</b>: means over the seeds with 95 % intervals, which are "
                   "cut at the ends of "
                   "the axis.", name)
    caption += html(" Lines: the law." if law and name in law.exponents else
                    " Lines join what differs in nothing else.")
    caption += _key(figure.axes[0], sheet)
    return Figure(_svg(figure, sheet, f"Level of the study against {name}"), caption)


def of_study(study: Study, law: Law | None, sheet: page_svg.Sheet) -> list[Figure]:
    """A picture for each key with two values or more; none where there are no levels."""
    if not np.isfinite(study.means()["level"]).any():
        return []
    return [_against(study, law, name, sheet) for name in study_plot.varied(study)]
