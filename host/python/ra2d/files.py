# SPDX-License-Identifier: BSD-3-Clause
"""Files in and out. Every fault is an error of this package."""
from __future__ import annotations

import os
import pathlib
import threading

from .errors import FileError


def read(path: pathlib.Path) -> str:
    """The text of a file."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as fault:
        raise FileError(f"cannot read {str(path)!r}: it is no text in UTF-8 ({fault.reason}, "
                        f"byte {fault.start})") from fault
    except OSError as fault:
        raise FileError(f"cannot read {str(path)!r}: {fault.strerror}") from fault


def require_folder(path: pathlib.Path) -> None:
    """Raises FileError where a file cannot be written since its folder does not exist."""
    if not path.parent.is_dir():
        raise FileError(f"cannot write {str(path)!r}: there is no folder {str(path.parent)!r}. "
                        "Make it first")


def make_folder(path: pathlib.Path) -> None:
    """Makes a folder, and those above it."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise FileError(f"cannot make the folder {str(path)!r}: {fault.strerror}. "
                        "Name another one") from fault


def write(path: pathlib.Path, text: str) -> None:
    """Writes a text and puts it in place whole: a reader sees the old one or the new one."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: pathlib.Path, data: bytes) -> None:
    """Writes a file and puts it in place whole: a reader sees the old one or the new one."""
    require_folder(path)
    partial = path.with_name(f".{os.getpid()}-{threading.get_native_id()}.partial")
    try:
        partial.write_bytes(data)
        partial.replace(path)
    except OSError as fault:
        raise FileError(f"cannot write {str(path)!r}: {fault.strerror}") from fault
    finally:
        partial.unlink(missing_ok=True)
