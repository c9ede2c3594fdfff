# SPDX-License-Identifier: BSD-3-Clause
"""Errors: one class for each way in which the program ends, with the program's own message."""
from __future__ import annotations

import contextlib
import re
import signal
import sys
import warnings
from collections.abc import Iterator
from contextvars import ContextVar


class Error(Exception):
    """Any error of the program or of this package. The message says the problem, why, and the
    cure; `args[0]` is the program's, without what is said of Python."""

    def __str__(self) -> str:
        return for_python(super().__str__())


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

    def __str__(self) -> str:
        return for_python(super().__str__())


_kept: ContextVar[list[str] | None] = ContextVar("kept", default=None)


def notice(message: str) -> None:
    """Tells a Notice, as `warnings.warn` does, at the line outside of this package that asked.
    Within `kept_notices` it is kept."""
    if (kept := _kept.get()) is not None:
        kept.append(message)
        return
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, Notice, stacklevel=level)


@contextlib.contextmanager
def kept_notices() -> Iterator[list[str]]:
    """The Notices of the block, which are told to nobody. `warnings.catch_warnings` is of the whole
    process: threads took each other's, and could leave it deaf to all later ones."""
    messages: list[str] = []
    before = _kept.set(messages)
    try:
        yield messages
    finally:
        _kept.reset(before)


# options of the program that are arguments in Python, too
_FLAGS = ("a-weighting", "force", "fresh", "normalize", "power", "retry-failed")
_OPTIONS = ("at", "checkpoint", "column", "cutoff", "cutoff-s", "decimal", "device", "filter",
            "form", "full-scale", "max-wall", "pressure", "probe", "rate", "resolution", "row",
            "sampling-lengths", "seeds", "segment", "shock", "slow", "spacing", "standard",
            "temperature", "threads", "time", "what", "x-unit", "z-unit")
# what the program says of its options, and the same in Python
_IN_PYTHON = ((r"duration <= ([\d.e-]+) s\b", r"duration=\1"),
              (r"with -o\b|--output\b", 'output="other.h5"'),
              (r"--from\b", "start=..."), (r"--to\b", "stop=..."),
              (r"--slider-probe\b", 'body="slider", probe=...'),
              *((rf"--{name}(?![\w-])", f"{name.replace('-', '_')}=True") for name in _FLAGS),
              *((rf"--{name}(?![\w-])", f"{name.replace('-', '_')}=...") for name in _OPTIONS))
_MORE_HELP = "\nRun with --help for more information."

_CRASHES = (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL)

BY_STATUS: dict[int, type[Error]] = {2: RequestError, 3: SimulationError, 4: FileError,
                                     5: OutOfTime}


def error_of(status: int, message: str) -> Error:
    """The exception for an exit status of the program (128 + n: signal n ended it)."""
    message = message.removesuffix(_MORE_HELP)
    if status in BY_STATUS:
        return BY_STATUS[status](message)
    if status - 128 in _CRASHES:
        return ProgramError(f"ra2d crashed: signal {status - 128}, "
                            f"{signal.strsignal(status - 128)}"
                            + (f". Its last words: {message}" if message else ""))
    if status > 128:
        return Interrupted(message or f"signal {status - 128} ended the program")
    return ProgramError(f"ra2d ended with status {status}: {message or 'it said nothing'}")


def for_python(message: str) -> str:
    """The program's message, and how the options it names are written in Python.

    >>> for_python("it exists: --force replaces it")
    'it exists: --force replaces it\\nIn Python: force=True'
    """
    found = [match.expand(cure) for words, cure in _IN_PYTHON
             if (match := re.search(words, message))]
    return message + (f"\nIn Python: {', '.join(found)}" if found else "")
