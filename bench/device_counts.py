#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What a GPU would have to issue for a step of the paper's scenes, counted without one, and compared with what it was.

usage: device_counts.py [--renew] PROGRAM PTX

PROGRAM is build/release/tests/device_counts. PTX is a folder that tests/ptx/make_ptx.py wrote. A count that is more
than 3 % above that of bench/device_counts.json is an error. --renew writes the file anew: for a rise on purpose, and
after a gain, so that it stays. Standard library only.

Of a step (backward_euler) or a stride (adaptive): `ptx_instructions` and `loads` that a warp issues, `sums`:
reductions over its lanes. `local_bytes`: a lane's local memory. `counted`: steps or strides. `in_contact`: the share of
the time steps with a contact.
"""
import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
KEPT = ROOT / "bench/device_counts.json"
GATED = ["ptx_instructions", "loads", "sums", "local_bytes"]
MARGIN = 1.03


def counts_of(program, ptx):
    done = subprocess.run([program, ptx, ROOT / "scenes"], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr or f"{program} ends with status {done.returncode}")
    return {name: {key: float(f"{value:.6g}") for key, value in of.items()}
            for name, of in json.loads(done.stdout).items()}


def rises(now, kept):
    """What is more than it may be, in words."""
    for name, of in kept.items():
        for key in GATED:
            if now[name][key] > MARGIN * of[key]:
                yield f"{name}: {key} rose from {of[key]:g} to {now[name][key]:g}"


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("ptx", type=pathlib.Path)
    parser.add_argument("--renew", action="store_true")
    asked = parser.parse_args()
    now = counts_of(asked.program.resolve(), asked.ptx)
    print(json.dumps(now, indent=2))
    if asked.renew:
        KEPT.write_text(json.dumps(now, indent=2) + "\n")
        return 0
    faults = list(rises(now, json.loads(KEPT.read_text())))
    if faults:
        print("A GPU would have more to do:\n  " + "\n  ".join(faults) + "\nWhere this is on purpose, renew the counts "
              f"and commit them: bench/device_counts.py --renew {asked.program} {asked.ptx}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
