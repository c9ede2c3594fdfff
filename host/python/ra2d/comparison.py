# SPDX-License-Identifier: BSD-3-Clause
"""Differences between two results, or two sets of them, and whether they are more than chance."""
from __future__ import annotations

import contextvars
import dataclasses
import html
import itertools
import json
import math
import os
import pathlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Union

import numpy as np
import numpy.typing as npt
import pandas as pd

from . import toml
from .errors import FileError, RequestError, kept_notices
from .results import Body, Result, load
from .scenes import UNITS, Scene, scene
from .student import Values, for_all, mean_differs, means_differ
from .studies import Study, load_study
from .style import quantity, unit_text

PARTS = 10       # of a run; their scatter gives the chance within it
FEWEST = 8       # parts or pairs with a value that a test within a run needs
OTHER_FACES = "more than chance within these runs, but the faces differ"
NO_SCATTER = "the values do not scatter, and so show no chance"
EQUAL = "both sides have the same values, which show no chance"
NOTHING_OF_CHANCE = "that they agree says nothing about chance."
MARK = 0.05      # a difference that chance makes rarer than this is marked
BANDS = "third octave"

Source = Union[str, "os.PathLike[str]", Result, Scene, Study, Sequence[Any]]


@dataclasses.dataclass(frozen=True)
class _Figure:
    """One number of an analysis. `kind`: "mean" (over time: of its parts it is the mean),
    "median"."""

    name: str
    unit: str
    kind: str
    of: Callable[[Mapping[str, Any]], Any]


def _mean_square(found: Mapping[str, Any]) -> Any:
    v = found["v_rms"]
    return None if v is None else v * v


_FIGURES = (_Figure("level", "dB re 1 nm/s", "mean", _mean_square),
            _Figure("rate of shocks", "1/s", "mean", lambda found: found["shocks"]["rate"]),
            _Figure("duration of a shock", "s", "median",
                    lambda found: found["shocks"]["duration"]["median"]),
            _Figure("peak force", "N", "median",
                    lambda found: found["shocks"]["peak_force"]["median"]),
            _Figure("impulse", "N s", "median", lambda found: found["shocks"]["impulse"]["median"]),
            _Figure("power lost to damping", "W", "mean",
                    lambda found: found["energy"]["damping_power"]),
            _Figure("power put in by sliding", "W", "mean",
                    lambda found: found["energy"]["sliding_power"]))
_IN_STUDIES = (("level", "level", "dB re 1 nm/s"), ("rate of shocks", "shock_rate", "1/s"),
               ("duration of a shock", "shock_duration_median", "s"),
               ("peak force", "peak_force_median", "N"))


@dataclasses.dataclass(frozen=True)
class Comparison:
    """The differences between A and B.

    - `names`: what A and B are called
    - `scene`: a row for each key that differs: `a`, `b`, `unit`; None where a side does not have
      it, a tuple where the results of a list differ in it
    - `answers`: a row for each quantity: `a`, `b`, `unit`; `difference`, b - a in dB for levels,
      and 100 ln(b/a) for others (small ones are per cent); `chance`: how likely chance alone makes
      such a difference or a greater one; `differs`: True where that is below 0.05, None where that
      is not known; `why`: why it is not
    - `bands`: the same of third octaves [dB re 1 nm/s]; their `chance` is that of the whole family
      (Holm): in one of twenty comparisons of equal noises any band is marked
    - `test`: which test was used and how often it raises a false alarm
    - `notes`: what to mind

    >>> import ra2d
    >>> slow, fast = [ra2d.run("dang2012", speed=v, duration=0.3, tolerance=1e-6)
    ...               for v in (0.1, 0.2)]
    >>> found = ra2d.compare(slow, fast)
    >>> found.scene.loc["scene.speed"].tolist()
    [0.1, 0.2, 'm/s']
    >>> found.answers["unit"]["level"]
    'dB re 1 nm/s'
    """

    names: tuple[str, str]
    scene: pd.DataFrame
    answers: pd.DataFrame
    bands: pd.DataFrame
    test: str
    notes: list[str]

    def text(self) -> str:
        """The text that `ra2d compare` prints.

        >>> import ra2d
        >>> print(ra2d.compare("cube.h5", "cube.h5").text().splitlines()[2])
        the scenes are the same
        """
        lines = [f"A: {self.names[0]}", f"B: {self.names[1]}"]
        if self.scene.empty:
            lines.append("the scenes are the same")
        else:
            lines += ["", "the scenes differ in", *_columns([("", "A", "B")] + [
                (f"{key} [{row.unit}]" if row.unit else str(key), _shown(row.a), _shown(row.b))
                for key, row in self.scene.iterrows()])]
        if len(self.answers):
            reasons = [row.why for _, row in self.answers.iterrows() if _is_unknown(row)]
            said_once = len(reasons) > 1 and len(set(reasons)) == 1
            lines += ["", "answers", *_columns([("", "A", "B", "B against A", "p", "")] + [
                (str(name), _value(row.a, row.unit), _value(row.b, row.unit),
                 _change(row.difference, row.unit), _chance(row.chance),
                 "not known" if said_once and _is_unknown(row) else _verdict(row))
                for name, row in self.answers.iterrows()])]
            if said_once:
                lines.append(f"not known: {reasons[0]}")
        if len(self.bands):
            lines += ["", *self._text_of_bands()]
        tests = ["", "p: how likely chance alone makes such a difference", self.test]
        return "\n".join([*lines, *(tests if self.test else []), *self.notes])

    def _text_of_bands(self) -> list[str]:
        tested = int(self.bands.chance.notna().sum())
        marked = self.bands[self.bands.chance < MARK]
        if not tested:
            causes = self.bands.why.value_counts()
            return ["third octaves: not known: " + "; ".join(
                f"{count} of {len(self.bands)}, {why}" if len(causes) > 1 else why
                for why, count in causes.items())]
        if marked.empty:
            return [f"third octaves: none of {tested} differs by more than chance"]
        what = "more than chance," if marked.differs.eq(True).all() else f"{OTHER_FACES}:"
        return [f"third octaves that differ by {what} {len(marked)} of {tested}"] + _columns(
            [("Hz", "A", "B", "B against A", "p")]
            + [(str(name), f"{row.a:.1f} dB", f"{row.b:.1f} dB", f"{row.difference:+.1f} dB",
                _chance(row.chance))
               for name, row in marked.iterrows()])

    def to_dict(self) -> dict[str, Any]:
        """The comparison as nested dicts in SI units, for JSON; None for what does not exist.

        >>> import ra2d
        >>> ra2d.compare("cube.h5", "cube.h5").to_dict()["scene"]
        []
        """
        tables = {name: [{key: _plain(value) for key, value in row.items()}
                         for row in table.reset_index().to_dict("records")]
                  for name, table in (("scene", self.scene), ("answers", self.answers),
                                      ("bands", self.bands))}
        return {"a": self.names[0], "b": self.names[1], **tables, "test": self.test,
                "notes": self.notes}

    def to_json(self) -> str:
        """`to_dict` as text.

        >>> import ra2d
        >>> ra2d.compare("cube.h5", "cube.h5").to_json().splitlines()[1]
        '  "a": "cube.h5",'
        """
        return json.dumps(self.to_dict(), ensure_ascii=False, indent=2, allow_nan=False)

    def __repr__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text())}</pre>"


# ---- words
# -----------------------------------------------------------------------------------------

def _columns(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return ["  " + "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths)).rstrip()
            for row in rows]


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, Mapping):
        return {str(key): _plain(of) for key, of in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(of) for of in value]
    if value is None or isinstance(value, bool | int | str) or (isinstance(value, float)
                                                                and math.isfinite(value)):
        return value
    return None if isinstance(value, float) else str(value)


def _shown(value: Any) -> str:
    if isinstance(value, tuple):  # of a list of results
        text = ", ".join(map(_shown, value))
    elif isinstance(value, float) and math.isfinite(value):  # the fewest digits that mean it
        text = next(short for digits in range(6, 18)
                    if float(short := f"{value:.{digits}g}") == value)
    else:
        text = "-" if value is None else value if isinstance(value, str) else toml.value(value)
    return text if len(text) <= 60 else text[:59] + "\u2026"


def _value(value: float, unit: str) -> str:
    if not math.isfinite(value):
        return "none"
    if unit.startswith("dB"):
        return f"{value:.2f} {unit}"
    return f"{value:.5g} {unit}" if unit.startswith("1/") else quantity(value, unit, 4)


def _change(difference: float, unit: str) -> str:
    if not math.isfinite(difference):
        return ""
    if unit.startswith("dB"):
        return f"{difference:+.2f} dB"
    if 0 < abs(difference) < 0.01:
        return "+ < 0.01 %" if difference > 0 else "- < 0.01 %"
    if abs(difference) < 50:
        return f"{100 * math.expm1(difference / 100):+.2g} %"
    return f"x {math.exp(difference / 100):.3g}"


def _chance(chance: float) -> str:
    if math.isnan(chance):
        return ""
    return "< 0.0001" if chance < 1e-4 else f"{chance:.2g}"


def _is_unknown(row: Any) -> bool:
    return row.differs is None and row.why != OTHER_FACES


def _verdict(row: Any) -> str:
    if row.differs is None:
        return ("more than chance in these runs" if row.why == OTHER_FACES
                else f"not known: {row.why}")
    return "more than chance" if row.differs else "within chance"


# ---- scenes
# -----------------------------------------------------------------------------------------

def _flat(content: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in content.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{above}{name}.")
        else:
            found[f"{above}{name}"] = value
    return found


def _scene_table(a: Mapping[str, Any], b: Mapping[str, Any]) -> pd.DataFrame:
    if not ("program" in a and "program" in b):  # of a scene it is not known
        a, b = ({name: value for name, value in side.items() if name != "program"}
                for side in (a, b))
    one, other = _flat(a), _flat(b)
    keys = [key for key in dict.fromkeys([*one, *other]) if key != "scene.name"
            and one.get(key) != other.get(key)]
    rows = []
    for key in keys:
        sides = [one.get(key), other.get(key)]
        is_number = any(isinstance(side, int | float | list | tuple) and not isinstance(side, bool)
                        for side in sides)
        rows.append({"a": sides[0], "b": sides[1], "unit": UNITS.get(key.rsplit(".", 1)[-1], "")
                     if is_number else ""})
    return pd.DataFrame(rows, index=pd.Index(keys, name="key", dtype=object),
                        columns=["a", "b", "unit"], dtype=object)


def _face(result: Result, body: Body) -> str:
    """A face as text: of a measured one its heights, whatever its file is called."""
    surface = result.scene.content().get(body, {}).get("surface", {})
    if surface.get("kind") != "file":
        return repr(sorted(surface.items()))
    face = result.profile(body).load()
    if face.ndim > 1:  # a map
        return result.height_hash(body)
    places = np.linspace(0, float(face.position[-1]), 1001)
    return repr(np.round(np.interp(places, face.position.values, face.values), 12).tolist())


def _faces(result: Result) -> str:
    """Both faces as text, to know whether two runs have the same ones: profiles or maps."""
    return f"{result.is_areal} {_face(result, 'resonator')} {_face(result, 'slider')}"


def _changed_profiles(a: Result, b: Result) -> list[str]:
    """Profiles of one name whose content is another by now."""
    contents = [result.scene.content() for result in (a, b)]
    bodies: tuple[Body, Body] = ("resonator", "slider")
    return [f"{body}.surface: the name is the same, the measured profile is not." for body in bodies
            if contents[0].get(body, {}).get("surface", {}).get("path") is not None
            and contents[0][body]["surface"] == contents[1].get(body, {}).get("surface")
            and a.profile(body).sizes == b.profile(body).sizes and _face(a, body) != _face(b, body)]


def _path(result: Result, found: Mapping[str, Any]) -> tuple[float, ...]:
    """Where on the resonator the stretch begins and ends, and how long the slider is [m]; NaN of a
    scene that does not say it."""
    content = result.scene.content()
    start, speed, length = (float(content.get(section, {}).get(key, math.nan)) for section, key in
                            (("scene", "start"), ("scene", "speed"), ("slider", "length")))
    return start + speed * found["from"], start + speed * found["to"], length


# ---- chance within a run
# -------------------------------------------------------------------------------

def _widening(result: Result) -> float:
    """By how much ten parts understate the chance of their mean, where the motion forgets as its
    slowest mode does: as the program widens its own interval (host/analysis/level_history.cpp)."""
    found = result.analysis()
    frequencies = [f for f in found["natural_frequencies"] if f > 0]
    damping = found["modal_damping"]
    if not frequencies or not damping:
        return 1.0
    forgotten = 1 / (4 * math.pi * damping * min(frequencies))
    part = (found["to"] - found["from"]) / PARTS

    def variance(seconds: float) -> float:
        a: float = forgotten / seconds
        return 2 * a * (1 + a * math.expm1(-1 / a))

    whole: float = variance(PARTS * part)
    scatter = (variance(part) - whole) / (PARTS - 1)
    return math.sqrt(whole / scatter) if scatter > 0 else 1.0


class _Run:
    """A result with its ten parts."""

    def __init__(self, result: Result) -> None:
        self.result, self.whole = result, result.analysis()
        self.why = _why_untested(self.whole)
        self.has_modes = result.scene.content().get("output", {}).get("modes") != "none"
        self.widening = 1.0 if self.why else _widening(result)
        self.parts: list[dict[str, Any]] = []
        if not self.why:
            rate, first = self.whole["rate"], self.whole["from"]
            edges = np.linspace(0, self.whole["samples"], PARTS + 1).astype(int)
            context = contextvars.copy_context()  # in which notices are kept
            with ThreadPoolExecutor(2) as pool:
                self.parts = list(pool.map(
                    lambda ends: context.copy().run(
                        result.analysis, start=first + ends[0] / rate,
                        stop=first + (ends[1] - 1) / rate),
                    zip(edges, edges[1:])))

    def series(self, kind: str, of: Callable[[Mapping[str, Any]], Any]) -> tuple[float, Values]:
        """The whole's value, and logarithms of the parts whose mean is the whole's logarithm. NaN:
        a part without a value."""
        whole = _finite(of(self.whole))
        parts = np.array([_finite(of(part)) for part in self.parts])
        if not (whole > 0) or not parts.size:
            return whole, np.full(parts.size, math.nan)
        if kind == "mean":  # ln(x) about the mean, to first order: a part may be 0
            middle = float(np.nanmean(parts)) if np.isfinite(parts).any() else math.nan
            return whole, math.log(whole) + (parts / middle - 1 if middle > 0
                                             else np.full(parts.size, math.nan))
        with np.errstate(divide="ignore", invalid="ignore"):
            logs = np.where(parts > 0, np.log(parts), math.nan)
        return whole, logs + math.log(whole) - (float(np.nanmean(logs))
                                                if np.isfinite(logs).any() else 0.0)


def _finite(value: float | None) -> float:
    return math.nan if value is None or not math.isfinite(value) else float(value)


def _why_untested(whole: Mapping[str, Any]) -> str:
    """Why a run is not compared by its parts: of one that has no interval, too, they are no sample
    of what it does. Empty where they are."""
    if whole["lv"] is not None:
        return str(whole["no_interval"] or "")
    if whole["v_rms"] is None:
        return "nothing was counted"
    return "its resonator does not vibrate, whose damping tells how long parts depend on each other"


def _test_of_runs(a: _Run, b: _Run, of: Callable[[_Run], tuple[float, Values]],
                  paired: bool) -> tuple[float, float, float, str]:
    """The values of two runs, the chance of their difference, and why it is not known where it is
    NaN."""
    (x, one), (y, other) = of(a), of(b)
    for side, run, whole, parts in (("A", a, x, one), ("B", b, y, other)):
        if run.why:
            return x, y, math.nan, f"{side}: {run.why}"
        if not whole > 0:
            return x, y, math.nan, f"{side}: the test takes logarithms, and it is not positive"
        if not run.has_modes and not np.isfinite(parts).any():
            return x, y, math.nan, f"{side}: the file has no motion of the modes (output.modes)"
        if np.isfinite(parts).sum() < FEWEST:
            return x, y, math.nan, f"{side}: fewer than {FEWEST} of its ten parts have a value"
    if not paired:
        return x, y, means_differ(one[np.isfinite(one)], other[np.isfinite(other)],
                                  (a.widening, b.widening)), NO_SCATTER
    both = one - other
    finite = both[np.isfinite(both)]
    if finite.size < FEWEST:
        return x, y, math.nan, f"fewer than {FEWEST} of ten pairs of parts have a value"
    # differences of the parts are free of one another: 60 pairs gave 18 alarms of 420
    return x, y, mean_differs(finite), NO_SCATTER if finite.any() else EQUAL


def _row(a: float, b: float, unit: str, difference: float, chance: float,
         why: str) -> dict[str, Any]:
    if math.isfinite(a) != math.isfinite(b):
        why = f"only {'A' if math.isfinite(a) else 'B'} has one"
    elif not math.isfinite(a):
        why = "neither has one"
    elif a == b:
        difference = 0.0
    tested = not math.isnan(chance)
    return {"a": a, "b": b, "unit": unit, "difference": difference, "chance": chance,
            "differs": bool(chance < MARK) if tested else None, "why": "" if tested else why}


def _decibels(square: float) -> float:
    return 10 * math.log10(square) + 180 if square > 0 else math.nan


def _ratio(a: float, b: float) -> float:
    """100 ln(b/a); NaN where there is none."""
    return 100 * math.log(b / a) if a > 0 and b > 0 else math.nan


def _band_of(centre: float, name: str = "level") -> Callable[[Mapping[str, Any]], Any]:
    """The mean square of a third octave in an analysis."""
    def of(found: Mapping[str, Any]) -> float | None:
        bands = found["bands"]
        at = next((i for i, c in enumerate(bands["centre"]) if abs(c / centre - 1) < 1e-6), None)
        level = None if at is None else bands[name][at]
        return None if level is None else 10.0 ** (level / 10)
    return of


def _table(rows: Mapping[str, Mapping[str, Any]], index: str) -> pd.DataFrame:
    columns = ["a", "b", "unit", "difference", "chance", "differs", "why"]
    table = pd.DataFrame(list(rows.values()), index=pd.Index(list(rows), name=index, dtype=object),
                         columns=columns)
    return table.astype({"differs": object, "why": object, "unit": object, "a": float, "b": float,
                         "difference": float, "chance": float})


def _shared_bands(sides: Sequence[Mapping[str, Any]]) -> list[tuple[str, float]]:
    """Third octaves that all have, below the last mode."""
    bands_of: list[dict[str, float]] = []
    for found in sides:
        bands = found["bands"]
        bands_of.append({name: centre for name, centre, above, level in zip(
            bands["nominal"], bands["centre"], bands["above_last_mode"], bands["level"])
                         if not above and level is not None})
    return [(name, centre) for name, centre in bands_of[0].items()
            if all(name in other for other in bands_of[1:])]


def _of_runs(a: Result, b: Result) -> tuple[pd.DataFrame, pd.DataFrame, str, list[str]]:
    one, other = _Run(a), _Run(b)
    same_faces = _faces(a) == _faces(b)
    paired = same_faces and np.allclose(_path(a, one.whole), _path(b, other.whole),
                                        rtol=1e-9, atol=1e-12)

    def compare(unit: str, kind: str, of: Callable[[Mapping[str, Any]], Any]) -> dict[str, Any]:
        x, y, chance, why = _test_of_runs(one, other, lambda run: run.series(kind, of), paired)
        if unit.startswith("dB"):
            x, y = ((_decibels(v) for v in (x, y)) if unit == "dB re 1 nm/s" else (x, y))
            return _row(x, y, unit, y - x, chance, why)
        return _row(x, y, unit, _ratio(x, y), chance, why)

    answers = {figure.name: compare(figure.unit, figure.kind, figure.of) for figure in _FIGURES}
    bands: dict[str, dict[str, Any]] = {}
    for name, centre in _shared_bands([one.whole, other.whole]):
        band = _band_of(centre)
        x, y, chance, why = _test_of_runs(one, other, lambda run: run.series("mean", band), paired)
        low, high = (10 * math.log10(v) if v > 0 else math.nan for v in (x, y))
        bands[name] = _row(low, high, "dB re 1 nm/s", high - low, chance, why)
    _mark_family(bands)
    if not same_faces:
        for row in [*answers.values(), *bands.values()]:
            if row["differs"]:
                row |= {"differs": None, "why": OTHER_FACES}
    test = ("test: Student's t of ten equal parts of each run, "
            + ("in pairs: the same asperities meet in both" if paired else "Welch's for two runs")
            + ". Of twenty quantities that do not differ it marks one, and in one of twenty "
              "comparisons any of the "
              "third octaves (Holm).")
    notes = [] if same_faces else _changed_profiles(a, b) + [
        "The faces differ, and each side is one pair of them: the test knows chance within these "
        "runs alone. Of runs that "
        "differ by their seeds alone it would mark a third of all quantities. Compare runs of "
        "several seeds on both "
        "sides: two studies, or in Python ra2d.compare([a1, a2, ...], [b1, b2, ...])."]
    return _table(answers, "quantity"), _table(bands, "band"), test, notes


def _mark_family(bands: dict[str, dict[str, Any]]) -> None:
    for name, chance in for_all({name: row["chance"] for name, row in bands.items()}).items():
        bands[name]["chance"] = chance
        bands[name]["differs"] = None if math.isnan(chance) else chance < MARK


# ---- chance between runs
# --------------------------------------------------------------------------------

def _test_of_sets(one: Values, other: Values, paired: bool) -> tuple[float, str]:
    """The chance of a difference, and why it is not known where it is NaN."""
    if paired:
        both = one - other
        finite = both[np.isfinite(both)]
        if finite.size < 2:
            return math.nan, "fewer than two pairs have a value"
        return mean_differs(finite), NO_SCATTER if finite.any() else EQUAL
    x, y = one[np.isfinite(one)], other[np.isfinite(other)]
    return means_differ(x, y), NO_SCATTER if min(x.size, y.size) > 1 else (
        "fewer than two runs of a side have a value")


def _mean(values: Values) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else math.nan


def _row_of_sets(x: Values, y: Values, unit: str, paired: bool) -> dict[str, Any]:
    """`x`, `y`: values of the runs. What is not finite, such as the level of a run at rest, is
    none."""
    x, y = (np.where(np.isfinite(side), side, math.nan) for side in (x, y))
    if not unit.startswith("dB"):
        for name, side in (("A", x), ("B", y)):
            if (side == 0).any():  # as the rate of shocks of a run without contact
                return _row(_mean(x), _mean(y), unit, math.nan, math.nan,
                            f"{name}: the test takes logarithms, and a run of it has 0")
        x, y = _logs(x), _logs(y)
    chance, why = _test_of_sets(x, y, paired)
    if paired:
        both = np.isfinite(x) & np.isfinite(y)
        x, y = np.where(both, x, math.nan), np.where(both, y, math.nan)
    low, high = _mean(x), _mean(y)
    if unit.startswith("dB"):
        return _row(low, high, unit, high - low, chance, why)
    return _row(math.exp(low), math.exp(high), unit, 100 * (high - low), chance, why)


def _logs(found: Values) -> Values:
    with np.errstate(divide="ignore", invalid="ignore"):
        logs: Values = np.where(found > 0, np.log(found), math.nan)
    return logs


def _of_sets(a: Sequence[Result], b: Sequence[Result]) -> tuple[pd.DataFrame, pd.DataFrame,
                                                                str, list[str]]:
    by_faces = [{_faces(result): result for result in side} for side in (a, b)]
    paired = len(by_faces[0]) == len(a) == len(b) and set(by_faces[0]) == set(by_faces[1])
    sides = [[result.analysis() for result in side] for side in
             ((list(a), [by_faces[1][_faces(result)] for result in a]) if paired else (a, b))]
    to_db = 10 / math.log(10)

    def compare(unit: str, of: Callable[[Mapping[str, Any]], Any],
                offset: float = 180.0) -> dict[str, Any]:
        x, y = (np.array([_finite(of(found)) for found in side]) for side in sides)
        if unit.startswith("dB"):
            x, y = to_db * _logs(x) + offset, to_db * _logs(y) + offset
        return _row_of_sets(x, y, unit, paired)

    answers = {figure.name: compare(figure.unit, figure.of) for figure in _FIGURES}
    bands = {name: compare("dB re 1 nm/s", _band_of(centre), 0.0)
             for name, centre in _shared_bands([found for side in sides for found in side])}
    _mark_family(bands)
    test = (_test_between(paired, len(a), len(b), "runs")
            + " In one of twenty comparisons it marks any of the third octaves (Holm).")
    return _table(answers, "quantity"), _table(bands, "band"), test, []


def _test_between(paired: bool, a: int, b: int, of: str) -> str:
    how = (f"of {a} pairs of {of} with the same faces" if paired
           else f"of Welch, of {a} and {b} {of}")
    return (f"test: Student's t {how}; A and B are means over them (of logarithms, but "
            "levels). Of twenty quantities that do not differ it marks one.")


def _of_studies(a: Study, b: Study) -> tuple[pd.DataFrame, pd.DataFrame, str, list[str]]:
    names = [str(name) for name in a.sizes if name != "seed"]
    if set(a.sizes) != set(b.sizes):
        raise RequestError(
            f"A varies {', '.join(map(str, a.sizes))} and B {', '.join(map(str, b.sizes))}: two "
            "studies "
                           "are compared where both vary the same keys")
    shared = {str(name): [value for value in a[name].values.tolist()
                          if value in b[name].values.tolist()]
              for name in a.sizes}
    if not all(shared.values()):
        raise RequestError(
            "A and B have no run in common: no combination of values and seed is in both")
    rows: dict[str, dict[str, Any]] = {}
    sides = [side.sel(shared).stack(point=names) if names else side.sel(shared).expand_dims("point")
             for side in (a, b)]
    for i in range(sides[0].sizes["point"]):
        one, other = (side.isel(point=i) for side in sides)
        where = ", ".join(f"{name} = {one[name].item()!s:.12}" for name in names)
        for words, variable, unit in _IN_STUDIES:
            if variable in a and variable in b:
                x, y = (side[variable].values.astype(float).ravel() for side in (one, other))
                rows[f"{words}, {where}" if where else words] = _row_of_sets(x, y, unit, True)
    _mark_family(rows)
    test = (f"test: Student's t of {len(shared['seed'])} pairs of seeds at each of "
            f"{sides[0].sizes['point']} points that "
            "both have. In one of twenty comparisons it marks any of them (Holm).")
    left = [f"{side}: {study.sizes[name] - len(shared[str(name)])} values of {name} are not in the "
            "other"
            for side, study in (("A", a), ("B", b)) for name in study.sizes
            if study.sizes[name] > len(shared[str(name)])]
    if (equal := _equal_runs(*sides)) and a.folder.resolve() != b.folder.resolve():
        runs = len(shared["seed"]) * sides[0].sizes["point"]
        left.append(f"{equal} of {runs} runs have the same values in both: {NOTHING_OF_CHANCE}")
    return _table(rows, "quantity"), _table({}, "band"), test, left


def _equal_runs(one: Any, other: Any) -> int:
    """How many runs are on both sides, as in a copy of a study. Its table has no keys of runs, but
    of two that differ at all no mean square agrees to the last digit; of runs at rest it is 0."""
    if not ("v_rms" in one and "v_rms" in other):
        return 0
    x, y = (side["v_rms"].values for side in (one, other))
    return int(((x == y) & (x > 0)).sum())


# ---- the two sides
# -----------------------------------------------------------------------------------

def _opened(source: Any) -> Any:
    """A result, a scene, a study, or a list of results."""
    if isinstance(source, Result | Scene | Study):
        return source
    if isinstance(source, list | tuple):
        opened = [_opened(one) for one in source]
        if not opened or not all(isinstance(one, Result) for one in opened):
            raise RequestError(
                "a list on one side holds results of ra2d.run or ra2d.load, one or more")
        return opened[0] if len(opened) == 1 else opened
    if isinstance(source, str | os.PathLike):
        path = pathlib.Path(source)
        if path.is_dir():
            return load_study(path)
        if path.suffix in (".h5", ".hdf5") or (path.is_file() and _is_hdf5(path)):
            return load(path)
    return scene(source)


def _is_hdf5(path: pathlib.Path) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(8) == b"\x89HDF\r\n\x1a\n"
    except OSError:
        return False


def _content_of_study(study: Study) -> dict[str, Any]:
    """Base, with what `--set` changed in it, and the study's own text. A table without its folder
    does not know what was set."""
    found = _flat(toml.parse(str(study.attrs["base"])))
    snapshot = study.folder / "study.json"
    try:
        changes = json.loads(snapshot.read_text(encoding="utf-8"))["set"]
        pairs = [(str(key).strip(), text) for key, _, text in
                 (change.partition("=") for change in changes)]
    except FileNotFoundError:
        pairs = []
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as fault:
        why = fault.strerror if isinstance(fault, OSError) else "it is not what 'ra2d study' wrote"
        raise FileError(f"'{snapshot}' cannot be read ({why}): move it away and run the study's "
                        "line again, which writes it anew") from fault
    for key, text in pairs:
        try:
            given = toml.parse(f"value = {text}")["value"]
        except RequestError:
            given = text  # a word, or a number with a unit
        found = {name: value for name, value in found.items() if not name.startswith(f"{key}.")}
        found |= _flat({key: given})
    return found | {"study": toml.parse(str(study.attrs["study"]))}


def _content_of_list(side: Sequence[Result]) -> dict[str, Any]:
    """Of each key the value that all have, or a tuple of the different ones, None where a run does
    not have it: in one order, so that sides with the same seeds do not differ."""
    contents = [_flat(one.scene.content()) for one in side]
    found = {}
    for key in dict.fromkeys(key for content in contents for key in content):
        values = {repr(content.get(key)): content.get(key) for content in contents}
        ordered = tuple(values[text] for text in sorted(values, key=lambda text: (len(text), text)))
        found[key] = ordered[0] if len(ordered) == 1 else ordered
    return found


def _content(side: Any) -> dict[str, Any]:
    if isinstance(side, Scene):
        return side.complete()
    if isinstance(side, Study):
        return _content_of_study(side)
    first = side[0] if isinstance(side, list) else side
    found = _content_of_list(side) if isinstance(side, list) else first.scene.content()
    program = {name: first.attrs[name] for name in ("version", "commit") if name in first.attrs}
    return dict(found) | ({"program": program} if program else {})


def _called(side: Any) -> str:
    if isinstance(side, Result):
        return side.path.name
    if isinstance(side, Study):
        return side.folder.name
    if isinstance(side, Scene):
        return f"the scene {side.title}"
    return (f"{len(side)} results: "
            f"{', '.join(one.path.name for one in side[:3])}{', ...' if len(side) > 3 else ''}")


def _cut_short(name: str, side: Any) -> list[str]:
    return [f"{name}: {one.path.name} was cut short after {quantity(one.duration, 's')}: "
            f"{one.attrs.get('ended')}."
            for one in (side if isinstance(side, list) else [side]) if isinstance(one, Result)
            and not one.complete]


def _key(result: Result) -> str:
    """Equal for results of one run."""
    return str(result.attrs.get("key") or result.path.resolve())


def _results(side: Any) -> list[Result]:
    return side if isinstance(side, list) else [side] if isinstance(side, Result) else []


def _one_run(name: str, side: Any) -> list[str]:
    """Of results that stand for the same run."""
    seen: dict[str, Result] = {}
    notes = []
    for one in _results(side):
        if _key(one) in seen:
            notes.append(f"{name}: {seen[_key(one)].path.name} and {one.path.name} are one run, "
                         "which counts twice: chance looks smaller than it is.")
        seen.setdefault(_key(one), one)
    return notes


def _touched(result: Result) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ends of the part of the resonator that a run touches, along and across it [m]."""
    content = result.scene.content()
    scene, slider = content["scene"], content["slider"]
    start, side = float(scene["start"]), float(scene.get("side", 0.0))
    sliding = float(scene["speed"]) * float(scene["duration"])
    return ((start, start + float(slider["length"]) + sliding),
            (side, side + float(slider["width"])))


def _overlap(one: Result, other: Result) -> bool:
    few = 1e-9  # m: roundings
    return all(max(a[0], b[0]) + few < min(a[1], b[1])
               for a, b in zip(_touched(one), _touched(other)))


def _one_stretch(name: str, side: Any) -> list[str]:
    """Of different runs of a list that touch a part of the same faces."""
    runs = list({_key(one): one for one in _results(side)}.values())
    if len(runs) < 2:
        return []
    by_faces: dict[str, list[Result]] = {}
    for run in runs:
        by_faces.setdefault(_faces(run), []).append(run)
    return [f"{name}: {one.path.name} and {other.path.name} touch a part of the same faces, and "
            "count as independent: chance looks smaller than it is."
            for same in by_faces.values() for one, other in
            [pair for pair in itertools.combinations(same, 2) if _overlap(*pair)][:1]]


def _on_both_sides(one: Any, other: Any) -> list[str]:
    """Of what is compared with itself."""
    if isinstance(one, Study) and one.folder.resolve() == other.folder.resolve():
        shared = "A and B are one study"
    elif isinstance(one, Result) and isinstance(other, Result) and _key(one) == _key(other):
        shared = "A and B are one run"
    elif common := {_key(run) for run in _results(one)} & {_key(run) for run in _results(other)}:
        shared = f"{len(common)} of the runs are on both sides"
    else:
        return []
    return [f"{shared}: {NOTHING_OF_CHANCE}"]


def _answers(one: Any, other: Any) -> tuple[pd.DataFrame, pd.DataFrame, str, list[str]]:
    if isinstance(one, Study):
        return _of_studies(one, other)
    if isinstance(one, Result) and isinstance(other, Result):
        return _of_runs(one, other)
    if isinstance(one, list) and isinstance(other, list):
        return _of_sets(one, other)
    raise RequestError("one side is a single result, the other a list: give several results on "
                       "both sides, of the same seeds if you can")


def compare(a: Source, b: Source) -> Comparison:
    """The differences between A and B in scene and answers, and whether the answers differ by
    more than chance.

    - `a`, `b`: results of `ra2d.run` (or their files); lists of them, of several seeds; studies (or
      their folders); or scenes, whose answers are not known

    Two runs are compared by ten equal parts of each: chance within these runs, of these faces.
    Other faces change the answers by more; lists of runs with several seeds are compared run by
    run, which holds for all faces. Runs of the same faces and the same way are compared in pairs.

    >>> import ra2d
    >>> seeds = [[ra2d.run("dang2012", {"slider.surface.seed": k}, speed=v, duration=0.05,
    ...                    tolerance=1e-6) for k in (1, 2, 3)] for v in (0.1, 0.4)]
    >>> found = ra2d.compare(*seeds)
    >>> bool(found.answers.differs["level"]), found.answers.difference["level"] > 3      # dB
    (True, True)
    """
    one, other = _opened(a), _opened(b)
    is_study = [isinstance(side, Study) for side in (one, other)]
    if any(is_study) and not all(is_study):
        raise RequestError(
            "a study is compared with a study: give results or scenes on both sides, or two "
            "studies")
    table = _scene_table(_content(one), _content(other))
    names = (_called(one), _called(other))
    notes = [note for name, side in (("A", one), ("B", other))
             for note in _cut_short(name, side) + _one_run(name, side) + _one_stretch(name, side)]
    if any(isinstance(side, Scene) for side in (one, other)):
        empty = _table({}, "quantity")
        return Comparison(names, table, empty, _table({}, "band"), "",
                          notes + ["A scene has no answers: run it, and compare the results."])
    with kept_notices():  # of runs that were cut short: the notes have it
        answers, bands, test, more = _answers(one, other)
    return Comparison(names, table, answers, bands, test,
                      notes + _on_both_sides(one, other) + more)
