# SPDX-License-Identifier: BSD-3-Clause
"""The error budget of a scene: how well level, rate and duration of its shocks are known."""
from __future__ import annotations

import dataclasses
import html
import math
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from .errors import RequestError
from .estimate import Estimate
from .scenes import Scene, scene
from .studies import Study, study

ASKED = "as asked"
CHANCE = "chance"
# variable of the study, its name and unit, and whether it is compared by ratios
_QUANTITIES = {"level": ("dB re 1 nm/s", False), "shock_rate": ("1/s", True), "shock_duration_median": ("s", True)}


@dataclasses.dataclass(frozen=True)
class Budget:
    """How well a scene's numbers are known.

    - `level` [dB re 1 nm/s], `shock_rate` [1/s], `shock_duration` [s]: means over the seeds, each
      with the interval of the whole
    - `table`: a row for each source. `chance`: half of the 95 % interval of the mean over the
      seeds. The others: by how much the mean moves when the source is changed as the row says, and
      95 % of chance in that (`_chance`). Level in dB; rate and duration in hundredths of the natural
      logarithm: small ones are per cent, -42 is a factor of exp(-0.42) = 0.66
    - `dominant`: for each quantity the source that moves it most
    - `study`: the runs, with a dimension `name` for the sources

    The interval of the whole adds chance and shifts as squares.

    >>> import ra2d
    >>> budget = ra2d.uncertainty(ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6), seeds=3)
    >>> budget.level.unit, budget.table.attrs["units"]["shock_rate"]
    ('dB re 1 nm/s', 'ln/100')
    """

    level: Estimate
    shock_rate: Estimate
    shock_duration: Estimate
    table: pd.DataFrame
    dominant: dict[str, str]
    study: Study

    def __repr__(self) -> str:
        lines = [f"{name:15}{getattr(self, name)!r}, mostly {self.dominant[name]}"
                 for name in ("level", "shock_rate", "shock_duration")]
        heads = {name: f"{name} [{unit}]" for name, unit in self.table.attrs["units"].items()}
        table = self.table.rename(columns=heads).to_string(float_format="{:.2g}".format, na_rep="")
        return "\n".join([*lines, "", table])

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"


def _cases(complete: Mapping[str, Any]) -> dict[str, tuple[str, dict[str, Any]]]:
    """Each source: what is done to it, and the keys with their other values."""
    time, contact = complete["time"], complete["contact"]
    cases: dict[str, tuple[str, dict[str, Any]]] = {}
    if time["scheme"] == "adaptive":
        cases["tolerance"] = ("a tenth", {"time.tolerance": max(time.get("tolerance", 1e-8) / 10, 1e-13)})
    else:
        cases["step"] = ("half", {"time.step": time["step"] / 2})
    cases["spacing"] = ("half", {"scene.spacing": complete["scene"]["spacing"] / 2})
    bodies = [body for body in ("resonator", "slider") if complete[body]["support"] != "rigid"]
    modes: dict[str, Any] = {f"{body}.max_frequency": 1.5 * complete[body]["max_frequency"]
                             for body in bodies if "max_frequency" in complete[body]}
    modes |= {f"{body}.modes": math.ceil(1.5 * complete[body]["modes"]) for body in bodies if "modes" in complete[body]}
    if modes:
        cases["modes"] = ("half as many more", modes)
    if contact["law"] == "penalty" and not isinstance(contact["stiffness"], str):
        cases["stiffness"] = ("twice", {"contact.stiffness": 2 * contact["stiffness"]})
    return cases


def _require_chance(complete: Mapping[str, Any]) -> None:
    """Of faces that are not random every seed is the same run."""
    if not any("seed" in complete[body].get("surface", {}) for body in ("resonator", "slider")):
        raise RequestError("chance is seen in runs of other faces, and neither face of this scene is random. Describe "
                           "a measured face by its roughness, as {'slider.surface': ra2d.surface.gaussian(rq=..., "
                           "rsm=..., seed=1)}. Or let the slider start elsewhere: ra2d.study(scene, "
                           "{'start': [0.05, 0.06, 0.07]}) shows the scatter over parts of one face")


def _run(what: Scene, cases: Mapping[str, tuple[str, dict[str, Any]]], seeds: int, **options: Any) -> Study:
    """All cases in one study. The scene's name tells them apart."""
    complete = what.complete()
    keys = list(dict.fromkeys(key for _, changed in cases.values() for key in changed))
    asked = {key: complete[key.split(".")[0]].get(key.split(".")[1], 1e-8) for key in keys}
    values = [[ASKED, *asked.values()]]
    values += [[name, *{**asked, **changed}.values()] for name, (_, changed) in cases.items()]
    return study(what, {("scene.name", *keys): values}, seeds, **options)


def _half(values: npt.NDArray[np.float64], student: float) -> float:
    """Half of the 95 % interval of the mean over the seeds."""
    return student * float(values.std(ddof=1)) / math.sqrt(values.size)


def uncertainty(source: str | os.PathLike[str] | Mapping[str, Any] | Scene, seeds: int = 5, *,
                folder: str | os.PathLike[str] | None = None, threads: int | None = None, show: bool = True) -> Budget:
    """The error budget of a scene: it runs `seeds` pairs of random faces as asked, then the same
    with a finer tolerance (or step), a finer spacing, more modes and a stiffer contact. At least
    one face must be random. The same call goes on where it was cut off.

    - `source`: a scene, or what `ra2d.scene` takes
    - `folder`: where the study is kept; without it in the current folder, SCENE-uncertainty

    >>> import ra2d
    >>> budget = ra2d.uncertainty(ra2d.scene("dang2012").change(duration=0.05, tolerance=1e-6), seeds=3)
    >>> budget.table.index.tolist()
    ['chance', 'tolerance', 'spacing', 'modes', 'stiffness']
    >>> budget.level.low < budget.level < budget.level.high
    True
    """
    if seeds < 2:
        raise RequestError(f"seeds = {seeds}: chance is seen in the difference of two runs or more (five are good)")
    what = scene(source)
    complete = what.complete()
    _require_chance(complete)
    cases = _cases(complete)
    runs = _run(what, cases, seeds, folder=folder or f"{what.title}-uncertainty", threads=threads, show=show)
    asked = runs.means().loc[ASKED]
    # Student's factor, as the program has used it for the interval of the level
    error = float(runs.level.sel(name=ASKED).std("seed", ddof=1)) / math.sqrt(seeds)
    student = (float(asked["level_high"]) - float(asked["level"])) / error if error else math.nan
    rows = {CHANCE: f"{seeds} seeds", **{name: how for name, (how, _) in cases.items()}}
    table = pd.DataFrame({"changed to": rows}).reindex(rows)
    found: dict[str, Estimate] = {}
    dominant: dict[str, str] = {}
    for variable, (unit, by_ratio) in _QUANTITIES.items():
        name = variable.removesuffix("_median")
        by_name = {case: runs[variable].sel(name=case).values for case in (ASKED, *cases)}
        if by_ratio:
            by_name = {case: np.log(values) for case, values in by_name.items()}
        base, percent = by_name.pop(ASKED), 100.0 if by_ratio else 1.0
        shifts = {case: values - base for case, values in by_name.items()}
        table[name] = pd.Series({CHANCE: percent * _half(base, student),
                                 **{case: percent * float(shift.mean()) for case, shift in shifts.items()}})
        table[f"{name}_chance"] = pd.Series({case: percent * _half(shift, student) for case, shift in shifts.items()})
        reach = math.sqrt(float((table[name] ** 2).sum(skipna=False))) / percent
        mean = float(base.mean())
        value, low, high = (math.exp(end) if by_ratio else end for end in (mean, mean - reach, mean + reach))
        found[name] = Estimate(value, low, high, unit, "chance and shifts, as squares")
        dominant[name] = str(table[name].abs().idxmax()) if table[name].notna().any() else "unknown"
    table.attrs["units"] = {"level": "dB", "shock_rate": "ln/100", "shock_duration": "ln/100"}
    return Budget(found["level"], found["shock_rate"], found["shock_duration"], table, dominant, runs)
