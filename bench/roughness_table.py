#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's Table 2 beside random profiles: for each of its rows, profiles of the plate's length with the row's Rq, RSm
and Rku are generated and measured, and the median and the middle 90 % of each parameter are printed.

usage: roughness_table.py [--seeds N] PROGRAM

The paper names no filter and no sampling length. Without a filter and with sampling lengths of 2.5 mm its Rz comes out.
RSm is that of ISO 21920-2, which leaves out small elements: --rsm of `surface generate`, between crossings of the mean
line, is set so that the median RSm is the paper's. Standard library only.

    bench/roughness_table.py build/release/ra2d
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

NAMES = ("Rq", "Rt", "Rz", "Ra", "Rku", "RSm")
ROWS = ((2, 12.8, 6.0, 1.7, 3.6, 1574), (4, 27.8, 12.2, 3.5, 4.6, 1520), (8, 53.0, 23.5, 6.8, 3.6, 1560),
        (12, 86.7, 36.1, 10.4, 3.8, 1552), (20, 138, 61, 17.6, 4.2, 1546))  # um, but for Rku
CROSSING = 1.19  # RSm over the mean distance of upward crossings, of such profiles


def measured(program, folder, row, seed):
    profile = pathlib.Path(folder) / "profile.csv"
    rq, rku, rsm = row[0], row[4], row[5]
    subprocess.run([program, "surface", "generate", "-o", profile, "--length", "0.3", "--spacing", "8e-6",
                    "--rq", f"{rq}e-6", "--rsm", f"{rsm / CROSSING:.6g}e-6", "--kurtosis", str(rku), "--seed", str(seed),
                    "--quiet"], check=True)
    text = subprocess.run([program, "surface", "measure", profile, "--filter", "none", "--cutoff", "2.5e-3",
                           "--sampling-lengths", "all", "--json"], check=True, text=True, stdout=subprocess.PIPE).stdout
    found = json.loads(text)["parameters"]
    return [found[name] * (1 if name == "Rku" else 1e6) for name in NAMES]


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=100)
    asked = parser.parse_args()
    print("| | " + " | ".join(f"{name}{'' if name == 'Rku' else ', um'}" for name in NAMES) + " |")
    print("|---" * (len(NAMES) + 1) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for row in ROWS:
            columns = list(zip(*(measured(asked.program, folder, row, seed) for seed in range(asked.seeds))))
            print("| paper | " + " | ".join(f"{value:g}" for value in row) + " |")
            cells = []
            for column in columns:
                cut = statistics.quantiles(column, n=20)
                cells.append(f"{statistics.median(column):.4g} ({cut[0]:.4g} to {cut[-1]:.4g})")
            print("| here | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
