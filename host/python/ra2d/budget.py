# SPDX-License-Identifier: BSD-3-Clause
"""The error budget of a scene: how well level, rate and duration of its shocks are known."""
from __future__ import annotations

import dataclasses
import html
import json
import math
import os
import pathlib
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from . import files, program
from .errors import RequestError, kept_notices, notice
from .estimate import Estimate
from .realisations import BODIES, Face, has_measured_map, of_scene
from .scenes import Scene, scene
from .student import half_interval
from .studies import Study, study

AS_GIVEN = "as asked"
CHANCE = "chance"
PAIRED = 3  # realisations that each source is tried on: shifts of pairs scatter little
# the quantity, its variable in the study, its unit, whether it is compared by ratios, and what it
# is called
QUANTITIES = (("level", "level", "dB re 1 nm/s", False, "level"),
              ("shock_rate", "shock_rate", "1/s", True, "rate of shocks"),
              ("shock_duration", "shock_duration_median", "s", True, "duration of a shock"))
UNITS = {"level": "dB", "shock_rate": "ln/100", "shock_duration": "ln/100"}
_SECONDS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


@dataclasses.dataclass(frozen=True)
class Budget:
    """How well a scene's numbers are known.

    - `level` [dB re 1 nm/s], `shock_rate` [1/s], `shock_duration` [s, median]: means over the
      realisations, each with the interval of the whole
    - `table`: a row for each source. `chance`: half of the 95 % interval of the mean over the
      realisations. The others: by how much the mean moves when the source is changed as the row
      says, and 95 % of chance in that (`_chance`); both with twice the step where that is stable
      (where it is not for more modes, they have the scene's own step, or half of it). Level in dB;
      rate and duration in hundredths of the natural logarithm: small ones are per cent, -42 is a
      factor of exp(-0.42) = 0.66
    - `realisations`: a row for each pair of faces: the `kind` of either face, and
      `distribution_error`, of surrogates: by how much their sorted heights are off, as a share of
      Rq
    - `runs`: a row for each run: `source`, `realisation`, the three quantities, and `message`, why
      a run has none
    - `dominant`: for each quantity the source that moves it most
    - `notes`: what is missing, and why
    - `study`: the runs as `ra2d.study` keeps them

    The interval of the whole adds chance and shifts as squares.

    >>> import ra2d
    >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
    >>> budget = ra2d.uncertainty(scene, seeds=3)
    >>> budget.level.unit, budget.table.attrs["units"]["shock_rate"]
    ('dB re 1 nm/s', 'ln/100')
    >>> budget.realisations["slider"].tolist()
    ['seed 1', 'seed 1001', 'seed 2001']
    """

    level: Estimate
    shock_rate: Estimate
    shock_duration: Estimate
    table: pd.DataFrame
    realisations: pd.DataFrame
    runs: pd.DataFrame
    dominant: dict[str, str]
    notes: list[str]
    study: Study

    def text(self) -> str:
        """The text that `ra2d uncertainty` prints.

        >>> import ra2d
        >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
        >>> budget = ra2d.uncertainty(scene, seeds=3)
        >>> print(budget.text().splitlines()[0])                       # doctest: +ELLIPSIS
        level                ... dB re 1 nm/s (95 %: ...), mostly ...
        """
        lines = [f"{words:21}{getattr(self, name)!r}" + (f", mostly {self.dominant[name]}"
                                                         if name in self.dominant else "")
                 for name, _, _, _, words in QUANTITIES]
        heads = [f"{words} [{'dB' if not ratio else '%'}]"
                 for _, _, _, ratio, words in QUANTITIES]
        lines += ["",
                  "chance: half of the 95 % interval; below it shifts, each \u00b1 95 % of chance "
                  "(%: 100 ln of the ratio)",
                  f"{'':10} {'changed to':17}" + "".join(f"{head:>30}" for head in heads)]
        for source, row in self.table.iterrows():
            cells = [_cell(row[name], row[f"{name}_chance"], str(source))
                     for name, *_ in QUANTITIES]
            lines.append(f"{source:10} {row['changed to']:17}"
                         + "".join(f"{cell:>30}" for cell in cells))
        lines += ["", "faces"] + [f"  {number}: " + ", ".join(f"{body} {kind}"
                                                              for body, kind in kinds.items())
                                  for number, kinds in self._kinds().items()]
        worst = float(self.realisations["distribution_error"].max())
        if worst > 0:
            lines.append("  surrogates have the spectrum of the face; their sorted heights differ "
                         "from its own by "
                         f"{100 * worst:.2g} % of Rq at most")
        return "\n".join([*lines, *(["", *self.notes] if self.notes else [])])

    def _kinds(self) -> dict[int, dict[str, str]]:
        bodies = [name for name in self.realisations if name != "distribution_error"]
        return {int(number): {str(body): str(row[body]) for body in bodies}
                for number, row in self.realisations.iterrows()}

    def to_dict(self) -> dict[str, Any]:
        """The budget as nested dicts in SI units, for JSON; None for what does not exist.

        >>> import ra2d
        >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
        >>> budget = ra2d.uncertainty(scene, seeds=3)
        >>> sorted(budget.to_dict())
        ['dominant', 'notes', 'quantities', 'realisations', 'runs', 'sources']
        """
        quantities = {}
        for name, *_ in QUANTITIES:
            found: Estimate = getattr(self, name)
            quantities[name] = {"value": float(found), "low": found.low, "high": found.high,
                                "unit": found.unit,
                                "note": found.note}
        sources = [{"source": str(source), "changed_to": row["changed to"],
                    **{name: {"shift": row[name], "chance": row[f"{name}_chance"],
                              "unit": UNITS[name]}
                       for name, *_ in QUANTITIES}} for source, row in self.table.iterrows()]
        realisations = [{"number": number, "faces": kinds,
                         "distribution_error":
                         float(self.realisations.loc[number, "distribution_error"])}
                        for number, kinds in self._kinds().items()]
        found_dict: dict[str, Any] = _without_nan(
            {"quantities": quantities, "dominant": self.dominant, "sources": sources,
             "realisations": realisations,
             "runs": self.runs.to_dict("records"), "notes": self.notes})
        return found_dict

    def to_json(self) -> str:
        """`to_dict` as text.

        >>> import ra2d
        >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
        >>> budget = ra2d.uncertainty(scene, seeds=3)
        >>> budget.to_json().splitlines()[1]
        '  "quantities": {'
        """
        return json.dumps(self.to_dict(), ensure_ascii=False, indent=2, allow_nan=False)

    def to_csv(self, path: str | os.PathLike[str]) -> pathlib.Path:
        """Writes `table` as CSV, its units in the heads. Returns where it is.

        >>> import ra2d
        >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
        >>> budget = ra2d.uncertainty(scene, seeds=3)
        >>> budget.to_csv("budget.csv").name
        'budget.csv'
        """
        place = pathlib.Path(path)
        files.write(place, self.csv())
        return place

    def csv(self) -> str:
        """`table` as text, its units in the heads.

        >>> import ra2d
        >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
        >>> budget = ra2d.uncertainty(scene, seeds=3)
        >>> budget.csv().splitlines()[0].split(",")[:3]
        ['source', 'changed to', 'level_dB']
        """
        heads = {f"{name}{end}": f"{name}{end}_{unit}" for name, unit in UNITS.items()
                 for end in ("", "_chance")}
        return str(self.table.rename(columns=heads).to_csv(index_label="source"))

    def __repr__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text())}</pre>"


def _cell(shift: float, chance: float, source: str) -> str:
    if math.isnan(shift):
        return "unknown"
    if source == CHANCE:
        return _short(shift, 2)
    return f"{'+' if shift >= 0 else '-'}{_short(abs(shift), 2)} \u00b1 {_short(chance, 1)}"


def _short(value: float, digits: int) -> str:
    """So many digits, more before the point, four behind it at most, and no power of ten.

    >>> _short(34.2, 1), _short(9.96, 1), _short(0.0123, 1), _short(1e-5, 1)
    ('34', '10', '0.01', '0.0000')
    """
    if not math.isfinite(value):
        return "unknown"
    if value == 0:
        return "0"
    if value < 10 ** digits:  # 9.96 becomes 10 before its digits are counted
        value = float(f"{value:.{digits}g}")
    decimals = digits - 1 - math.floor(math.log10(value))
    return f"{value:.{min(max(decimals, 0), 4)}f}"


def _without_nan(of: Any) -> Any:
    """Plain Python for JSON: None in the place of what is no finite number."""
    if isinstance(of, Mapping):
        return {str(name): _without_nan(value) for name, value in of.items()}
    if isinstance(of, list | tuple):
        return [_without_nan(value) for value in of]
    if isinstance(of, np.generic):
        of = of.item()
    return None if isinstance(of, float) and not math.isfinite(of) else of


def _largest_step(plan: str) -> float:
    """The smallest of the limits that `ra2d plan` says of the scheme [s]; 0 where it says none."""
    _, _, stability = plan.partition("\nstability ")
    line = next((line for line in stability.splitlines() if line.lstrip().startswith("> ")), "")
    limits = [float(number) * _SECONDS[unit]
              for number, unit in re.findall(r"([\d.e+-]+) (ns|us|ms|s)\b", line)]
    return min(limits, default=math.inf if "every step" in line else 0.0)


def _other_step(what: Scene, step: float) -> tuple[str, dict[str, Any]]:
    """Twice the step costs a quarter of half of it, and moves a scheme of first order by its whole
    error instead of half. Half the step is taken near the limit of stability, or of the samples."""
    try:
        plan = what.change({"time.step": 2 * step}).plan()
    except RequestError:
        plan = ""
    if plan and 4 * step <= _largest_step(plan):
        return "twice", {"time.step": 2 * step}
    return "half", {"time.step": step / 2}


def _plan_of(what: Scene) -> dict[str, Any]:
    with program.scratch() as folder:
        found: dict[str, Any] = program.ask("plan", what.file(folder), *what.options())
    return found


def _with_counted_modes(what: Scene) -> Scene:
    """The scene with the numbers of its elastic modes, also where it says up to which frequency:
    frequencies of a beam go as the square of the number, those of a plate as the number."""
    plan = _plan_of(what)
    return what.change({f"{body}.modes": plan[body]["elastic_modes"] for body in BODIES
                        if plan[body]["elastic_modes"] > 0})


def _refusal(what: Scene, changed: Mapping[str, Any]) -> str:
    """Why the program would not run the scene with these values; empty where it would."""
    try:
        with kept_notices():  # of runs that may not be made
            plan = _plan_of(what.change(changed))
    except RequestError as fault:
        return str(fault).splitlines()[-1].strip()  # the first ones name the file and the faults
    return next((str(note) for note in plan["notes"] if "'ra2d run' refuses" in note), "")


def _other_modes(what: Scene, complete: Mapping[str, Any],
                 cases: Mapping[str, tuple[str, dict[str, Any]]]
                 ) -> tuple[dict[str, tuple[str, dict[str, Any]]], list[str]]:
    """The source of truncation beside the other `cases`, with what to say of it. More modes have
    higher frequencies: where they do not bear the step of the other sources, they are compared at
    the scene's own, or at half of it. A third fewer are taken where there is no room for more.
    `complete` has numbers of modes."""
    counts = {f"{body}.modes": complete[body]["modes"] for body in BODIES
              if complete[body]["support"] != "rigid" and complete[body].get("modes", 0) > 0}
    if not counts:
        return {}, ["modes: neither body has elastic ones; what more of them would show is not in "
                    "this budget"]
    # whole numbers: 1.5 n and 2/3 n in floating point may be just above one
    more: dict[str, Any] = {key: (3 * count + 1) // 2 for key, count in counts.items()}
    fewer: dict[str, Any] = {key: (2 * count + 2) // 3 for key, count in counts.items()}
    tries = [more]
    if "step" in cases:
        how, other = cases["step"]
        tries.append({**more, "time.step": complete["time"]["step"] if how == "twice"
                      else other["time.step"]})
    why = ""
    for changed in tries:
        found = {"modes": ("1.5 times as many", changed)}
        why = _refusal(what, _values("modes", {**cases, **found}))
        if not why:
            return found, []
    if fewer == counts:
        return {}, ["modes: 1.5 times as many cannot be run, and they are too few to leave out a "
                    f"third: {why}"]
    return ({"modes": ("a third fewer", fewer)},
            [f"modes: 1.5 times as many cannot be run, so there are a third fewer: {why}"])


def _cases(what: Scene, complete: Mapping[str, Any]
           ) -> tuple[dict[str, tuple[str, dict[str, Any]]], list[str]]:
    """Each source: what is done to it, and the keys with their other values; and notes."""
    time, contact = complete["time"], complete["contact"]
    cases: dict[str, tuple[str, dict[str, Any]]] = {}
    if time["scheme"] == "adaptive":
        cases["tolerance"] = ("a tenth",
                              {"time.tolerance": max(time.get("tolerance", 1e-8) / 10, 1e-13)})
    else:
        cases["step"] = _other_step(what, time["step"])
    spacings = ("spacing", "spacing_y") if "spacing_y" in complete["scene"] else ("spacing",)
    cases["spacing"] = ("half", {f"scene.{key}": complete["scene"][key] / 2 for key in spacings})
    modes, notes = _other_modes(what, complete, cases)
    cases |= modes
    if contact["law"] == "penalty" and not isinstance(contact["stiffness"], str):
        cases["stiffness"] = ("twice", {"contact.stiffness": 2 * contact["stiffness"]})
    return cases, notes


def _reference(source: str, cases: Mapping[str, tuple[str, Any]]) -> str:
    """The runs that a source's own are compared with: those with the same step. Where twice the
    step is stable, both take it: their difference hardly feels the step, and costs half."""
    if source == "step" or "step" not in cases:
        return AS_GIVEN
    how, other = cases["step"]
    own = cases[source][1].get("time.step")
    is_other = how == "twice" if own is None else own == other["time.step"]
    return "step" if is_other else AS_GIVEN


def _values(source: str, cases: Mapping[str, tuple[str, dict[str, Any]]]) -> dict[str, Any]:
    """The keys that a source's runs change, with their values."""
    reference = _reference(source, cases)
    return {**(cases[reference][1] if reference != AS_GIVEN else {}), **cases[source][1]}


def _run(what: Scene, cases: Mapping[str, tuple[str, dict[str, Any]]], faces: list[list[Face]],
         **options: Any
         ) -> Study:
    """All runs in one study. The scene's name tells them apart."""
    complete = what.complete()
    keys = list(dict.fromkeys(key for _, changed in cases.values() for key in changed))
    settings = {key: complete[key.split(".")[0]].get(key.split(".")[1], 1e-8) for key in keys}
    sources: dict[str, dict[str, Any]] = {AS_GIVEN: {}}
    sources |= {name: _values(name, cases) for name in cases}
    values = []
    for source, changed in sources.items():
        for number, pair in enumerate(faces if source == AS_GIVEN else faces[:PAIRED], 1):
            values.append([_name(source, number), *{**settings, **changed}.values(),
                           *(face.value for face in pair)])
    return study(what, {("scene.name", *keys, *(face.key for face in faces[0])): values}, **options)


def _name(source: str, number: int) -> str:
    return f"{source} {number}"


def _runs(table: Study, sources: list[str]) -> pd.DataFrame:
    """A row for each run."""
    rows = []
    for name in table["name"].values.tolist():
        source, _, number = str(name).rpartition(" ")
        one = table.sel(name=name).squeeze()
        rows.append({"source": source, "realisation": int(number),
                     **{quantity: float(one[variable]) for quantity, variable, *_ in QUANTITIES},
                     "message": str(one["message"].item()) if one["status"].item() else ""})
    found = pd.DataFrame(rows)
    order = {source: i for i, source in enumerate(sources)}
    return found.sort_values(["source", "realisation"], key=lambda of: of.map(order)
                             if of.name == "source" else of,
                             ignore_index=True)


def _by_realisation(runs: pd.DataFrame, source: str, quantity: str) -> pd.Series[float]:
    found: pd.Series[float] = runs[runs.source == source].set_index("realisation")[quantity]
    return found


def _logarithms(values: pd.Series[float]) -> pd.Series[float]:
    """NaN of what has none."""
    return np.log(values.where(values > 0))


def _notes(runs: pd.DataFrame) -> list[str]:
    found = []
    for source, of in runs[runs.message != ""].groupby("source", sort=False):
        found.append(f"{source}: {len(of)} of {(runs.source == source).sum()} runs failed: "
                     f"{of.message.iloc[0]}")
    return found


def _finite(values: pd.Series[float]) -> npt.NDArray[np.float64]:
    found: npt.NDArray[np.float64] = values.to_numpy(dtype=float)
    finite: npt.NDArray[np.float64] = found[np.isfinite(found)]
    return finite


def uncertainty(source: str | os.PathLike[str] | Mapping[str, Any] | Scene, seeds: int = 5, *,
                folder: str | os.PathLike[str] | None = None, threads: int | None = None,
                show: bool = True) -> Budget:
    """The error budget of a scene. It runs `seeds` realisations of its faces as asked, then three
    of them with another tolerance (or step), a finer spacing, more modes and a stiffer contact. The
    same call continues it.

    Realisations of a random face are other seeds. Of a measured one they are other stretches of its
    trace or map where it is large enough, then its mirror images, then surrogates: the same
    spectrum with other phases, and nearly the same heights (`Budget.realisations`). All are of the
    heights as they stand in a run, filtered and levelled. A mirror image keeps its highest
    asperities, and a surrogate the amplitude of each wave: both scatter less than other traces
    would.

    - `source`: a scene, or what `ra2d.scene` takes
    - `folder`: where the study is kept; without it in the current folder, SCENE-uncertainty
    - `threads`: all processors without it

    >>> import ra2d
    >>> scene = ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6)
    >>> budget = ra2d.uncertainty(scene, seeds=3)
    >>> budget.table.index.tolist()
    ['chance', 'tolerance', 'spacing', 'modes', 'stiffness']
    >>> budget.level.low < budget.level < budget.level.high
    True
    """
    if isinstance(seeds, bool) or not isinstance(seeds, int | np.integer):
        raise RequestError(f"seeds = {seeds!r}: expected a whole number, 2 or more")
    if seeds < 2:
        raise RequestError(
            f"seeds = {seeds!r}: chance is seen in the difference of two runs or more (five are "
            "good)")
    what = scene(source)
    place = pathlib.Path(folder or f"{what.title}-uncertainty").resolve()
    files.require_folder(place)
    with kept_notices() as messages:
        what = _with_counted_modes(what)
        complete = what.complete()
        varied, faces = of_scene(what, complete, int(seeds), place / "faces")
        cases, notes = _cases(what, complete)
        table = _run(varied, cases, faces, folder=place, threads=threads, show=show)
    for message in dict.fromkeys(messages):  # plans and study say the same of a scene
        if "failed (--retry-failed" not in message:  # which the notes tell
            notice(message)
    runs = _runs(table, [AS_GIVEN, *cases])
    if has_measured_map(complete):
        notes.append("spacing: between the points of a measured map stands their spline; what "
                     "finer points would show is not in this budget")
    return _of_runs(runs, cases, faces, table, notes)


def _of_runs(runs: pd.DataFrame, cases: Mapping[str, tuple[str, dict[str, Any]]],
             faces: list[list[Face]],
             table_of: Study, notes: Sequence[str] = ()) -> Budget:
    rows = {CHANCE: f"{len(faces)} realisations", **{name: how for name, (how, _) in cases.items()}}
    table = pd.DataFrame({"changed to": pd.Series(rows, dtype=object)}).reindex(list(rows))
    found: dict[str, Estimate] = {}
    more: list[str] = []
    dominant: dict[str, str] = {}
    for name, _, unit, by_ratio, words in QUANTITIES:
        by_case = {case: _by_realisation(runs, case, name) for case in (AS_GIVEN, *cases)}
        if by_ratio:
            by_case = {case: _logarithms(values) for case, values in by_case.items()}
        base, percent = by_case[AS_GIVEN], 100.0 if by_ratio else 1.0
        shifts = {case: _finite(by_case[case]
                                - by_case[_reference(case, cases)].reindex(by_case[case].index))
                  for case in cases}
        finite_base = _finite(base)
        moved = {case: percent * float(shift.mean()) if shift.size else math.nan
                 for case, shift in shifts.items()}
        table[name] = pd.Series({CHANCE: percent * half_interval(finite_base), **moved},
                                dtype=float)
        # what moves no realisation at all has no effect, and no chance in it
        table[f"{name}_chance"] = pd.Series(
            {case: 0.0 if shift.size and not shift.any() else percent * half_interval(shift)
             for case, shift in shifts.items()}, dtype=float)
        if not finite_base.size:
            found[name] = Estimate(math.nan, unit=unit, note=f"no run has a {words}")
            continue
        total = math.sqrt(float((table[name] ** 2).sum(skipna=False))) / percent
        mean = float(finite_base.mean())
        value, low, high = (math.exp(end) if by_ratio else end
                            for end in (mean, mean - total, mean + total))
        note = "chance and shifts, as squares"
        if finite_base.size > 1 and np.ptp(finite_base) == 0:
            note = "all realisations have the same value, which shows no chance: try more of them"
            more.append(f"{words}: {note}")
        if finite_base.size < len(faces):
            note += f"; {finite_base.size} of {len(faces)} realisations have one"
        found[name] = Estimate(value, low, high, unit, note)
        if table[name].notna().any():
            dominant[name] = str(table[name].abs().idxmax())
    table.attrs["units"] = UNITS
    pairs: list[dict[str, Any]] = [{face.key.split(".")[0]: face.kind for face in pair}
                                   for pair in faces]
    for row, pair in zip(pairs, faces):
        row["distribution_error"] = max(face.distribution_error for face in pair)
    realisations = pd.DataFrame(
        pairs, index=pd.RangeIndex(1, len(faces) + 1, name="realisation"))
    return Budget(found["level"], found["shock_rate"], found["shock_duration"], table, realisations,
                  runs, dominant,
                  [*_notes(runs), *more, *notes], table_of)
