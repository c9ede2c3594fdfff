#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compare.py OLD NEW [--filter REGEX] [--rounds N]: two builds of one benchmark, run in turns.

A table of the cases: the time of both, the ratio of the medians, and how far the medians of two
halves of one program's own rounds are apart. What is slower by more than that, and by more than 2
%, is marked. Cases that fail are named and left out.
"""

import argparse
import json
import re
import statistics
import subprocess
import tempfile


def time_of(case):
    """What the benchmark times: the march alone where it says so (manual time), else processor
    time. That of all threads counts those that wait, too."""
    return case.get("cpu_ns_per_step", case["real_time"] if "/manual_time" in case["name"]
                    else case["cpu_time"])


def times(program, pattern):
    """ns a step of every case, None of those that fail."""
    with tempfile.NamedTemporaryFile() as out:
        done = subprocess.run([program, f"--benchmark_filter={pattern}",
                               f"--benchmark_out={out.name}",
                               "--benchmark_out_format=json"], capture_output=True, text=True)
        try:
            cases = json.load(out)["benchmarks"]
        except ValueError:
            raise SystemExit(f"{program}: status {done.returncode}\n{done.stderr}")
    return {re.sub("/iterations:.*", "", case["name"]):
            None if case.get("error_occurred") else time_of(case)
            for case in cases if case.get("run_type", "iteration") == "iteration"}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--filter", default="-small", help="cases; all but the small ones")
    parser.add_argument("--rounds", type=int, default=8)
    options = parser.parse_args()
    found = {options.old: {}, options.new: {}}
    for round_ in range(options.rounds):
        for program in (options.old,
                        options.new) if round_ % 2 == 0 else (options.new, options.old):
            for name, time in times(program, options.filter).items():
                found[program].setdefault(name, []).append(time)
    slower = 0
    print(f"{'case':48} {'old':>10} {'new':>10}  new/old  scatter")
    for name, old in found[options.old].items():
        new = found[options.new].get(name)
        if new is None or None in new or None in old:
            print(f"{name:48} {'only in the old program' if new is None else 'failed'}")
            continue
        ratio = statistics.median(new) / statistics.median(old)
        scatter = max(abs(statistics.median(t[::2]) / statistics.median(t[1::2]) - 1)
                      for t in (old, new)) if options.rounds > 1 else float("nan")
        worse = ratio > 1 + max(0.02, scatter)
        slower += worse
        print(f"{name:48} {statistics.median(old):10.3f} {statistics.median(new):10.3f}  "
              f"{ratio:7.3f}  "
              f"{scatter:7.3f}{'  slower' if worse else ''}")
    print(f"{slower} of {len(found[options.old])} cases are slower")


if __name__ == "__main__":
    main()
