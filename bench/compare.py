#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compare.py OLD NEW [--filter REGEX] [--rounds N]: two builds of one benchmark, run in turns.

A table of the cases: processor time a step of both, the ratio of the medians, and how far the medians
of two halves of one program's own rounds are apart. What is slower by more than that, and by more than
2 %, is marked.
"""

import argparse
import json
import statistics
import subprocess
import tempfile


def times(program, pattern):
    with tempfile.NamedTemporaryFile() as out:
        subprocess.run([program, f"--benchmark_filter={pattern}", f"--benchmark_out={out.name}",
                        "--benchmark_out_format=json"], check=True, capture_output=True)
        cases = json.load(out)["benchmarks"]
    return {case["name"].removesuffix("/manual_time"): case.get("cpu_ns_per_step", case["cpu_time"])
            for case in cases if case.get("run_type", "iteration") == "iteration"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--filter", default="-small", help="cases; all but the small ones")
    parser.add_argument("--rounds", type=int, default=8)
    asked = parser.parse_args()
    found = {asked.old: {}, asked.new: {}}
    for round_ in range(asked.rounds):
        for program in (asked.old, asked.new) if round_ % 2 == 0 else (asked.new, asked.old):
            for name, time in times(program, asked.filter).items():
                found[program].setdefault(name, []).append(time)
    slower = 0
    print(f"{'case':48} {'old':>10} {'new':>10}  new/old  scatter")
    for name, old in found[asked.old].items():
        new = found[asked.new].get(name)
        if new is None:
            print(f"{name:48} only in the old program")
            continue
        ratio = statistics.median(new) / statistics.median(old)
        scatter = max(abs(statistics.median(t[::2]) / statistics.median(t[1::2]) - 1)
                      for t in (old, new)) if asked.rounds > 1 else float("nan")
        worse = ratio > 1 + max(0.02, scatter)
        slower += worse
        print(f"{name:48} {statistics.median(old):10.3f} {statistics.median(new):10.3f}  {ratio:7.3f}  "
              f"{scatter:7.3f}{'  slower' if worse else ''}")
    print(f"{slower} of {len(found[asked.old])} cases are slower")


if __name__ == "__main__":
    main()
