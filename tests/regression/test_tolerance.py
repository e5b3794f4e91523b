"""Tolerances follow from what moving the start does."""

import pytest

from slipctl.regression.tolerance import measure, number
from tests.fakes import payload, run_entry


@pytest.mark.parametrize(
    ("value", "nudged", "tolerance", "why"),
    [
        (0.5, [0.5, 0.5], 5e-3, "1% of the value"),
        (0.001, [0.001, 0.001], 2e-5, "the floor"),
        (0.01, [0.0101, 0.00995], 1e-3, "10 spreads"),
    ],
)
def test_the_largest_of_three_reasons_counts_and_is_said(value, nudged, tolerance, why):
    result = number(value, nudged)
    assert result.tolerance == pytest.approx(tolerance, rel=1e-9)
    assert result.why.startswith(why)
    assert "spread" in result.why
    assert not result.chaotic


def test_both_nudges_count():
    assert number(0.01, [0.01, 0.0101]) == number(0.01, [0.0101, 0.01])


def test_a_spread_of_a_fifth_of_the_value_makes_it_chaotic():
    assert not number(1.0, [1.19, 1.0]).chaotic
    chaotic = number(1.0, [1.21, 1.0])
    assert chaotic.chaotic
    assert 1.0 + chaotic.tolerance == pytest.approx(3 * 1.21)


def test_noise_far_below_the_floor_is_not_chaos():
    assert not number(1e-9, [3e-9, 1e-9]).chaotic


def test_a_value_that_a_nudge_makes_infinite_is_chaotic():
    assert number(1.0, [None, 1.0]).chaotic


def test_a_value_that_is_not_finite_is_recorded_as_such():
    assert number(None, [1.0]).value is None


def test_runs_are_paired_with_their_own_nudged_runs():
    base = payload([run_entry("a", rms=0.01), run_entry("b", rms=0.01)])
    nudged = payload([run_entry("b", rms=0.0101, status="tipped"), run_entry("a", rms=0.01)])
    a, b = measure(base, [nudged])
    assert (a.nudged_statuses, b.nudged_statuses) == ([], ["tipped"])
    assert a.metrics["rms_position_error"].why.startswith("1%")
    assert b.metrics["rms_position_error"].why.startswith("10 spreads")
