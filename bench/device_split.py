#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From which files of kernels/ the instructions come that tests/ptx counts.

usage: device_split.py PTX LINES [FILE]

PTX is a file that tests/ptx/make_ptx.py wrote, LINES what device_counts wrote of a stretch of its
march. Prints the share of each file. What stands in one of HELPERS counts for the file that calls
it. With FILE: the share of each of its lines, and how often its instructions were run: another
number for each copy that the compiler made of the line. Standard library only.
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
    """The kernels' file and line that a place belongs to."""
    seen = set()
    while place is not None and place not in seen:
        seen.add(place)
        path = files.get(place[0], "")
        if "/kernels/" in path and pathlib.Path(path).name not in HELPERS:
            return path.split("/kernels/")[-1], place[1]
        place = inlined_at.get(place)
    return "elsewhere", 0


def main():
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__.split("\n\n")[1])
    lines = pathlib.Path(sys.argv[1]).read_text().splitlines()
    only = sys.argv[3] if len(sys.argv) == 4 else None
    files = {int(number): path for number, path in
             (match.groups() for match in map(FILE.match, lines) if match)}
    times = {}
    for row in pathlib.Path(sys.argv[2]).read_text().splitlines():
        line, count = map(int, row.split())
        times[line] = count
    counts, copies = collections.Counter(), collections.defaultdict(set)
    inlined_at, place = {}, None
    for number, line in enumerate(lines, 1):
        if match := PLACE.match(line):
            words = [int(word) if word else None for word in match.groups()]
            place = tuple(words[:3])
            if words[3] is not None:
                inlined_at[place] = tuple(words[3:])
            else:
                inlined_at.pop(place, None)
        elif times.get(number):
            file, source_line = source_of(place, inlined_at, files)
            key = file
            if only is not None and pathlib.Path(file).name == only:
                key = source_line
                copies[key].add(times[number])
            counts[key] += times[number]
    total = sum(counts.values())
    for key, count in counts.most_common():
        if only is None:
            print(f"{count / total:7.2%}  {key}")
        elif key in copies:
            print(f"{count / total:7.2%}  {only}:{key}  {sorted(copies[key], reverse=True)}")


if __name__ == "__main__":
    main()
