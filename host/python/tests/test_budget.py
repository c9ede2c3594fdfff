# SPDX-License-Identifier: BSD-3-Clause
"""The error budget: chance is Student's interval over realisations, shifts are differences of the
program's levels."""
import csv
import json
import math

import numpy as np
import pytest

import ra2d
from ra2d import budget as budgets
from ra2d import errors, realisations
from ra2d.student import student_factor


@pytest.fixture(scope="module")
def budget(base, folder):
    return ra2d.uncertainty(base.change(duration=0.05, rate=1e4), seeds=4,
                            folder=folder / "budget", show=False)


@pytest.fixture(scope="module")
def measured(base, folder):
    """A slider with a measured face whose trace is long enough for one other stretch; its form is
    taken off."""
    x = np.arange(0, 0.0455, 2e-6)
    random = np.random.default_rng(5)
    z = sum(3e-6 / k * np.sin(2 * np.pi * k * x / 2.1e-3 + random.uniform(0, 6))
            for k in range(1, 9)) + 1e-3 * x
    face = ra2d.surface.array(z, 2e-6, folder / "trace.csv", form="line", filter="gaussian",
                              cutoff=2.5e-3)
    return base.change({"slider.surface": face}, duration=0.02, rate=1e4)


@pytest.fixture(scope="module")
def of_measured(measured, folder):
    return ra2d.uncertainty(measured, seeds=5, folder=folder / "of-measured", show=False)


def test_seeds_are_those_of_a_study_and_chance_is_its_interval(budget, base, folder):
    runs = ra2d.study(base.change(duration=0.05, rate=1e4), {"tolerance": [1e-6]}, seeds=4,
                      folder=folder / "seeds",
                      show=False)
    options = runs.means().iloc[0]
    assert budget.level == pytest.approx(options.level, abs=1e-9)
    assert budget.table.level["chance"] == pytest.approx(options.level_high
                                                         - options.level, rel=1e-9)


def test_shifts_are_paired_and_the_whole_is_their_sum_of_squares(budget):
    by = budget.runs.set_index(["source", "realisation"])
    shift = (by.level["stiffness"] - by.level["as asked"]).dropna()
    assert len(shift) == 3
    assert budget.table.level["stiffness"] == pytest.approx(shift.mean(), abs=1e-9)
    assert budget.table.level_chance["stiffness"] == pytest.approx(
        student_factor(2) * shift.std(ddof=1) / math.sqrt(3), rel=1e-9)
    whole = math.sqrt((budget.table.level ** 2).sum())
    assert budget.level.high - budget.level == pytest.approx(whole, rel=1e-9)
    ratio = np.log(by.shock_rate["spacing"] / by.shock_rate["as asked"]).mean()
    assert budget.table.shock_rate["spacing"] == pytest.approx(100 * ratio, abs=1e-9)


def test_a_stiffer_contact_makes_shorter_shocks(budget):
    """Twice the stiffness: half a period of a mass on it is 1/sqrt(2) as long, -35 % in the
    logarithm."""
    assert -60 < budget.table.shock_duration["stiffness"] < -20
    assert budget.dominant["shock_duration"] in budget.table.index
    assert "mostly" in repr(budget) and "stiffness" in budget._repr_html_()


def test_text_json_and_csv_say_the_same(budget, folder):
    messages = json.loads(budget.to_json())
    assert messages["quantities"]["level"]["value"] == budget.level and not messages["notes"]
    rows = list(csv.DictReader(budget.to_csv(folder / "b.csv").open()))
    assert [row["source"] for row in rows] == [source["source"] for source in messages["sources"]]
    assert float(rows[1]["level_dB"]) == messages["sources"][1]["level"][
        "shift"] == budget.table.level.iloc[1]
    assert f"{budget.level:.1f} dB" in budget.text() and "±" in budget.text()
    with pytest.raises(ra2d.FileError, match="no folder"):
        budget.to_csv(folder / "no" / "b.csv")


@pytest.mark.parametrize("shift, chance, cell", [
    (3.9, 9.7, "+3.9 ± 10"), (-46.2, 12.3, "-46 ± 12"), (0.0996, 0.96, "+0.10 ± 1"),
    (99.7, 99.7, "+100 ± 100"), (-1e-7, 2e-5, "-0.0000 ± 0.0000"), (0.0, 0.0, "+0 ± 0"),
    (123456789.0, math.nan, "+123456789 ± unknown")])
def test_cells_have_no_powers_of_ten(shift, chance, cell):
    assert budgets._cell(shift, chance, "stiffness") == cell


def test_there_are_really_one_and_a_half_times_as_many_modes(budget, base, folder):
    """A beam of 19 modes has 29, at 2.3 times the frequency; `as asked` keeps its motion."""
    whole = base.change(duration=0.05, rate=1e4)
    by = budget.runs.set_index(["source", "realisation"]).level
    for source, changed in (("as asked", {}), ("modes", {"resonator.modes": 29})):
        one = ra2d.run(whole, changed, output=folder / f"{source}.h5", show=False)
        assert by[source, 1] == pytest.approx(one.level, abs=1e-9)
    assert budget.table["changed to"]["modes"] == "1.5 times as many"


def cases_of(name, changes=None, **changed):
    with errors.kept_notices():
        what = budgets._with_counted_modes(ra2d.scene(name).change(changes or {}, **changed))
        return budgets._cases(what, what.complete())


def test_modes_of_each_body_are_counted():
    """By their number, whether the scene gives that or a frequency; of bodies that bend."""
    found, notes = cases_of("dang2012", {"slider.thickness": 0.002, "slider.modes": 3,
                                         "resonator.max_frequency": "20 kHz"})
    assert found["modes"] == ("1.5 times as many", {"resonator.modes": 29, "slider.modes": 5})
    assert not notes
    found, notes = cases_of("areal", {"resonator.max_frequency": 5e3})  # a plate
    assert found["modes"] == ("1.5 times as many", {"resonator.modes": 62}) and not notes
    found, notes = cases_of("dang2012", {"resonator.support": "rigid"})
    assert "modes" not in found and notes[0].startswith("modes: neither body has elastic ones")


@pytest.mark.parametrize("name, modes, fewer", [("dang2012", 200, 134), ("areal", 174, 116)])
def test_modes_that_do_not_fit_are_a_third_fewer(name, modes, fewer):
    """256 of both bodies are the most. It is said why."""
    found, notes = cases_of(name, {"resonator.modes": modes})
    assert found["modes"] == ("a third fewer", {"resonator.modes": fewer})
    assert len(notes) == 1 and "so there are a third fewer: " in notes[0]
    assert "at most 256 can be marched" in notes[0] and "\n" not in notes[0]


def test_more_modes_take_a_step_that_they_bear():
    """Heun's limit goes as one through the highest frequency. The step that holds 19 modes at 2.6
    us holds 29 up to 2.05 us; rk4's twice the step, 11 us, up to 10.4 us."""
    found, _ = cases_of("dang2012", scheme="heun", step=1.9e-6)
    assert "time.step" not in found["modes"][1]
    assert budgets._reference("modes", found) == "as asked"
    found, notes = cases_of("dang2012", scheme="heun", step=2.6e-6)
    assert found["modes"][1] == {"resonator.modes": 29, "time.step": 1.3e-6} and not notes
    assert [budgets._reference(name, found) for name in found] == ["as asked", "as asked", "step",
                                                                   "as asked"]
    found, notes = cases_of("dang2012", {"contact.law": "multiplier"}, scheme="rk4", step=5.5e-6,
                            rate=2e4)
    assert found["step"] == ("twice", {"time.step": 1.1e-5}) and not notes
    assert found["modes"][1] == {"resonator.modes": 29, "time.step": 5.5e-6}
    assert budgets._reference("spacing", found) == "step"
    assert budgets._reference("modes", found) == "as asked"


def test_more_modes_that_bear_no_step_are_fewer():
    """Heun holds 19 modes up to 4.8 us; half of 4.7 us is too long for 29."""
    found, notes = cases_of("dang2012", {"contact.law": "multiplier"}, scheme="heun", step=4.7e-6)
    assert found["modes"] == ("a third fewer", {"resonator.modes": 13})
    assert "heun holds a free mode at 43972 Hz up to" in notes[0]


def test_modes_at_half_the_step_are_compared_there(folder):
    near = ra2d.scene("dang2012").change(scheme="heun", step=2.6e-6, duration=0.005, rate=1e4)
    found = ra2d.uncertainty(near, seeds=2, folder=folder / "near", show=False)
    by = found.runs.set_index(["source", "realisation"]).level
    assert found.table.level["modes"] == pytest.approx((by["modes"] - by["step"]).mean())
    assert found.table.level["spacing"] == pytest.approx((by["spacing"] - by["as asked"]).mean())
    one = ra2d.run(near, {"resonator.modes": 29, "time.step": 1.3e-6},
                   output=folder / "near.h5", show=False)
    assert by["modes", 1] == pytest.approx(one.level, abs=1e-9)


def test_the_other_step_is_twice_where_it_is_stable():
    """A scheme of first order errs by h c: from h to 2 h it moves by its whole error. Near the
    limit: half."""
    plain = ra2d.scene("dang2012")
    assert budgets._other_step(plain, 1e-8) == ("twice", {"time.step": 2e-8})
    near = plain.change(scheme="explicit-euler", step=1e-9)
    assert budgets._other_step(near, 1e-9) == ("half", {"time.step": 5e-10})  # the limit is 2.91 ns
    samples = plain.change(step=1e-5)
    assert budgets._other_step(samples, 1e-5)[0] == "half"  # fewer steps than samples are refused


def test_sources_are_seen_at_twice_the_step(folder):
    """Runs with fixed steps: each source against the runs at twice the step, the step against the
    scene's own."""
    fixed = ra2d.scene("dang2012").change(scheme="backward-euler", step=1e-7,
                                          duration=0.005, rate=1e4)
    found = ra2d.uncertainty(fixed, seeds=3, folder=folder / "fixed", show=False)
    assert found.table["changed to"].to_dict() == {"chance": "3 realisations", "step": "twice",
                                                   "spacing": "half",
                                                   "modes": "1.5 times as many",
                                                   "stiffness": "twice"}
    by = found.runs.set_index(["source", "realisation"]).level
    assert found.table.level["step"] == pytest.approx((by["step"] - by["as asked"]).mean())
    assert found.table.level["spacing"] == pytest.approx((by["spacing"] - by["step"]).mean())
    one = ra2d.run(fixed, {"contact.stiffness": 2e15, "time.step": 2e-7},
                   output=folder / "stiff.h5", show=False)
    assert by["stiffness", 1] == pytest.approx(one.level, abs=1e-9)


def test_the_largest_step_is_what_the_plan_says():
    """Contact of one node on its spring, k = 2 pi f: no step beyond a period, none below a
    thousandth of it."""
    assert 0 < budgets._largest_step(ra2d.scene("dang2012").plan()) < 1e-4
    assert budgets._largest_step(
        ra2d.scene("dang2012").change(contact_force="new").plan()) == math.inf
    assert budgets._largest_step("nothing of it") == 0


# ---- measured faces
# ---------------------------------------------------------------------------------

def test_measured_faces_have_offsets_then_the_mirror_then_surrogates(of_measured):
    """45.5 mm less a cut-off of 2.5 mm leave 43 mm: two stretches of 20 mm."""
    assert of_measured.realisations["slider"].tolist() == ["as measured", "offset 20 mm",
                                                           "mirror image", "surrogate 1",
                                                           "surrogate 2"]
    assert of_measured.realisations["resonator"].tolist()[:2] == ["seed 2", "seed 1002"]
    assert of_measured.level.low < of_measured.level < of_measured.level.high
    assert "slider mirror image" in of_measured.text() and "of Rq at most" in of_measured.text()
    errors = of_measured.realisations["distribution_error"]
    assert (errors[:3] == 0).all() and (errors[3:] > 0).all() and (errors < 0.03).all()


def faces_of(study_folder, kind):
    return np.loadtxt(study_folder / "faces" / f"slider-{kind}.csv", delimiter=",",
                      skiprows=1)[:, 1]


def test_realisations_are_of_the_heights_that_a_run_has(of_measured, measured, folder):
    """At the nodes of the scene: the program's own heights, filtered and levelled."""
    ran = ra2d.run(measured, output=folder / "with-face.h5", show=False)
    place = folder / "of-measured"
    options = faces_of(place, "as-measured")
    assert np.allclose(options[::2] - options[::2].mean(), ran.profile("slider").values,
                       atol=1e-15, rtol=0)
    assert np.array_equal(faces_of(place, "mirror-image"), options[::-1])
    level = of_measured.runs.set_index(["source", "realisation"]).level["as asked", 1]
    # a rounding of heights makes other trajectories
    assert level == pytest.approx(ran.level, abs=0.5)
    moved = faces_of(place, "offset-20-mm")
    whole = ra2d.surface.Surface(measured.complete()["slider"]["surface"]).heights(0.042,
                                                                                   4e-6).values
    assert np.allclose(moved - moved.mean(),
                       whole[5000:10001] - whole[5000:10001].mean(), atol=1e-15)


def test_surrogates_keep_spectrum_and_heights(of_measured, folder):
    """The periodogram of what lies off the line from end to end is equal to rounding; sorted
    heights to 3 % of Rq."""
    place = folder / "of-measured"
    one, other = faces_of(place, "as-measured"), faces_of(place, "surrogate-1")

    def off_line(z):
        y = z - np.linspace(z[0], z[-1], z.size)
        return y - y.mean()

    # the surrogate's own ends differ, so its line is that of the face
    y = off_line(one)
    made = other - np.linspace(one[0], one[-1], one.size)
    assert np.allclose(np.abs(np.fft.rfft(made - made.mean())), np.abs(np.fft.rfft(y)),
                       atol=1e-9 * np.abs(np.fft.rfft(y)).max())
    rq = y.std()
    assert np.sqrt(((np.sort(made) - np.sort(one - np.linspace(one[0], one[-1], one.size)))
                    ** 2).mean()) < 0.03 * rq
    assert abs(np.corrcoef(made, y)[0, 1]) < 0.6  # another profile
    # no noise between nodes
    assert np.diff(made).std() == pytest.approx(np.diff(y).std(), rel=1e-3)


def test_a_surrogate_of_skewed_heights_stays_skewed():
    """Without the amplitudes' step, phases alone would make heights normal: skewness 0."""
    random = np.random.default_rng(2)
    smooth = np.convolve(random.normal(size=6000), np.exp(-np.linspace(-3, 3, 61) ** 2), "same")
    z = 1e-6 * np.exp(0.6 * smooth / smooth.std())
    z = z - np.linspace(z[0], z[-1], z.size)

    def skewness(y):
        return ((y - y.mean()) ** 3).mean() / y.std() ** 3

    made, error = realisations.surrogate(z, 4)
    assert skewness(made) == pytest.approx(skewness(z),
                                           rel=0.1) and skewness(z) > 1.5 and error < 0.03
    assert np.array_equal(made, realisations.surrogate(z, 4)[0])  # the same call goes on


def test_flat_and_odd_profiles():
    assert not realisations.surrogate(np.zeros(10), 1)[0].any()
    for n in (2, 3, 7, 64):
        z = np.random.default_rng(n).normal(size=n)
        assert np.isfinite(realisations.surrogate(z, 1)[0]).all()


def test_offsets_do_not_overlap():
    assert realisations.offsets(0.3, 0.1, 0.12) == []
    assert realisations.offsets(0.3, 0.1, 0.05) == pytest.approx([0.05, 0.1, 0.15, -0.05, -0.1])


def test_a_resonator_that_is_as_long_as_its_trace_has_offsets_within_it():
    """Only what is touched counts: beyond the trace its mirror image stands."""
    trace = np.arange(11.0)
    assert realisations._moved(trace, 4, 11).tolist() == [4, 5, 6, 7, 8, 9, 10, 9, 8, 7, 6]
    assert realisations._moved(trace, -3, 11).tolist() == [3, 2, 1, 0, 1, 2, 3, 4, 5, 6, 7]


def test_a_short_profile_that_is_repeated_has_no_offsets(base, folder):
    z = 2e-6 * np.sin(np.arange(3000) / 40)
    face = ra2d.surface.array(z, 2e-6, folder / "short.csv", short="repeat")
    found = ra2d.uncertainty(base.change({"slider.surface": face}, duration=0.005,
                                         rate=1e4), seeds=3,
                             folder=folder / "repeated", show=False)
    assert found.realisations["slider"].tolist() == ["as measured", "mirror image", "surrogate 1"]


# ---- what goes wrong
# --------------------------------------------------------------------------------

def test_failed_runs_are_told_in_the_notes_alone(base, folder, monkeypatch):
    run = budgets._run

    def run_and_tell(*args, **options):
        errors.notice("2 runs failed (--retry-failed runs them again):")
        errors.notice("a doubt")
        return run(*args, **options)

    monkeypatch.setattr(budgets, "_run", run_and_tell)
    with pytest.warns(ra2d.Notice, match="a doubt") as said:
        ra2d.uncertainty(base.change(duration=0.005, rate=1e4), np.int64(2),
                         folder=folder / "telling", show=False)
    texts = [str(one.message) for one in said]
    assert not any("failed" in text for text in texts)
    assert len(texts) == len(set(texts))  # what plans and study say of the scene comes once


def test_runs_without_shocks_and_rigid_resonators(base, folder):
    """What does not exist is told, and no interval is made of it."""
    apart = base.change({"scene.gap": 1e-3, "slider.load": 0.0, "scene.initial": "rest"},
                        duration=0.005, rate=1e4)
    none = ra2d.uncertainty(apart, seeds=2, folder=folder / "apart", show=False)
    assert math.isnan(none.shock_rate) and "no run has a rate of shocks" in none.text()
    assert json.loads(none.to_json())["quantities"]["shock_rate"]["value"] is None
    rigid = base.change({"resonator.support": "rigid"}, duration=0.005, rate=1e4)
    silent = ra2d.uncertainty(rigid, seeds=2, folder=folder / "rigid", show=False)
    assert "modes" not in silent.table.index and "neither body has elastic" in silent.notes[-1]
    assert math.isnan(silent.level) and silent.shock_rate > 0 and "level" not in silent.dominant


def test_failed_runs_are_told_and_make_no_interval(budget):
    runs = budget.runs.copy()
    runs.loc[runs.source == "stiffness", ["level", "shock_rate", "shock_duration"]] = math.nan
    runs.loc[runs.source == "stiffness", "message"] = "too stiff"
    rows = {name: (how, {}) for name, how in budget.table["changed to"].items() if name != "chance"}
    faces = [[realisations.Face("seed 1", "slider.surface.seed", 1)]] * 4
    found = budgets._of_runs(runs, rows, faces, budget.study)
    assert found.notes == ["stiffness: 3 of 3 runs failed: too stiff"]
    assert math.isnan(found.level.low) and found.level == pytest.approx(budget.level)
    assert "unknown" in found.text() and "too stiff" in found.text()


def test_realisations_of_one_value_are_no_certainty(budget):
    """Medians that are whole numbers of steps may agree by rounding: no interval of no width."""
    runs = budget.runs.copy()
    runs["shock_duration"] = 3e-5
    rows = {name: (how, {}) for name, how in budget.table["changed to"].items() if name != "chance"}
    faces = [[realisations.Face("seed 1", "slider.surface.seed", 1)]] * 4
    found = budgets._of_runs(runs, rows, faces, budget.study)
    assert found.shock_duration == pytest.approx(3e-5) and math.isnan(found.shock_duration.low)
    assert "duration of a shock: all realisations have the same value" in found.text()
    assert found.level.low == budget.level.low
    # but what moves no realisation has no effect
    assert not found.table["shock_duration_chance"].drop("chance").any()


def test_wrong_requests(base, folder):
    whole = "expected a whole number"
    for seeds, words in ((1, "two runs or more"), (2.5, whole), ("3", whole), (None, whole)):
        with pytest.raises(ra2d.RequestError, match=f"seeds = .*: .*{words}"):
            ra2d.uncertainty(base, seeds=seeds)
    smooth = base.change({"resonator.surface": {"kind": "flat"},
                          "slider.surface": {"kind": "flat"}}, duration=0.01)
    with pytest.raises(ra2d.RequestError,
                       match="neither face of this scene is random.*gaussian.*'start'"):
        ra2d.uncertainty(smooth, seeds=2, folder=folder / "smooth", show=False)
    level = ra2d.surface.array(np.zeros(20_000), 2e-6, folder / "level.csv")
    with pytest.raises(ra2d.RequestError, match="measured and rough"):
        ra2d.uncertainty(smooth.change({"slider.surface": level}), seeds=2,
                         folder=folder / "smooth", show=False)
    rough = ra2d.surface.array(1e-6 * np.sin(np.arange(20_000) / 90), 2e-6, folder / "rough.csv")
    (folder / "taken").mkdir()
    (folder / "taken" / "faces").write_text("a file")
    for place in (folder / "taken", "/proc/budget"):
        with pytest.raises(ra2d.FileError, match="cannot make the folder"):
            ra2d.uncertainty(smooth.change({"slider.surface": rough}), seeds=2,
                             folder=place, show=False)
    assert not (folder / "smooth.toml").exists() and not (folder / "smooth").exists()
    with pytest.raises(ra2d.FileError, match="there is no folder"):
        ra2d.uncertainty(base, folder=folder / "no" / "budget")
