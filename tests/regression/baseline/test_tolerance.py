"""Tolerances follow from how far a number was seen to move."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.regression import Number
from slipctl.regression.baseline.gated import (
    CHAOTIC,
    GATED,
    NOTEWORTHY,
    NUDGE,
    SPREADS,
    is_chaotic,
    is_repeated,
)
from slipctl.regression.baseline.tolerance import Seen, number

ERROR = "rms_position_error"
SHARE = "guarantee_fraction"


def of(value, nudged=None, threads=None, halved=(), metric=ERROR, same_status=True, ticks=1000) -> Number:
    """Give a number that did not move but where the test says so."""
    nudged, threads = ([value, value] if given is None else given for given in (nudged, threads))
    return number(metric, value, Seen(nudged, threads, halved, same_status), ticks)


def moved(where, values) -> Number:
    """Give 1, with these values in one of the places where a number can move."""
    places = {"nudged": None, "threads": None, "halved": ()} | {where: values}
    return of(1.0, places["nudged"], places["threads"], places["halved"])


@pytest.mark.parametrize(
    ("value", "nudged", "tolerance", "why"),
    [
        (0.5, [0.5, 0.5], 5e-7, "1e-06 of the value"),
        (1e-4, [1e-4, 1e-4], 1e-9, "the floor"),
        (0.5, [0.50001, 0.499995], 1e-4, "10 spreads"),
    ],
)
def test_the_largest_of_three_reasons_counts_and_is_said(value, nudged, tolerance, why):
    result = of(value, nudged)
    assert result.tolerance == pytest.approx(tolerance, rel=1e-9)
    assert result.why.startswith(why)
    assert "moved by" in result.why
    assert result.gate == "number"


def test_threads_count_as_nudges_do():
    by_nudge, by_thread = of(0.01, nudged=[0.01, 0.0101]), of(0.01, threads=[0.0101, 0.01])
    assert by_nudge.spread == by_thread.spread == pytest.approx(1e-4)
    assert by_nudge.tolerance == by_thread.tolerance == pytest.approx(1e-3)
    assert "nothing on 1 to 3 threads" in by_nudge.why
    assert "1.0e-04 m on 1 to 3 threads" in by_thread.why


def test_half_the_timestep_widens_the_tolerance_elsewhere_only():
    still, halved = of(0.5), of(0.5, halved=[0.501])
    assert halved.halving == pytest.approx(1e-3)
    assert halved.tolerance == still.tolerance
    assert halved.tolerance_elsewhere == halved.halving
    assert still.halving is None
    assert still.tolerance_elsewhere == still.tolerance
    assert "half the timestep" not in still.why
    assert "1.0e-03 m at half the timestep" in halved.why


def test_a_tick_may_turn_in_a_share_of_ticks():
    result = of(0.95, metric=SHARE, ticks=200)
    assert result.tolerance == pytest.approx(1.5 / 200)
    assert result.why.startswith("1.5 of 200 ticks")
    assert of(0.0, metric=SHARE, ticks=1).tolerance == 1.5


def test_half_the_timestep_alone_is_never_chaos():
    """The numbers of a run on good grip: a step of a millisecond is a third of its error, and repeatable."""
    result = of(0.0015, nudged=[0.0015 + 6e-11], halved=[0.0015 + 5.4e-4])
    assert result.gate == "number"
    assert result.tolerance < 1e-8
    assert result.tolerance_elsewhere == pytest.approx(5.4e-4)


@pytest.mark.parametrize("where", ["nudged", "threads"])
def test_a_tolerance_of_over_a_fifth_of_the_value_makes_it_chaotic(where):
    assert moved(where, [1.019]).gate == "number"
    chaotic = moved(where, [1.021])
    assert chaotic.gate == "verdict"
    assert chaotic.why.startswith("chaotic: 10 spreads are more than 20% of the value")
    assert "2.1e-02" in chaotic.why


def test_a_movement_too_small_to_care_about_is_not_chaos():
    assert of(1e-5, [1.9e-5]).gate == "number"
    assert of(1e-5, [2.1e-5]).gate == "verdict"
    assert of(0.001, [0.0019], metric="command_variation").gate == "number"


def test_a_run_beside_it_that_ended_otherwise_makes_it_chaotic():
    result = of(1.0, same_status=False)
    assert result.gate == "verdict"
    assert result.spread is None
    assert "ended otherwise" in result.why


@pytest.mark.parametrize("where", ["nudged", "threads", "halved"])
def test_a_value_that_is_not_finite_nearby_is_chaotic(where):
    assert moved(where, [None, 1.0]).gate == "verdict"


@pytest.mark.parametrize(("metric", "why"), [(ERROR, "not finite"), (SHARE, "no theorem")])
def test_what_has_no_value_is_recorded_as_such(metric, why):
    result = of(None, metric=metric)
    assert (result.value, result.gate, result.why) == (None, "number", why)
    chaotic = of(None, [None, 1.0], metric=metric)
    assert chaotic.gate == "verdict"
    for found in (result, chaotic):
        assert (found.tolerance, found.tolerance_elsewhere) == (0.0, 0.0)


VALUE = st.floats(min_value=1e-12, max_value=1e3)
MOVE = st.floats(min_value=0.0, max_value=1.0)
METRIC = st.sampled_from(GATED)


@given(VALUE, st.lists(MOVE, min_size=1), st.lists(MOVE, min_size=1), st.lists(MOVE, max_size=1), METRIC)
def test_a_tolerance_covers_what_it_was_made_from(value, nudges, threads, halved, metric):
    """Also the constructor of the number holds this: a baseline that does not cannot be written."""
    nudged, threaded, half = (
        [value * (1 + share) for share in shares] for shares in (nudges, threads, halved)
    )
    result = number(metric, value, Seen(nudged, threaded, half), ticks=500)
    spread = max(abs(other - value) for other in nudged + threaded)
    assert result.spread == spread
    assert result.tolerance >= max(10 * spread, 1e-6 * value, NUDGE)
    assert result.tolerance_elsewhere >= max([result.tolerance, *(abs(v - value) for v in half)])
    assert (result.gate == "verdict") == is_chaotic(metric, value, result.spread)


@given(VALUE, st.lists(MOVE, min_size=2), METRIC)
def test_the_order_of_the_runs_beside_does_not_matter(value, shares, metric):
    moved = [value * (1 + share) for share in shares]
    forth, back = (number(metric, value, Seen(order, [value]), 500) for order in (moved, moved[::-1]))
    assert forth == back


@given(VALUE, MOVE, METRIC)
def test_chaos_is_a_tolerance_of_a_share_of_the_value_and_something_to_notice(value, share, metric):
    moved = share * value
    expected = SPREADS * moved > CHAOTIC * value and SPREADS * moved > NOTEWORTHY[metric]
    assert is_chaotic(metric, value, moved) == is_chaotic(metric, -value, moved) == expected


@given(VALUE, st.lists(MOVE, min_size=1), METRIC)
def test_a_gated_number_may_move_by_a_fifth_at_most_unless_that_is_hardly_anything(value, shares, metric):
    result = number(metric, value, Seen([value * (1 + share) for share in shares], [value]), ticks=500)
    if result.gate == "number":
        assert result.tolerance <= max(CHAOTIC * value, NOTEWORTHY[metric])


@given(st.one_of(st.none(), VALUE), METRIC)
def test_the_same_number_is_repeated_and_another_is_not(value, metric):
    assert is_repeated(metric, value, value, 500)
    assert not is_repeated(metric, value, 0.1 if value is None else 1.1 * value + 0.01, 500)
    if value is not None:
        assert not is_repeated(metric, value, None, 500)
        assert is_repeated(metric, value, value * (1 + 1e-7), 500)


def test_nothing_is_chaotic_without_a_number():
    assert not is_chaotic(ERROR, None, math.inf)
    assert not is_chaotic(ERROR, 1.0, None)


def test_what_moved_is_said_with_its_unit():
    known = of(0.5, nudged=[0.5001], threads=[0.5], halved=[0.501])
    assert known.why == (
        "10 spreads; moved by 1.0e-04 m from starts moved by 1e-09 m or rad, nothing on 1 to 3 threads, "
        "1.0e-03 m at half the timestep"
    )
    unknown = of(0.5, nudged=[None], threads=[0.5001], halved=[None])
    assert unknown.why.endswith(
        "; moved by an unknown amount from starts moved by 1e-09 m or rad, 1.0e-04 m on 1 to 3 threads, "
        "an unknown amount at half the timestep"
    )
    share = of(0.5, nudged=[0.501], threads=[0.5], metric=SHARE, ticks=100)
    assert "moved by 1.0e-03 from starts moved by" in share.why  # a share has no unit


def test_a_share_repeats_to_a_tick_and_an_error_to_rounding():
    assert is_repeated(SHARE, 0.5, 0.51, 100)
    assert not is_repeated(SHARE, 0.5, 0.52, 100)
    assert not is_repeated(ERROR, 0.5, 0.51, 100)
    assert is_repeated(ERROR, 0.0, NUDGE, 100)  # the limit itself
    assert not is_repeated(ERROR, 0.0, 1.01 * NUDGE, 100)
