# SPDX-License-Identifier: BSD-3-Clause
"""Runs: the program simulates a scene."""
from __future__ import annotations

import hashlib
import os
import pathlib
import re
from collections.abc import Mapping
from typing import Any

from . import program, progress
from .errors import notice
from .results import Result
from .scenes import Scene, scene, short_key

LONGEST_NAME = 120  # bytes


def output_name(what: Scene) -> str:
    """A name that tells the changes, so that runs of a notebook keep apart:
    dang2012-speed=0.2.h5."""
    words = [f"{short_key(name)}={value}" for name, value in sorted(what.changes.items())]
    name = re.sub(r"[^\w.=+-]+", "_", "-".join([what.title, *words]))
    if len(name.encode(errors="replace")) > LONGEST_NAME:
        key = hashlib.sha256(" ".join(what.options()).encode()).hexdigest()
        name = f"{what.title[:24]}-{key[:12]}"
    return f"{name}.h5"


def run(source: str | os.PathLike[str] | Mapping[str, Any] | Scene,
        changes: Mapping[str, Any] | None = None, /, *,
        output: str | os.PathLike[str] | None = None, fresh: bool = False, force: bool = False,
        checkpoint: float = 10, max_wall: float | str | None = None, device: int | None = None,
        show: bool = True, **short: Any) -> Result:
    """Simulates a scene and returns its result. The same call again returns the result that is
    there; one that was cut short goes on from its checkpoint.

    - `source`: a scene, or what `ra2d.scene` takes
    - `changes`: values by whole keys, {"slider.surface.seed": 3}; `short`: by names that one
      section alone has, speed=0.2 [m/s], load=5.0 [N], duration=0.5 [s], tolerance=1e-6 (which
      asks for the scheme "adaptive")
    - `output`: the HDF5 file; without it, in the current folder under the scene's name and changes
    - `fresh`: run again if the result is there; `force`: replace the result of another run
    - `checkpoint` [min]: wall time between two checkpoints
    - `max_wall` [s, or "H:M:S"]: wall time after which OutOfTime is raised, with a checkpoint
    - `device`: number of the GPU; `show`: whether to show progress

    Ctrl-C, or the stop button of a notebook, raises KeyboardInterrupt after a checkpoint.

    >>> import ra2d
    >>> ra2d.run("dang2012", speed=0.2, duration=0.01, tolerance=1e-6).path.name
    'dang2012-duration=0.01-speed=0.2-scheme=adaptive-tolerance=1e-06.h5'
    """
    what = scene(source).change(changes, **short)
    path = pathlib.Path(output) if output else pathlib.Path(output_name(what))
    options = program.options({"--fresh": bool(fresh), "--force": bool(force),
                               "--checkpoint": checkpoint,
                               "--max-wall": max_wall, "--device": device})
    with program.scratch() as folder, progress.shown(show) as shown:
        report = program.follow(["run", what.file(folder), *what.options(), "-o", path, *options],
                                shown)
    for line in report.splitlines():  # what a reader of the figures should not overlook
        if line.startswith("  warning "):
            notice(line.removeprefix("  warning").strip())
    return Result(path)
