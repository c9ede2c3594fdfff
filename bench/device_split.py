#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Where the instructions that tests/ptx counts come from: shares of the source files, and of the
functions' callers where a file holds but helpers.

usage: device_split.py PTX LINES

PTX is a file that tests/ptx/make_ptx.py wrote, LINES what device_counts wrote of a stretch of its
march. An instruction counts for the innermost file of the kernels that is not one of HELPERS.
Standard library only.
"""
import collections
import pathlib
import re
import sys

HELPERS = {"lanes.hpp", "function.hpp", "check.hpp"}  # called from everywhere
FILE = re.compile(r'\s*\.file\s+(\d+)\s+"([^"]*)"')
PLACE = re.compile(r"\s*\.loc\s+(\d+)\s+(\d+)\s+(\d+)"
                   r"(?:.*inlined_at\s+(\d+)\s+(\d+)\s+(\d+))?")


def source_of(place, inlined_at, files):
    """The kernels' file that a place belongs to."""
    seen = set()
    while place is not None and place not in seen:
        seen.add(place)
        path = files.get(place[0], "")
        if "/kernels/" in path and pathlib.Path(path).name not in HELPERS:
            return path.split("/kernels/")[-1]
        place = inlined_at.get(place)
    return "elsewhere"


def main():
    if len(sys.argv) != 3:
        raise SystemExit(__doc__.split("\n\n")[1])
    lines = pathlib.Path(sys.argv[1]).read_text().splitlines()
    files = {int(number): path for number, path in
             (match.groups() for match in map(FILE.match, lines) if match)}
    times = {}
    for row in pathlib.Path(sys.argv[2]).read_text().splitlines():
        line, count = map(int, row.split())
        times[line] = count
    counts, inlined_at, place = collections.Counter(), {}, None
    for number, line in enumerate(lines, 1):
        if match := PLACE.match(line):
            words = [int(word) if word else None for word in match.groups()]
            place = tuple(words[:3])
            if words[3] is not None:
                inlined_at[place] = tuple(words[3:])
            else:
                inlined_at.pop(place, None)
        elif times.get(number):
            counts[source_of(place, inlined_at, files)] += times[number]
    total = sum(counts.values())
    for source, count in counts.most_common():
        print(f"{count / total:7.2%}  {source}")


if __name__ == "__main__":
    main()
