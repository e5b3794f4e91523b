"""Means over seeds with the interval that the seeds leave open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95
"""How often such intervals hold the mean over all seeds there could be, with a dozen seeds or more. As they
never go beyond the values seen, few seeds hold it less often: two 50 %, three 75 %, four 87 %, five 91 %,
eight 93 % (measured on normally distributed values)."""

RESAMPLES = 9999
SEED = 20100
"""Of the resampling: the same values always give the same interval."""

BATCH = 1_000_000
"""Values drawn at a time, which keeps the resamples within some 20 MB."""

LEAST_FOR_RESAMPLING = 5
"""Values from which on the percentiles differ from the extremes."""

SMALLEST = 1e-12
"""Values below this count as this much in ratios (assumed; no metric that matters is so small)."""


@dataclass(frozen=True)
class Estimate:
    """A mean over seeds.

    Attributes
    ----------
    value
        The mean.
    interval
        Interval that holds the mean over all seeds there could be; None where there is only one value.
    """

    value: float
    interval: tuple[float, float] | None


def mean(values: Sequence[float]) -> Estimate:
    """Return the mean of some values, one per seed, with its interval.

    The interval is that of the percentile bootstrap, its level raised as the number n of values asks for: the
    resampled means of few values spread too little, by √((n−1)/n), and have normal tails in place of
    Student's. So the tail on each side has the probability Φ(−√(n/(n−1)) t), where t is Student's quantile
    of n − 1 degrees of freedom (Hesterberg, What teachers should know about the bootstrap, The American
    Statistician 69, 2015). Below `LEAST_FOR_RESAMPLING` values these tails are rarer than the most extreme
    resample, and the interval goes from the smallest to the largest value. It never goes beyond those, and
    it does not depend on the order of the values.

    Parameters
    ----------
    values
        At least one finite number.

    Raises
    ------
    ValueError
        There are no values, or one is not finite.
    """
    if not len(values) or not all(map(math.isfinite, values)):
        raise ValueError("a mean needs finite values, at least one")
    ordered = np.sort(np.asarray(values, dtype=float))
    low, high = float(ordered[0]), float(ordered[-1])
    value = min(max(math.fsum(ordered) / len(ordered), low), high)
    if len(ordered) == 1:
        return Estimate(value, None)
    if len(ordered) < LEAST_FOR_RESAMPLING or low == high:
        return Estimate(value, (low, high))
    first, last = _percentiles(ordered)
    return Estimate(value, (min(max(first, low), value), max(min(last, high), value)))


def mean_difference(values: Sequence[float], others: Sequence[float]) -> Estimate:
    """Return the mean of values − others, paired seed by seed, with its interval.

    Raises
    ------
    ValueError
        There are not equally many of both, or as by `mean`.
    """
    return mean([value - other for value, other in zip(values, others, strict=True)])


def mean_ratio(values: Sequence[float], others: Sequence[float]) -> Estimate:
    """Return the geometric mean of values / others, paired seed by seed, with its interval.

    Parameters
    ----------
    values, others
        Numbers ≥ 0; those below `SMALLEST` count as that much, so that 0 / 0 is 1.

    Raises
    ------
    ValueError
        There are not equally many of both, one is negative, or as by `mean`.
    """
    if any(value < 0 for value in (*values, *others)):
        raise ValueError("a geometric mean needs values of at least 0")
    pairs = [
        (max(value, SMALLEST), max(other, SMALLEST)) for value, other in zip(values, others, strict=True)
    ]
    logarithms = mean([math.log(value) - math.log(other) for value, other in pairs])
    if logarithms.interval is None:
        return Estimate(pairs[0][0] / pairs[0][1], None)
    low, high = logarithms.interval
    return Estimate(math.exp(logarithms.value), (math.exp(low), math.exp(high)))


def _percentiles(ordered: np.ndarray) -> tuple[float, float]:
    from scipy import special

    count = len(ordered)
    student = -float(special.stdtrit(count - 1, (1.0 - CONFIDENCE) / 2.0))
    tail = float(special.ndtr(-math.sqrt(count / (count - 1)) * student))
    rng = np.random.default_rng(SEED)
    means = np.empty(RESAMPLES)
    rows = max(1, BATCH // count)
    for first in range(0, RESAMPLES, rows):
        drawn = rng.integers(0, count, (min(rows, RESAMPLES - first), count))
        means[first : first + rows] = ordered[drawn].mean(axis=1)
    low, high = np.quantile(means, [tail, 1.0 - tail])
    return float(low), float(high)
