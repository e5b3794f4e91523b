"""Dead reckoning: exact where the wheels roll, off by the slip where they do not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipctl.sensing.odometry import OdometryPose, advance
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import ProportionalSlip
from slipctl.tick import Array, Motion
from tests.builders import full
from tests.sensing.worlds import TICK, camera, drive, headings, positions, sense, sensor_of

RATES = st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-3.0, 3.0)), min_size=1, max_size=20)


def reckoned(motions: list[Motion]) -> list[Motion]:
    """Return what a robot without a camera believes."""
    sensor = sensor_of(1, len(motions), pose="odometry_camera", camera=camera(1, rate=0.0))
    return sense(sensor, motions)[1]


def rolled(length: float, turn: float, steps: int = 1) -> OdometryPose:
    """Reckon from the origin, heading along x, over wheels that rolled a length and turned the robot."""
    pose = OdometryPose(np.zeros((1, 2)), full(1, 0.0), np.zeros((1, 2)))
    whole = MAGELLAN_PRO.wheel_rates(full(1, length), full(1, turn))
    for step in range(1, steps + 1):
        pose = advance(pose, whole * step / steps, MAGELLAN_PRO)
    return pose


def test_equal_wheels_go_straight() -> None:
    pose = rolled(0.7, 0.0)
    np.testing.assert_allclose(pose.position, [[0.7, 0.0]], atol=1e-15)
    np.testing.assert_allclose(pose.heading, 0.0, atol=1e-15)


@pytest.mark.parametrize("steps", [1, 4, 37])
def test_a_circle_is_exact_in_any_number_of_steps(steps: int) -> None:
    radius, turn = 0.8, 1.9
    pose = rolled(radius * turn, turn, steps)
    expected = [radius * np.sin(turn), radius * (1.0 - np.cos(turn))]
    np.testing.assert_allclose(pose.position[0], expected, atol=1e-14)
    np.testing.assert_allclose(pose.heading, turn, atol=1e-14)


def test_a_small_turn_is_as_exact_as_a_large_one() -> None:
    # both sides of the switch to the series of sin(x)/x
    for turn in (1.9e-4, 2.1e-4):
        np.testing.assert_allclose(
            rolled(1.0, turn).position[0], [np.sin(turn) / turn, (1.0 - np.cos(turn)) / turn], atol=1e-12
        )


@settings(max_examples=30, deadline=None)
@given(RATES)
def test_without_slip_it_agrees_with_the_plant(rates: list[tuple[float, float]]) -> None:
    motions = drive(*np.array(rates).T)
    seen = reckoned(motions)
    # the plant's step at 3 rad/s and 50 ms is off by 1e-6
    np.testing.assert_allclose(positions(seen), positions(motions), atol=2e-6 * len(rates))
    np.testing.assert_allclose(headings(seen), headings(motions), atol=1e-12)


def drift(slip_law: ProportionalSlip, speeds: Array) -> tuple[Array, float]:
    """Return how far the reckoning is off after a straight command, in the frame of the start."""
    motions = drive(speeds, np.zeros_like(speeds), slip_law, heading=0.0)
    seen = reckoned(motions)
    return positions(motions)[-1] - positions(seen)[-1], headings(motions)[-1] - headings(seen)[-1]


def slip(longitudinal: float, lateral: float, yaw: float) -> ProportionalSlip:
    return ProportionalSlip(full(1, longitudinal), full(1, lateral), full(1, yaw))


def test_slip_along_and_across_is_missed_in_full() -> None:
    speeds = np.linspace(0.5, 0.9, 40)
    length = speeds.sum() * TICK
    off, turned = drift(slip(-0.2, 0.1, 0.0), speeds)
    # lateral slip is positive to the right
    np.testing.assert_allclose(off, [-0.2 * length, -0.1 * length], rtol=1e-9)
    assert turned == pytest.approx(0.0, abs=1e-12)


def test_yaw_slip_is_missed_in_full() -> None:
    speeds = np.full(40, 0.6)
    length = 0.6 * 40 * TICK
    off, turned = drift(slip(0.0, 0.0, 0.5), speeds)
    assert turned == pytest.approx(0.5 * length, rel=1e-9)
    expected = [np.sin(0.5 * length) / 0.5 - length, (1.0 - np.cos(0.5 * length)) / 0.5]
    np.testing.assert_allclose(off, expected, atol=1e-8)
