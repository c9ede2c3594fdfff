# SPDX-License-Identifier: BSD-3-Clause
"""Errors: one class for each way in which the program ends, with the program's own message."""
from __future__ import annotations


class Error(Exception):
    """Any error of the program or of this package. The message says the problem, why, and the cure."""


class RequestError(Error, ValueError):
    """The request is wrong: a scene, a study, an option, a profile (exit status 2)."""


class SimulationError(Error):
    """The simulation failed: unstable or not finite (exit status 3). The file named in the message
    holds what was computed until then; `ra2d.load` reads it."""


class FileError(Error, OSError):
    """A file could not be read or written (exit status 4)."""


class OutOfTime(Error):
    """`max_wall` was reached (exit status 5). The same call goes on from the checkpoint."""


class Interrupted(Error):
    """A signal from outside ended the program (exit status 128 + n). Ctrl-C in Python raises
    KeyboardInterrupt instead, after the program has written its checkpoint."""


class ProgramError(Error):
    """The program `ra2d` is missing, too old, or crashed."""


class Notice(UserWarning):
    """A message of the program beside its answer, such as a doubt about a number of the scene."""


BY_STATUS: dict[int, type[Error]] = {2: RequestError, 3: SimulationError, 4: FileError, 5: OutOfTime}


def error_of(status: int, message: str) -> Error:
    """The exception for an exit status of the program (a negative one: killed by that signal)."""
    if status in BY_STATUS:
        return BY_STATUS[status](message)
    if status > 128:
        return Interrupted(message or f"signal {status - 128} ended the program")
    return ProgramError(f"ra2d ended with status {status}: {message or 'it said nothing'}")
