# SPDX-License-Identifier: BSD-3-Clause
"""Runs of CalculiX for the cases six-shocks and six-bumps: what it is asked, and what it prints."""
import argparse
import os
import pathlib
import subprocess
import tempfile
import time


def requested(description, meshes):
    """The options of a script that writes the input of a mesh, or runs CalculiX on some."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--input", nargs=2, metavar=("MESH", "FILE"),
                        help="writes the input of a mesh")
    parser.add_argument("--run", nargs=2, metavar=("CCX", "FOLDER"),
                        help="runs CalculiX and keeps what it finds")
    parser.add_argument("meshes", nargs="*", default=meshes,
                        help=f"of --run: {', '.join(meshes)}; all without")
    return parser.parse_args()


def version(ccx):
    return subprocess.run([ccx, "-v"], text=True, capture_output=True).stdout.split()[-1]


def solve(ccx, text):
    """What CalculiX prints of an input, on one core, and its seconds of the processor and by the
    clock."""
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        (scratch / "model.inp").write_text(text)
        begun = time.monotonic()
        with open(scratch / "log", "w") as log:
            process = subprocess.Popen([ccx, "model"], cwd=scratch, stdout=log,
                                       env={**os.environ, "OMP_NUM_THREADS": "1"})
            _, status, used = os.wait4(process.pid, 0)
        if status != 0:
            raise SystemExit(f"{ccx} did not come to the "
                             f"end:\n{(scratch / 'log').read_text()[-2000:]}")
        return (scratch / "model.dat").read_text(), used.ru_utime, time.monotonic() - begun


def increments(text, end):
    """Of each increment that was printed: its time [s], the displacement of the printed node [mm]
    and the total contact force [N, as the input has it], each as words x, y, z, and the largest
    contact pressure [MPa]. An error where the last one is not at `end` [s]."""
    rows, part, now, moved, pressure = [], None, 0.0, [], 0.0
    for line in text.splitlines():
        words = line.split()
        if "time" in words:
            part, now = words[0], float(words[-1])
            if part == "displacements":
                pressure = 0.0
        elif not words:
            continue
        elif part == "displacements":
            moved = words[1:]
        elif part == "contact" and len(words) == 5:
            pressure = max(pressure, float(words[2]))
        elif part == "statistics" and words[0] == "total":
            part = "force"
        elif part == "force":
            part = None
            rows.append((now, moved, words, pressure))
    if not rows or rows[-1][0] < end - 1e-5:
        raise SystemExit(f"CalculiX stopped at {rows[-1][0] if rows else 0:g} s of {end:g}")
    return rows
