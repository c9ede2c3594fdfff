#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What surfaces and results take: wall time and peak memory of `ra2d surface generate` of a profile
of 1e6 nodes, of `ra2d surface measure` of one, and of `ra2d analyze` of a second of the paper's
scene at 100 kHz.

usage: analysis.py [--rounds N] [--nodes N] [--seconds S] [--folder FOLDER] PROGRAM [OTHER_PROGRAM
       ...]

Makes its inputs itself, with the first program. The programs take turns, so that all see the same
machine. Files go to FOLDER (/dev/shm unless told otherwise: a disk is another matter) and are
removed. Prints medians of the wall time from start to exit and of the processor time of all threads
in ms, the least wall time, and the largest peak of memory in MB. Standard library only.

    bench/analysis.py build/release/ra2d
"""
import argparse
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

SCENE = pathlib.Path(__file__).resolve().parent.parent / "scenes" / "dang2012.toml"
SPACING = 1e-6  # m


def run(words):
    """(wall s, processor s, peak MB) of a command, which must end with 0."""
    begun = time.perf_counter()
    child = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    wall = time.perf_counter() - begun
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: status {child.returncode}")
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def commands(program, place, nodes):
    """What is timed: {name: words}. The first makes the profile that the second measures."""
    profile, length = place / "profile.csv", (nodes - 1) * SPACING
    return {
        "surface generate": [program, "surface", "generate", "-o", profile, "--length",
                             repr(length),
                             "--spacing", repr(SPACING), "--rq", "2e-6", "--rsm",
                             "1e-4", "--quiet"],
        "surface measure": [program, "surface", "measure", profile, "--cutoff", "8e-4",
                            "--sampling-lengths", "all"],
        "analyze": [program, "analyze", place / "out.h5"]}


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--nodes", type=int, default=1_000_000)
    parser.add_argument("--seconds", default="1")
    parser.add_argument("--folder", default="/dev/shm")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        place = pathlib.Path(folder)
        run([options.programs[0], "run", SCENE, "-o", place / "out.h5", "--quiet", "--set",
             "time.scheme=adaptive",
             "--set", "time.tolerance=1e-6", "--set", f"scene.duration={options.seconds}", "--set",
             "output.rate=100e3"])
        names = list(commands("", place, options.nodes))
        found = {(name, program): [] for name in names for program in options.programs}
        for _ in range(options.rounds):
            for program in options.programs:
                for name, words in commands(program, place, options.nodes).items():
                    found[name, program].append(run(words))
    print(f"{'ms':<17}{'wall':>8}{'least':>8}{'processor':>11}{'peak MB':>9}")
    for (name, program), times in found.items():
        walls, used, peaks = zip(*times)
        print(f"{name:<17}{1e3 * statistics.median(walls):8.1f}{1e3 * min(walls):8.1f}"
              f"{1e3 * statistics.median(used):11.1f}{max(peaks):9.1f}  {program}")


if __name__ == "__main__":
    main()
