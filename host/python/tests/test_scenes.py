# SPDX-License-Identifier: BSD-3-Clause
"""Scenes, faces and TOML."""
import math
import pathlib
import re
import tomllib

import numpy as np
import pytest

import ra2d
from ra2d import scenes, toml

DOCS = pathlib.Path(__file__).resolve().parents[3] / "docs"


@pytest.mark.skipif(not DOCS.is_dir(), reason="the source's docs are not here")
def test_the_keys_are_those_of_the_program():
    """docs/scene.md is made from the program's own table."""
    page = (DOCS / "scene.md").read_text()
    tables = dict(re.findall(r"<!-- keys: (\S+) -->\n(.*?)<!-- end of keys -->", page, re.DOTALL))

    def keys(name):
        return {name: who for name, who in re.findall(r"^\| `(\w+)` \|(?: ([^|]*?) ?\|)?",
                                                      tables[name], re.MULTILINE)}

    body = keys("body")
    for section in ("scene", "contact", "time", "output"):
        assert set(scenes.KEYS[section]) == set(keys(section))
    for name, other in (("resonator", "slider"), ("slider", "resonator")):
        assert set(scenes.KEYS[name]) == {key for key, who in body.items() if who != other}
        assert set(scenes.KEYS[f"{name}.surface"]) == set(keys("resonator.surface"))


def test_short_names():
    assert [scenes.full_key(name) for name in ("speed", "load", "stiffness", "probes", "spacing",
                                               "scheme")] == [
        "scene.speed", "slider.load", "contact.stiffness", "output.probes", "scene.spacing",
        "time.scheme"]
    with pytest.raises(ra2d.RequestError,
                       match="resonator.length and slider.length have this name"):
        ra2d.scene("dang2012").change(length=0.1)
    with pytest.raises(ra2d.RequestError, match="resonator.surface.rq and slider.surface.rq"):
        ra2d.scene("dang2012").change(rq=1e-6)


def test_a_tolerance_asks_for_the_scheme_that_takes_it():
    assert ra2d.scene("dang2012").change(tolerance=1e-5)["scheme"] == "adaptive"
    with pytest.warns(ra2d.Notice, match="tolerance = 1e-05 has no effect: .*scheme = 'rk4'"):
        assert ra2d.scene("dang2012").change(tolerance=1e-5, scheme="rk4")["scheme"] == "rk4"


def test_later_changes_take_the_place_of_earlier_ones():
    seeded = ra2d.scene("dang2012").change({"slider.surface.seed": 7, "slider.length": 0.01})
    flat = seeded.change({"slider.surface": {"kind": "flat"}})
    assert flat.changes == {"slider.length": 0.01, "slider.surface": {"kind": "flat"}}
    assert list(flat.change({"slider.surface.kind": "gaussian"}).changes)[
        -1] == "slider.surface.kind"
    assert flat["slider.surface"] == {"kind": "flat"}


def test_a_text_with_a_unit_is_the_number_that_the_program_reads():
    cube = ra2d.scene("dang2012")
    inches = cube.change({"slider.surface": {"kind": "gaussian", "rq": "8 \u00b5m",
                                             "rsm": "1.55 mm", "seed": 1},
                          "resonator.length": "30 cm", "output.probes": ["10 mm", 0.02]},
                         speed="100 mm/s",
                         load="2 weight", name="3 balls")
    assert inches["speed"] == 0.1 and inches["resonator.length"] == 0.3
    assert inches["slider.surface"] == {"kind": "gaussian", "rq": 8e-6, "rsm": 1.55e-3, "seed": 1}
    assert inches["slider.surface.rq"] == 8e-6 and inches["probes"] == [0.01, 0.02]
    assert inches["load"] == "2 weight" and inches["name"] == "3 balls"
    assert inches.changes["scene.speed"] == "100 mm/s"
    assert {**inches.complete()["scene"], "name": ""} == {**cube.complete()["scene"], "name": ""}
    with pytest.raises(ra2d.RequestError, match='"100 mm" is a length, not a speed.*"100 mm/s"'):
        cube.change(speed="100 mm")["speed"]


def test_a_scene_never_changes():
    """Neither with what it was made of, nor with what it gave."""
    probes = [0.1, 0.15]
    one = ra2d.scene("dang2012").change(probes=probes)
    probes.append(0.2)
    one.changes["scene.speed"] = 9.0
    one.changes["output.probes"].append(0.2)
    one.content()["output"]["probes"].append(0.2)
    assert one["probes"] == [0.1, 0.15] and one["speed"] == 0.1


def test_names_of_scenes():
    with pytest.raises(ra2d.RequestError,
                       match="no scene 'dang2021'. Scenes .*dang2012, dang2012-pinned.*peaks"):
        ra2d.scene("dang2021")
    with pytest.raises(ra2d.RequestError, match="nowhere.toml"):
        ra2d.scene("nowhere.toml")


def test_a_dict_runs_like_its_file(base, folder):
    """To the same bits: the program's key of a run says so."""
    of_file = ra2d.run(base, duration=0.01, output=folder / "file.h5", show=False)
    of_dict = ra2d.run(base.change(duration=0.01).content(), output=folder / "dict.h5", show=False)
    again = ra2d.run(of_file.scene, output=folder / "again.h5", show=False)
    assert of_file.attrs["key"] == of_dict.attrs["key"] == again.attrs["key"]


def test_output_names_keep_runs_apart(base):
    from ra2d.runs import output_name
    assert output_name(base.change(speed=0.2)) != output_name(base.change(speed=0.3))
    assert output_name(base.change(speed=0.2).change(load=1.0)) == output_name(
        base.change(load=1.0).change(speed=0.2))
    assert output_name(base.change({"slider.surface.seed": 3})) != output_name(
        base.change({"resonator.surface.seed": 3}))
    long = base.change({"output.probes": list(np.linspace(0, 0.3, 50))})
    assert len(output_name(long)) < 100 and output_name(long) != output_name(long.change(speed=1.0))


@pytest.mark.parametrize("value", [1e-8, 0.1 + 0.2, 5, True, "a \"quoted\"\n$x$ \\ \u00e4 \x7f",
                                   [1.0, "weight"],
                                   [[1, 2], [3.5]], {"kind": "file", "x y": [{"at": 1e300}]},
                                   np.float64(0.3),
                                   np.arange(3), math.inf])
def test_toml_comes_back(value):
    back = tomllib.loads(f"x = {toml.value(value)}")["x"]
    assert back == (value.tolist() if isinstance(value, np.ndarray) else value)


def test_a_path_counts_from_the_current_folder(profile):
    words = ra2d.surface.read("measured.txt", x_unit="mm", z_unit="um")
    assert words["path"] == str(profile)
    face = {"kind": "file", "path": "measured.txt", "x_unit": "mm", "z_unit": "um"}
    content = {**ra2d.scene("dang2012").content()}
    content["slider"] = {**content["slider"], "length": 0.01, "surface": face}
    assert ra2d.scene(content)["slider.surface.path"] == str(profile)


def test_an_array_is_the_face_that_runs(base, folder):
    heights = 2e-6 * np.sin(np.arange(2501) / 40) + 1e-7 * np.arange(2501) / 2501
    face = ra2d.surface.array(heights, spacing=8e-6)
    ran = ra2d.run(base, {"slider.surface": face}, duration=1e-3,
                   output=folder / "face.h5", show=False)
    assert np.allclose(ran.profile("slider"), heights - heights.mean(), rtol=0, atol=1e-15)


def test_heights_are_those_of_a_run(result):
    face = ra2d.surface.gaussian(rq=8e-6, rsm=1.55e-3, seed=1)
    assert np.array_equal(face.heights(0.02, 8e-6), result.profile("slider"))


def test_faces_are_checked_early(profile):
    with pytest.raises(ra2d.RequestError, match=r"shape \(1, 2, 2\)"):
        ra2d.surface.array([[[1, 2], [3, 4]]], spacing=1e-6)
    with pytest.raises(ra2d.RequestError, match="1 values that are not finite"):
        ra2d.surface.array([0, math.nan], spacing=1e-6)
    with pytest.raises(ra2d.RequestError, match="spacing is 0"):
        ra2d.surface.array([0, 1e-6], spacing=0)
    with pytest.raises(ra2d.RequestError, match="rsm or correlation_length"):
        ra2d.surface.gaussian(rq=1e-6, seed=1)
    with pytest.raises(ra2d.FileError, match="no such file"):
        ra2d.surface.read("nowhere.sdf")
    with pytest.raises(ra2d.RequestError, match="roughness is measured of a file"):
        ra2d.surface.gaussian(rq=1e-6, rsm=1e-3, seed=1).roughness()


def test_roughness_of_a_sine(profile):
    """Rq of a sine of 2 um is 2/sqrt(2) um, before the filter takes 2 % of a wave of a third of the
    cut-off."""
    messages = ra2d.surface.read(profile, x_unit="mm", z_unit="um",
                                 form="line").roughness(cutoff=2.5e-3)
    assert messages["Rq"] == pytest.approx(2e-6 / math.sqrt(2),
                                           rel=0.05) and messages.name == "iso21920"


def test_a_notice_stands_at_the_users_line():
    with pytest.warns(ra2d.Notice) as heard:
        ra2d.scene("dang2012").plan()
        ra2d.scene("dang2012").complete()
    assert len(heard) == 2 and {one.filename for one in heard} == {__file__}
