#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""check_study.py TABLE: a study's table opens in xarray and h5py by defaults, with its axes, units
and hashes.

The study: scheme (words) x speed x seed, of which all runs of rk4 were refused.
"""
import sys

import h5py
import numpy as np
import xarray
import xxhash

import seal

table = xarray.open_dataset(sys.argv[1])
assert list(table.level.dims) == ["scheme", "speed", "seed"], table.level.dims
assert list(table.scheme.values) == ["adaptive", "heun", "rk4"], table.scheme.values
assert list(table.speed.values) == [0.1, 0.3] and list(table.seed.values) == [0, 3]
assert table.speed.attrs["units"] == "m s-1" and table.speed.attrs[
    "long_name"] == "scene.speed", table.speed.attrs
there = table.sel(scheme=["adaptive", "heun"])
assert (there.status == 0).all() and (there.message == "").all()
assert np.allclose(there.level, 20 * np.log10(there.v_rms / 1e-9), rtol=1e-12, atol=0)
assert (there.shock_rate > 0).all() and (there.wall_seconds > 0).all()
gone = table.sel(scheme="rk4")
assert (gone.status == 2).all() and all("time.step" in text for text in gone.message.values.ravel())
assert np.isnan(gone.v_rms).all() and np.isnan(gone.peak_force_median).all()
# the mean over the seeds, as a user takes it
assert table.level.mean("seed").shape == (3, 2)

with open(sys.argv[1], "rb") as file:
    data = file.read()
assert seal.has_fitting_seal(data)

with h5py.File(sys.argv[1]) as file:
    assert file.attrs["creator"] == "ra2d" and file.attrs["complete"] == 1
    assert (file.attrs["runs"], file.attrs["done"], file.attrs["failed"]) == (12, 8, 4)
    assert "[vary]" in file.attrs["study"] and "[resonator]" in file.attrs["base"]
    for name, dataset in file.items():
        data = dataset[()]
        if data.dtype == object:
            raw = b"".join(text + b"\0" for text in data.ravel())
        else:
            raw = np.ascontiguousarray(data).tobytes()
        assert dataset.attrs["xxh3_128"] == xxhash.xxh3_128_hexdigest(raw), name
        assert dataset.attrs["units"] and dataset.attrs["long_name"], name
print("fine:", len(table.variables), "variables")
