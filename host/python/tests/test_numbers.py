# SPDX-License-Identifier: BSD-3-Clause
"""Numbers are the program's own; fields agree with what the program wrote at its probes."""
import json
import pathlib
import resource
import subprocess
import time

import h5py
import numpy as np
import pytest

import ra2d
from ra2d import plots


def answer(*words):
    return json.loads(subprocess.run([ra2d.find(), *map(str, words), "--json"], capture_output=True,
                                     check=True).stdout)


def test_level_and_rate_are_those_of_analyze(result):
    messages = answer("analyze", result.path)
    assert (result.level, result.level.low, result.level.high) == (
        messages["lv"], messages["lv_interval"]["low"], messages["lv_interval"]["high"])
    rate = messages["shocks"]["rate_interval"]
    assert (result.shock_rate, result.shock_rate.low) == (messages["shocks"]["rate"], rate["low"])
    assert len(result.shocks) == messages["shocks"]["count"]


def test_an_analysis_is_its_callers_own(result):
    """What is changed in it changes no later answer."""
    found, level = result.analysis(), float(result.level)
    found["lv"] += 20
    found["bands"]["level"].clear()
    assert result.level == level and result.bands().sizes["frequency"] > 10


def test_what_was_read_can_be_set(result):
    """As of any Dataset; the file stays as it is."""
    probes = result.probes
    probes.velocity[:1000] = 0
    assert float(abs(probes.velocity[:1000]).max()) == 0 < float(abs(probes.velocity).max())
    assert float(abs(result.probes.velocity[:1000]).max()) > 0


def test_a_level_without_interval_says_why(base, folder):
    short = ra2d.run(base, duration=0.01, output=folder / "short.h5", show=False)
    assert np.isnan(short.level.low) and "too short" in short.level.note
    assert "no interval" in repr(short.level)


def test_spectrum_and_bands_are_those_of_analyze(result):
    messages = answer("analyze", result.path, "--from", 0.2, "--resolution", 50)
    spectrum = result.spectrum(start=0.2, resolution=50.0)
    assert np.array_equal(spectrum.density, messages["spectrum"]["psd_mean"])
    assert np.array_equal(spectrum.density_probe.sel(position=0.15),
                          messages["spectrum"]["psd_probe"][0])
    bands = result.bands(start=0.2, resolution=50.0, a_weighting=True)
    assert np.array_equal(bands.level,
                          messages["bands"]["level"]) and (bands.level_a < bands.level).any()


def test_spectrum_and_bands_are_tables_without_probes_too(base, folder):
    none = ra2d.run(base, {"output.probes": []}, duration=0.02, output=folder / "no-probe.h5",
                    show=False)
    for found in (none.spectrum(), none.bands()):
        assert len(found.to_dataframe()) == found.sizes["frequency"] > 0


@pytest.mark.parametrize("what", ["displacement", "velocity"])
def test_field_passes_through_the_probes(result, what):
    """At a place of the shapes to rounding; between two of them to the error of a straight line,
    h^2/8 times the curvature: its modes have wave numbers up to 19 pi/L."""
    field = result.field(slice(0.3, 0.31), what=what)
    probe = result.probes[what].sel(time=slice(0.3, 0.31))
    size = float(abs(probe).max())
    assert abs(field.sel(position=0.152, method="nearest")
               - probe.sel(position=0.152)).max() < 1e-12 * size
    h, wave = float(field.position[1]), 19 * np.pi / 0.3
    apart = abs(field.interp(position=0.15) - probe.sel(position=0.15)).max()
    assert apart < (h * wave) ** 2 / 8 * float(abs(field).max())


def test_field_takes_the_nearest_sample_and_the_slider(result):
    assert float(result.field(0.1000049).time) == pytest.approx(0.1)
    assert result.field([0.1, 0.2], body="slider").shape == (2,
                                                             result.modes("slider").sizes[
                                                                 "position"])


def test_level_in_time_is_the_level_of_each_stretch(result):
    """Of the program over the samples of one window."""
    time_, levels = plots.level_in_time(result)
    edges = np.linspace(0, result.samples, len(levels) + 1).astype(int)
    messages = answer("analyze", result.path, "--from", edges[40] / 1e5, "--to",
                      (edges[41] - 1) / 1e5)
    assert levels[40] == pytest.approx(messages["lv"], abs=1e-9)
    assert edges[40] / 1e5 < time_[40] < edges[41] / 1e5


def test_series_have_units(result):
    for group in (result.probes, result.contact, result.energy, result.modes(), result.spectrum(),
                  result.bands()):
        for name, values in group.variables.items():
            if values.dtype.kind == "f":
                assert values.attrs.get("units"), name


def test_ten_gigabytes_open_at_once(result, folder):
    big = folder / "big.h5"
    with h5py.File(result.path, "r") as old, h5py.File(big, "w") as new:
        new.attrs.update(old.attrs)
        old.copy("summary", new)
        group = new.create_group("resonator")
        for name in ("mode", "position", "frequency", "mean_square", "shape"):
            old.copy(f"resonator/{name}", group)
        rows = 10 * 2**30 // (8 * 19)
        group["time"] = new["time"] = np.arange(4) / 1e5
        plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)  # room on the disk, unwritten
        plan.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        plan.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        space = h5py.h5s.create_simple((rows, 19))
        h5py.h5d.create(group.id, b"velocity", h5py.h5t.NATIVE_DOUBLE, space, plan)
    assert big.stat().st_size > 10 * 2**30
    before, used = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    opened = ra2d.load(big)
    assert repr(opened)
    with h5py.File(big, "r") as file:
        from ra2d import stored
        velocity = stored._Dataset(stored.File(big), "resonator/velocity",
                                   file["resonator/velocity"])
    assert velocity.shape == (rows, 19)
    assert time.process_time() - before < 0.1
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - used < 50_000  # kB
    big.unlink()


def test_what_is_no_result_is_refused(folder, profile):
    with pytest.raises(ra2d.FileError, match="cannot read"):
        ra2d.load(profile)
    with h5py.File(folder / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(ra2d.FileError, match="no result of 'ra2d run'"):
        ra2d.load(folder / "other.h5")
    with pytest.raises(ra2d.RequestError, match="load_study"):
        ra2d.load(folder)


def test_a_later_format_is_refused(result, folder):
    copy = folder / "later.h5"
    copy.write_bytes(pathlib.Path(result.path).read_bytes())
    with h5py.File(copy, "r+") as file:
        file.attrs["format"] = 99
    with pytest.raises(ra2d.FileError, match="format 99"):
        ra2d.load(copy)


def test_a_damaged_result_has_the_programs_message(result, folder):
    data = bytearray(pathlib.Path(result.path).read_bytes())
    for at in range(len(data) // 5, len(data) * 4 // 5, 50_000):
        data[at] ^= 1
    (folder / "damaged.h5").write_bytes(data)
    with pytest.raises(ra2d.FileError, match="damaged|cannot read"):
        ra2d.load(folder / "damaged.h5").level
