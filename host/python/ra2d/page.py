# SPDX-License-Identifier: BSD-3-Clause
"""Pages to keep or to send (docs/report.md): complete in themselves, for a telephone and in the
dark, too."""
from __future__ import annotations

import dataclasses
import math
import pathlib
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import jinja2
import numpy as np
import pandas as pd
from markupsafe import Markup

from . import files, page_pictures, page_svg, plots, program, study_plot
from .errors import RequestError, kept_notices
from .page_words import (html, message_without_folders, number, printable, requested, shortened,
                         spread, without_folders)
from .results import BODIES
from .style import quantity, unit_text

if TYPE_CHECKING:
    from .results import Result
    from .sound import Sound
    from .studies import Law, Study

LONGEST_CLIP, LONGEST_SLOW, SLOWER = 5.0, 20.0, 20  # s that are heard; times slower
MOST_SOUNDS = 8       # results that have sounds: some 1 MB each
MOST_ROWS = 500       # of the table of means
MOST_MESSAGES = 3     # of failed runs
MOST_WARNINGS = 8     # of a run
MUCH_ENERGY = 0.05    # of the largest term of the balance
LONGEST_TITLE, LONGEST_DOUBT = 200, 300

Facts = list[tuple[str, Markup]]

# Figures of several results: the program's name, the page's, and what one of its unit is.
MEANS = {"lv": ("level Lv, dB re 1 nm/s", 1), "v_rms": ("velocity, rms, mm/s", 1e-3),
         "contact_share": ("share of the time in contact", 1), "shocks.rate": ("shocks, 1/s", 1),
         "shocks.duration.median": ("median duration of shocks, \u00b5s", 1e-6),
         "shocks.peak_force.median": ("median peak force, N", 1),
         "shocks.impulse.median": ("median impulse, \u00b5N s", 1e-6),
         "shocks.simultaneous.mean": ("shocks at once", 1),
         "energy.sliding_power": ("power from sliding, mW", 1e-3),
         "energy.damping_power": ("power to damping, mW", 1e-3),
         "energy.per_shock": ("energy that a shock gives, nJ", 1e-9)}


# ---- figures of a result
# ---------------------------------------------------------------------------

def _level(found: dict[str, Any]) -> Markup:
    if found["v_rms"] is None:
        return Markup("none: nothing was counted")
    if not found["v_rms"]:
        return Markup("\u2212\u221e dB: the resonator did not vibrate")
    text = html("<b>{} dB</b> re 1 nm/s (v<sub>rms</sub> {} m/s)", f"{found['lv']:.2f}",
                number(found["v_rms"]))
    low, high = found["lv_interval"]["low"], found["lv_interval"]["high"]
    if low is None:
        return text + html("; no interval: {}", found["no_interval"])
    return text + html("; 95 %: {} to {} dB, with these surfaces", f"{low:.1f}", f"{high:.1f}")


def _shocks(shocks: dict[str, Any]) -> Facts:
    if not shocks["count"]:
        return [("shocks", Markup("none"))]
    low, high = shocks["rate_interval"]["low"], shocks["rate_interval"]["high"]
    interval = "" if low is None else f"; 95 %: {low:.0f} to {high:.0f}"
    rows = [("shocks", html("<b>{} a second</b> ({} in all){}", f"{shocks['rate']:.0f}",
                            shocks["count"], interval))]
    rows += [(name, spread(shocks[key], one, unit)) for key, name, one, unit in (
        ("duration", "their duration", 1e-6, "\u00b5s"), ("peak_force", "their peak force", 1, "N"),
        ("impulse", "their impulse", 1e-6, "\u00b5N s"))]
    at_once = shocks["simultaneous"]
    return rows + [("at once", html("{} on average, {} at most", number(at_once["mean"]),
                                    at_once["max"]))]


def _loudest(found: dict[str, Any]) -> Facts:
    bands = found["bands"]
    levels = np.array(bands["level"], dtype=float)
    if not found["v_rms"] or not np.isfinite(levels).any():
        return []
    i = int(np.nanargmax(levels))
    return [("loudest third octave", html("{} Hz, {} dB", bands["nominal"][i],
                                          f"{levels[i]:.1f}"))]


def _damping(found: dict[str, Any]) -> Facts:
    """The smallest and the largest damping of all modes that have one."""
    ratios = [peak["damping"] for peak in found["peaks"] if peak["damping"] is not None]
    if not ratios:
        return []
    modal = found["modal_damping"]
    return [("half-power damping", html("{} to {}, of {} of {} modes{}", number(min(ratios)),
                                        number(max(ratios)),
                                        len(ratios), len(found["peaks"]),
                                        "" if modal is None
                                        else html("; modal damping {}", number(modal))))]


def _figures(found: dict[str, Any]) -> Facts:
    """Name and value of each figure."""
    energy = found["energy"]
    rows = [("level Lv", _level(found)), *_shocks(found["shocks"])]
    if energy["per_shock"] is not None:
        rows.append(("energy they give",
                     html("{} nJ each, on average", number(energy["per_shock"] * 1e9))))
    if found["contact_share"] is not None:
        rows.append(("in contact", html("{} % of the time", f"{100 * found['contact_share']:.2f}")))
    rows += _loudest(found) + _damping(found)
    if energy["sliding_power"] is not None:
        rows.append(("power", html("{} W from sliding, {} W from loads, {} W to damping", *(
            number(energy[key]) for key in ("sliding_power", "load_power", "damping_power")))))
    for i, microphone in enumerate(found.get("microphones", []), 1):
        if microphone["lp"] is not None:
            place = ", ".join(f"{x:g}" for x in microphone["position"])
            weighted = Markup("") if microphone["lpa"] is None else \
                html("<b>{} dB(A)</b>, ", f"{microphone['lpa']:.1f}")
            unknown = f"; dB(A) not known: {why}" if (why := microphone["no_lpa"]) else ""
            rows.append((f"microphone {i}",
                         weighted + html("{} dB re 20 \u00b5Pa at {} m{}",
                                         f"{microphone['lp']:.1f}", place, unknown)))
    if energy["closure"] is not None:
        rows.append(("energy balance",
                     html("off by {} of its largest term", number(energy["closure"], 2))))
    return rows


def _peaks(found: dict[str, Any]) -> list[list[Markup]]:
    """Mode, natural frequency, resonance and damping, of the modes whose damping is known."""
    return [[html("{}", peak["mode"]), html("{}", f"{peak['natural_frequency']:.1f}"),
             html("{}", f"{peak['resonance']:.1f}"),
             html("{} \u00b1 {}", f"{peak['damping']:.4f}", f"{peak['damping_error']:.4f}")]
            for peak in found["peaks"] if peak["damping"] is not None]


def _brief(message: str) -> str:
    return shortened(message_without_folders(message), LONGEST_DOUBT)


def _doubts(result: Result, found: dict[str, Any]) -> list[str]:
    """Doubts that a reader should not overlook."""
    closure, aliased, tone, doubts = found["energy"]["closure"], found["aliased_modes"], found[
        "mesh_tone"], []
    if not result.complete:
        why = str(result.attrs.get("ended", "the file does not say why"))
        doubts.append("The run was cut short: " + _brief(why))
    if "beyond_limit" in result.attrs:
        doubts.append("The step is beyond a limit of stability, on request: "
                      + _brief(str(result.attrs["beyond_limit"])))
    if closure is not None and closure > MUCH_ENERGY:
        doubts.append(f"{100 * closure:.0f} % of the energy is unaccounted for.")
    odd = str(result.attrs.get("doubts", "")).splitlines()
    doubts += [f"The scene: {_brief(line)}" for line in odd[:MOST_WARNINGS]]
    # that of the energy is of the whole run: the line above is of what the page shows
    warned = [line for line in str(result.attrs.get("warnings", "")).splitlines()
              if "of the energy is unaccounted for" not in line]
    doubts += [f"The run warned: {shortened(line, LONGEST_DOUBT)}"
               for line in warned[:MOST_WARNINGS]]
    if aliased:
        doubts.append(f"{aliased} mode{' lies' if aliased == 1 else 's lie'} above half the rate "
                      "of the samples: "
                      "spectrum, third octaves and sound have their power in wrong places. A "
                      "higher output.rate mends "
                      "that.")
    if tone["stands_out"]:
        doubts.append(f"The mesh's own tone at {quantity(tone['frequency'], 'Hz')} (speed/spacing) "
                      "stands "
                      f"{tone['rise']:.0f} dB above its surroundings: linear faces make it, smooth "
                      "ones do not.")
    doubts += [f"Microphone {i}: {one['warning']}."
               for i, one in enumerate(found.get("microphones", []), 1) if one["warning"]]
    return doubts


# ---- sounds
# -------------------------------------------------------------------------------------------

def _rate_for(highest: float) -> int:
    """The lowest rate of a sound that carries all that the samples have."""
    return next((rate for rate in (8000, 16000, 24000) if highest < 0.45 * rate), 48000)


def _cuts(result: Result) -> tuple[list[Sound], str]:
    """The first probe as it is and slower; or why there is nothing to hear."""
    found = result.analysis()
    if not result.probes.position.size or found["samples"] < 2:
        return [], "No sound: the result has no probe, or too few samples (output.probes)."
    begin, end = found["from"], found["to"]
    try:
        cuts = [result.listen(start=begin, stop=min(end, begin + LONGEST_CLIP)),
                result.listen(start=begin, stop=min(end, begin + LONGEST_SLOW / SLOWER),
                              slow=SLOWER,
                              rate=_rate_for(found["rate"] / 2 / SLOWER))]
    except RequestError as why:
        return [], f"No sound: {shortened(why.args[0], LONGEST_DOUBT)}"
    if not any(sound.about["peak_m_per_s"] for sound in cuts):
        return [], f"There is nothing to hear: {cuts[0].place()} does not move."
    return cuts, ""


def _heard(result: Result) -> list[Sound]:
    """What the first microphone hears, where there is one."""
    for microphone in plots.heard_by(result)[:1]:
        begin, end = microphone["from"], microphone["to"]
        try:
            return [result.listen(at=[microphone["position"]], start=begin,
                                  stop=min(end, begin + LONGEST_CLIP))]
        except RequestError:  # too few samples
            break
    return []


def _about_heard(result: Result, sound: Sound, full_scale: float) -> Markup:
    """The text above a sound pressure."""
    about, microphone = sound.about, plots.heard_by(result)[0]
    whole = microphone["to"] - microphone["from"]
    text = html("Sound pressure at {} m: {} s to {} s of the run. Full scale is {} Pa.",
                ", ".join(f"{x:g}" for x in microphone["position"]), number(about["from"]),
                number(about["to"]),
                number(full_scale))
    shortened_to = html(" Shortened: all of it would last {} s.", number(whole))
    return text + (shortened_to if len(sound.samples) < 0.999 * whole * sound.rate else Markup(""))


def _about(result: Result, sound: Sound, full_scale: float) -> Markup:
    """The text above a sound."""
    about, found = sound.about, result.analysis()
    if "full_scale_pa" in about:
        return _about_heard(result, sound, full_scale)
    slow, whole = about["slow"], (found["to"] - found["from"]) * about["slow"]
    text = html("<b>{}</b>, {}: {} s to {} s of the run. Full scale is {} m/s.",
                f"{slow:g} times slower" if slow > 1 else "As it is", sound.place(),
                number(about["from"]), number(about["to"]), number(full_scale))
    if len(sound.samples) < 0.999 * whole * sound.rate:
        text += html(" Shortened: all of it would last {} s.", number(whole))
    return text + (html(" What is heard at 1 kHz moves at {} kHz.", f"{slow:g}") if slow > 1
                   else Markup(""))


def _lead(sounds: Sequence[Sound]) -> str:
    """What the sounds are."""
    pressures = sum("full_scale_pa" in sound.about for sound in sounds)
    if not pressures:
        return "The velocity of a place on the resonator; it is no sound pressure."
    if pressures == len(sounds):
        return "The sound pressure at a microphone."
    return ("First the sound pressure at a microphone, then the velocity of a place on the "
            "resonator, which is no pressure.")


def _clips(results: Sequence[Result]) -> list[dict[str, Any]]:
    """The sounds of each result, all pressures and all velocities on one full scale, or why it has
    none. First what a microphone hears."""
    chosen = []
    for result in results[:MOST_SOUNDS]:
        cuts, why = _cuts(result)
        chosen.append((_heard(result) + cuts, why))
    chosen += [([],
                f"Of many results the first {MOST_SOUNDS} alone have their sounds here: ra2d sound "
                "makes them of "
                "any.")] * (len(results) - len(chosen))
    scales: dict[str, float] = {}
    for sound in (sound for cuts, _ in chosen for sound in cuts):
        scales[sound.about["quantity"]] = max(sound.full_scale(),
                                              scales.get(sound.about["quantity"], 0.0))

    def clip(result: Result, sound: Sound) -> tuple[Markup, str]:
        scale = scales[sound.about["quantity"]]
        scaled = dataclasses.replace(sound, samples=sound.samples * (sound.full_scale() / scale))
        return _about(result, sound, scale), scaled.source()

    return [{"why_none": why, "lead": _lead(cuts), "clips": [clip(result, sound) for sound in cuts]}
            for result, (cuts, why) in zip(results, chosen)]


# ---- results
# -------------------------------------------------------------------------------------------

def _requested(result: Result) -> Facts:
    """Facts of the scene. There are none of another version's scene, which has other keys."""
    try:
        return requested(result.scene.content())
    except (LookupError, TypeError, AttributeError, ValueError):
        return []


def _profile(scene: dict[str, Any], body: str) -> str | None:
    """The name of a measured face's file."""
    section = scene.get(body)
    face = section.get("surface") if isinstance(section, dict) else None
    if isinstance(face, dict) and face.get("kind") == "file":
        return pathlib.PurePath(str(face.get("path"))).name
    return None


def _scene_text(result: Result) -> str:
    """The scene to copy. Profiles have the hash of their heights: by it a reader knows the
    files."""
    scene = result.scene.content()
    lines = [f"# {printable(name)}: put it beside this scene. surface/{body}/height in the result: "
             "xxh3_128 "
             f"{result.height_hash(body)}\n" for body in BODIES
             if (name := _profile(scene, body)) is not None]
    return "".join(lines) + without_folders(str(result.attrs["scene"]))


def _origin(attrs: dict[str, Any]) -> str:
    """The program that made a file, and when."""
    started = f", started {attrs['started']}" if "started" in attrs else ""
    return f"ra2d {attrs.get('version', '?')} ({attrs.get('commit', '?')}){started}"


def _section(result: Result, sheet: page_svg.Sheet, sounds: dict[str, Any]) -> dict[str, Any]:
    found = result.analysis()
    return {"title": shortened(result.title, LONGEST_TITLE), "doubts": _doubts(result, found),
            "lead": html("{}, {} s to {} s. {}", result.path.name, number(found["from"], 6),
                         number(found["to"], 6),
                         _origin(result.attrs)),
            "figures": _figures(found), "damping": _peaks(found), "sounds": sounds,
            "has_intervals": found["lv_interval"]["low"] is not None
            or found["shocks"]["rate_interval"]["low"] is not None,
            "pictures": page_pictures.of_result(result, sheet), "requested": _requested(result),
            "scene": _scene_text(result)}


def _comparison(results: Sequence[Result]) -> list[tuple[str, bool, list[Markup]]]:
    """Name, whether it is complete, and figures of each result."""
    rows = []
    for result in results:
        found = result.analysis()
        shocks = found["shocks"]
        duration = shocks["duration"]["median"]
        rows.append((result.path.name, result.complete, [
            number(found["lv"], 5), number(shocks["rate"], 5),
            number(None if duration is None else duration * 1e6),
            number(shocks["peak_force"]["median"])]))
    return rows


def _means(results: Sequence[Result]) -> tuple[list[list[Markup]], list[str]]:
    """Figure, mean, interval and deviation, by the program; doubts of them."""
    answer, rows = program.ask("analyze", *(result.path for result in results)), []
    for key, found in answer["mean"].items():
        name, one = MEANS.get(key, (key, 1))
        mean, low, high, deviation = (None if found[part] is None else found[part] / one
                                      for part in ("mean", "low", "high", "deviation"))
        rows.append([html("{}", name), number(mean, 5),
                     html("{} to {}", number(low, 5), number(high, 5)),
                     number(deviation, 2)])
    doubts = answer["doubts"]
    for result in results:
        doubts = [doubt.replace(str(result.path), result.path.name) for doubt in doubts]
    return rows, doubts


def results_text(results: Sequence[Result], command: str = "") -> str:
    """The page of one result, or of several side by side. `command`: the line that made it, for its
    end."""
    if not results:
        raise RequestError("a page takes one or more results of ra2d.run or ra2d.load")
    with kept_notices():  # the page says it
        sheet, many = page_svg.Sheet(), len(results) > 1
        sections = [_section(result, sheet, sounds)
                    for result, sounds in zip(results, _clips(results))]
        means, doubts = _means(results) if many else ([], [])
        return _page(f"Roughness noise: {len(results)} results" if many else sections[0]["title"],
                     command, sheet,
                     results=sections, comparison=_comparison(results) if many else [],
                     means=means, doubts=doubts, study=None)


def of_results(results: Sequence[Result], path: pathlib.Path, command: str = "") -> pathlib.Path:
    """Writes the page of one result, or of several side by side."""
    _require_page(path)
    files.write(path, results_text(results, command))
    return path


# ---- studies
# -------------------------------------------------------------------------------------------

_AMPLITUDES = {"v_rms": Markup("v<sub>rms</sub>"), "lp": Markup("p<sub>rms</sub>"),
               "lpa": Markup("p<sub>rms</sub>, A-weighted,"), "lw": Markup("\u221aW"),
               "lwa": Markup("\u221aW, A-weighted,")}


def _law_note(law: Law) -> Markup:
    about = law.about
    text = html("Least squares of log {} over {} runs; R\u00b2 = {}", _AMPLITUDES[about["of"]],
                about["runs"],
                f"{law.r_squared:.4f}")
    if math.isfinite(law.deviation):
        text += html(", {} dB from the law to a run", f"{law.deviation:.2f}")
    text += html(".")
    if about["left_out"]:
        text += html(" {} runs without a level are left out.", about["left_out"])
    text += Markup("").join(html(" All values of {} are taken together.", name)
                            for name in about["pooled"])
    return text + html(" {}", _sentence(about["intervals"]))


def _change(of: dict[str, Any]) -> str:
    """How an exponent changes along another key."""
    word = "falls" if of["exponent_to"] < of["exponent_from"] else "rises"
    return (f"The exponent of {of['of']} {word} from {of['exponent_from']:.3f} at {of['along']} = "
            f"{of['from']:g} to "
            f"{of['exponent_to']:.3f} at {of['to']:g}.")


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].removesuffix('.')}."


def _law(law: Law) -> dict[str, Any]:
    powers = Markup("").join(html(" {}<sup>{}</sup>", name, f"{float(e):.3f}")
                             for name, e in law.exponents.items())
    line = law.about["straight_line"]
    return {"formula": html("{} \u221d{}", _AMPLITUDES[law.about["of"]], powers),
            "note": _law_note(law),
            "shape": [_sentence(line["says"]), *map(_change, line["changes"])],
            "bends": line["fits"] is False,
            "exponents": [(name, f"{float(e):.3f}", _between(e.low, e.high, ".3f"))
                          for name, e in law.exponents.items()]}


def _large(value: float, form: str) -> str:
    """A rate; no powers of ten where the whole number is as short."""
    return f"{value:.0f}" if 1000 <= value < 1e7 else f"{value:{form}}"


def _between(low: float, high: float, form: str) -> str:
    return f"{_large(low, form)} to {_large(high, form)}" if math.isfinite(
        low) else "too few runs for one"


def _columns(study: Study, means: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Heads and texts of what was varied; numbers with the prefix that suits the largest."""
    heads, columns = [], []
    for name in _dimensions(study):
        values = means[name].tolist()
        texts = [value for value in values if isinstance(value, str)]
        shown, unit = (texts, "") if texts else study_plot.words(values,
                                                                 unit_text(study[name].attrs.get(
                                                                     "units", "1")))
        heads.append(f"{name}, {unit}" if unit else name)
        columns.append(shown)
    return heads, columns


def _dimensions(study: Study) -> list[str]:
    return [name for name in str(study.attrs["dimensions"]).split() if name != "seed"]


def _rows(study: Study) -> tuple[list[str], list[list[str]], int]:
    """Heads, the rows that are shown, and how many there are."""
    means = study.means().reset_index()
    shown = means.head(MOST_ROWS)
    heads, columns = _columns(study, shown)
    kinds = [("level", ".2f", "Lv, dB"), ("shock_rate", ".4g", "shocks, 1/s")]
    kinds += [(name, ".2f", head)
              for name, head in (("lpa", "pressure, dB(A)"), ("lwa", "power, dB(A) re 1 pW"))
              if name in means and means[name].notna().any()]
    rows = []
    for i, row in enumerate(shown.to_dict("records")):
        rows.append([column[i] for column in columns] + [str(int(row["runs"]))])
        for name, form, _ in kinds:
            there = math.isfinite(row[name])
            interval = _between(row[f"{name}_low"], row[f"{name}_high"], form)
            rows[-1] += [_large(row[name], form) if there else "\u2013",
                         interval if there and row["runs"] > 1 else "\u2013"]
    return [*heads, "runs",
            *(text for _, _, head in kinds for text in (head, "95 %"))], rows, len(means)


def _failures(study: Study) -> list[str]:
    """Messages of the failed runs, the most frequent first. Those that differ only in numbers are
    one."""
    said: dict[str, list[str]] = {}
    for message, status in zip(study.message.values.ravel(), study.status.values.ravel()):
        if status >= 2:
            said.setdefault(re.sub(r"\d[\d.e+-]*", "", str(message)), []).append(str(message))
    if not said:
        return []
    kinds = sorted(said.values(), key=len, reverse=True)[:MOST_MESSAGES]
    return [f"{sum(map(len, said.values()))} of {study.status.size} runs failed.",
            *(f"{len(texts)}: {_brief(texts[0])}" for texts in kinds)]


def _warnings(study: Study) -> list[str]:
    """Warnings of finished runs, the most frequent first."""
    return [f"{one['runs']} of {study.attrs['done']} finished runs (the first: {one['first']}): "
            + _brief(one["text"])
            for one in study._whole()["warnings"][:MOST_MESSAGES]]


def study_text(study: Study, command: str = "") -> str:
    """The page of a study. `command`: the line that made it, for its end."""
    a, law, why = study.attrs, None, ""
    try:
        law = study.law()
    except RequestError as fault:
        why = _sentence(str(fault).removeprefix("this study has "))
    sheet = page_svg.Sheet()
    missing = int(a["runs"]) - int(a["done"]) - int(a["failed"])
    lead = (f"{a['runs']} runs: {a['done']} done, {a['failed']} failed, {missing} missing. "
            f"{_origin(a)}")
    heads, rows, count = _rows(study)
    return _page(f"Study: {study.folder.name}", command, sheet, results=[], comparison=[],
                 means=[], doubts=[], study={
        "lead": lead, "failures": _failures(study) + _warnings(study),
        "law": _law(law) if law else None,
        "why_no_law": why, "sound_laws": [_law(one) for one in study_plot.sound_laws(study)],
        "pictures": page_pictures.of_study(study, law, sheet), "heads": heads, "rows": rows,
        "count": count,
        "study": without_folders(str(a["study"])), "set": without_folders(str(a.get("set", ""))),
        "base": without_folders(str(a["base"]))})


def of_study(study: Study, path: pathlib.Path, command: str = "") -> pathlib.Path:
    """Writes the page of a study."""
    _require_page(path)
    files.write(path, study_text(study, command))
    return path


# ---- the page
# --------------------------------------------------------------------------------------------

def _require_page(path: pathlib.Path) -> None:
    """Nothing but a page is replaced. Asked before the work."""
    files.require_folder(path)
    if path.suffix.lower() not in (".html", ".htm"):
        raise RequestError(f"{str(path)!r}: expected a name that ends in .html")


def _shown(value: object) -> object:
    """Texts from outside as they are shown."""
    return value if isinstance(value,
                               Markup) else printable(str(value).replace("\r\n", "\n"), lines=True)


def _page(title: str, command: str, sheet: page_svg.Sheet, **parts: Any) -> str:
    """Fills the page."""
    environment = jinja2.Environment(loader=jinja2.PackageLoader("ra2d", "."), autoescape=True,
                                     trim_blocks=True,
                                     lstrip_blocks=True, undefined=jinja2.StrictUndefined,
                                     finalize=_shown)
    return environment.get_template("page.html").render(parts, title=title, command=command,
                                                        sheet=sheet,
                                                        made_by=program.call("--version").strip())
