"""The interval over seeds: closed forms, invariances, and how often it holds the truth."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special, stats

from slipctl.regression.claims.bootstrap import (
    CONFIDENCE,
    LEAST_FOR_RESAMPLING,
    RESAMPLES,
    SEED,
    SMALLEST,
    Estimate,
    mean,
    mean_difference,
    mean_ratio,
)

POSITIVE = st.floats(1e-6, 1e6)
VALUES = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=12)


@given(st.lists(POSITIVE, min_size=2, max_size=12), st.floats(0.01, 100.0))
def test_a_constant_ratio_has_no_width(values, ratio):
    found = mean_ratio([ratio * value for value in values], values)
    assert found.value == pytest.approx(ratio, rel=1e-12)
    assert found.interval == pytest.approx((ratio, ratio), rel=1e-12)


@given(VALUES)
def test_an_interval_lies_between_the_extremes_and_holds_the_mean(values):
    found = mean(values)
    assert found.value == pytest.approx(np.mean(values), rel=1e-9, abs=1e-9)
    if len(values) == 1:
        assert found == Estimate(values[0], None)
        return
    assert found.interval is not None
    low, high = found.interval
    assert min(values) <= low <= found.value <= high <= max(values)
    if len(values) < LEAST_FOR_RESAMPLING:
        assert (low, high) == (min(values), max(values))


@given(VALUES, st.randoms())
def test_the_order_of_the_seeds_means_nothing(values, random):
    mixed = list(values)
    random.shuffle(mixed)
    assert mean(mixed) == mean(values)


@given(st.lists(st.integers(-50, 50), min_size=5, max_size=10), st.integers(-8, 8), st.integers(0, 5))
def test_it_moves_and_grows_with_the_values(values, shift, power):
    first, scale = mean(values), 2.0**power
    moved = mean([scale * value + shift for value in values])
    assert first.interval is not None
    assert moved.value == pytest.approx(scale * first.value + shift, abs=1e-9)
    assert moved.interval == pytest.approx([scale * end + shift for end in first.interval], abs=1e-9)


@given(st.lists(st.tuples(POSITIVE, POSITIVE), min_size=1, max_size=8))
def test_the_ratio_turned_round_is_the_inverse(pairs):
    values, others = zip(*pairs, strict=True)
    there, back = mean_ratio(values, others), mean_ratio(others, values)
    assert there.value * back.value == pytest.approx(1.0, rel=1e-9)
    if there.interval is not None and back.interval is not None and len(pairs) < LEAST_FOR_RESAMPLING:
        assert there.interval[0] * back.interval[1] == pytest.approx(1.0, rel=1e-9)


def test_pairing_takes_out_what_seeds_have_in_common():
    rng = np.random.default_rng(1)
    hard = rng.lognormal(0.0, 2.0, 20)  # some seeds are a hundred times harder than others
    found = mean_ratio(list(2.0 * hard * rng.lognormal(0.0, 0.05, 20)), list(hard))
    assert found.interval is not None
    assert 1.9 < found.interval[0] < 2.0 < found.interval[1] < 2.1
    difference = mean_difference([3.0, 5.0, 104.0], [1.0, 4.0, 101.0])
    assert difference == Estimate(2.0, (1.0, 3.0))


def test_zeros_are_no_trouble():
    assert mean_ratio([0.0], [0.0]).value == 1.0
    assert mean_ratio([2.0, 2.0], [0.0, 0.0]).value == pytest.approx(2.0 / SMALLEST)
    assert mean_ratio([0.0], [2.0]).value == pytest.approx(SMALLEST / 2.0)


def test_what_has_no_mean_is_refused():
    for values in ([], [1.0, math.nan], [math.inf]):
        with pytest.raises(ValueError, match="finite"):
            mean(values)
    with pytest.raises(ValueError, match="at least 0"):
        mean_ratio([1.0], [-1.0])
    with pytest.raises(ValueError, match="zip"):
        mean_ratio([1.0, 2.0], [1.0])
    with pytest.raises(ValueError, match="zip"):
        mean_difference([1.0, 2.0], [1.0])


@pytest.mark.parametrize("count", [5, 8, 20, 128])  # the last one is drawn in two batches
def test_it_is_the_percentile_bootstrap_of_scipy_at_the_raised_level(count):
    values = np.sort(np.random.default_rng(count).exponential(1.0, count))
    student = stats.t.ppf(0.5 + CONFIDENCE / 2, count - 1)
    level = float(1.0 - 2.0 * stats.norm.cdf(-math.sqrt(count / (count - 1)) * student))
    assert level > CONFIDENCE
    assert special.ndtr(-math.sqrt(4 / 3) * stats.t.ppf(0.975, 3)) < 4.0**-4  # below 5: the extremes
    theirs = stats.bootstrap(
        (values,),
        np.mean,
        n_resamples=RESAMPLES,
        confidence_level=level,
        method="percentile",
        rng=np.random.default_rng(SEED),
    ).confidence_interval
    assert mean(list(values)).interval == pytest.approx((theirs.low, theirs.high), rel=1e-12)


@pytest.mark.parametrize(
    ("count", "skewed", "least", "most"),
    [
        (2, False, 0.45, 0.55),  # the median lies between the extremes of n values with 1 − 2^(1−n)
        (3, False, 0.70, 0.80),
        (5, False, 0.885, 0.935),
        (8, False, 0.915, 0.96),
        (20, False, 0.92, 0.97),
        (20, True, 0.89, 0.95),
    ],
)
def test_how_often_it_holds_the_truth(count, skewed, least, most):
    """600 draws: the standard error is 0.9 % at 95 % and 2 % at 50 %."""
    rng = np.random.default_rng(7)
    truth = math.exp(0.125) if skewed else 0.0
    hits = 0
    for _ in range(600):
        values = rng.lognormal(0.0, 0.5, count) if skewed else rng.normal(size=count)
        interval = mean(list(values)).interval
        assert interval is not None
        hits += interval[0] <= truth <= interval[1]
    assert least <= hits / 600 <= most


def test_more_seeds_narrow_it():
    rng = np.random.default_rng(3)
    widths = []
    for count in (8, 32, 128):
        intervals = [mean(list(rng.normal(size=count))).interval for _ in range(20)]
        widths.append(np.mean([interval[1] - interval[0] for interval in intervals if interval is not None]))
    assert widths[0] > 1.7 * widths[1] > 2.9 * widths[2]
