# SPDX-License-Identifier: BSD-3-Clause
"""Progress of a run or a study: a bar in a notebook, a line in a terminal, nothing elsewhere."""
from __future__ import annotations

import contextlib
import html
import re
import sys
from collections.abc import Callable, Iterator


def _share(text: str) -> float:
    """The part that is done, as the text says it: "7.5 % ...", or "3 of 12 runs"."""
    if percent := re.match(r"([\d.]+) %", text):
        return float(percent[1]) / 100
    if runs := re.match(r"(\d+) of (\d+) runs", text):
        return int(runs[1]) / max(int(runs[2]), 1)
    return 0.0


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


@contextlib.contextmanager
def _bar() -> Iterator[Callable[[str], None]]:
    from IPython.display import HTML, display

    handle = display(HTML(""), display_id=True)
    def write(text: str) -> None:
        handle.update(HTML(f'<progress value="{_share(text):.4f}" style="width:12em"></progress> '
                           f"<code>{html.escape(text)}</code>"))

    try:
        yield write
    finally:
        handle.update(HTML(""))


@contextlib.contextmanager
def _line() -> Iterator[Callable[[str], None]]:
    def write(text: str) -> None:
        sys.stderr.write(f"\r{text}\x1b[K")
        sys.stderr.flush()

    try:
        yield write
    finally:
        write("")


@contextlib.contextmanager
def _nothing() -> Iterator[Callable[[str], None]]:
    yield lambda text: None


def shown(wanted: bool) -> contextlib.AbstractContextManager[Callable[[str], None]]:
    """A function that shows a text in the place of the one before; the last one goes at the end."""
    if not wanted:
        return _nothing()
    if _in_notebook():
        return _bar()
    return _line() if sys.stderr.isatty() else _nothing()
