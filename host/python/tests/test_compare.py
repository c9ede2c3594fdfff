# SPDX-License-Identifier: BSD-3-Clause
"""Comparisons: scenes key by key, answers by the program's numbers, and false alarms as rare as is
said."""
import dataclasses
import json
import math
import pathlib
import re
import shutil
import warnings

import h5py
import numpy as np
import pytest

import ra2d
from ra2d import comparison, program, scenes

DOCS = pathlib.Path(__file__).resolve().parents[3] / "docs"


@pytest.fixture(scope="module")
def other(base, folder):
    """The same faces and way, a contact half as stiff."""
    return ra2d.run(base, {"contact.stiffness": 5e14, "output.probes": [0.15, 0.152]},
                    output=folder / "soft.h5", show=False)


def test_units_are_those_of_the_page():
    page = (DOCS / "scene.md").read_text()
    for name, unit in re.findall(
        r"^\| `(\w+)` \|.*?(?:number|numbers)[^|,]*(?:, at most [^|,]*)?, "
        r"([A-Za-z/^0-9]+)(?:,| \|)", page, re.M):
        assert scenes.UNITS.get(name) == unit, name
    assert scenes.UNITS["speed"] == "m/s" and scenes.UNITS["probes"] == "m"


def test_scenes_differ_key_by_key_with_units(base):
    found = ra2d.compare("dang2012", base.change({"slider.surface.rq": 4e-6}, speed=0.15))
    table = found.scene
    assert table.loc["scene.speed"].tolist() == [0.1, 0.15, "m/s"]
    assert table.loc["slider.surface.rq"].tolist() == [8e-6, 4e-6, "m"]
    assert table.loc["time.scheme"].tolist() == ["backward-euler", "adaptive", ""]
    assert set(table.index) >= {"time.tolerance"} and "resonator.length" not in table.index
    assert found.answers.empty and "run it" in found.text() and "scene.speed [m/s]" in found.text()


def test_a_result_does_not_differ_from_itself(result):
    found = ra2d.compare(result, result.path)
    assert found.scene.empty
    for table in (found.answers, found.bands):  # that it agrees with itself is no chance
        assert (table.difference == 0).all() and table.chance.isna().all()
        assert table.differs.isna().all()
    assert (found.answers.why == comparison.EQUAL).all()
    assert found.bands.why["1000"] == comparison.EQUAL  # at 20 Hz parts are too short
    assert "the scenes are the same" in found.text() and "within chance" not in found.text()


def test_answers_are_the_programs_and_differences_their_ratios(result, other):
    found = ra2d.compare(result, other)
    a, b = result.analysis(), other.analysis()
    assert found.answers.a["level"] == pytest.approx(a["lv"], abs=1e-6)
    assert found.answers.b["rate of shocks"] == b["shocks"]["rate"]
    ratio = b["shocks"]["duration"]["median"] / a["shocks"]["duration"]["median"]
    assert found.answers.difference["duration of a shock"] == pytest.approx(100 * math.log(ratio))
    at = a["bands"]["nominal"].index("1000")
    assert found.bands.difference["1000"] == pytest.approx(b["bands"]["level"][at]
                                                           - a["bands"]["level"][at], abs=1e-9)


def test_half_the_stiffness_makes_longer_shocks_at_the_same_level(result, other):
    """By sqrt(2) of a mass on its spring, far beyond chance; the level hardly depends on it
    (docs/choices.md)."""
    found = ra2d.compare(result, other)
    assert found.scene.index.tolist() == ["contact.stiffness"] and "in pairs" in found.test
    assert found.answers.differs["duration of a shock"] and found.answers.differs["rate of shocks"]
    assert abs(found.answers.difference["level"]) < 0.5
    assert "more than chance" in found.text() and not found.notes


def test_ten_parts_give_the_programs_interval(result):
    """Of one run: the scatter of its parts, widened, is the program's interval of level and
    rate."""
    run = comparison._Run(result)
    _, parts = run.series(comparison._FIGURES[0].kind, comparison._FIGURES[0].of)
    half = 10 / math.log(10) * run.widening * ra2d.student.half_interval(parts)
    assert half == pytest.approx(result.level - result.level.low, rel=0.02)
    _, parts = run.series(comparison._FIGURES[1].kind, comparison._FIGURES[1].of)
    factor = math.exp(run.widening * ra2d.student.half_interval(parts))
    assert result.shock_rate.high / result.shock_rate == pytest.approx(factor, rel=0.02)


def test_other_faces_are_told_and_not_taken_in_pairs(result, base, folder):
    """One pair of faces a side does not tell what other faces do: nothing is marked, however far
    they are apart."""
    seed = ra2d.run(base, {"slider.surface.seed": 9}, output=folder / "seed9.h5", show=False)
    found = ra2d.compare(result, seed)
    assert "Welch" in found.test and "faces differ" in found.notes[0]
    assert found.scene.loc["slider.surface.seed"].tolist() == [1, 9, ""]
    soft = ra2d.run(base, {"slider.surface.seed": 9, "contact.stiffness": 1e14},
                    output=folder / "soft9.h5", show=False)
    far = ra2d.compare(result, soft)
    assert far.answers.chance["duration of a shock"] < 1e-4 and far.answers.differs[
        "duration of a shock"] is None
    # noqa: E712
    assert "but the faces differ" in far.text() and not (far.bands.differs == True).any()


def test_measured_faces_are_known_by_their_heights(base, folder):
    """Not by their names: the same name may mean another profile by now, another name the same
    one."""
    x = np.arange(15_000)

    def ran(name, profile, height):
        face = ra2d.surface.array(height * np.sin(x / 90), 2e-6, folder / profile)
        return ra2d.run(base, {"slider.surface": face}, duration=0.01,
                        output=folder / name, show=False)

    one, copy = ran("m1.h5", "one.csv", 2e-6), ran("m2.h5", "two.csv", 2e-6)
    assert "A and B are one run" in ra2d.compare(one, copy).notes[0]
    assert "in pairs" in ra2d.compare(one, copy).test
    changed = ra2d.compare(one, ran("m3.h5", "one.csv", 3e-6))
    assert changed.notes[0] == "slider.surface: the name is the same, the measured profile is not."
    assert "Welch" in changed.test


@pytest.fixture(scope="module")
def sets(base, folder):
    return {v: [ra2d.run(base, {"slider.surface.seed": k}, speed=v, duration=0.05,
                         output=folder / f"set-{v}-{k}.h5",
                         show=False) for k in range(4)] for v in (0.1, 0.4)}


def test_sets_are_paired_by_their_faces_in_any_order(sets):
    found = ra2d.compare(sets[0.1], sets[0.4][::-1])
    assert "4 pairs" in found.test and found.answers.differs[
        "level"] and found.scene.index.tolist() == ["scene.speed"]
    levels = np.array([[float(one.level) for one in side] for side in sets.values()])
    assert found.answers.difference["level"] == pytest.approx((levels[1] - levels[0]).mean(),
                                                              abs=1e-6)
    assert found.answers.chance["level"] == pytest.approx(
        ra2d.student.mean_differs(levels[0] - levels[1]), rel=1e-6)
    unlike = ra2d.compare(sets[0.1][:3], sets[0.1][1:])
    assert "Welch" in unlike.test and not unlike.answers.differs.any()
    assert unlike.scene.to_dict("index") == {
        "slider.surface.seed": {"a": (0, 1, 2), "b": (1, 2, 3), "unit": ""}}
    assert re.search(r"the scenes differ in\n.*\n +slider.surface.seed +0, 1, 2 +1, 2, 3\n",
                     unlike.text())
    fast = ra2d.compare([sets[0.1][0], sets[0.4][0]], sets[0.1][:2]).scene
    assert fast.loc["scene.speed"].tolist() == [(0.1, 0.4), 0.1, "m/s"]
    assert fast.loc["slider.surface.seed"].tolist() == [0, (0, 1), ""]


def test_studies_of_other_settings_differ(base, folder):
    """What `--set` changed is no part of the study's own text."""
    place = folder / "set.toml"
    (folder / "base-of-set.toml").write_text(base.text(), encoding="utf-8")
    place.write_text('base = "base-of-set.toml"\nseeds = 1\n', encoding="utf-8")
    for name, duration in (("short", "5 ms"), ("long", "0.01")):
        program.call("study", place, "-o", folder / name, "--set", f"scene.duration={duration}",
                     "--set", "time.scheme=adaptive", "--quiet")
    found = ra2d.compare(folder / "short", folder / "long").scene
    assert found.index.tolist() == ["scene.duration"]
    assert found.loc["scene.duration"].tolist() == ["5 ms", 0.01, "s"]
    short, long = (ra2d.load_study(folder / name) for name in ("short", "long"))
    for damaged in ('{"set": 3}', "[" * 100_000):
        (folder / "short/study.json").write_text(damaged, encoding="utf-8")
        with pytest.raises(ra2d.FileError, match="study.json.*run the study's line again"):
            ra2d.compare(short, long)
    (folder / "short/study.json").unlink()  # a table by itself
    assert ra2d.compare(short, long).scene.loc["scene.duration", "b"] == 0.01


def test_studies_at_rest_have_no_level_to_compare(folder):
    (folder / "rest.toml").write_text("""base = "base-of-rest.toml"
seeds = 2
[set]
"scene.duration" = 0.005
"scene.initial" = "rest"
"slider.load" = 0
"time.scheme" = "adaptive"
[vary]
gap = { key = "scene.gap", values = [1e-4, 2e-4] }
""", encoding="utf-8")
    (folder / "base-of-rest.toml").write_text(program.call("scenes", "dang2012"), "utf-8")
    program.call("study", folder / "rest.toml", "-o", folder / "rest", "--quiet")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = ra2d.compare(folder / "rest", folder / "rest")
    rates = found.answers.index.str.startswith("rate of shocks")
    assert (found.answers.a[rates] == 0).all() and (found.answers.difference[rates] == 0).all()
    assert (found.answers.why[~rates] == "neither has one").all()


def test_studies_are_compared_where_both_have_runs(study, folder, base):
    same = ra2d.compare(study, folder / "small")
    assert len(same.answers) == 4 * 6 and (same.answers.difference == 0).all()
    assert same.answers.chance.isna().all() and (same.answers.why == comparison.EQUAL).all()
    assert same.notes == ["A and B are one study: that they agree says nothing about chance."]
    both = ("resonator.surface.rq", "slider.surface.rq")
    fewer = ra2d.study(base.change(duration=0.02, rate=1e4, stiffness=5e14),
                       {"speed": [0.2, 0.4], both: [8e-6]}, seeds=2,
                       folder=folder / "fewer", show=False)
    found = ra2d.compare(study, fewer)
    assert len(found.answers) == 4 * 2 and any("values of speed" in note for note in found.notes)
    level = study.level.sel(speed=0.2, rq=8e-6).mean()
    assert found.answers.a["level, speed = 0.2, rq = 8e-06"] == pytest.approx(float(level))
    with pytest.raises(ra2d.RequestError, match="a study is compared with a study"):
        ra2d.compare(study, "dang2012")


def test_a_copy_of_a_study_with_more_seeds_says_nothing_about_chance(folder):
    """The runs that both have are the same, to the last bit."""
    (folder / "copied.toml").write_text("""base = "base-of-copied.toml"
[set]
"scene.duration" = 0.005
"time.scheme" = "adaptive"
[vary]
speed = { key = "scene.speed", values = [0.1, 0.2] }
""", encoding="utf-8")
    (folder / "base-of-copied.toml").write_text(program.call("scenes", "dang2012"), "utf-8")
    text = (folder / "copied.toml").read_text("utf-8")
    for name, seeds in (("two", 2), ("two-and-one", 3)):
        (folder / "copied.toml").write_text(f"seeds = {seeds}\n{text}", encoding="utf-8")
        program.call("study", folder / "copied.toml", "-o", folder / name, "--quiet")
        if seeds == 2:
            shutil.copytree(folder / name, folder / "two-and-one")
    found = ra2d.compare(folder / "two", folder / "two-and-one")
    assert found.answers.chance.isna().all() and (found.answers.why == comparison.EQUAL).all()
    assert found.text().count(f"\nnot known: {comparison.EQUAL}\n") == 1
    assert found.notes[-1] == ("4 of 4 runs have the same values in both: that they agree says "
                               "nothing about chance.")


def test_false_alarms_in_runs_that_differ_by_rounding(base, folder):
    """Five pairs of the same faces whose contacts differ by 1e-7: trajectories part, statistics
    stay. Of 35 tests 5 % are 1.75; more than 7 are chance once in two thousand (binomial, were they
    independent)."""
    alarms = 0
    for k in range(5):
        pair = [ra2d.run(base, {"slider.surface.seed": 50 + k, "contact.stiffness": stiffness},
                         duration=0.8, rate=2e4,
                         output=folder / f"p{k}-{stiffness!r}.h5", show=False)
                for stiffness in (1e15, 1.0000001e15)]
        found = ra2d.compare(*pair)
        assert found.answers.chance.notna().all()
        alarms += int(found.answers.differs.sum())
        assert found.answers.difference["level"] != 0
    assert alarms <= 7


# ---- what goes wrong
# --------------------------------------------------------------------------------

def test_json_has_no_nan_and_says_what_the_text_says(result, other):
    found = ra2d.compare(result, other)
    messages = json.loads(found.to_json())
    assert messages["scene"] == [{"key": "contact.stiffness", "a": 1e15, "b": 5e14, "unit": "Pa/m"}]
    assert [row["quantity"] for row in messages["answers"]] == found.answers.index.tolist()
    assert isinstance(messages["answers"][0]["differs"], bool) and messages["test"] in found.text()
    assert "contact.stiffness" in found._repr_html_()


def test_numbers_have_the_digits_that_they_take(result, other):
    text = ra2d.compare(result, other).text()
    assert "  contact.stiffness [Pa/m]  1e+15  5e+14\n" in text
    shown = comparison._shown  # what the table of scenes has
    assert [shown(value) for value in (0.1, 0.1000001, 1 / 3, 12, True, None, "a", [0.1, 3])] \
        == ["0.1", "0.1000001", "0.3333333333333333", "12", "true", "-", "a", "[0.1, 3]"]
    change = comparison._change
    assert [change(value, "N") for value in (-1e-9, 1e-7, 0.0, 2.0, -100.0)] \
        == ["- < 0.01 %", "+ < 0.01 %", "+0 %", "+2 %", "x 0.368"]


def test_runs_without_noise_or_shocks(base, folder, result):
    """A rigid resonator has no level, bodies apart no shocks: told, not compared."""
    rigid = ra2d.run(base, {"resonator.support": "rigid"}, duration=0.3,
                     output=folder / "rigid.h5", show=False)
    found = ra2d.compare(result, rigid)
    assert found.answers.why["level"] == "only A has one" and found.answers.differs["level"] is None
    assert math.isnan(found.answers.b["level"]) and "not known: only A has one" in found.text()
    twice = ra2d.compare(rigid, rigid)
    assert twice.answers.why["level"] == "neither has one" and json.loads(twice.to_json())[
        "answers"][0]["a"] is None
    still = ra2d.run(base, {"scene.gap": 1e-3, "slider.load": 0.0, "scene.initial": "rest"},
                     duration=0.3,
                     output=folder / "apart.h5", show=False)
    found = ra2d.compare(still, still)
    assert found.answers.a["rate of shocks"] == 0 and found.answers.why[
        "duration of a shock"] == "neither has one"
    assert "third octaves" in found.text() or found.bands.empty


def test_no_shocks_are_a_rate_of_zero(base, folder):
    """In sets of runs, too, a rate of 0 is a number, and the mean is that of all runs."""
    apart = [ra2d.run(base, {"scene.gap": 1e-3, "slider.load": 0.0, "scene.initial": "rest",
                             "slider.surface.seed": seed}, duration=0.05,
                      output=folder / f"apart-{seed}.h5", show=False) for seed in (1, 2)]
    shocks = [ra2d.run(base, {"slider.surface.seed": seed}, duration=0.05,
                       output=folder / f"shocks-{seed}.h5", show=False) for seed in (1, 2)]
    rate = "rate of shocks"
    found = ra2d.compare(apart, shocks)
    assert found.answers.a[rate] == 0 and found.answers.b[rate] > 0
    assert found.answers.why[rate] == "A: the test takes logarithms, and a run of it has 0"
    assert found.answers.differs[rate] is None and "none" not in next(
        line for line in found.text().splitlines() if rate in line)
    same = ra2d.compare(apart, apart).answers
    assert same.a[rate] == same.b[rate] == same.difference[rate] == 0
    mixed = ra2d.compare([apart[0], shocks[0]], shocks).answers
    assert mixed.a[rate] == pytest.approx(shocks[0].analysis()["shocks"]["rate"] / 2)


def test_each_reason_is_of_its_quantity(base, folder, result):
    """Not of the level's interval, where something else is missing."""
    bare = ra2d.run(base, {"output.modes": "none"}, output=folder / "bare.h5", show=False)
    why = ra2d.compare(result, bare).answers
    assert why.why["level"] == "B: the file has no motion of the modes (output.modes)"
    assert why.why["rate of shocks"] == comparison.EQUAL  # of one motion
    short = ra2d.run(base, {"output.modes": "none"}, duration=0.05, output=folder / "bare-short.h5",
                     show=False)
    assert "the run is too short" in ra2d.compare(short, short).answers.why["peak force"]
    rigid = ra2d.run(base, {"resonator.support": "rigid"}, duration=0.3,
                     output=folder / "rigid-again.h5", show=False)
    why = ra2d.compare(rigid, rigid).answers.why
    assert why["rate of shocks"].startswith("A: its resonator does not vibrate, whose")
    lossless = dataclasses.replace(comparison._FIGURES[0], of=lambda found: -1.0)
    _, _, _, why = comparison._test_of_runs(
        comparison._Run(result), comparison._Run(result),
        lambda run: run.series(lossless.kind, lossless.of), True)
    assert why == "A: the test takes logarithms, and it is not positive"
    rare = [math.nan] * 3 + [1.0] * 7
    _, _, _, why = comparison._test_of_runs(
        comparison._Run(result), comparison._Run(result), lambda run: (1.0, np.array(rare)), True)
    assert why == "A: fewer than 8 of its ten parts have a value"


def test_each_cause_for_which_third_octaves_are_not_known_is_told(result):
    found = ra2d.compare(result, result)
    bands = found.bands.iloc[:3].assign(chance=math.nan, differs=None, why="A: too few")
    alike = dataclasses.replace(found, bands=bands)
    assert "third octaves: not known: A: too few\n" in alike.text()
    bands = bands.assign(why=["only A has one", "A: too few", "A: too few"])
    unlike = dataclasses.replace(found, bands=bands)
    assert ("third octaves: not known: 2 of 3, A: too few; 1 of 3, only A has one\n"
            in unlike.text())


def test_one_run_twice_is_told(result, folder):
    copy = folder / "same-run.h5"
    shutil.copy(result.path, copy)
    assert ra2d.compare(result, copy).notes == [
        "A and B are one run: that they agree says nothing about chance."]
    notes = ra2d.compare([result, ra2d.load(copy)], [result, result]).notes
    assert [note[:2] for note in notes] == ["A:", "B:", "1 "] and "run.h5 are one run" in notes[0]
    assert notes[2].startswith("1 of the runs are on both sides: ")


def test_values_that_do_not_scatter_show_no_chance():
    same = np.array([2.0, 2.0])
    for paired in (True, False):
        chance, why = comparison._test_of_sets(same, same + 1, paired)
        assert math.isnan(chance) and why == comparison.NO_SCATTER
    rising = np.array([1.0, 2.0])
    chance, why = comparison._test_of_sets(rising, rising, True)
    assert math.isnan(chance) and why == comparison.EQUAL


def test_a_run_that_was_cut_short_is_told_once(folder, result):
    """By the notes, and not by each analysis of its parts."""
    with pytest.raises(ra2d.OutOfTime):
        ra2d.run("dang2012", output=folder / "late.h5", max_wall=0.2, show=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = ra2d.compare(result, folder / "late.h5")
    assert sum("was cut short" in note for note in found.notes) == 1


def test_short_and_interrupted_runs(base, folder, result):
    short = ra2d.run(base, duration=2e-4, output=folder / "too-short.h5", show=False)
    found = ra2d.compare(result, short)
    assert found.answers.why["level"].startswith("B: ") and found.answers.chance.isna().all()
    with pytest.raises(ra2d.OutOfTime):
        ra2d.run(ra2d.scene("dang2012"), output=folder / "cut.h5", max_wall=0.3, show=False)
    cuts = sorted(folder.glob("cut*.h5"))
    if cuts and not ra2d.load(cuts[0]).complete:
        assert "was cut short" in ra2d.compare(result, cuts[0]).text()


def test_wrong_sides(result, folder, study, tmp_path):
    for wrong, words in (([], "one or more"), ([1], "not int"), (["dang2012"], "holds results"),
                         (3, "not int"),
                         ("no.h5", "no such file"), ("nothing-of-it", "no scene 'nothing-of-it'"),
                         (None, "not NoneType")):
        with pytest.raises(ra2d.Error, match=words):
            ra2d.compare(result, wrong)
    with pytest.raises(ra2d.RequestError, match="several results on both sides"):
        ra2d.compare(result, [result, result])
    with pytest.raises(ra2d.RequestError, match="no folder of a study"):
        ra2d.compare(result, tmp_path)
    with pytest.raises(ra2d.RequestError, match="within a study|one or more"):
        ra2d.compare([study], result)
    text = tmp_path / "text.h5"
    text.write_text("no result")
    with pytest.raises(ra2d.FileError, match="cannot read"):
        ra2d.compare(text, result)
    damaged = tmp_path / "damaged.h5"
    shutil.copy(result.path, damaged)
    with h5py.File(damaged, "r+") as file:
        file["resonator/velocity"][500:600] = 7.0
    with pytest.raises(ra2d.FileError, match="damaged"):
        ra2d.compare(damaged, result)
    other = tmp_path / "elsewhere.h5"
    shutil.copy(result.path, other)
    with h5py.File(other, "r+") as file:
        file.attrs["scene"] = "[scene]\nname = 'x'\n"
    with pytest.raises(ra2d.Error):
        ra2d.compare(other, result)


def test_runs_on_one_stretch_are_told(base, folder):
    """The slider is 20 mm long and slides 1 mm."""
    runs = [ra2d.run(base, {"scene.start": start}, duration=0.01,
                     output=folder / f"start{start}.h5", show=False)
            for start in (0.05, 0.06, 0.1)]
    seed = ra2d.run(base, {"slider.surface.seed": 9}, duration=0.01, output=folder / "start9.h5",
                    show=False)
    apart = [runs[0], runs[2]]
    assert ra2d.compare(apart, [runs[0], seed]).notes == [
        "1 of the runs are on both sides: that they agree says nothing about chance."]
    notes = ra2d.compare(runs, [runs[2], seed]).notes
    assert notes[0] == ("A: start0.05.h5 and start0.06.h5 touch a part of the same faces, and "
                        "count as independent: chance looks smaller than it is.")
