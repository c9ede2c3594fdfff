# SPDX-License-Identifier: BSD-3-Clause
"""What the cases of the validation chapter share.

A case is a script NAME.py with a function `compare(case)`. It drives the program as a user would,
compares, and hands what it found to its Case: checks (numbers with a bound), texts for the chapter,
tables, a figure.

    bench/validation/NAME.py PROGRAM [--short] [--peers PROGRAM] [--folder docs/validation]

The whole case writes NAME.json (texts and numbers), NAME.csv and NAME.svg into the folder; page.py
makes docs/validation.md of them. --short takes a part of the case that a test has time for, and
writes nothing. Either ends with status 1 when a number leaves its bound.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
from pictures import pyplot


def shown(value, digits=2):
    """A number as the chapter has it: 1.8e-7, 0.014, 353."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.{max(digits, 1 + math.floor(math.log10(abs(value))))}g}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa}e{int(exponent)}"  # of 1e-07: 1e-7


def markdown(header, rows):
    """A table as the chapter has it."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def to_toml(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {to_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(to_toml, value)) + "]"
    return repr(value)  # the number to its last bit


def scene_text(scene):
    """A scene, {section: {key: value}}, as TOML."""
    return "\n".join(f"[{section}]\n" + "".join(f"{key} = {to_toml(value)}\n"
                                                for key, value in keys.items())
                     for section, keys in scene.items())


class Case:
    def __init__(self, name, options, folder):
        self.name, self.short, self.folder = name, options.short, options.folder
        self.program, self.peers = options.program, options.peers
        self.scratch = pathlib.Path(folder)
        self.checks, self.texts, self.rows, self.picture = {}, {}, None, None

    def call(self, program, *words):
        """What a program prints on stdout; ends the case where it fails."""
        done = subprocess.run([program, *map(str, words)], text=True, capture_output=True)
        if done.returncode:
            sys.exit(f"{self.name}: {program} {' '.join(map(str, words))} ended with "
                     f"{done.returncode}:\n{done.stderr}")
        return done.stdout

    def scene_file(self, scene):
        """A file of a scene: a dictionary, or a file that is there."""
        if isinstance(scene, dict):
            file = self.scratch / "scene.toml"
            file.write_text(scene_text(scene))
            return file
        return scene

    def run(self, scene, *datasets, sets=()):
        """Runs a scene and returns the datasets asked for, each an array; `sets`:
        section.key=value."""
        result = self.scratch / "result.h5"
        self.call(self.program, "run", self.scene_file(scene), "-o", result, "--fresh",
                  "--force", "--quiet",
                  *(word for each in sets for word in ("--set", each)))
        with h5py.File(result) as file:
            return [file[name][()] for name in datasets]

    def check(self, what, value, most, why):
        """A number and its bound. `why`: where the bound comes from. Of several of one name the
        nearest to its bound counts, or the first beyond."""
        value, most, previous = float(value), float(most), self.checks.get(what)
        if previous is None or previous[0] <= previous[1] and not value / most <= previous[
            0] / previous[1]:
            self.checks[what] = (value, most, why)

    def text(self, name, value, digits=2):
        """What stands in the chapter at {{case.name}}: a text, or a number with so many digits."""
        self.texts[name] = value if isinstance(value, str) else shown(float(value), digits)

    def table(self, header, rows):
        """The numbers of the case, for other programs."""
        self.rows = [header, *rows]

    def figure(self, figure):
        self.picture = figure

    def broken(self):
        """The checks that fail: one line each. NaN is beyond any bound."""
        return [f"{what}: {value:.3g} is beyond {most:.3g} ({why})"
                for what, (value, most, why) in self.checks.items() if not value <= most]

    def write(self, seconds):
        self.folder.mkdir(parents=True, exist_ok=True)
        self.texts["checks"] = markdown(("what", "found", "bound", "where the bound comes from"),
                                        [(what, shown(value), shown(most), why)
                                         for what, (value, most, why) in self.checks.items()])
        self.text("seconds", seconds, 1)
        with open(self.folder / f"{self.name}.json", "w") as file:
            json.dump(self.texts, file, indent=1)
            file.write("\n")
        with open(self.folder / f"{self.name}.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(self.rows)
        if self.picture:
            _, style = pyplot()
            (self.folder / f"{self.name}.svg").write_bytes(style.Picture.drawn(self.picture, "svg"))


def main(name, compare):
    parser = argparse.ArgumentParser(description=f"The case {name} of docs/validation.md.")
    parser.add_argument("program", help="ra2d")
    parser.add_argument("--short", action="store_true",
                        help="a part of it, for the tests; writes nothing")
    parser.add_argument("--peers", help="ra2d_peers; without it what needs it is left out")
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "docs" / "validation")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        case = Case(name, options, folder)
        compare(case)
    for what, (value, most, why) in case.checks.items():
        print(f"{name}: {what}: {value:.3g}, at most {most:.3g}")
    broken = case.broken()
    if not case.checks:
        broken = ["nothing was checked"]
    if broken:
        sys.exit("\n".join(f"{name}: {line}" for line in broken))
    if not case.short:
        # processor time, with that of the programs: others may use the machine
        case.write(sum(os.times()[:4]))
