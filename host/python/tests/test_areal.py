# SPDX-License-Identifier: BSD-3-Clause
"""Results of areal scenes: maps, numbers of half waves, and what is not there."""
import re

import numpy as np
import pytest

import ra2d
from ra2d import page_words

BLOCK = {"length": 2e-3, "width": 1.5e-3}


@pytest.fixture(scope="module")
def areal(folder):
    scene = ra2d.scene("areal").change({f"slider.{key}": value for key, value in BLOCK.items()},
                                      duration=1e-3, spacing=50e-6)
    return ra2d.run(scene, output=folder / "areal.h5", show=False)


def test_faces_are_maps(areal):
    assert areal.is_areal
    face, under = areal.profile("slider"), areal.profile("resonator")
    assert face.dims == ("y", "position") and face.shape == (30, 41)
    assert under.sizes["y"] == 30 and float(under.y[0]) == pytest.approx(0.2 / 2 - 0.75e-3 + 25e-6)
    assert np.allclose(np.diff(face.y), 50e-6) and np.allclose(np.diff(face.position), 50e-6)


def test_modes_have_their_half_waves(areal):
    """Frequencies of a pinned plate: sqrt(D/mu) pi/2 (m^2/a^2 + n^2/b^2)."""
    modes = areal.modes("resonator")
    stiffness = 210e9 * 0.002**3 / (12 * (1 - 0.3**2))
    expected = np.sqrt(stiffness / (7800 * 0.002)) * np.pi / 2 * ((modes.mode_x / 0.3) ** 2 + (modes.mode_y / 0.2) ** 2)
    assert modes.sizes["mode"] == 174 and np.allclose(modes.frequency, expected, rtol=1e-13)
    assert modes.displacement.units == "m2" and modes.mean_square.units == "m-2"
    assert "shape" not in modes and areal.modes("slider").sizes["mode"] == 3


def test_fields_are_refused_by_name(areal):
    with pytest.raises(ra2d.RequestError, match="areal scene, whose fields are not built yet"):
        areal.field(0.0)


def test_pages_say_what_was_requested(areal):
    facts = dict(page_words.requested(areal.scene.content()))
    assert "pinned plate" in facts["resonator"] and "Poisson" in facts["resonator"]
    assert "free block" in facts["slider"] and "across; the slider's side at 99.25 mm" in facts["spacing"]


@pytest.mark.parametrize("what", ["overview", "profiles", "force", "spectrum", "shocks", "level", "energy", "bands", "shock"])
def test_pictures_are_drawn(areal, what):
    assert areal.plot(what).axes


def test_results_are_compared(areal, folder):
    other = ra2d.run(areal.scene.change(speed=0.2), output=folder / "faster.h5", show=False)
    assert ra2d.compare(areal, other).scene.index.tolist() == ["scene.speed"]


def test_uncertainty_takes_other_seeds_and_halves_both_spacings(areal, folder):
    scene = areal.scene.change(duration=0.002, spacing_y=1.5e-4)
    budget = ra2d.uncertainty(scene, seeds=2, folder=folder / "budget", show=False)
    assert budget.table.index.tolist() == ["chance", "tolerance", "spacing", "modes", "stiffness"]
    assert budget.level.low < budget.level < budget.level.high
    assert len(set(budget.realisations["slider"])) == 2
    assert {"scene.spacing", "scene.spacing_y"} <= set(re.findall(r"scene\.\w+", budget.study.attrs["study"]))
    assert "7.5e-05" in budget.study.attrs["study"]


def test_uncertainty_of_measured_maps_is_refused_by_name(areal, folder):
    np.save(folder / "map.npy", areal.profile("slider").values)
    measured = areal.scene.change({"slider.surface": {"kind": "file", "path": str(folder / "map.npy"),
                                                      "spacing": 50e-6, "spacing_y": 50e-6}})
    with pytest.raises(ra2d.RequestError, match="slider.surface.*areal"):
        ra2d.uncertainty(measured, seeds=2, folder=folder / "measured", show=False)
