"""Amounts: units that people think in, and digits that tell two values apart."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.metrics import UNITS
from slipctl.report.amounts import amount, change_text, interval_text, relative_change, share_text

NUMBERS = st.floats(-1e6, 1e6).filter(lambda value: value == 0 or abs(value) > 1e-12)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0123, "m", "12.3 mm"),
        (math.pi, "rad", "180°"),
        (0.5, "1", "0.500"),
        (12.0, "rad/s (wheel_speed) or N·m (wheel_torque)", "12.0"),
        (0.25, "m/s", "250 mm/s"),
        (3.0, "N", "3.00 N"),
        (0.0, "m", "0 mm"),
        (1e-9, "m", "1e-06 mm"),
        (2e6, "m", "2e+09 mm"),
        (None, "m", "not finite"),
        ("left_the_arena", None, "left the arena"),
    ],
)
def test_a_value_is_written_with_the_unit_of_people(value, unit, text):
    assert amount(value, unit) == text


def test_every_metric_has_a_unit_that_can_be_written():
    assert all(amount(1.0, unit).strip() for unit in UNITS.values())


@pytest.mark.parametrize(
    ("baseline", "current", "text"),
    [
        (0.0123, 0.0145, "12.3 → 14.5 mm"),
        (0.01, 0.0100000123, "10.000000 → 10.000012 mm"),
        (0.0123, None, "12.3 mm → not finite"),
        (None, 0.0123, "not finite → 12.3 mm"),
        (0.0, 0.5, "0 → 500 mm"),
    ],
)
def test_a_change_is_written_with_one_unit(baseline, current, text):
    assert change_text(baseline, current, "m") == text


@given(NUMBERS, NUMBERS)
def test_two_values_that_differ_are_written_differently_and_in_their_order(first, second):
    if abs(first - second) <= 1e-13 * max(abs(first), abs(second)):
        return  # beyond the digits of a double
    before, after = (float(part) for part in change_text(first, second, "N").removesuffix(" N").split(" → "))
    assert (before < after) == (first < second)
    assert before != after


@given(NUMBERS, st.sampled_from(["m", "rad", "m/s", "1", "N"]))
def test_a_written_value_is_the_value_to_three_digits(value, unit):
    factor = {"m": 1e3, "rad": 180 / math.pi, "m/s": 1e3}.get(unit, 1.0)
    written = float(amount(value, unit).replace("°", "").split()[0])
    assert math.isclose(written, factor * value, rel_tol=5.1e-3)


def test_an_interval_is_written_by_its_ends():
    assert interval_text((0.0021, 0.0024), "m") == "2.10 to 2.40 mm"


@pytest.mark.parametrize(
    ("baseline", "current", "text"),
    [
        (1.0, 1.05, "+5 %"),
        (1.0, 0.9, "-10 %"),
        (1.0, 1.0000012, "+0.00012 %"),
        (1.0, 12.0, "×12"),
        (-1.0, -1.5, "-50 %"),
        (0.0, 1.0, ""),
        (1.0, None, ""),
        ("completed", "tipped", ""),
    ],
)
def test_a_share_is_of_the_baseline(baseline, current, text):
    assert share_text(baseline, current) == text


@given(NUMBERS.filter(bool), st.floats(-0.5, 5.0))
def test_the_relative_change_is_what_was_added(value, share):
    changed = relative_change(value, value + share * abs(value))
    assert changed is not None
    assert math.isclose(changed, share, rel_tol=1e-9, abs_tol=1e-12)
