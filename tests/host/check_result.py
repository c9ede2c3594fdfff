#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks a result file as its users open it: with h5py, netCDF4 and xarray, defaults only.

    check_result.py OUT.h5

The file must end in its seal. Names, axes, units, long names, coordinates and shapes must be those
of docs/results.md, and the numbers those of their hashes. Times carry the unit "s": xarray makes
time differences of "seconds", but leaves "s" as numbers. Every group has the values along its axes;
the time of the samples is one dataset with a link in each.
"""
import sys

import h5py
import netCDF4
import numpy as np
import xarray
import xxhash

import seal

TIME, SHOCK = ("time",), ("shock",)
MODE, MODES, PROBES, NODES = ("mode",), ("time", "mode"), ("time", "position"), ("position",)
BODY = {"mode": ("1", MODE), "position": ("m", NODES), "frequency": ("Hz", MODE),
        "shape": ("m-0.5", ("mode", "position")),
        "mean_square": ("m-1", MODE), "displacement": ("m1.5", MODES),
        "velocity": ("m1.5 s-1", MODES), "time": ("s", TIME)}
PROBE = {"position": ("m", NODES), "displacement": ("m", PROBES), "velocity": ("m s-1", PROBES),
         "time": ("s", TIME)}
SUMMARY = {"lv": "dB", "lv_low": "dB", "lv_high": "dB", "v_rms": "m s-1", "shock_rate": "s-1",
           "shock_rate_low": "s-1", "shock_rate_high": "s-1", "shock_duration_median": "s",
           "shock_duration_90": "s",
           "peak_force_median": "N", "peak_force_90": "N", "contact_share": "1",
           "nodes_evaluated": "1", "energy_residual": "J",
           "energy_turnover": "J", "energy_closure": "1", "step_seconds": "s", "wall_seconds": "s"}
DATASETS = {  # group: {name: (units, axes)}
    "": {"time": ("s", TIME)},
    "resonator": BODY,
    "slider": BODY,
    "contact": {"force": ("N", TIME), "nodes": ("1", TIME), "time": ("s", TIME)},
    "probes": PROBE,
    "slider_probes": PROBE,
    "energy": {name: ("J", TIME) for name in ("kinetic", "elastic", "contact", "damping_loss",
                                              "sliding_work", "load_work")} | {"time": ("s", TIME)},
    "shocks": {"shock": ("1", SHOCK), "start": ("s", SHOCK), "duration": ("s", SHOCK),
               "peak_force": ("N", SHOCK), "impulse": ("N s", SHOCK), "position": ("m", SHOCK)},
    "level": {"v_rms": ("m s-1", ()), "lv": ("dB", ())},
    "summary": {name: (unit, ()) for name, unit in SUMMARY.items()},
    "surface/slider": {"position": ("m", NODES), "height": ("m", NODES)},
    "surface/resonator": {"position": ("m", NODES), "height": ("m", NODES)},
}
AREAL_FORMAT = 5
GRID = {"mode": ("1", MODE), "position": ("m", NODES), "y": ("m", ("y",))}
HALF_WAVES = {"mode_x": ("1", MODE), "mode_y": ("1", MODE)}
AREAL_BODY = {"frequency": ("Hz", MODE), "shape_x": ("m-1", ("mode", "position")),
              "shape_y": ("1", ("mode", "y")), "mean_square": ("m-2", MODE),
              "displacement": ("m2", MODES), "velocity": ("m2 s-1", MODES), "time": ("s", TIME)}
AREAL_PROBE = {"probe": ("1", ("probe",)), "position": ("m", ("probe",)), "y": ("m", ("probe",)),
               "displacement": ("m", ("time", "probe")), "velocity": ("m s-1", ("time", "probe")),
               "time": ("s", TIME)}
MAP = {"position": ("m", NODES), "y": ("m", ("y",)), "height": ("m", ("y", "position"))}
AREAL_DATASETS = DATASETS | {"resonator": {**GRID, **HALF_WAVES, **AREAL_BODY},
                             "slider": {**GRID, **AREAL_BODY},
                             "probes": AREAL_PROBE, "slider_probes": AREAL_PROBE,
                             "shocks": DATASETS["shocks"] | {"y": ("m", SHOCK)},
                             "surface/slider": MAP, "surface/resonator": MAP}
# left out where there is none: without shocks, or when the run ended before output.from
NOT_ALWAYS = {"level/v_rms", "level/lv", "summary/v_rms", "summary/lv", "summary/shock_rate",
              "summary/contact_share"} | {
    f"summary/{name}" for name in SUMMARY if name.startswith(("shock_duration", "peak_force"))
    or name.endswith(("_low", "_high"))}
COUNTS = {"shocks/shock", "contact/nodes", "resonator/mode", "slider/mode", "resonator/mode_x",
          "resonator/mode_y", "probes/probe", "slider_probes/probe"}  # integers
ATTRIBUTES = {"creator": str, "format": np.integer, "version": str, "commit": str, "scene": str,
              "key": str, "backend": str, "threads": np.integer,
              "started": str, "wall_seconds": np.floating, "steps": np.integer,
              "complete": np.integer, "ended": str}


def expect(right, *what):
    if not right:
        sys.exit("check_result: " + " ".join(str(w) for w in what))


def expect_seal(path):
    """The seal of docs/results.md, made anew by another library."""
    with open(path, "rb") as file:
        data = file.read()
    expect(seal.has_fitting_seal(data), "the seal", data[-64:])


def type_of(name):
    return np.int64 if name in COUNTS else np.float64


def same(a, b):
    return np.array_equal(np.asarray(a), np.asarray(b), equal_nan=True)


def members_of(file):
    """The datasets without those that may be missing and are; h5py's own listing names a dataset of
    many links once."""
    here = {}
    for group, members in (AREAL_DATASETS if file.attrs["format"] == AREAL_FORMAT
                           else DATASETS).items():
        names = set(file[group or "/"]) - {name for name, item in file[group or "/"].items()
                                           if isinstance(item, h5py.Group)}
        here[group] = {name: what for name, what in members.items()
                       if f"{group}/{name}" not in NOT_ALWAYS or name in names}
        expect(names == set(here[group]), "h5py lists", sorted(names), "in", group)
    return here


def check_attributes(reader, attributes):
    # there when time.force passes a limit, the scene has doubts and the run has warnings
    always = [name for name in attributes if name not in ("beyond_limit", "doubts", "warnings")]
    expect(always == list(ATTRIBUTES), reader, "root attributes", list(attributes))
    for name, kind in ATTRIBUTES.items():
        expect(isinstance(attributes[name], kind), reader, name, "is", type(attributes[name]))
    expect(attributes["creator"] == "ra2d", reader, "creator")
    expect(attributes["complete"] in (0, 1), reader, "complete")


def check_variable(reader, path, variable, units, axes, shape, attributes):
    expect(attributes["units"] == units, reader, path, "units", attributes["units"])
    expect(isinstance(attributes["long_name"], str) and attributes["long_name"], reader, path,
           "long_name")
    expect(tuple(axes) == tuple(variable), reader, path, "axes", tuple(variable), "not", axes)
    expect(len(shape) == len(axes), reader, path, "shape", shape)


def check(path):
    with h5py.File(path, "r") as file:
        check_attributes("h5py", file.attrs)
        datasets = members_of(file)
        for group in datasets:
            for one in filter(None, (group, group.rpartition("/")[0])):
                expect(isinstance(file[one].attrs.get("description"), str), one,
                       "does not say what it is")
        names = [f"{group}/{name}".lstrip("/") for group, members in datasets.items()
                 for name in members]
        values = {name: file[name][()] for name in names}
        for group, members in datasets.items():
            for name, (units, axes) in members.items():
                full = f"{group}/{name}".lstrip("/")
                data = file[full]
                expect(data.dtype == type_of(full), full, data.dtype)
                expect(data.attrs["xxh3_128"]
                       == xxhash.xxh3_128_hexdigest(np.ascontiguousarray(values[full]).tobytes()),
                       full, "has another hash than", data.attrs["xxh3_128"])
                if h5py.h5ds.is_scale(data.id):
                    own = (data.attrs["NAME"].decode(),)
                else:
                    own = tuple(axis.keys()[0] for axis in data.dims)
                    for axis, length in zip(data.dims, data.shape):
                        expect(axis[0].shape == (length,), full, "and its scale differ in length")
                check_variable("h5py", full, own, units, axes, data.shape, data.attrs)

    with netCDF4.Dataset(path) as root:
        check_attributes("netCDF4", {name: root.getncattr(name) for name in root.ncattrs()})
        for group, members in datasets.items():
            here = root[group] if group else root
            expect(list(here.variables) == list(members), "netCDF4 lists", list(here.variables),
                   "in", group)
            for name, (units, axes) in members.items():
                variable = here.variables[name]
                check_variable("netCDF4", f"{group}/{name}", variable.dimensions, units, axes,
                               variable.shape,
                               {key: variable.getncattr(key) for key in variable.ncattrs()})
                expect(same(np.ma.getdata(variable[...]), values[f"{group}/{name}".lstrip("/")]),
                       "netCDF4 reads other values in", group, name)

    with xarray.open_dataset(path) as root:
        check_attributes("xarray", root.attrs)
        for group, members in datasets.items():
            with xarray.open_dataset(path, group=group or None) as here:
                expect(set(here.variables) == set(members), "xarray lists", list(here.variables),
                       "in", group)
                for name, (units, axes) in members.items():
                    variable = here[name]
                    full = f"{group}/{name}".lstrip("/")
                    check_variable("xarray", full, variable.dims, units, axes, variable.shape,
                                   variable.attrs)
                    expect(variable.dtype == type_of(full), "xarray decodes", full, "to",
                           variable.dtype)
                    expect(same(variable.values, values[full]),
                           "xarray reads other values in", full)
                    for axis in axes:
                        expect(axis in here.coords, "xarray:", full, "has no values along", axis)

    for ascending in ("time", "shocks/start"):
        expect((np.diff(values[ascending]) >= 0).all(), ascending, "is not in order")
    for name in ("shocks/start", "contact/force", "energy/kinetic"):
        expect(np.isfinite(values[name]).all(), name, "has gaps")
    return values


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    expect_seal(sys.argv[1])
    v = check(sys.argv[1])
    print(f"{sys.argv[1]}: OK in h5py, netCDF4 and xarray: {v['time'].size} samples, "
          f"{v['resonator/frequency'].size} + "
          f"{v['slider/frequency'].size} modes, {v['probes/position'].size} probes, "
          f"{v['shocks/start'].size} shocks")
