# SPDX-License-Identifier: BSD-3-Clause
"""Student's t: against tables, and by Monte Carlo."""
import math

import numpy as np
import pytest

from ra2d import student


@pytest.mark.parametrize("freedom, factor", [(1, 12.7062), (2, 4.3027), (4, 2.7764), (9, 2.2622),
                                             (30, 2.0423), (1e6, 1.95997)])
def test_factors_are_those_of_the_tables(freedom, factor):
    assert student.student_factor(freedom) == pytest.approx(factor, abs=6e-5)


def test_closed_forms():
    """One degree of freedom is Cauchy's distribution; of two P = 1 - t / sqrt(2 + t^2)."""
    for t in (0.1, 1.0, 7.0, 300.0):
        assert student.chance_beyond(t,
                                     1) == pytest.approx(1 - 2 / math.pi * math.atan(t), rel=1e-9)
        assert student.chance_beyond(t, 2) == pytest.approx(1 - t / math.sqrt(2 + t * t), rel=1e-9)
    assert student.chance_beyond(math.inf, 3) == 0


@pytest.mark.parametrize("scatter", [1.0, 5.0])
def test_false_alarms_are_five_of_a_hundred(scatter):
    """20000 pairs of ten parts of equal means: 5 % within three standard deviations of a count, and
    what Welch's approximation leaves."""
    random = np.random.default_rng(7)
    n = 20_000
    a, b = random.normal(size=(n, 10)), scatter * random.normal(size=(n, 10))
    alarms = sum(student.means_differ(x, y) < 0.05 for x, y in zip(a, b)) / n
    assert abs(alarms - 0.05) < 3 * math.sqrt(0.05 * 0.95 / n) + 0.002
    paired = sum(student.mean_differs(x - y) < 0.05 for x, y in zip(a, b)) / n
    assert abs(paired - 0.05) < 3 * math.sqrt(0.05 * 0.95 / n)


def test_a_family_has_one_false_alarm_in_twenty():
    random = np.random.default_rng(3)
    families = random.random((5000, 30))
    alarms = sum(min(student.for_all(dict(enumerate(map(float, family)))).values()) < 0.05
                 for family in families) / 5000
    assert abs(alarms - 0.05) < 3 * math.sqrt(0.05 * 0.95 / 5000)


def test_what_cannot_be_tested():
    one, same = np.array([1.0]), np.array([2.0, 2.0])
    assert math.isnan(student.half_interval(one)) and math.isnan(student.mean_differs(one))
    assert math.isnan(student.means_differ(one, same))
    # that a run agrees with itself is no chance
    assert math.isnan(student.means_differ(same, same))
    assert math.isnan(student.mean_differs(same - same))
    # equal values, of which three tenths have a mean beside them: no certainty
    for equal in (same, np.array([0.3, 0.3, 0.3])):
        assert math.isnan(student.half_interval(equal))
        assert math.isnan(student.means_differ(equal, equal + 1))
        assert math.isnan(student.mean_differs(equal))
    assert 0 < student.means_differ(same, np.array([3.0, 3.1])) < 1
