# SPDX-License-Identifier: BSD-3-Clause
"""Studies: every combination of what is varied, in one table (docs/studies.md)."""
from __future__ import annotations

import contextlib
import copy
import dataclasses
import html
import math
import os
import pathlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from . import files, program, progress, stored, toml
from .errors import FileError, RequestError, SimulationError, notice
from .estimate import Estimate
from .scenes import Scene, full_key, scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARK = "# Written by ra2d.study, which replaces it.\n"
FORMAT = 1  # of a table, that this package reads
_SOUNDS = ("lp", "lpa", "lw", "lwa")
_NUMBERS = ("level", "v_rms", "shock_rate", "shock_duration_median", "peak_force_median", *_SOUNDS,
            "contact_share", "energy_closure", "wall_seconds", "status")
_VARIABLES = (*_NUMBERS, "message", "file")
_ENDS = ("", "_low", "_high")  # of a mean: itself and its interval
_INTERVALS = {"level": ("lv", "dB re 1 nm/s"), "v_rms": ("v_rms", "m/s"),
              "shock_rate": ("shock_rate", "1/s")}
_SOUND_INTERVALS = {"lp": ("lp", "dB re 20 uPa"), "lpa": ("lpa", "dB(A)"),
                    "lw": ("lw", "dB re 1 pW"),
                    "lwa": ("lwa", "dB(A) re 1 pW")}


@dataclasses.dataclass(frozen=True)
class Law:
    """v_rms = factor * x1^e1 * x2^e2 * ..., fitted by the program to all runs of a study. Of sound
    the amplitude is the pressure, or the square root of the power (`about["of"]`).

    - `exponents`: by dimension, each with its 95 % interval by the seeds
    - `constant` [dB]: Lv = sum of 20 e log10 x, and this
    - `deviation` [dB]: from the law to a run; `r_squared`
    - `about`: all that `ra2d analyze --json` says of it

    >>> getfixture("study").law()["speed"] > 0.5
    True
    """

    exponents: dict[str, Estimate]
    constant: float
    deviation: float
    r_squared: float
    about: dict[str, Any]

    def __getitem__(self, name: str) -> Estimate:
        return self.exponents[name]

    def level(self, **point: float) -> float:
        """Level by the law [dB re 1 nm/s, or that of the sound] at a value of each of its
        dimensions, in SI units. RequestError where one is missing, is none of the law, or is not
        positive.

        >>> getfixture("study").law().level(speed=0.3, rq=6e-6) > 100
        True
        """
        if point.keys() != self.exponents.keys() or not all(
                isinstance(value, int | float | np.number) and 0 < value < math.inf
                for value in point.values()):
            raise RequestError(f"the law is of {', '.join(self.exponents)}: expected a number > 0 "
                               f"of each, in SI units, not {point}")
        return self.constant + sum(20 * e * math.log10(point[name])
                                   for name, e in self.exponents.items())

    @property
    def amplitude(self) -> str:
        """What the exponents are of.

        >>> getfixture("study").law().amplitude
        'v_rms'
        """
        return {"v_rms": "v_rms", "lp": "p_rms", "lpa": "p_rms, A-weighted,",
                "lw": "(sound power)^(1/2)",
                "lwa": "(sound power, A-weighted)^(1/2)"}[self.about["of"]]

    def __repr__(self) -> str:
        powers = " ".join(f"{name}^{float(e):.3f}" for name, e in self.exponents.items())
        lines = [f"{self.amplitude} ~ {powers}   (R² = {self.r_squared:.4f}, {self.about['runs']} "
                 "runs)"]
        lines += [f"  {name}: {float(e):.3f}" + ("" if math.isnan(e.low)
                                                 else f", 95 %: {e.low:.3f} to {e.high:.3f}")
                  for name, e in self.exponents.items()]
        return "\n".join([*lines, f"  {self.about['straight_line']['says']}"])

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"


class Study(xr.Dataset):  # type: ignore[no-untyped-call]
    """The table of a study: an xarray Dataset with a dimension for each varied key, then `seed`.
    Variables: `level` [dB re 1 nm/s], `v_rms` [m/s], `shock_rate` [1/s], `shock_duration_median`
    [s], `peak_force_median` [N], `contact_share`, `energy_closure`, `wall_seconds` [s], `status` (0
    done), `message`; with `keep_sound` `lp`, `lpa`, `lw`, `lwa` [dB]. Runs that are missing or
    failed are NaN.

    A dimension that has the name of a method, such as `load`, is `study["load"]`.

    `law`, `means` and `plot` are those of the whole study; a part of it, such as
    `study.sel(speed=0.2)`, has none.

    >>> table = getfixture("study")
    >>> dict(table.sizes)
    {'speed': 3, 'rq': 2, 'seed': 2}
    >>> table.level.mean("seed").sel(speed=0.2).dims
    ('rq',)
    """

    __slots__ = ("_folder", "_answer")

    @classmethod
    def _of(cls, place: pathlib.Path) -> Study:
        """Reads the table, by its folder or itself, and asks the program for means and law."""
        table = _table(place / "results.h5" if place.is_dir() else place)
        made = cls(table.data_vars, table.coords, table.attrs)
        made._folder = place if place.is_dir() else place.parent
        made._answer = program.ask("analyze", place)
        return made

    def _whole(self) -> dict[str, Any]:
        if not hasattr(self, "_answer"):
            raise RequestError(
                "this is a part of a study, or a copy: ask the whole one for its law, means and "
                "picture")
        answer: dict[str, Any] = self._answer
        return answer

    @property
    def folder(self) -> pathlib.Path:
        """Where the study is kept.

        >>> getfixture("study").folder.name
        'small'
        """
        self._whole()
        return pathlib.Path(self._folder)

    def law(self, of: str = "v_rms") -> Law:
        """The power law of v_rms; of "lp", "lpa", "lw" or "lwa" where the study keeps its sound.
        RequestError says why where there is none.

        >>> sorted(getfixture("study").law().exponents)
        ['rq', 'speed']
        """
        answer = self._whole()
        if of != "v_rms" and of not in _SOUNDS:
            raise RequestError(
                f"of = {of!r}: expected 'v_rms', {', '.join(map(repr, _SOUNDS[:-1]))} or "
                f"{_SOUNDS[-1]!r}")
        found = answer["law"] if of == "v_rms" else answer.get("sound_laws", {}).get(of)
        if found is None and of != "v_rms":
            raise RequestError(
                f"this study has no law of {of}: the table holds no sound (keep_sound=True, or "
                "keep = "
                               "[\"sound\"] in its file)")
        if not found or "why_none" in found:
            why = str(found["why_none"] if found else answer["why_no_law"])
            raise RequestError(f"this study has no law: {why.removeprefix('no law: ')}")
        note = "by the seeds" if found["drawn_by"] == ["seed"] and found[
            "seeds"] > 1 else str(found["intervals"])
        exponents = {name: Estimate.of(e["value"], e, "", note)
                     for name, e in found["exponents"].items()}
        return Law(exponents, found["constant_db"], _number(found["deviation_db"]),
                   _number(found["r_squared"]), copy.deepcopy(found))

    def means(self) -> pd.DataFrame:
        """Means over the seeds, a row for each combination: `runs`, then `level` [dB re 1 nm/s],
        `v_rms` [m/s], `shock_rate` [1/s], and the levels of sound that the table has, each with
        `_low` and `_high` of its 95 % interval.

        >>> int(getfixture("study").means().loc[(0.2, 8e-6), "runs"])
        2
        """
        answer = self._whole()
        names = [name for name in answer["dimensions"] if name != "seed"]
        rows, intervals = [], _INTERVALS | {name: its for name, its in _SOUND_INTERVALS.items()
                                            if name in self}
        for point in answer["points"]:
            row = {name: point[name] for name in names} | {"runs": point["runs"]}
            for name, (key, _) in intervals.items():
                found = point.get(key) or {}
                row |= {name: _number(found.get("mean")), f"{name}_low": _number(found.get("low")),
                        f"{name}_high": _number(found.get("high"))}
            rows.append(row)
        figures = [name + end for name in intervals for end in _ENDS]
        table = pd.DataFrame(rows,
                             columns=[*names, "runs",
                                      *figures]).astype(dict.fromkeys(figures, float))
        table.attrs["units"] = {name: unit for name, (_, unit) in intervals.items()}
        return table.set_index(names) if names else table

    def plot(self) -> Figure:  # type: ignore[override]
        """Level against each varied key, with 95 % intervals and the law, as a matplotlib Figure.

        >>> len(getfixture("study").plot().axes)
        2
        """
        from .study_plot import picture

        return picture(self)

    def report(self, path: str | os.PathLike[str] | None = None) -> pathlib.Path:
        """Writes one page: law, picture, means, and the texts of the study. Returns where it is.

        >>> getfixture("study").report("study.html").name
        'study.html'
        """
        from . import page

        return page.of_study(self, pathlib.Path(path or f"{self.folder}.html"))


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _table(path: pathlib.Path) -> xr.Dataset:
    """The table of a study, read whole: it is small."""
    file = stored.File(path)
    attrs = file.attributes()
    damaged = FileError(f"{str(path)!r} is no table of a study, or is damaged")
    if not {"study_format", "dimensions"} <= set(attrs):
        raise damaged
    if str(attrs["study_format"]) != str(FORMAT):
        raise FileError(f"{str(path)!r} has format {attrs['study_format']}, this package reads "
                        f"{FORMAT}: take the package that came with the program")
    if not {"study", "base"} <= set(attrs) or not all(
            str(attrs.get(count)).isdigit() for count in ("runs", "done", "failed")):
        raise damaged
    dims = tuple(str(attrs["dimensions"]).split())
    variables: dict[str, tuple[str, ...]] = {name: (name,) for name in dims}
    variables |= {name: dims for name in _VARIABLES if name not in dims}
    found = file.read("/", variables, gaps=True).load().assign_attrs(attrs)
    if not {"status", "message"} <= set(found) or any(
            found[name].dtype.kind not in "fiu" for name in _NUMBERS if name in found.data_vars):
        raise damaged
    return found


def load_study(folder: str | os.PathLike[str]) -> Study:
    """A study that has been run, by its folder or its table.

    >>> import ra2d
    >>> ra2d.load_study("small").sizes["seed"]
    2
    """
    path = pathlib.Path(folder)
    if not (path / "results.h5").is_file() and not path.is_file():
        raise RequestError(f"{str(folder)!r} is no folder of a study: it holds no results.h5")
    return Study._of(path.resolve())


def _dimensions(vary: Mapping[str | tuple[str, ...],
                              Iterable[Any]]) -> dict[str, tuple[list[str], list[Any]]]:
    """The keys and values of each dimension, by its name in the table."""
    if not isinstance(vary, Mapping):
        raise RequestError(
            f"vary: expected keys with their values, as {{'speed': [0.1, 0.2]}}, not {vary!r}")
    found: dict[str, tuple[list[str], list[Any]]] = {}
    for names, values in vary.items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise RequestError(
                f"{names}: expected a list of values, as [{values!r}], not {values!r}")
        keys = [full_key(name) for name in ([names] if isinstance(names, str) else names)]
        short = keys[0].rsplit(".", 1)[-1]
        name = short if short not in found and short != "seed" else keys[0].replace(".", "_")
        found[name] = (keys, list(values))
        if not found[name][1]:
            raise RequestError(f"{name}: there is no value to vary it over")
    return found


def _study_text(base: pathlib.Path, what: Scene,
                dimensions: Mapping[str, tuple[list[str], list[Any]]],
                seeds: int | Sequence[int], keep: Sequence[str]) -> str:
    lines = [f"base = {toml.value(str(base))}", f"seeds = {toml.value(seeds)}"]
    lines += [f"keep = {toml.value(['level', 'shocks', *keep])}"] * bool(keep)
    lines += ["", "[set]",
              *(f"{toml.key(name)} = {toml.value(value)}" for name, value in what.changes.items())]
    lines += ["", "[vary]", *(f"{name} = {toml.value({'keys': keys, 'values': values})}"
                              for name, (keys, values) in dimensions.items())]
    return _MARK + "\n".join(lines) + "\n"


def _write(path: pathlib.Path, text: str) -> None:
    """Replaces only a study file that was written here."""
    if path.exists() and not files.read(path).startswith(_MARK):
        raise RequestError(f"{str(path)!r} was not written by ra2d.study: give another folder=")
    files.write(path, text)


@contextlib.contextmanager
def _as_it_was_if_refused(*paths: pathlib.Path) -> Iterator[None]:
    """Puts these files back as they were where the study is refused: nothing was run."""
    before = {path: files.read(path) if path.exists() else None for path in paths}
    try:
        yield
    except RequestError:
        for path, text in before.items():
            if text is None:
                path.unlink(missing_ok=True)
            elif files.read(path) != text:
                files.write(path, text)
        raise


def study(source: str | os.PathLike[str] | Mapping[str, Any] | Scene,
          vary: Mapping[str | tuple[str, ...], Iterable[Any]], seeds: int | Sequence[int] = 1, *,
          folder: str | os.PathLike[str] | None = None, keep_files: bool = False,
          keep_sound: bool = False, threads: int | None = None,
          retry_failed: bool = False, max_wall: float | str | None = None,
          show: bool = True) -> Study:
    """Runs every combination of what is varied, on all processors, and returns the table. The same
    call continues it; with more values only what is new is run.

    - `source`: a scene with its changes, or what `ra2d.scene` takes
    - `vary`: values by key, {"speed": [0.1, 0.2]} [m/s]; a tuple of keys varies them together:
      {("resonator.surface.rq", "slider.surface.rq"): [4e-6, 8e-6]} [m]
    - `seeds`: runs of each combination with other random surfaces, or a list of their numbers
    - `folder`: where it is kept; without it in the current folder under scene and dimensions. The
      study's file stands beside it, as FOLDER.toml
    - `keep_files`: keep each run's result in FOLDER/runs; `keep_sound`: the levels of its pressure
      at the scene's microphones and of its sound power; `retry_failed`: run those again
    - `max_wall` [s, or "H:M:S"]: wall time after which OutOfTime is raised

    A Notice names failed runs; they are NaN in the table.

    >>> import ra2d
    >>> base = ra2d.scene("dang2012").change(duration=0.01, tolerance=1e-6, rate=1e4)
    >>> table = ra2d.study(base, vary={"speed": [0.1, 0.2], "load": [0.5, 1.0]}, seeds=2)
    >>> dict(table.sizes), table.speed.units
    ({'speed': 2, 'load': 2, 'seed': 2}, 'm s-1')
    """
    what = scene(source)
    dimensions = _dimensions(vary)
    varied = {key for keys, _ in dimensions.values() for key in keys}
    if "time.tolerance" in varied:
        what = what.change(scheme="adaptive")
    what = what.without(varied)
    place = pathlib.Path(folder or "-".join([what.title, *(dimensions or ["seeds"])])).resolve()
    file = place.with_name(place.name + ".toml")
    with _as_it_was_if_refused(file, place.parent / f"{what.title}.toml"):
        base = what.file(place.parent).resolve()
        _write(file, _study_text(base, what, dimensions, seeds,
                                 ["sound"] * bool(keep_sound) + ["files"] * bool(keep_files)))
        options = program.options({"--threads": threads, "--retry-failed": bool(retry_failed),
                                   "--max-wall": max_wall})
        try:
            with progress.shown(show) as shown:
                program.follow(["study", file, "-o", place, *options], shown)
        except SimulationError as failed:
            notice(failed.args[0])
    return Study._of(place)
