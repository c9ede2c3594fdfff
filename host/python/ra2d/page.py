# SPDX-License-Identifier: BSD-3-Clause
"""Pages to keep or to send (docs/report.md): complete in themselves, for a telephone and in the dark, too."""
from __future__ import annotations

import math
import os
import pathlib
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import jinja2
from markupsafe import Markup

from . import files, plots, study_plot
from .errors import RequestError
from .style import DECIBEL, GREY, SERIES, Picture, quantity, unit_text

if TYPE_CHECKING:
    from .results import Result
    from .sound import Sound
    from .studies import Study

PICTURES = ("spectrum", "bands", "level", "shocks", "profiles")
LONGEST_CLIP, LONGEST_SLOW = 5.0, 1.0  # s of the run: as it is, and 20 times slower
MUCH_ENERGY = 0.05                     # of what went through
COLOURS = ("blue", "rust", "plum", "sky", "black", "green", "amber", "moss")


def _svg(picture: Picture) -> Markup:
    """A picture within the page. Its colours are names, which the page gives by day and by night."""
    text = picture.drawn("svg").decode()
    text = text[text.index("<svg"):]
    text = re.sub(r' id="[A-Za-z0-9.]+_\d+"', "", text)              # ids that two pictures would share
    text = re.sub(r"fill: #ffffff(?=[;\"])", "fill: var(--paper)", text)
    text = re.sub('fill="(?:white|#ffffff)"', 'style="fill: var(--paper)"', text)  # behind hatches
    for colour, name in [*zip(SERIES, COLOURS), (GREY, "faint")]:
        text = text.replace(colour, f"var(--{name})")
    return Markup(re.sub(r'(<svg[^>]*?) (?:height|width)="[^"]*"', r"\1", re.sub(
        r'(<svg[^>]*?) (?:height|width)="[^"]*"', r"\1", text, 1), 1))


def _scene_text(text: str) -> str:
    """Profiles by their names alone: folders are nobody else's business."""
    return re.sub(r'(path = ")([^"]*)"', lambda found: f'{found[1]}{os.path.basename(found[2])}"', text)


def _interval(low: float | None, high: float | None, digits: str) -> str:
    return "" if low is None or high is None or math.isnan(low) else f"95 %: {low:{digits}} to {high:{digits}}"


def _figures(result: Result) -> list[tuple[str, str, str]]:
    """Name, value and remark of each figure."""
    found, level, rate = result.analysis(), result.level, result.shock_rate
    shocks, energy, bands = found["shocks"], found["energy"], result.bands()
    rows = [("vibration level", f"{level:.2f} {DECIBEL}" if math.isfinite(level) else "none",
             _interval(level.low, level.high, ".1f") or level.note)]
    if found["v_rms"]:
        rows.append(("root mean square velocity", quantity(found["v_rms"], "m/s", 4),
                     "of the resonator's elastic motion"))
    if rate > 0:
        digits = ".0f" if rate >= 1000 else ".3g"
        rows.append(("shocks", f"{rate:{digits}} a second", _interval(rate.low, rate.high, digits)))
        rows += [(name, quantity(shocks[key]["median"], unit),
                  f"median; nine of ten up to {quantity(shocks[key]['p90'], unit)}")
                 for key, name, unit in (("duration", "duration of a shock", "s"), ("peak_force", "peak force", "N"),
                                         ("impulse", "impulse", "N s"))]
    if found["contact_share"] is not None:
        rows.append(("in contact", f"{100 * found['contact_share']:.3g} %", "of the time"))
    if found["v_rms"] and bands.sizes["frequency"]:
        loudest = bands.isel(frequency=int(bands.level.values.argmax()))
        rows.append(("loudest third octave", f"{float(loudest.level):.1f} dB", f"at {loudest.nominal.item()} Hz"))
    rows += [(name, quantity(energy[key], "W"), remark) for key, name, remark in (
        ("sliding_power", "power of sliding", "put in"), ("load_power", "power of loads", "put in"),
        ("damping_power", "power of damping", "lost")) if energy[key] is not None]
    if energy["closure"] is not None:
        rows.append(("energy balance", f"{energy['closure']:.1e}", "is missing, of what went through"))
    return rows


def _doubts(result: Result) -> list[str]:
    found, doubts = result.analysis(), [plots.doubts(result)] if plots.doubts(result) else []
    closure, tone = found["energy"]["closure"], found["mesh_tone"]
    if closure is not None and closure > MUCH_ENERGY:
        doubts.append(f"{100 * closure:.0f} % of the energy is unaccounted for.")
    if found["aliased_modes"]:
        doubts.append(f"{found['aliased_modes']} modes lie above half the rate of the samples: their power stands at "
                      "frequencies not theirs. A higher output.rate helps.")
    if tone["stands_out"]:
        doubts.append(f"A tone at {quantity(tone['frequency'], 'Hz')} (speed/spacing) stands {tone['rise']:.1f} dB "
                      "above its surroundings: it belongs to the spacing, not to the surface.")
    return doubts


def _damping(result: Result) -> list[tuple[str, str, str, str]]:
    """Mode, natural frequency, resonance and damping, of the modes whose damping is known."""
    return [(str(peak["mode"]), f"{peak['natural_frequency']:.1f}", f"{peak['resonance']:.1f}",
             f"{peak['damping']:.4f} \u00b1 {peak['damping_error']:.4f}")
            for peak in result.analysis()["peaks"] if peak["damping"] is not None]


def _clips(result: Result) -> list[tuple[str, Sound]]:
    """The first probe as it is and slower, on one full scale."""
    if not result.probes.sizes["position"] or not result.analysis()["v_rms"]:
        return []
    begin = result.analysis()["from"]
    plain = result.listen(start=begin, stop=min(result.duration, begin + LONGEST_CLIP))
    slow = result.listen(start=begin, stop=min(result.duration, begin + LONGEST_SLOW), slow=20, rate=8000,
                         full_scale=plain.about["full_scale_m_per_s"])
    return [("as it is", plain), ("20 times slower", slow)]


def _require_page(path: pathlib.Path) -> None:
    """Nothing but a page is replaced. Asked before the work."""
    files.require_folder(path)
    if path.suffix.lower() not in (".html", ".htm"):
        raise RequestError(f"{str(path)!r}: expected a name that ends in .html")


def _render(**parts: Any) -> str:
    """Fills the page."""
    environment = jinja2.Environment(loader=jinja2.PackageLoader("ra2d", "."), autoescape=True, trim_blocks=True,
                                     lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    text: str = environment.get_template("page.html").render(parts)
    return text


def of_result(result: Result, path: pathlib.Path) -> pathlib.Path:
    """Writes the page of one result."""
    _require_page(path)
    files.write(path, results_text([result]))
    return path


def of_study(study: Study, path: pathlib.Path) -> pathlib.Path:
    """Writes the page of a study."""
    _require_page(path)
    files.write(path, study_text(study))
    return path


def results_text(results: Sequence[Result], command: str = "") -> str:
    """The page of results."""
    result = results[0]
    a = result.attrs
    return _render(title=result.title,
                  subtitle=f"{result.path.name}: {result.duration:g} s of sliding, {a['steps']} steps",
                  doubts=_doubts(result), figures=_figures(result), damping=_damping(result), clips=_clips(result),
                  pictures=[_svg(plots.result(result, what, for_page=True)) for what in PICTURES], paper="", table=None,
                  texts=[("the scene", _scene_text(str(a["scene"])))],
                  end=f"ra2d {a['version']} ({a['commit']}), {a['started']}")


def study_text(study: Study, command: str = "") -> str:
    """The page of a study."""
    a, means = study.attrs, study.means()
    try:
        law = study.law()
        figures = [(f"exponent of {name}", f"{float(e):.3f}", _interval(e.low, e.high, ".3f"))
                   for name, e in law.exponents.items()]
        figures.append(("law", f"R\u00b2 = {law.r_squared:.4f}", law.about["straight_line"]["says"]))
    except RequestError as why:
        figures = [("law", "none", str(why))]
    failed = [f"{a['failed']} of {a['runs']} runs failed."] * bool(a["failed"])
    units = means.attrs["units"] | {name: unit_text(study[name].units) for name in means.index.names if name in study}
    heads = {name: f"{name} [{unit}]" for name, unit in units.items() if unit}
    table = means.reset_index().rename(columns=heads).to_html(index=False, float_format="{:.5g}".format, border=0,
                                                              na_rep="")
    return _render(title=f"study: {study.folder.name}", subtitle=f"{a['done']} of {a['runs']} runs done",
                  doubts=failed, figures=figures, damping=[], clips=[],
                  pictures=[_svg(study_plot.picture(study, for_page=True))], paper="light",
                  table=Markup(table),
                  texts=[("the study", _scene_text(str(a["study"]))), ("its base", _scene_text(str(a["base"])))],
                  end=f"ra2d {a['version']} ({a['commit']})")
