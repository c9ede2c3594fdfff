#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What a user waits for: wall time of `ra2d run` for one second of both readings of the paper,
adaptive to a tolerance of 1e-6, and how much of it is the march.

usage: wait.py [--runs N] [--folder FOLDER] [--set KEY=VALUE ...] PROGRAM [OTHER_PROGRAM ...]

The programs take turns. Result files go to FOLDER (/dev/shm unless told otherwise: a disk is
another matter) and are removed. Prints medians in ms: from start to exit; marching; reading the
file back, where the program says so; the rest; and the processor time of all threads. Standard
library only.

    bench/wait.py build/release/ra2d
"""
import argparse
import os
import pathlib
import re
import resource
import statistics
import subprocess
import tempfile
import time

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(program, scene, settings, folder):
    """Seconds: in all, marching, reading back, processor."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        words = [program, "run", SCENES / f"{scene}.toml", "-o", os.path.join(place, "out.h5")]
        for setting in settings:
            words += ["--set", setting]
        used, begun = processor_seconds(), time.perf_counter()
        report = subprocess.run(words, check=True, text=True, stdout=subprocess.PIPE).stdout
        wall, used = time.perf_counter() - begun, processor_seconds() - used
    steps = int(re.search(r"(\d+) steps", report)[1])
    step = float(re.search(r"([\d.]+) ns a step", report)[1]) * 1e-9
    back = re.search(r"([\d.]+) s of them to read the file back", report)
    return wall, steps * step, float(back[1]) if back else 0.0, used


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--folder", default="/dev/shm")
    parser.add_argument("--set", action="append", default=[])
    options = parser.parse_args()
    settings = ["time.scheme=adaptive", "time.tolerance=1e-6", *options.set]
    print(f"{'ms':<17}{'in all':>8}{'least':>8}{'march':>8}{'back':>8}{'rest':>8}{'processor':>11}")
    for scene in ("dang2012-pinned", "dang2012"):
        times = {program: [] for program in options.programs}
        for _ in range(options.runs):
            for program, found in times.items():
                found.append(run(program, scene, settings, options.folder))
        for program, found in times.items():
            wall, march, back, used = (1e3 * statistics.median(column) for column in zip(*found))
            rest = 1e3 * statistics.median(w - m - b for w, m, b, _ in found)
            least = 1e3 * min(w for w, *_ in found)
            print(f"{scene:<17}{wall:8.1f}{least:8.1f}{march:8.1f}{back:8.1f}{rest:8.1f}"
                  f"{used:11.1f}  {program}")


if __name__ == "__main__":
    main()
