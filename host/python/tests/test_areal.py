# SPDX-License-Identifier: BSD-3-Clause
"""Results of areal scenes: maps, numbers of half waves, motion and gaps."""
import re
import shutil

import h5py
import numpy as np
import pytest
from scipy import ndimage

import ra2d
from ra2d import maps, page_words, realisations

BLOCK = {"length": 2e-3, "width": 1.5e-3}


@pytest.fixture(scope="module")
def areal(folder):
    scene = ra2d.scene("areal").change({f"slider.{key}": value for key, value in BLOCK.items()},
                                      duration=1e-3, spacing=50e-6)
    return ra2d.run(scene.change({"output.probes": [[0.1, 0.13], [0.15, 0.1]]}),
                    output=folder / "areal.h5", show=False)


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
    expected = np.sqrt(stiffness / (7800 * 0.002)) * np.pi / 2 * ((modes.mode_x / 0.3) ** 2
                                                                  + (modes.mode_y / 0.2) ** 2)
    assert modes.sizes["mode"] == 174 and np.allclose(modes.frequency, expected, rtol=1e-13)
    assert modes.displacement.units == "m2" and modes.mean_square.units == "m-2"
    assert "shape" not in modes and areal.modes("slider").sizes["mode"] == 3


def test_a_file_without_the_y_of_its_shocks_is_refused(areal, folder):
    broken = shutil.copy(areal.path, folder / "broken.h5")
    with h5py.File(broken, "r+") as file:
        del file["shocks/y"]
    with pytest.raises(ra2d.FileError, match="as a result of ra2d"):
        ra2d.load(broken).shocks  # noqa: B018
    with pytest.raises(ra2d.FileError):
        ra2d.load(broken).check()


def test_probes_have_two_coordinates(areal):
    probes = areal.probes
    assert probes.velocity.dims == ("time", "probe") and probes.probe.values.tolist() == [1, 2]
    assert probes.position.values.tolist() == [0.1,
                                               0.15] and probes.y.values.tolist() == [0.13, 0.1]
    modes = areal.modes("resonator")
    shape = 2 / np.sqrt(0.3 * 0.2) * np.sin(modes.mode_x * np.pi * 0.1
                                            / 0.3) * np.sin(modes.mode_y * np.pi * 0.13 / 0.2)
    assert np.allclose(probes.displacement.sel(probe=1), (modes.displacement * shape).sum("mode"),
                       rtol=1e-9, atol=1e-20)
    assert areal.listen(2).about["y"] == 0.1
    for found in (areal.spectrum().density_probe, areal.bands().level_probe):
        assert found.dims == ("probe", "frequency")
        assert [*zip(found.position.values, found.y.values)] == [(0.1, 0.13), (0.15, 0.1)]


def test_shocks_stand_on_the_plate_under_the_block(areal):
    shocks = areal.shocks
    assert len(shocks) > 5 and shocks.attrs["units"]["y"] == "m"
    assert shocks.y.between(0.1 - 0.75e-3, 0.1 + 0.75e-3).all() and shocks.y.nunique() > 3


def test_fields_are_maps(areal):
    times = areal.modes("resonator").time
    field = areal.field(float(times[-1]), what="velocity")
    assert field.dims == ("y", "position") and field.units == "m s-1"
    assert float(field.position[-1]) == 0.3 and float(field.y[-1]) == 0.2
    # the integral of the square over the plate is the sum over the modes; zero at the edges
    modes = areal.modes("resonator").velocity.isel(time=-1)
    square = (field**2).integrate("position").integrate("y")
    assert float(square) == pytest.approx(float((modes**2).sum()), rel=1e-9)
    assert not field.isel(y=0).any() and abs(field.isel(position=-1)).max() < 1e-12 * abs(
        field).max()
    assert areal.field(slice(0, 1e-4)).dims == ("time", "y", "position")
    assert areal.field(0.0, body="slider").dims == ("y", "position")


def test_the_gap_is_closed_at_the_nodes_in_contact(areal):
    """Nodes with no gap are as many as the program counts, and their springs carry the force."""
    contact = areal.contact.load()
    stiffness = float(areal.scene["contact.stiffness"]) * 50e-6 * 50e-6
    counted = contact.isel(time=(contact.nodes > 0).values)
    assert counted.sizes["time"] > 2
    for i in range(counted.sizes["time"]):
        gap = maps.gap(areal, float(counted.time[i]))
        assert gap.shape == (30, 41) and int((gap <= 0).sum()) == int(counted.nodes[i])
        assert stiffness * float(-gap.where(gap < 0).sum()) == pytest.approx(
            float(counted.force[i]), rel=1e-5)


def test_the_gap_of_smooth_faces_is_closed_where_their_force_acts(folder):
    scene = ra2d.scene("areal").change({f"slider.{key}": value for key, value in BLOCK.items()},
                                      duration=1e-3, spacing=62.5e-6, spacing_y=50e-6,
                                      faces="smooth")
    result = ra2d.run(scene, output=folder / "smooth.h5", show=False)
    contact = result.contact.load()
    counted = contact.isel(time=(contact.force > 0.01 * contact.force.max()).values)
    for i in range(0, counted.sizes["time"], 5):
        gap = maps.gap(result, float(counted.time[i]), points=256)
        pressed = -50e-6 * float(gap.clip(max=0).integrate("position").sum())
        # by trapezia, and a distance of the faces that is known to 1e-11 m
        assert float(scene["contact.stiffness"]) * pressed == pytest.approx(
            float(counted.force[i]), abs=2e-3 * float(contact.force.max()))
    titles = [axes.get_title("left") for axes in result.plot("shock").axes]
    assert any("brown: in contact" in title for title in titles), titles


def test_motion_is_shown_at_a_time(areal):
    figure = areal.plot("motion", time=5e-4)
    assert figure.axes[0].get_title("left").startswith("Displacement of the resonator at 500")
    assert [len(axes.images) for axes in figure.axes[:2]] == [1, 1]
    with pytest.raises(ra2d.RequestError, match="a time is chosen for the picture 'motion'"):
        areal.plot("force", time=5e-4)
    with pytest.raises(ra2d.RequestError, match="the samples go from 0"):
        areal.plot("motion", time=5.0)


def test_pages_have_the_maps(areal, folder):
    page = areal.report(folder / "areal.html").read_text()
    assert page.count('href="data:image/png;base64,') == 2
    assert page.count("</b>, probe 1 at 0.1, 0.13 m: ") == 2  # as it is, and slower


def test_pages_say_what_was_requested(areal):
    facts = dict(page_words.requested(areal.scene.content()))
    assert "pinned plate" in facts["resonator"] and "Poisson" in facts["resonator"]
    assert "free block" in facts[
        "slider"] and "across; the slider's side at 99.25 mm" in facts["spacing"]


@pytest.mark.parametrize("what", ["overview", "profiles", "force", "spectrum", "shocks", "level",
                                  "energy", "bands", "shock", "motion"])
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
    assert {"scene.spacing", "scene.spacing_y"} <= set(re.findall(r"scene\.\w+",
                                                                  budget.study.attrs["study"]))
    assert "7.5e-05" in budget.study.attrs["study"]


def test_uncertainty_takes_measured_maps(areal, folder):
    np.save(folder / "map.npy", areal.profile("slider").values)
    measured = areal.scene.change({"slider.surface": {"kind": "file",
                                                      "path": str(folder / "map.npy"),
                                                      "spacing": 50e-6, "spacing_y": 50e-6}})
    budget = ra2d.uncertainty(measured, seeds=3, folder=folder / "measured", show=False)
    assert budget.realisations["slider"].tolist() == ["as measured", "mirror image",
                                                      "mirror image across"]
    assert "spacing" in budget.table.index
    assert any("stands their spline" in note for note in budget.notes)
    assert np.isfinite(budget.runs.level).all()


def test_arrays_are_maps(areal, folder):
    random = np.random.default_rng(1)
    z = 1e-6 * random.normal(size=(60, 130))
    face = ra2d.surface.array(z, 50e-6, folder / "face.npy", spacing_y=100e-6)
    taken = face.heights(0.004, 50e-6, width=0.002, spacing_y=100e-6)
    assert taken.dims == ("y", "position")
    assert np.allclose(taken.values, (z - z.mean())[:20, :81], rtol=0, atol=1e-20)  # some roundings
    for refused in (lambda: ra2d.surface.array(z, 50e-6, spacing_y=0),
                    lambda: ra2d.surface.array(z[0], 50e-6, spacing_y=1e-4),
                    lambda: ra2d.surface.array(z[:1], 50e-6),
                    lambda: ra2d.surface.array(np.ma.masked_greater(z, z.mean()), 50e-6),
                    lambda: ra2d.surface.array(z * 1j, 50e-6),
                    lambda: ra2d.surface.array(z, 50e-6, folder / "face.csv"),
                    lambda: face.heights(0.004, 50e-6)):
        with pytest.raises(ra2d.RequestError):
            refused()


@pytest.mark.parametrize("words", [{}, {"short": "mirror"}, {"offset_x": 2e-5}])
def test_measured_maps_have_other_parts_mirror_images_and_surrogates(folder, words):
    random = np.random.default_rng(1)
    z = 1e-6 * ndimage.gaussian_filter(random.normal(size=(70, 90)), 3)
    scene = ra2d.scene("areal").change({"slider.length": 2e-3, "slider.width": 1.5e-3,
                                        "duration": 1e-3,
                                        "spacing": 50e-6,
                                        "slider.surface":
                                        ra2d.surface.array(z, 50e-6, folder / "z.npy",
                                                           **words)})
    _, found = realisations.of_scene(scene, scene.complete(), 9, folder)
    kinds = [pair[1].kind for pair in found]
    # 41 of 90 nodes and 30 of 70 rows are touched: two parts across, two along, none overlaps
    assert kinds == ["as measured", "offset 2.05 and 0 mm", "offset 0 and 1.5 mm",
                     "offset 2.05 and 1.5 mm",
                     "mirror image", "mirror image across", "turned", "surrogate 1", "surrogate 2"]
    maps_of = [np.load(pair[1].value)[:30, :41] for pair in found]
    z = z - z.mean()
    for made, part in zip(maps_of, [z[:30, :41], z[:30, 41:82], z[30:60, :41], z[30:60, 41:82],
                                    z[:30, 40::-1],
                                    z[29::-1, :41], z[29::-1, 40::-1]]):
        assert np.allclose(made, part, rtol=0, atol=1e-20)  # some roundings
    whole = np.load(found[-1][1].value)
    # the map is small
    assert abs(whole.std() / z.std() - 1) < found[-1][1].distribution_error < 0.2
    assert abs(np.corrcoef(whole.ravel(), z.ravel())[0, 1]) < 0.5


def test_mirror_images_of_a_map_that_goes_on_have_no_steps(folder):
    z = 1e-6 * ndimage.gaussian_filter(np.random.default_rng(1).normal(size=(20, 30)), 3)
    face = ra2d.surface.array(z, 50e-6, folder / "short.npy", short="mirror")
    scene = ra2d.scene("areal").change({"slider.length": 2e-3, "slider.width": 1.5e-3,
                                        "duration": 1e-3, "spacing": 50e-6,
                                        "slider.surface": face, "resonator.surface": face})
    _, found = realisations.of_scene(scene, scene.complete(), 4, folder)
    assert [pair[1].kind for pair in found] == ["as measured", "mirror image",
                                                "mirror image across", "turned"]
    for pair in found:
        for face in pair:
            made = np.load(face.value)
            for axis in (0, 1):
                steps = np.abs(np.diff(made, axis=axis)).max()
                assert steps == np.abs(np.diff(z - z.mean(), axis=axis)).max()


def test_a_surrogate_has_the_spectrum_of_its_map_without_edges():
    z = ndimage.gaussian_filter(np.random.default_rng(2).normal(size=(40, 61)), 2)
    smooth = realisations._smooth_part(z)
    made, _ = realisations.map_surrogate(z, seed=3)
    own, other = np.abs(np.fft.rfft2(z - smooth)), np.abs(np.fft.rfft2(made - smooth))
    assert np.allclose(other, own, rtol=0, atol=1e-12 * own.max())
    # what is left of a map has no steps from edge to edge
    steps = np.abs((z - smooth)[0] - (z - smooth)[-1]).max()
    assert steps < 0.5 * np.abs(z[0] - z[-1]).max()


def test_maps_are_other_faces_than_profiles(areal, result):
    assert "faces differ" in ra2d.compare(areal, result).notes[0]
    notes = ra2d.compare(areal, areal).notes
    assert len(notes) == 1 and "one run" in notes[0]
