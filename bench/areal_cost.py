#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""areal_cost.py FILE.json [--csv FILE.csv] [--picture FILE.png]: what a second of areal sliding
costs, over the spacing and over the area.

Of what `OMP_NUM_THREADS=1 bench_areal --benchmark_repetitions=3 --benchmark_out=FILE.json` wrote.
Prints the medians as a table: seconds of one core for a simulated second of `adaptive` at 1e-6,
steps and shocks a simulated second, the most nodes in contact at once, seconds until it is ready.
"""
import argparse
import collections
import csv
import json
import pathlib
import re
import statistics
import sys

from pictures import pyplot

COUNTERS = {"wall_per_second": "wall time, s/s", "steps_per_second": "steps, 1/s",
            "shocks_per_second": "shocks, 1/s", "most_nodes": "nodes at once", "ready": "ready, s"}
OVER_AREA = 32.0  # um, the spacing of the cases over the area


def read(file):
    """{(side in mm, spacing in um): {counter: median}}."""
    found = collections.defaultdict(lambda: collections.defaultdict(list))
    try:
        for case in json.loads(pathlib.Path(file).read_text())["benchmarks"]:
            name = re.match(r"second/([\d.]+)mm/([\d.]+)um/adaptive:1e-06/iterations", case["name"])
            if name and case.get("run_type") != "aggregate" and not case.get("error_occurred"):
                for counter in COUNTERS:
                    found[float(name[1]), float(name[2])][counter].append(float(case[counter]))
    except (OSError, ValueError, KeyError, TypeError) as fault:
        sys.exit(f"{file}: not what --benchmark_out writes: {fault!r}")
    if not found:
        sys.exit(f"{file}: holds no case of bench_areal")
    return {place: {counter: statistics.median(values) for counter, values in counters.items()}
            for place, counters in sorted(found.items())}


def draw(costs, picture):
    plt, _ = pyplot()
    figure, (over_spacing, over_area) = plt.subplots(1, 2, figsize=(9, 3.8), sharey=True,
                                                     layout="constrained")
    for side in sorted({side for side, _ in costs}):
        points = [(spacing, cost["wall_per_second"]) for (own, spacing), cost in costs.items()
                  if own == side]
        if len(points) > 1:
            over_spacing.loglog(*zip(*points), "o-", label=f"{side:g} x {side:g} mm")
    over_spacing.set_xlabel("spacing [µm]")
    over_spacing.set_ylabel("wall time of a simulated second [s]")
    over_spacing.legend()
    areas = [(side ** 2 / 100, cost["wall_per_second"]) for (side, spacing), cost in costs.items()
             if spacing == OVER_AREA]
    over_area.loglog(*zip(*areas), "o-")
    over_area.set_xlabel(f"area of the block [cm²], nodes {OVER_AREA:g} µm apart")
    for axes in (over_spacing, over_area):
        axes.grid(True, which="both", alpha=0.3)
    for axes, ticks in ((over_spacing, sorted({spacing for _, spacing in costs})),
                        (over_area, [area for area, _ in areas])):
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    walls = [cost["wall_per_second"] for cost in costs.values()]
    ticks = [tick for tick in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)
             if min(walls) / 2 < tick < 2 * max(walls)]
    over_spacing.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    figure.savefig(picture, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("file", help="what bench_areal --benchmark_out=FILE.json wrote")
    parser.add_argument("--csv", help="writes the table")
    parser.add_argument("--picture", help="draws it")
    request = parser.parse_args()
    costs = read(request.file)
    print("side, mm  spacing, um  " + "  ".join(COUNTERS.values()))
    for (side, spacing), cost in costs.items():
        print(f"{side:8g}  {spacing:11g}  " + "  ".join(f"{cost[name]:{len(head)}.4g}"
                                                        for name, head in COUNTERS.items()))
    if request.csv:
        with open(request.csv, "w", newline="") as out:
            lines = csv.writer(out, lineterminator="\n")
            lines.writerow(["side, mm", "spacing, um", *COUNTERS.values()])
            lines.writerows([side, spacing, *(f"{cost[name]:.4g}" for name in COUNTERS)]
                            for (side, spacing), cost in costs.items())
    if request.picture:
        draw(costs, request.picture)


if __name__ == "__main__":
    main()
