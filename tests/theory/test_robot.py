import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.theory.robot import MAGELLAN_PRO, WheelGeometry

lengths = st.floats(0.01, 2.0)
rates = st.floats(-10.0, 10.0)


@given(lengths, lengths, rates, rates)
def test_body_rates_survive_the_wheels(radius, half_track, v, w):
    geometry = WheelGeometry(radius, half_track)
    forward, turn = geometry.body_rates(geometry.wheel_rates(np.array([v]), np.array([w])))
    scale = abs(v) + half_track * abs(w)
    assert forward[0] == pytest.approx(v, abs=1e-15 * (1.0 + 4.0 * scale))
    assert turn[0] == pytest.approx(w, abs=1e-15 * (1.0 + 4.0 * scale / half_track))


@given(lengths, lengths, rates, rates)
def test_wheel_rates_survive_the_body(radius, half_track, left, right):
    geometry = WheelGeometry(radius, half_track)
    wheels = geometry.wheel_rates(*geometry.body_rates(np.array([[left, right]])))
    np.testing.assert_allclose(wheels, [[left, right]], rtol=0, atol=4e-15 * (1.0 + abs(left) + abs(right)))


@given(lengths, lengths, rates, rates)
def test_wheels_differ_by_the_whole_track(radius, half_track, v, w):
    """Right minus left is 2 b w/r, with b half the distance between the wheels."""
    left, right = WheelGeometry(radius, half_track).wheel_rates(np.array([v]), np.array([w]))[0]
    tolerance = 4e-15 * (1.0 + abs(left) + abs(right))
    assert right - left == pytest.approx(2.0 * half_track * w / radius, abs=tolerance)
    assert right + left == pytest.approx(2.0 * v / radius, abs=tolerance)


def test_pivot_about_the_left_wheel():
    """A robot turning about its left contact point moves its middle at v = b w."""
    left, right = MAGELLAN_PRO.wheel_rates(np.array([0.1624 * 2.0]), np.array([2.0]))[0]
    assert left == 0.0
    assert right == pytest.approx(2.0 * 2.0 * 0.1624 / 0.0825, rel=1e-15)


def test_table_two():
    assert (MAGELLAN_PRO.wheel_radius, MAGELLAN_PRO.half_track) == (0.0825, 0.1624)
