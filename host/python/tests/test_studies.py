# SPDX-License-Identifier: BSD-3-Clause
"""Studies: the table, going on, the law."""
import json
import math
import subprocess

import matplotlib.text
import numpy as np
import pytest
import xarray as xr

import ra2d


def messages(study):
    words = [ra2d.find(), "analyze", study.folder, "--json"]
    return json.loads(subprocess.run(words, capture_output=True, check=True).stdout)


def test_the_table_is_an_xarray_dataset_with_units(study):
    assert isinstance(study, xr.Dataset) and study.sizes == {"speed": 3, "rq": 2, "seed": 2}
    assert (study.speed.units, study.rq.units, study.level.units) == ("m s-1", "m", "dB")
    assert (study.status == 0).all() and np.isfinite(study.level).all()
    assert study.message.values.ravel().tolist() == [""] * 12


def test_law_and_means_are_those_of_analyze(study):
    answer, law = messages(study), study.law()
    for name, exponent in answer["law"]["exponents"].items():
        assert (law[name], law[name].low, law[name].high) == (exponent["value"], exponent["low"],
                                                              exponent["high"])
    point = answer["points"][3]
    mean = study.means().loc[(point["speed"], point["rq"])]
    assert (mean.level, mean.level_low, mean.shock_rate_high) == (
        point["lv"]["mean"], point["lv"]["low"], point["shock_rate"]["high"])
    v_rms = answer["law"]["factor"] * 0.3 ** law["speed"] * 6e-6 ** law["rq"]
    assert law.level(speed=0.3, rq=6e-6) == pytest.approx(20 * np.log10(v_rms / 1e-9), abs=1e-9)
    law.about["exponents"]["rq"]["value"] = 0  # a caller's own
    assert study.law()["rq"] == law["rq"] != 0
    for point in ({}, {"speed": 0.3}, {"speed": 0.3, "rq": 6e-6, "load": 2}, {"speed": 0, "rq": 1},
                  {"speed": float("nan"), "rq": 6e-6}, {"speed": "0.3 m/s", "rq": 6e-6}):
        with pytest.raises(ra2d.RequestError, match="the law is of speed, rq: expected a number"):
            law.level(**point)


def test_a_study_of_seeds_alone_leaves_its_scene_alone(base, folder):
    """Its folder, and the file beside it, are not called as the scene."""
    scene = folder / "plate.toml"
    scene.write_text(base.text())
    study = ra2d.study(ra2d.scene(scene).change(base.changes, duration=0.005), {}, seeds=2,
                       show=False)
    assert study.folder.name == "plate-seeds" and scene.read_text() == base.text()


def test_a_part_has_no_law(study):
    with pytest.raises(ra2d.RequestError, match="part of a study"):
        study.sel(speed=0.2).law()
    assert study.level.max("seed").shape == (3, 2)  # xarray itself goes on working


def test_it_goes_on_and_grows(base, folder):
    small = base.change(duration=0.01, rate=1e4)
    first = ra2d.study(small.change(speed=0.7), {"speed": [0.1, 0.2]}, seeds=2,
                       folder=folder / "grows", show=False)
    again = ra2d.study(small, {"speed": [0.1, 0.2]}, seeds=2, folder=folder / "grows", show=False)
    assert np.array_equal(first.wall_seconds, again.wall_seconds)  # nothing ran twice
    more = ra2d.study(small, {"speed": [0.1, 0.2, 0.3]}, seeds=2,
                      folder=folder / "grows", show=False)
    assert np.array_equal(more.wall_seconds.sel(speed=[0.1, 0.2]), first.wall_seconds)
    assert ra2d.load_study(folder / "grows").sizes["speed"] == 3


def test_a_study_that_was_cut_off_goes_on(folder):
    slow = ra2d.scene("dang2012").change(duration=0.4)  # backward Euler: seconds
    with pytest.raises(ra2d.OutOfTime):
        ra2d.study(slow, {"speed": [0.1, 0.2, 0.3, 0.4]}, folder=folder / "cut",
                   max_wall=0.3, show=False)
    cut = ra2d.load_study(folder / "cut")
    assert (cut.status == 1).any() and np.isnan(cut.level.where(cut.status == 1)).all()
    whole = ra2d.study(slow, {"speed": [0.1, 0.2, 0.3, 0.4]}, folder=folder / "cut", show=False)
    assert (whole.status == 0).all() and whole.attrs["complete"] == 1


def test_failed_runs_are_told_and_missing(base, folder):
    forced = ra2d.scene("dang2012").change({"time.force": True}, scheme="explicit-euler",
                                           duration=0.01)
    with pytest.warns(ra2d.Notice, match="1 run failed"):
        table = ra2d.study(forced, {"step": [1e-7, 5e-6]}, folder=folder / "failing", show=False)
    assert table.status.values.ravel().tolist() == [0, 3] and np.isnan(table.level[1, 0])
    assert "step" in str(table.message.values[1, 0])


def test_a_wrong_combination_is_refused(base, folder):
    with pytest.raises(ra2d.RequestError,
                       match="(?s)^[^\\n]*refused.toml: 1 of 2.*with start = 0.29"):
        ra2d.study(base.change(duration=0.01), {"start": [0.1, 0.29]},
                   folder=folder / "refused", show=False)


def test_a_study_without_law_says_why(base, folder):
    one = ra2d.study(base.change(duration=0.01), {"load": ["weight", 1.0]},
                     folder=folder / "words", show=False)
    assert one["load"].values.tolist() == ["weight", "1.0"]
    with pytest.raises(ra2d.RequestError, match="no law"):
        one.law()
    assert one.plot().axes


def test_a_dict_is_a_base(base, folder):
    content = base.change(duration=0.005).content()
    table = ra2d.study(content, {"speed": [0.1, 0.2]}, folder=folder / "of-dict", show=False)
    assert (table.status == 0).all()


def test_wrong_requests(base, folder):
    with pytest.raises(ra2d.RequestError, match="no value"):
        ra2d.study(base, {"speed": []}, folder=folder / "empty")
    with pytest.raises(ra2d.RequestError, match="expected a number >= 0"):
        ra2d.study(base, {"speed": [-1.0]}, folder=folder / "wrong", show=False)
    (folder / "mine.toml").write_text("[scene]\n")
    with pytest.raises(ra2d.RequestError, match="not written by ra2d.study"):
        ra2d.study(base, {"speed": [0.1]}, folder=folder / "mine", show=False)
    with pytest.raises(ra2d.RequestError, match="no folder of a study"):
        ra2d.load_study(folder)


def test_sound_is_a_column_with_a_law(folder):
    base = ra2d.scene("dang2012").change({"output.microphones": [{"x": 0.15, "y": 0.1, "z": 0.5}]},
                                         duration=0.01,
                                         tolerance=1e-6, rate=4e4)
    heard = ra2d.study(base, vary={"speed": [0.1, 0.2, 0.4]}, seeds=2, folder=folder / "heard",
                       keep_sound=True, show=False)
    assert heard.lpa.shape == (3, 2) and heard.lw.units == "dB" and np.isfinite(heard.lwa).all()
    messages_of = messages(heard)["sound_laws"]["lpa"]
    law = heard.law("lpa")
    assert law["speed"] == messages_of["exponents"]["speed"]["value"] and law.amplitude in repr(law)
    assert heard.means().loc[0.2,
                             "lpa"] == pytest.approx(float(heard.lpa.mean("seed").sel(speed=0.2)))
    text = heard.report(folder / "heard.html").read_text()
    assert "pressure, dB(A)" in text and "A-weighted" in text
    written = [text.get_text() for text in heard.plot().findobj(matplotlib.text.Text)]
    assert any(f"p_rms, A-weighted, ~ speed^{float(law['speed']):.3f}" in text
               for text in written), written
    with pytest.raises(ra2d.RequestError, match="expected 'v_rms', 'lp'"):
        heard.law("loudness")


def test_without_sound_there_is_no_law_of_it(study):
    with pytest.raises(ra2d.RequestError, match="keep_sound=True"):
        study.law("lpa")
    assert "lpa" not in study.means()


def test_a_refused_study_leaves_no_file_of_its_own(base, folder):
    place = folder / "refused"
    short = base.change(duration=1e-3)
    for what in (short, ra2d.scene(short.content())):
        before = sorted(folder.iterdir())
        with pytest.raises(ra2d.RequestError, match="scene.speed"):
            ra2d.study(what, {"speed": [0.1, -1.0]}, folder=place, show=False)
        assert sorted(folder.iterdir()) == before
    ra2d.study(short, {"speed": [0.1]}, folder=place, show=False)
    text = (folder / "refused.toml").read_text()
    with pytest.raises(ra2d.RequestError, match="scene.speed"):
        ra2d.study(short, {"speed": [0.1, -1.0]}, folder=place, show=False)
    assert (folder / "refused.toml").read_text() == text


def test_starts_on_one_stretch_have_no_interval(base, folder):
    """The slider is 20 mm long and slides up to 4 mm."""
    short = base.change(duration=0.01, rate=1e4)
    for starts, is_told in (([0.1, 0.11, 0.2], True), ([0.05, 0.1, 0.2], False)):
        law = ra2d.study(short, {"start": starts, "speed": [0.1, 0.2, 0.4]},
                         folder=folder / f"starts-{is_told}", show=False).law()
        assert math.isnan(law.exponents["speed"].low) is is_told
        assert ("values of start lie so close that runs touch a part of the same faces: each takes "
                "up to 0.024 m along x"
                in law.about["intervals"]) is is_told
