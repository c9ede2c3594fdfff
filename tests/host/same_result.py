#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""same_result.py A.h5 B.h5: every dataset of the two result files is equal, bit for bit, but for
what the run cost."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bits"))
from same_bits import compare_results, read

differences = compare_results(sys.argv[1], sys.argv[2], attributes=False)
for difference in differences:
    print(difference, file=sys.stderr)
if differences:
    sys.exit(1)
data, _ = read(sys.argv[1])
assert len(data["contact/force"]) > 1 and len(data["shocks/start"]) > 0, "nothing happened"
print("same:", len(data), "datasets")
