#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Memory, disk and time of a study against the number of its runs, all tiny: a first run of it, and
the same line again when all is done.

usage: study_memory.py PROGRAM [--runs N ...] [--threads N] [--folder FOLDER] [--most BYTES]

Prints for each number the largest memory of the process (peak resident set), wall times, and the
size of the ledger; at the end what each run beyond the first number adds. With --most the status is
1 where that is more memory. The tests ask for 1000 bytes: a finished run is kept as its key, its
numbers, its name and its ledger record (four hundred bytes), its point and its place in the table
(two hundred), and some of these stand twice while the table is written; of a run's heights, which
would be five thousand bytes here, nothing may stay. Needs Linux and its Python alone.

    bench/study_memory.py build/release/ra2d
"""
import argparse
import os
import pathlib
import subprocess
import tempfile
import time

BASE = """[scene]
duration = 2e-5
speed = 0.1
start = 0.02
gap = "touching"
spacing = 1e-4
faces = "linear"
[resonator]
support = "pinned"
length = 0.06
thickness = 1e-3
width = 0.02
young = 210e9
density = 7800
damping = 0.02
modes = 2
surface = { kind = "gaussian", rq = 3e-6, rsm = 1e-3, seed = 2 }
[slider]
support = "free"
length = 0.01
thickness = 4e-3
width = 0.02
young = 210e9
density = 7800
damping = 0.02
modes = 0
surface = { kind = "gaussian", rq = 3e-6, rsm = 1e-3, seed = 1 }
[contact]
stiffness = 1e13
[time]
scheme = "adaptive"
tolerance = 1e-6
[output]
rate = 1e5
"""


def measured(words, folder):
    """Peak of the memory in bytes, and seconds."""
    begun = time.perf_counter()
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"the study ended with {process.returncode}")
    return used.ru_maxrss * 1024, time.perf_counter() - begun


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("program")
    parser.add_argument("--runs", type=int, nargs="+", default=[10, 1000, 10000])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--most", type=float, default=float("inf"))
    parser.add_argument("--folder",
                        help="where the studies stand while they run [the system's own for such]")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    rows = []
    print(f"{'runs':>8} {'peak':>10} {'time':>9} {'again: peak':>12} {'time':>9} {'ledger':>12}")
    for runs in options.runs:
        with tempfile.TemporaryDirectory(dir=options.folder) as place:
            folder = pathlib.Path(place)
            (folder / "base.toml").write_text(BASE)
            (folder / "study.toml").write_text(f'base = "base.toml"\nseeds = {runs}\n')
            words = [program, "study", "study.toml", "-o", "out", "--threads", str(options.threads)]
            first, again = measured(words, folder), measured(words, folder)
            ledger = (folder / "out/ledger/all.log").stat().st_size
        rows.append((runs, first[0], again[0], ledger))
        print(f"{runs:8} {first[0] * 1e-6:7.1f} MB {first[1]:7.2f} s {again[0] * 1e-6:9.1f} MB "
              f"{again[1]:7.2f} s "
              f"{ledger:10} B")
    (few, *least), (many, *most) = rows[0], rows[-1]
    if many > few:
        names = ("memory of a first run", "memory of the line again", "ledger")
        print("each run beyond: " + ", ".join(f"{(b - a) / (many - few):.0f} B of {name}"
                                              for name, a, b in zip(names, least, most)))
        if max(b - a for a, b in zip(least[:2], most[:2])) > options.most * (many - few):
            raise SystemExit(f"that is more than {options.most:g} B of memory")


if __name__ == "__main__":
    main()
