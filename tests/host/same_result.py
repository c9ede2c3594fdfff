#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""same_result.py A.h5 B.h5: every dataset of the two result files is equal, bit for bit, but for what the run cost."""
import sys

import h5py
import numpy as np


def datasets(file):
    found = {}
    file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


with h5py.File(sys.argv[1], "r") as a, h5py.File(sys.argv[2], "r") as b:
    left, right = datasets(a), datasets(b)
assert left.keys() == right.keys(), left.keys() ^ right.keys()
COST = {f"summary/{name}" for name in ("nodes_evaluated", "step_seconds", "wall_seconds")}
for name in left.keys() - COST:
    assert np.asarray(left[name]).tobytes() == np.asarray(right[name]).tobytes(), f"{name} differs"
assert len(left["contact/force"]) > 1 and len(left["shocks/start"]) > 0, "nothing happened"
print("same:", len(left), "datasets")
