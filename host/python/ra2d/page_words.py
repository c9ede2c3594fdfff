# SPDX-License-Identifier: BSD-3-Clause
"""Words and numbers of pages: texts from outside, quantities, and the facts of a scene."""
from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup, escape

from .scenes import UNITS

_CONTROLS = re.compile(
    "[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")
_TEXTS = re.compile(
    r'"""(?P<long>.*?)"""' r"|'''(?P<plain_long>.*?)'''"            # of many lines
    r'|"(?P<quoted>(?:\\.|[^"\\\n])*)(?:"|$)' r"|'(?P<plain>[^'\n]*)(?:'|$)"
    r"|(?P<comment>\#[^\n]*)",
    re.DOTALL | re.MULTILINE)
_FOLDERS = re.compile(r"(?<=')/[^'\n]*/(?=[^'/\n]+')" r"|^/[^:'\n]*/(?=[^:/\n]+:)"
                      r"|(?<![^\s(])/(?:[^\s/']+/)+(?=[^\s/'])", re.MULTILINE)
_IN_COMMENT = re.compile(r"""(["'`])(/(?:[^"'`\n]*/)?)[^"'`/\n]+\1""")


# ---- texts from outside
# ----------------------------------------------------------------------------

def printable(text: str, lines: bool = False) -> str:
    r"""A text in which characters that turn its direction or hide in it are spelled out; `lines`:
    ends of lines stay.

    >>> printable("a\u202eb\n"), printable("a\n", lines=True), printable("\udcff")
    ('a\\u202Eb\\u000A', 'a\n', '\\xFF')
    """
    def shown(found: re.Match[str]) -> str:
        code = ord(found[0])
        if lines and code in (0x09, 0x0A):
            return found[0]
        return f"\\x{code - 0xDC00:02X}" if 0xDC80 <= code <= 0xDCFF else f"\\u{code:04X}"

    return _CONTROLS.sub(shown, text)


def shortened(text: str, most: int) -> str:
    """At most so many characters of a text."""
    return text if len(text) <= most else text[:most] + "..."


def without_folders(toml: str) -> str:
    """A document in which files are named without their folders: they are nobody else's business.

    >>> print(without_folders("path = '/home/ann/face.csv'  # was '/home/ann/old.csv'"))
    path = 'face.csv'  # was 'old.csv'
    """
    def bare(found: re.Match[str]) -> str:
        if found["comment"]:
            return _IN_COMMENT.sub(lambda inner: inner[0].replace(inner[2], "", 1), found[0])
        text = next(part for part in found.groups() if part is not None)
        inner = text.lstrip("\r\n")  # which TOML leaves out
        name = inner.rsplit("/", 1)[-1]
        return found[0].replace(inner, name, 1) if inner.startswith("/") and name else found[0]

    return _TEXTS.sub(bare, toml)


def message_without_folders(message: str) -> str:
    """A message in which files are named without their folders: in quotes, before the colon that
    follows the file's name at the beginning of a line, or as a word.

    >>> message_without_folders("/home/ann b/c.csv: 2 m long; cannot read '/home/d e/f.toml'")
    "c.csv: 2 m long; cannot read 'f.toml'"
    """
    return _FOLDERS.sub("", message)


# ---- numbers
# -----------------------------------------------------------------------------------------

def number(value: float | None, digits: int = 3) -> Markup:
    """A number as people write it; powers of ten where it is small or large.

    >>> str(number(-0.25)), str(number(7.2134e-4)), str(number(None))
    ('−0.25', '7.21\\xa0×\\xa010<sup>−4</sup>', '–')
    """
    if value is None or math.isnan(value):
        return Markup("\u2013")
    if math.isinf(value):
        return Markup("\u221e" if value > 0 else "\u2212\u221e")
    small = value != 0 and abs(value) < 1e-3
    text = f"{value:.{digits - 1}e}" if small else f"{value:.{digits}g}"
    if abs(value) < 1e6 and "e+" in text:
        text = f"{float(text):.0f}"
    base, _, power = text.partition("e")
    base = f"{float(base):g}" if power else base
    raised = (f"\u00a0\u00d7\u00a010<sup>{str(int(power)).replace('-', chr(0x2212))}</sup>"
              if power else "")
    return Markup(base.replace("-", "\u2212") + raised)


def html(form: str, *values: object) -> Markup:
    """A text with values in it, which are escaped unless they are markup."""
    return Markup(form).format(*(value if isinstance(value, Markup) else printable(str(value))
                                 for value in values))


def spread(found: Mapping[str, float | None], one: float, unit: str) -> Markup:
    """Median and the middle 80 % of a quantity of the shocks. `one`: what one of the unit is."""
    median, low, high = (None if found[key] is None else found[key] / one  # type: ignore[operator]
                         for key in ("median", "p10", "p90"))
    return html("median {} {}; eight of ten from {} to {}", number(median), unit, number(low),
                number(high))


def with_unit(key: str, value: Any, digits: int = 3, prefix: str = "", one: float = 1) -> Markup:
    """A value of a scene's key with its unit. Texts and tables stay as they are written."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return html("{}", value)
    unit = UNITS[key.rsplit(".", 1)[-1]].replace("^3", "\u00b3")
    return html("{} {}{}", number(value / one, digits), prefix, unit)


def _length(key: str, value: Any) -> Markup:
    """A length, with a prefix that suits its size."""
    if isinstance(value, int | float) and 0 < abs(value) < 0.9995:
        return with_unit(key, value, 4,
                         *(("m", 1e-3) if abs(value) >= 0.9995e-3 else ("\u00b5", 1e-6)))
    return with_unit(key, value, 4)


# ---- what was requested
# ------------------------------------------------------------------------------------

def _random_face(face: Mapping[str, Any]) -> Markup:
    text = html("random, {} correlation, Rq {}", face.get("correlation", "gaussian"),
                _length("rq", face["rq"]))
    text += Markup("").join(html(", {} {}", name, _length(key, face[key])) for key, name in (
        ("rsm", "RSm"), ("rsm_y", "RSm across"), ("correlation_length", "correlation length"))
                            if key in face)
    text += Markup("").join(html(", {} {}", name, number(face[key])) for key, name in (
        ("hurst", "Hurst exponent"), ("skewness", "skewness"), ("kurtosis", "kurtosis"))
                            if key in face)
    return text + html(", seed {}", face.get("seed", 1))


def _face(face: Mapping[str, Any]) -> Markup:
    kind = face.get("kind", "flat")
    if kind == "gaussian":
        return _random_face(face)
    if kind == "file":
        return html("measured: {}", os.path.basename(str(face["path"])))
    if kind == "peaks":
        count = len(face["peaks"])
        return html("{} peak{}", count, "s" if count != 1 else "")
    return html("{}", kind)


def _body(body: Mapping[str, Any], kind: str = "beam") -> Markup:
    sizes = [html("{} {}", _length(key, body[key]), word)
             for key, word in (("length", "long"), ("thickness", "thick"), ("width", "wide"))
             if key in body]
    text = html("{} {}, {}", body["support"], kind, Markup(", ").join(sizes))
    if body["support"] == "rigid":
        return text
    if kind == "block":
        return text + html("; {}", with_unit("density", body["density"], 4))
    text += html("; {}, {}, damping ratio {}", with_unit("young", body["young"], 4, "G", 1e9),
                 with_unit("density", body["density"], 4), number(body["damping"]))
    if kind == "plate":
        text += html("; Poisson's ratio {}", number(body["poisson"]))
    if "max_frequency" in body:
        text += html("; modes up to {}",
                     with_unit("max_frequency", body["max_frequency"], 3, "k", 1e3))
    if "modes" in body:
        text += html("; {} elastic modes", body["modes"])
    return text


def requested(scene: Mapping[str, Any]) -> list[tuple[str, Markup]]:
    """The facts of a complete scene: names and texts."""
    run, slider, resonator = scene["scene"], scene["slider"], scene["resonator"]
    contact, time, output = scene["contact"], scene["time"], scene["output"]
    load = slider.get("load", 0.0)
    areal = run.get("kind") == "areal"
    kinds = ("plate", "block") if areal else ("beam", "beam")
    rows = [
        ("sliding", html("{} at {}, from {} on", with_unit("duration", run["duration"], 4),
                         with_unit("speed", run["speed"]), _length("start", run["start"]))),
        ("resonator", _body(resonator, kinds[0])),
        ("its face", _face(resonator.get("surface", {}))),
        ("slider", _body(slider, kinds[1])), ("its face", _face(slider.get("surface", {}))),
        ("load", html("its weight") if load == "weight" else with_unit("load", load)),
        ("contact", html("penalty, {}", with_unit("stiffness", contact["stiffness"]))
         if contact.get("law", "penalty") == "penalty"
         else html("Lagrange multipliers: no penetration")),
        ("spacing", html("{} along, {} across; the slider's side at {}",
                         _length("spacing", run["spacing"]),
                         _length("spacing_y", run["spacing_y"]), _length("side", run["side"]))
         if areal else _length("spacing", run["spacing"])),
        ("time scheme", html("{}, tolerance {}", time["scheme"], number(time["tolerance"]))
         if time["scheme"] == "adaptive" else html("{}, steps of {}", time["scheme"],
                                                   with_unit("step", time["step"]))),
        ("samples", html("{}; counted from {} on", with_unit("rate", output["rate"], 4, "k", 1e3),
                         with_unit("from", output.get("from", 0.0))))]
    return rows + [("moving force", html("{} at {}{}", with_unit("force", force["force"]),
                                         with_unit("speed", force["speed"]),
                                         html(", {} across", _length("y", force["y"]))
                                         if "y" in force else ""))
                   for force in resonator.get("moving_force", [])]
