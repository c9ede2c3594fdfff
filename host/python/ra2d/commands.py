# SPDX-License-Identifier: BSD-3-Clause
"""Commands of the program that this package answers. Each takes the request that the program made
of the command line (host/commands), writes into the files that it names, and returns what is
printed."""
from __future__ import annotations

import errno
import io
import json
import os
import pathlib
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Any, TextIO

import numpy as np

from . import (budget, charts, compare_plot, comparison, page, plots, profile_plot, sound,
               study_plot, toml)
from .__main__ import library_missing
from .errors import BY_STATUS, Error, FileError, Notice, RequestError
from .page_words import printable
from .results import Result, load
from .scenes import Scene
from .studies import load_study
from .style import DPI, Picture

Request = dict[str, Any]


def _path(text: str) -> pathlib.Path:
    """A path of a request (host/commands/python.hpp): its bytes as characters."""
    return pathlib.Path(os.fsdecode(text.encode("latin-1")))


def _result(file: pathlib.Path, request: Request) -> Result:
    """A result, with the microphones of the request."""
    air = {name: request.get(name) for name in ("temperature", "pressure")}
    return load(file).with_microphones(request["at"], **air) if "at" in request else load(file)


def _picture(request: Request) -> Picture:
    files = [_path(text) for text in request.get("files", [])]
    if request["subject"] == "chart":
        return charts.picture(request["chart"], files)
    if request["subject"] == "profile":
        return profile_plot.picture(request["profile"])
    if request["subject"] == "study":
        return study_plot.picture(load_study(files[0]))
    stretch: dict[str, Any] = {name: request.get(name) for name in ("start", "stop")}
    if len(files) == 1:
        return plots.result(_result(files[0], request), request["what"], shock=request.get("shock"),
                            time=request.get("time"), **stretch)
    return compare_plot.plot([_result(file, request) for file in files], request["what"], **stretch)


def plot(request: Request) -> str:
    """A picture into the file `output`, of the kind "png", "svg" or "pdf"."""
    _write(_path(request["output"]), _picture(request).drawn(request["kind"], DPI))
    return ""


def report(request: Request) -> str:
    """A page into the file `output`."""
    files = [_path(text) for text in request["files"]]
    command = os.fsdecode(request["line"].encode("latin-1"))
    made = page.study_text(load_study(files[0]), command) if request["subject"] == "study" else \
        page.results_text([_result(file, request) for file in files], command)
    _write(_path(request["output"]), made.encode("utf-8", "replace"))
    return ""


def play(request: Request) -> str:
    """A sound into the file `output`, and the text about it into `sidecar`."""
    name = _path(request["made"])
    result = load(_path(request["file"]))
    if "pressure" in request:
        heard = np.fromfile(_path(request["pressure"])).reshape(
            len(request["heard"]["microphones"]), -1)
        made = sound.of_pressure(result, heard, request["heard"], **request["options"])
    else:
        made = sound.of_probe(result, **request["options"])
    _write(_path(request["output"]), made.encoded(request["encoding"]))
    _write(_path(request["sidecar"]), made.about_text(name.name).encode("utf-8", "replace"))
    for doubt in (*made.doubts, *made.doubts_in(request["encoding"])):
        warnings.warn(doubt, stacklevel=1)
    return "" if request["quiet"] else made.describe(str(name))


def uncertainty(request: Request) -> str:
    """The error budget of a scene as text or JSON; its table as CSV into the file `csv`."""
    what = Scene(_path(request["scene"]).resolve(), _changes(request["set"]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Notice)  # the program has told its doubts of this scene
        found = budget.uncertainty(what, request["seeds"], folder=_path(request["folder"]),
                                   threads=request["threads"],
                                   show=request["show"])
    if "csv" in request:
        _write(_path(request["csv"]), found.csv().encode())
    return (found.to_json() if request["json"] else found.text()) + "\n"


def compare(request: Request) -> str:
    """The differences between A and B, as text or JSON."""
    found = comparison.compare(_path(request["a"]), _path(request["b"]))
    return (found.to_json() if request["json"] else found.text()) + "\n"


def _changes(words: list[str]) -> dict[str, Any]:
    """Of `--set`, key by key: a value of TOML, or else a text. The program has checked them."""
    found = {}
    for word in words:
        name, _, text = os.fsdecode(word.encode("latin-1")).partition("=")
        try:
            found[name.strip()] = toml.parse(f"value = {text}")["value"]
        except RequestError:
            found[name.strip()] = text
    return found


COMMANDS: dict[str, Callable[[Request], str]] = {"plot": plot, "report": report, "sound": play,
                                                "uncertainty": uncertainty, "compare": compare}


def _write(path: pathlib.Path, data: bytes) -> None:
    """Into a file that is there."""
    try:
        with open(path, "r+b", buffering=0) as file:
            rest = memoryview(data)
            while rest:
                rest = rest[file.write(rest):]
    except OSError as fault:
        cure = ". Free some space, or write to another disk" if fault.errno in (
            errno.ENOSPC, errno.EDQUOT) else ""
        raise FileError(f"cannot write: {fault.strerror}{cure}") from fault


def _say(message: object) -> None:
    """A message of the program. Control characters stay out of terminals."""
    text = "".join(c if c.isprintable() or c == "\n" else "?" for c in str(message))
    try:
        print(f"ra2d: {text}", file=sys.stderr)
    except OSError:  # as on a full disk: what was asked for is made all the same
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # or Python's end is a failure


def _status(fault: Error) -> int:
    return next((status for status, kind in BY_STATUS.items() if isinstance(fault, kind)), 3)


def main(requests: TextIO) -> int:
    """Answers one request; returns the exit status."""
    for stream in (sys.stdout, sys.stderr):  # as the program writes, in every locale
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="utf-8", errors="replace")
    warnings.showwarning = lambda message, *rest: _say(
        message.args[0] if isinstance(message, Notice) else message)
    request = json.load(requests)
    made = printable(str(_path(request["made"]))) if "made" in request else "the answer"
    warnings.simplefilter("ignore" if request.get("quiet") else "always", UserWarning)
    # a name in letters that the font has not
    warnings.filterwarnings("ignore", message="Glyph .* missing")
    try:
        sys.stdout.write(COMMANDS[request["command"]](request))
        sys.stdout.flush()
    except Error as fault:
        said = fault.args[0]  # without what is said of Python
        _say(said if isinstance(fault, RequestError) else f"{made} was not made: {said}")
        return _status(fault)
    except ImportError:
        return library_missing()
    except KeyboardInterrupt:
        return 130
    except MemoryError:
        _say("out of memory")
        return 3
    # a fault of ours ends with a message, and with no picture
    except Exception as fault:  # noqa: BLE001
        if isinstance(fault, OSError) and fault.filename is not None:
            _say(f"{made} was not made: cannot read or write '{fault.filename}': {fault.strerror}")
            return 4
        at = traceback.extract_tb(fault.__traceback__)[-1]
        _say(f"{made} was not made: {type(fault).__name__}: {fault} "
             f"({pathlib.Path(at.filename).name}, line {at.lineno}). Ask 'ra2d check' whether a "
             "file is damaged; if none is, this is a fault of ra2d: please report it")
        return 4
    return 0
