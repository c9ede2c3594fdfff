# SPDX-License-Identifier: BSD-3-Clause
"""The error budget: chance is the program's own interval, shifts are differences of its levels."""
import math

import numpy as np
import pytest

import ra2d


@pytest.fixture(scope="module")
def budget(base, folder):
    return ra2d.uncertainty(base.change(duration=0.05, rate=1e4), seeds=3, folder=folder / "budget", show=False)


def test_chance_is_the_programs_interval(budget):
    asked = budget.study.means().loc["as asked"]
    assert float(budget.level) == pytest.approx(asked.level, abs=1e-9)
    assert budget.table.level["chance"] == pytest.approx(asked.level_high - asked.level, rel=1e-9)


def test_shifts_are_paired_and_the_whole_is_their_sum_of_squares(budget):
    level = budget.study.level
    shift = (level.sel(name="stiffness") - level.sel(name="as asked")).values
    assert budget.table.level["stiffness"] == pytest.approx(shift.mean(), abs=1e-9)
    whole = math.sqrt((budget.table.level ** 2).sum())
    assert budget.level.high - budget.level == pytest.approx(whole, rel=1e-9)
    rate = budget.study.shock_rate
    ratio = np.log(rate.sel(name="spacing") / rate.sel(name="as asked")).values.mean()
    assert budget.table.shock_rate["spacing"] == pytest.approx(100 * ratio, abs=1e-9)


def test_a_stiffer_contact_makes_shorter_shocks(budget):
    """Twice the stiffness: half a period of a mass on it is 1/sqrt(2) as long, -35 % in the logarithm."""
    assert -60 < budget.table.shock_duration["stiffness"] < -20
    assert budget.dominant["shock_duration"] in budget.table.index
    assert "mostly" in repr(budget) and "stiffness" in budget._repr_html_()


def test_wrong_requests(base, folder):
    with pytest.raises(ra2d.RequestError, match="seeds = 1"):
        ra2d.uncertainty(base, seeds=1)
    smooth = base.change({"resonator.surface": {"kind": "flat"}, "slider.surface": {"kind": "flat"}}, duration=0.01)
    with pytest.raises(ra2d.RequestError, match="neither face of this scene is random.*gaussian.*'start'"):
        ra2d.uncertainty(smooth, seeds=2, folder=folder / "smooth", show=False)
    assert not (folder / "smooth.toml").exists()
