#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What a GPU would have to issue for a step of the paper's scenes, counted without one, and
compared with what it was.

usage: device_counts.py [--quick | --renew] PROGRAM PTX

PROGRAM is build/release/tests/device_counts. PTX is a folder that tests/ptx/make_ptx.py wrote:
adaptive and semi_implicit. A count that is more than 3 % above that of bench/device_counts.json is
an error. --quick leaves out what ptxas is needed for. --renew writes the file anew: for a rise on
purpose, and after a gain, so that it stays.

Of a step of a scene: `ptx_instructions`, `loads` and `machine_instructions` that a warp issues
(machine_code.py; `machine_error` is its share of error). Where scenes share a warp: over the steps
of all of them. `lanes_at_work`: the share of the lanes that do what is issued.
`distinct_instructions`: how many different ones of PTX are in 16 steps drawn at random. That is
what 16 scenes that keep step make a GPU fetch, and `adaptive` waits for it (docs/gpu.md).
`in_step_instructions`: what the one of them with most to do issues, summed over the phases of a
step; `_2`, `_4`: if a block had two or four times as many scenes as warps, and each warp took the
next scene in every phase.
`sums`: reductions over its lanes. `local_bytes`: a lane's local memory that the source asks for.
`registers` of a thread and `spilled_bytes`, as ptxas says, with the launch bounds of the march.
`counted`: steps. `in_contact`: the share of the time steps with a contact. ptxas and
readelf must be on the path. Standard library only.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import machine_code

ROOT = pathlib.Path(__file__).resolve().parent.parent
KEPT = ROOT / "bench/device_counts.json"
QUICK = ["ptx_instructions", "distinct_instructions", "loads", "sums", "local_bytes"]
MACHINE = ["machine_instructions", "registers", "spilled_bytes"]
MARGIN = 1.03
MOST_ERROR = 0.1


def counts_of(program, ptx, folder):
    """What the program counts; beside each stretch the times that each line of its PTX was run."""
    done = subprocess.run([program, ptx, ROOT / "scenes", folder], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr or f"{program} ends with status {done.returncode}")
    for name, of in json.loads(done.stdout).items():
        lines = (folder / f"{name}.lines").read_text().splitlines()
        yield name, of, {int(line): int(times) for line, times in (row.split() for row in lines)}


def count(program, ptx, quick):
    counts, compiled = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name, of, times in counts_of(program, ptx, folder):
            if not quick:
                march = of["march"]
                if march not in compiled:
                    compiled[march] = machine_code.MachineCode(ptx / f"{march}.ptx", folder)
                code = compiled[march]
                issued, error = code.issued(times)
                if error > MOST_ERROR:
                    raise SystemExit(f"{name}: machine_code.py is off by {error:.0%}: it no longer "
                                     "fits what ptxas makes")
                of |= {"machine_instructions": issued / of["counted"], "machine_error": error,
                       "registers": code.registers, "spilled_bytes": code.spilled_bytes}
            counts[name] = {key: value if isinstance(value, str) else float(f"{value:.6g}")
                            for key, value in of.items()}
    return counts


def expected(kept, name, key, in_contact):
    """What was counted, for another share of contact: on the line through both stretches of a
    march. Motions are chaotic, and begin with another last bit on another make of processor."""
    of = kept[name]
    other = next(there for at, there in kept.items()
                 if at != name and there["march"] == of["march"])
    slope = (of[key] - other[key]) / (of["in_contact"] - other["in_contact"])
    return of[key] + slope * (in_contact - of["in_contact"])


def rises(now, kept, keys):
    """What is more than it may be, in words."""
    for name in kept:
        for key in keys:
            most = expected(kept, name, key, now[name]["in_contact"])
            if now[name][key] > MARGIN * most:
                yield f"{name}: {key} rose from {most:g} to {now[name][key]:g}"


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("ptx", type=pathlib.Path)
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--quick", action="store_true")
    how.add_argument("--renew", action="store_true")
    options = parser.parse_args()
    now = count(options.program.resolve(), options.ptx.resolve(), options.quick)
    print(json.dumps(now, indent=2))
    if options.renew:
        KEPT.write_text(json.dumps(now, indent=2) + "\n")
        return 0
    faults = list(rises(now, json.loads(KEPT.read_text()), QUICK if options.quick
                        else QUICK + MACHINE))
    if faults:
        print("A GPU would have more to do:\n  " + "\n  ".join(faults)
              + "\nWhere this is on purpose, renew the counts "
              f"and commit them: bench/device_counts.py --renew {options.program} {options.ptx}",
              file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
