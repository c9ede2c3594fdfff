# SPDX-License-Identifier: BSD-3-Clause
"""The program `ra2d`: where it is, and how it is called."""
from __future__ import annotations

import contextlib
import fcntl
import functools
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import termios
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from .errors import Error, ProgramError, error_of, notice

OLDEST = (0, 1, 0)  # version of the program that this package reads
_CLEARS = b"\x1b[K"  # the rest of a terminal's line: the end of each text of progress
CURE = "install ra2d, put it on the PATH, or name it: export RA2D=/path/to/ra2d"


def _candidates() -> list[pathlib.Path]:
    """Where the program may be. RA2D decides alone; then beside the package, then the PATH."""
    if named := os.environ.get("RA2D"):
        return [pathlib.Path(named).absolute()]
    here = pathlib.Path(__file__).resolve().parent
    candidates = [here.parents[2] / "build/release/ra2d",  # of the source: host/python/ra2d
              here.parents[2] / "bin/ra2d",            # installed: share/ra2d/ra2d
              pathlib.Path(sys.prefix) / "bin/ra2d"]
    on_path = shutil.which("ra2d")
    return candidates + ([pathlib.Path(on_path)] if on_path else [])


def find() -> pathlib.Path:
    """The program that is called: that of the environment variable RA2D, the one beside this
    package, or the first on the PATH. Raises ProgramError, with the cure, where there is none or
    where it is too old.

    >>> find().name
    'ra2d'
    """
    for path in _candidates():
        if path.is_file() and os.access(path, os.X_OK):
            _require_version(path)
            return path
    named = os.environ.get("RA2D")
    where = f"RA2D names {named!r}, which is no program" if named else \
        "it is neither beside the package nor on the PATH"
    raise ProgramError(f"the program ra2d was not found: {where}. {CURE}")


@functools.lru_cache
def _require_version(path: pathlib.Path) -> None:
    try:
        said = subprocess.run([path, "--version"], capture_output=True, encoding="utf-8",
                              errors="replace").stdout
    except OSError as fault:
        raise ProgramError(f"{path} does not start: {fault.strerror}. {CURE}") from fault
    found = re.match(r"ra2d (\d+)\.(\d+)\.(\d+)", said)
    oldest = ".".join(map(str, OLDEST))
    if not found:
        raise ProgramError(f"{path} does not say a version of ra2d: {said.strip()[:80]!r}. {CURE}")
    if tuple(map(int, found.groups())) < OLDEST:
        raise ProgramError(
            f"{path} is {said.split()[1]}, this package needs {oldest} or later: {CURE}")


def _messages(text: str) -> list[str]:
    """The single messages of stderr. Each begins behind the program's name; lines without it go
    on."""
    parts = re.split(r"^ra2d: ", text, flags=re.MULTILINE)
    return [part.strip() for part in parts if part.strip()]


def _finish(status: int, messages: list[str]) -> None:
    """Tells notices as warnings. Raises the error that the last message describes."""
    last = messages.pop() if status and messages else ""
    for message in messages:
        notice(message)
    if status:
        raise error_of(status, last)


def options(given: Mapping[str, object]) -> list[str]:
    """Options as the program takes them: None and False are left out, True stands without a value.

    >>> options({"--fresh": True, "--device": None, "--max-wall": 60})
    ['--fresh', '--max-wall', '60']
    """
    words: list[str] = []
    for name, value in given.items():
        if value is True:
            words.append(name)
        elif value is not None and value is not False:
            words += [name, str(value)]
    return words


def call(*words: object) -> str:
    """Calls the program and returns what it prints.

    >>> call("--version").split()[0]
    'ra2d'
    """
    ended = subprocess.run([find(), *map(str, words)], capture_output=True, encoding="utf-8",
                           errors="replace", stdin=subprocess.DEVNULL)
    _finish(_status(ended.returncode), _messages(ended.stderr))
    return ended.stdout


def ask(*words: object) -> Any:
    """Calls the program with --json and returns its answer; null becomes None."""
    return json.loads(call(*words, "--json"))


def follow(words: Sequence[object], show: Callable[[str], None]) -> str:
    """Calls the program, shows its progress, and returns what it prints. An interrupt (Ctrl-C, or
    the stop button of a notebook) is handed on: the program writes its checkpoint, then
    KeyboardInterrupt is raised. A second one ends the program at once.

    The program shows progress on a terminal only, so it is given one of its own. When this process
    dies, that terminal hangs up, and the program ends in order with a checkpoint.
    """
    command = [str(find()), *map(str, words)]
    ours, its = pty.openpty()
    with tempfile.TemporaryFile() as printed, os.fdopen(ours, "rb", buffering=0) as screen:
        with _HeldInterrupt() as held:  # or a program that has just begun would be forgotten
            child = subprocess.Popen(command, stdin=its, stdout=printed, stderr=its,
                                     start_new_session=True,
                                     preexec_fn=lambda: fcntl.ioctl(2, termios.TIOCSCTTY, 0))
            os.close(its)
            messages, interrupted = _watch(screen.fileno(), child, show, held)
        printed.seek(0)
        said = printed.read().decode(errors="replace")
    if interrupted:
        raise KeyboardInterrupt(messages[-1] if messages else "")
    _finish(_status(child.returncode), messages)
    return said


class _HeldInterrupt:
    """Holds an interrupt (SIGINT) back until `release`, which raises it then. It can only arrive in
    the main thread."""

    def __enter__(self) -> _HeldInterrupt:
        self._arrived, self._handler = False, None
        handler = signal.getsignal(signal.SIGINT)
        if threading.current_thread() is threading.main_thread() and callable(handler):
            self._handler = handler
            signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *error: object) -> None:
        self.release()

    def _note(self, number: int, frame: object) -> None:
        self._arrived = True

    def release(self) -> None:
        if self._handler is None:
            return
        signal.signal(signal.SIGINT, self._handler)
        self._handler = None
        if self._arrived:
            signal.raise_signal(signal.SIGINT)


def _status(code: int) -> int:
    """The exit status as a shell tells it: 128 + the number of the signal that ended a program."""
    return code if code >= 0 else 128 - code


def _watch(screen: int, child: subprocess.Popen[bytes],
           show: Callable[[str], None], held: _HeldInterrupt) -> tuple[list[str], bool]:
    """Reads until the program has ended: its messages, and whether there was an interrupt, also one
    that was held back."""
    said, rest, interrupted = "", b"", False
    try:
        while True:
            try:
                held.release()
                block = os.read(screen, 1 << 16)
                if not block:
                    break
                *lines, rest = (rest + block).split(b"\n")
                said += "".join(_pieces(line)[-1] + "\n" for line in lines)
                if rest.endswith(_CLEARS) and (text := _pieces(rest)[-2]):
                    show(text)
            except KeyboardInterrupt:
                interrupted = True
                child.send_signal(signal.SIGINT)
            except OSError:  # the program has closed its terminal
                break
        child.wait()
    finally:
        if child.poll() is None:
            child.terminate()
            child.wait()
    return _messages(said), interrupted


def _pieces(line: bytes) -> list[str]:
    """The texts that stood in a line of the terminal one after another; each replaced the one
    before."""
    parts = re.split(rb"\r|" + re.escape(_CLEARS), line.rstrip(b"\r"))
    return ["", *(part.decode(errors="replace").strip() for part in parts)]


@contextlib.contextmanager
def scratch() -> Iterator[pathlib.Path]:
    """A folder for files that only one call needs. Errors name them without it: it is gone by
    then."""
    with tempfile.TemporaryDirectory(prefix="ra2d-") as folder:
        try:
            yield pathlib.Path(folder)
        except Error as fault:
            fault.args = (fault.args[0].replace(f"{folder}/", ""),)
            raise
