#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How often `ra2d compare` marks a difference where there is none.

usage: RA2D=build/release/ra2d PYTHONPATH=host/python bench/false_alarms.py [PAIRS] [FOLDER]

Second runs of the paper's scene have contacts stiffer by 1e-7: their trajectories part, their
statistics do not. Expected: 5 % of the quantities, and 5 % of the families of third octaves. Then
neighbours, whose seeds differ: what the test would mark, had it not been told that the faces
differ. Then sets of five runs with other seeds on either side.

Found with 60 pairs: 18 of 420 and 3 of 60; between seeds 155 of 413; between sets 22 of 420.
"""
import pathlib
import random
import sys
import warnings

import ra2d

COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 60
FOLDER = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "false-alarms")


def run(k: int, stiffness: float) -> ra2d.Result:
    return ra2d.run("dang2012", {"slider.surface.seed": 100 + k, "resonator.surface.seed": 3000 + k,
                                 "contact.stiffness": stiffness}, tolerance=1e-6,
                    output=FOLDER / f"{k}-{stiffness!r}.h5",
                    show=False)


def say(what: str, found: list[ra2d.Comparison]) -> None:
    marked = sum(int((one.answers.chance < 0.05).sum()) for one in found)
    tested = sum(int(one.answers.chance.notna().sum()) for one in found)
    families = sum(bool((one.bands.chance < 0.05).any()) for one in found)
    print(f"{what}: {marked} of {tested} quantities, {families} of {len(found)} families of third "
          "octaves", flush=True)


warnings.simplefilter("ignore", ra2d.Notice)
FOLDER.mkdir(exist_ok=True)
first, second = ([run(k, stiffness) for k in range(COUNT)] for stiffness in (1e15, 1.0000001e15))
say("the same faces", [ra2d.compare(a, b) for a, b in zip(first, second)])
say("other seeds", [ra2d.compare(a, b) for a, b in zip(first, first[1:])])
chosen = random.Random(1)
sets = [chosen.sample(first, 10) for _ in range(COUNT)] if COUNT >= 10 else []
say("sets of five", [ra2d.compare(one[:5], one[5:]) for one in sets])
