# SPDX-License-Identifier: BSD-3-Clause
"""Student's t: intervals of means, and whether two of them differ by more than chance.

It is of values that scatter. Of a continuous quantity no two are equal: those that are come from
rounding, as durations that are whole numbers of steps do, and show no chance smaller than their
step, which nothing here knows. Values that agree altogether are of one run, or of runs that differ
in nothing that matters to them: no chance had a part in it. So equal values have no interval, and
no chance."""
from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]


def chance_beyond(t: float, freedom: float) -> float:
    """Probability that Student's t of so many degrees of freedom is further from 0 than `t`.

    >>> round(chance_beyond(2.776445, 4), 6)
    0.05
    """
    from scipy.special import stdtr  # pictures do without scipy, and do not wait for it

    return float(2 * stdtr(freedom, -abs(t)))


def student_factor(freedom: float, share: float = 0.95) -> float:
    """How many standard errors hold the mean with probability `share`.

    >>> round(student_factor(4), 4)
    2.7764
    """
    from scipy.special import stdtrit

    return float(stdtrit(freedom, (1 + share) / 2))


def half_interval(values: Values) -> float:
    """Half of the 95 % interval of the mean; NaN of fewer than two values, or of equal ones.

    >>> round(half_interval(np.array([1.0, 2.0, 3.0])), 4)
    2.4841
    """
    n = values.size
    if n < 2 or np.ptp(values) == 0:
        return math.nan
    return student_factor(n - 1) * float(values.std(ddof=1)) / math.sqrt(n)


def mean_differs(differences: Values) -> float:
    """Probability of a mean so far from 0 by chance, by Student's t of paired differences. NaN of
    fewer than two, or of equal ones.

    >>> mean_differs(np.array([1.0, 1.1, 0.9])) < 0.01
    True
    """
    n = differences.size
    if n < 2 or np.ptp(differences) == 0:
        return math.nan
    error = float(differences.std(ddof=1)) / math.sqrt(n)
    return chance_beyond(float(differences.mean()) / error, n - 1)


def means_differ(a: Values, b: Values, widening: tuple[float, float] = (1.0, 1.0)) -> float:
    """Probability of means so far apart by chance, by Welch's t. `widening`: by how much the
    scatter of either side understates the error of its mean. NaN of fewer than two on a side, or
    where neither side scatters.

    >>> means_differ(np.array([1.0, 1.1, 0.9]), np.array([2.0, 2.1, 1.8])) < 0.01
    True
    """
    if min(a.size, b.size) < 2 or np.ptp(a) == np.ptp(b) == 0:
        return math.nan
    squares = [w * w * float(x.var(ddof=1)) / x.size for x, w in zip((a, b), widening)]
    apart, both = float(a.mean() - b.mean()), sum(squares)
    freedom = both ** 2 / sum(s * s / (x.size - 1) for s, x in zip(squares, (a, b)))
    return chance_beyond(apart / math.sqrt(both), freedom)


def for_all(chances: Mapping[str, float]) -> dict[str, float]:
    """Chances of a family, each raised so that any of them falls below 0.05 by chance in at most
    one family of twenty (Holm 1979). NaN stays.

    >>> for_all({"a": 0.01, "b": 0.04, "c": math.nan})
    {'a': 0.02, 'b': 0.04, 'c': nan}
    """
    ordered = sorted((p, name) for name, p in chances.items() if not math.isnan(p))
    found, largest = dict(chances), 0.0
    for i, (p, name) in enumerate(ordered):
        largest = max(largest, min(1.0, (len(ordered) - i) * p))
        found[name] = largest
    return found
