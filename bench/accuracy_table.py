#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""accuracy_table.py PREFIX.csv: what reaches an error at the least cost, as docs/ has it.

Of the table that `ra2d chart accuracy` writes: seconds of wall time per simulated second at which
each method reaches an error of the state before the 5th shock, between two of its settings
interpolated in the logarithms; the best of its kind, and in brackets how many times the time of
adaptive that is.
"""
import csv
import math
import sys

KINDS = ("adaptive", "best fixed step", "best peer, every node", "best peer, candidates")


def kind(row):
    if row["program"] != "ra2d":
        return KINDS[2] if row["nodes"] == "all" else KINDS[3]
    return KINDS[0] if row["scheme"] == "adaptive" else KINDS[1]


def time_at(points, error):
    """The least time of a method's settings that reach the error; None where none does."""
    best = None
    points = sorted(points, reverse=True)  # from the largest error on
    for (e1, t1), (e2, t2) in zip(points, points[1:]):
        if e1 >= error >= e2:
            share = math.log(e1 / error) / math.log(e1 / e2) if e1 > e2 else 1.0
            time = math.exp(math.log(t1) + share * math.log(t2 / t1))
            best = time if best is None else min(best, time)
    reached = [t for e, t in points if e <= error]
    if points and points[0][0] <= error:  # its coarsest setting will do
        best = min(reached)
    return best


methods = {}
with open(sys.argv[1]) as file:
    for row in csv.DictReader(line for line in file if not line.startswith("#")):
        if row["kind"] == "state-5" and row["law"] == "penalty" and row["error"] and row[
            "wall_median"] and float(row["error"]) > 0:
            name = row["scheme"] + (", new force" if row["contact_force"] == "new" else "")
            methods.setdefault((kind(row), name),
                               []).append((float(row["error"]), float(row["wall_median"])))
print("| error | " + " | ".join(f"`{k}`" if k == "adaptive" else k for k in KINDS) + " |\n|"
      + "---|" * (len(KINDS) + 1))
for error in (1e-3, 1e-5, 1e-7, 1e-9):
    cells, own = [], None
    for k in KINDS:
        times = [(time, name) for (of, name), points in methods.items() if of == k
                 and (time := time_at(points, error))]
        if not times:
            cells.append("none")
            continue
        time, name = min(times)
        own = own or time
        cells.append(f"{time:.3g}" if k == "adaptive"
                     else f"{time:.2g} ({time / own:.{1 if time < 5 * own else 0}f}) {name}")
    print(f"| {error:.0e} | ".replace("e-0", "e-") + " | ".join(cells) + " |")
