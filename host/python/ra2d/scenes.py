# SPDX-License-Identifier: BSD-3-Clause
"""Scenes: what is simulated (docs/scene.md)."""
from __future__ import annotations

import copy
import difflib
import hashlib
import html
import itertools
import os
import pathlib
import re
from collections.abc import Collection, Mapping
from typing import Any

from . import files, program, toml
from .errors import RequestError, kept_notices, notice

_BODY = ("support length thickness width young density poisson damping max_frequency modes "
         "surface").split()
_FACE = ("kind peaks path x_unit z_unit spacing spacing_y offset_x offset_y decimal row column "
         "fill form cutoff_s filter "
         "cutoff short rq rsm rsm_y correlation_length correlation hurst longest shortest skewness "
         "kurtosis exact seed").split()
# The keys of docs/scene.md, which the program makes from its own table. A test holds both together.
KEYS: dict[str, list[str]] = {
    "scene": "name kind duration speed start gap spacing spacing_y side faces initial".split(),
    "resonator": [*_BODY, "moving_force"],
    "slider": [*_BODY, "load"],
    "contact": "law stiffness".split(),
    "time": "scheme contact_force step tolerance nodes force".split(),
    "output":
    "rate probes slider_probes microphones from window modes precision compression".split(),
    "air": "temperature pressure".split(),
    "resonator.surface": _FACE,
    "slider.surface": _FACE,
}
# Units by the name of a key, as docs/scene.md has them; a test holds both together.
UNITS: dict[str, str] = {name: unit for unit, names in {
    "s": "duration step from window", "m/s": "speed", "Hz": "max_frequency rate",
    "Pa": "young pressure", "kg/m^3": "density",
    "Pa/m": "stiffness", "N": "load force",
    "m":
    "start gap spacing spacing_y side y offset_x offset_y rsm_y length thickness width cutoff_s "
    "cutoff rq rsm correlation_length longest shortest probes "
         "slider_probes"}.items() for name in names.split()}
LONGEST_TITLE = 48  # characters of a name within the names of files


def full_key(name: str) -> str:
    """The key that a short name means. A name that only one section has is enough. Whole keys are
    left to the program, which names the nearest one.

    >>> full_key("speed"), full_key("tolerance"), full_key("slider.surface.rq")
    ('scene.speed', 'time.tolerance', 'slider.surface.rq')
    """
    if not isinstance(name, str):
        raise RequestError(f"the keys of a scene are texts, not {type(name).__name__}: {name!r}")
    if "." in name:
        return name
    for depth in (0, 1):  # sections before the tables within them
        found = [f"{section}.{name}" for section, keys in KEYS.items()
                 if section.count(".") == depth and name in keys]
        if len(found) == 1:
            return found[0]
        if found:
            raise RequestError(
                f"{name}: {' and '.join(found)} have this name: give the whole key, as "
                               f"{{{found[-1]!r}: ...}}")
    near = difflib.get_close_matches(name, {key for keys in KEYS.values() for key in keys}, 1)
    raise RequestError(f"{name}: no key of a scene has this name" + (f" (did you mean `{near[0]}`?)"
                                                                     if near else ""))


def short_key(name: str) -> str:
    """A key as a reader writes it: its last word, if that is enough.

    >>> short_key("scene.speed"), short_key("slider.surface.seed")
    ('speed', 'slider.surface.seed')
    """
    last = name.rsplit(".", 1)[-1]
    try:
        return last if full_key(last) == name else name
    except RequestError:  # several keys have this name, or none
        return name


def full_keys(changes: Mapping[str, Any] | None, short: Mapping[str, Any]) -> dict[str, Any]:
    """Both kinds of changes with whole keys. A tolerance alone asks for the scheme that takes
    it."""
    given = {full_key(name): value for name, value in {**(changes or {}), **short}.items()}
    if "time.tolerance" in given and given.setdefault("time.scheme", "adaptive") != "adaptive":
        notice(f"tolerance = {given['time.tolerance']!r} has no effect: it is of the scheme "
               f"'adaptive', and scheme = {given['time.scheme']!r} was given, too")
    return given


def _has_unit(value: Any) -> bool:
    """Whether it is a text such as "500 mm", or holds one."""
    if isinstance(value, str):
        return re.match(r"\s*[-+\u2212]?\.?\d", value) is not None
    if isinstance(value, Mapping):
        return any(map(_has_unit, value.values()))
    return isinstance(value, list | tuple) and any(map(_has_unit, value))


def _as_read(value: Any, read: Any) -> Any:
    """A value with the numbers that the program has read its units as."""
    if isinstance(value, str):
        return read if isinstance(read, int | float) else value
    if isinstance(value, Mapping) and isinstance(read, Mapping):
        return {key: _as_read(inner, read.get(key)) for key, inner in value.items()}
    if isinstance(value, list | tuple) and isinstance(read, list) and len(read) == len(value):
        return [_as_read(*both) for both in zip(value, read)]
    return value


def _own(content: dict[str, Any]) -> dict[str, Any]:
    """A copy, which nothing outside changes."""
    try:
        return copy.deepcopy(content)
    except TypeError as fault:  # of a generator, or an open file
        raise RequestError(
            f"a scene holds numbers, texts, lists and tables alone: {fault}") from fault


class Scene:
    """A simulation: a file or a dict, and changes to it. A scene never changes; `change`
    makes another one.

    - `title`: its name in results and in names of files
    - `changes`: the values that differ from the file, by their whole keys
    - `scene["speed"]`, `scene["resonator.length"]`: a value, in SI units also where the scene has
      "100 mm/s"; KeyError where the scene leaves it to its default

    >>> import ra2d
    >>> cube = ra2d.scene("dang2012")
    >>> cube["speed"]                                 # m/s
    0.1
    >>> cube.change(speed=0.2)["scene.speed"]
    0.2
    """

    def __init__(self, source: pathlib.Path | Mapping[str, Any],
                 changes: Mapping[str, Any] | None = None) -> None:
        self._source: pathlib.Path | dict[str, Any]
        self._source = source if isinstance(source, pathlib.Path) else _own(dict(source))
        self._changes = _own(dict(changes or {}))

    @property
    def changes(self) -> dict[str, Any]:
        """The values that differ from the file, by their whole keys.

        >>> import ra2d
        >>> ra2d.scene("dang2012").change(speed=0.2).changes
        {'scene.speed': 0.2}
        """
        return _own(self._changes)  # the caller's own

    @property
    def title(self) -> str:
        """The stem of the file; of a dict the scene's name and eight digits of its content.

        >>> import ra2d
        >>> ra2d.scene("peaks").title
        'peaks'
        """
        if isinstance(self._source, pathlib.Path):
            return self._source.stem
        digits = hashlib.sha256(toml.document(self._source).encode()).hexdigest()[:8]
        name = str(self._source.get("scene", {}).get("name", "scene")).replace(" ", "-")
        return re.sub(r"[^\w.=+-]+", "_", name)[:LONGEST_TITLE] + f"-{digits}"

    def change(self, changes: Mapping[str, Any] | None = None, /, **short: Any) -> Scene:
        """A scene with other values: by short names, or by whole keys in a mapping. Numbers are in
        SI units; texts say theirs, as "500 mm".

        `tolerance` alone also sets `time.scheme = "adaptive"`, the one scheme that takes it.

        >>> import ra2d
        >>> ra2d.scene("dang2012").change({"slider.surface.seed": 7}, load=1.0).changes
        {'slider.surface.seed': 7, 'slider.load': 1.0}
        >>> ra2d.scene("dang2012").change(speed="50 mm/s")["speed"]
        0.05
        """
        given = full_keys(changes, short)
        replaced = tuple(f"{name}." for name in given)  # a whole table takes the place of its keys
        kept = {name: value for name, value in self.changes.items()
                if not f"{name}.".startswith(replaced)}
        return Scene(self._source, kept | given)

    def without(self, names: Collection[str]) -> Scene:
        """A scene without the changes of these whole keys.

        >>> import ra2d
        >>> ra2d.scene("dang2012").change(speed=0.2, load=1.0).without(["scene.speed"]).changes
        {'slider.load': 1.0}
        """
        return Scene(self._source,
                     {name: value for name, value in self.changes.items() if name not in names})

    def text(self) -> str:
        """The scene as TOML, without the changes.

        >>> import ra2d
        >>> "[resonator]" in ra2d.scene("dang2012").text()
        True
        """
        if isinstance(self._source, pathlib.Path):
            return files.read(self._source)
        return toml.document(self._source)

    def content(self) -> dict[str, Any]:
        """The scene as nested dicts, with the changes. Values as they were given; defaults are not
        in it.

        >>> import ra2d
        >>> ra2d.scene("dang2012").content()["resonator"]["thickness"]     # m
        0.002
        """
        content = toml.parse(self.text(), repr(str(self._source))
                             if isinstance(self._source, pathlib.Path) else "it")
        for name, value in self.changes.items():
            *tables, last = name.split(".")
            inner = content
            for table in tables:
                inner = inner.setdefault(table, {})
                if not isinstance(inner, dict):
                    raise RequestError(
                        f"{name}: {table} is a value of the scene, and holds no keys")
            inner[last] = value
        return content

    def complete(self) -> dict[str, Any]:
        """The scene as nested dicts with the changes and all defaults, as the program reads it.

        >>> import ra2d
        >>> ra2d.scene("dang2012").complete()["time"]["nodes"]
        'candidates'
        """
        parts = itertools.takewhile(lambda part: part.startswith(("#", "[")),
                                    self.plan().split("\n\n"))
        return toml.parse("\n\n".join(parts))

    def __getitem__(self, name: str) -> Any:
        path = full_key(name).split(".")
        value: Any = self.content()
        for part in path:
            if not isinstance(value, Mapping) or part not in value:
                raise KeyError(f"{name}: the scene leaves it to its default, or has no such key: "
                               "complete() holds all")
            value = value[part]
        if not _has_unit(value):
            return value
        with kept_notices():  # what is odd is said when the scene is run
            read: Any = self.complete()
        for part in path:
            read = read.get(part) if isinstance(read, Mapping) else None
        return _as_read(value, read)

    def file(self, folder: pathlib.Path) -> pathlib.Path:
        """The file that the program reads: the scene's own; of a dict one written into `folder`.

        >>> import pathlib, ra2d
        >>> ra2d.scene(ra2d.scene("peaks").content()).file(pathlib.Path(".")).suffix
        '.toml'
        """
        if isinstance(self._source, pathlib.Path):
            return self._source
        path = folder / f"{self.title}.toml"
        files.write(path, toml.document(self._source))
        return path

    def options(self) -> list[str]:
        """The changes as options of the program.

        >>> import ra2d
        >>> ra2d.scene("dang2012").change(speed=0.2).options()
        ['--set', 'scene.speed=0.2']
        """
        return [word for name, value in self.changes.items()
                for word in ("--set", f"{name}={toml.value(value)}")]

    def plan(self) -> str:
        """What the program would model, and why: modes, limits of stability, cost (`ra2d plan`).

        >>> import ra2d
        >>> print(ra2d.scene("dang2012").plan().split("stability")[0].splitlines()[-1][:25])
        scheme     backward-euler
        """
        with program.scratch() as folder:
            return program.call("plan", self.file(folder), *self.options())

    def __repr__(self) -> str:
        changed = "".join(f", {name}={value!r}" for name, value in self.changes.items())
        return f"<ra2d.Scene {self.title}{changed}>"

    def _repr_html_(self) -> str:
        changed = "".join(f"{name} = {toml.value(value)}\n" for name, value in self.changes.items())
        return (f"<b>{html.escape(self.title)}</b><pre>{html.escape(changed)}</pre>"
                "<details><summary>the "
                f"scene</summary><pre>{html.escape(self.text())}</pre></details>")


def _folders() -> list[pathlib.Path]:
    """Where the scenes that come with the program are: of the installed one, and of the source."""
    binary = program.find().resolve().parent
    return [binary.parent / "share/ra2d/scenes", binary.parents[1] / "scenes",
            pathlib.Path(__file__).resolve().parents[3] / "scenes"]


def _named(name: str) -> pathlib.Path:
    folders = [folder for folder in _folders() if folder.is_dir()]
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return folder / f"{name}.toml"
    found_names = sorted({file.stem for folder in folders for file in folder.glob("*.toml")
                    if "[resonator]" in files.read(file)})
    raise RequestError(f"there is no file and no scene {name!r}. Scenes that come with ra2d: "
                       f"{', '.join(found_names) or 'none found'}")


def _with_paths(content: Mapping[str, Any]) -> dict[str, Any]:
    """A dict's relative paths of profiles count from the current folder. Wrong types are left to
    the program."""
    whole = _own(dict(content))
    toml.document(whole)  # refuses what is no scene
    for body in ("resonator", "slider"):
        face = whole.get(body, {}).get("surface")
        if isinstance(face, Mapping) and isinstance(face.get("path"), str | os.PathLike):
            whole[body]["surface"] = {**face, "path": str(pathlib.Path(face["path"]).resolve())}
    return whole


def scene(source: str | os.PathLike[str] | Mapping[str, Any] | Scene) -> Scene:
    """A scene by the name of one that comes with ra2d, from a TOML file, or from a dict of
    sections with values in SI units.

    >>> import ra2d
    >>> ra2d.scene("dang2012")
    <ra2d.Scene dang2012>
    >>> ball = {**ra2d.scene("drop").content(),
    ...         "scene": {"name": "ball", "duration": 1e-3, "speed": 0.0, "start": 0.1,
    ...                   "spacing": 8e-6}}
    >>> ra2d.scene(ball)["duration"]                  # s
    0.001
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, Mapping):
        return Scene(_with_paths(source))
    if not isinstance(source, str | os.PathLike):
        raise RequestError(
            f"a scene is a name, a file, a dict or a ra2d.Scene, not {type(source).__name__}")
    path = pathlib.Path(source)
    if "\n" in str(path):
        raise RequestError(
            "a scene is a name, a file, a dict or a ra2d.Scene: write the text to a file first")
    if path.is_file():
        return Scene(path.resolve())
    if path.suffix or len(path.parts) != 1:
        is_installed = (len(path.parts) == 1
                        and any((folder / path).is_file() for folder in _folders()))
        raise RequestError(f"cannot read the scene {str(path)!r}: there is no such file"
                           + (f". {path.stem!r}, without an ending, is the one that comes with ra2d"
                              if is_installed else ""))
    return Scene(_named(str(source)))
