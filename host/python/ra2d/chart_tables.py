# SPDX-License-Identifier: BSD-3-Clause
"""Tables of `ra2d chart`, and the names and colours of the schemes in its pictures."""
from __future__ import annotations

import csv
import pathlib

# (time.scheme, time.contact_force): name, colour
NAMES = {
    ("explicit-euler", "old"): ("explicit Euler", "#d62728"),
    ("midpoint", "old"): ("midpoint", "#2ca02c"),
    ("backward-euler", "old"): ("backward Euler, old force", "#1f77b4"),
    ("backward-euler", "new"): ("backward Euler, new force", "#17becf"),
    ("heun", "old"): ("Heun", "#ff7f0e"),
    ("rk4", "old"): ("RK4", "#9467bd"),
    ("rk8", "old"): ("RK8", "#8c564b"),
    ("exact", "old"): ("exact, force held", "#7f7f7f"),
    ("gautschi", "old"): ("Gautschi", "#e7298a"),
    ("adaptive", "continuous"): ("adaptive", "black"),
}


Row = dict[str, str]


def read(file: pathlib.Path) -> list[Row]:
    """The rows of a table, without the # lines."""
    with open(file, newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def read_context(file: pathlib.Path) -> Row:
    """What the # lines say: {what: which}."""
    with open(file, encoding="utf-8") as lines:
        return dict(line[2:].rstrip("\n").split(": ", 1) for line in lines if line.startswith("# "))
