"""From (μ̄₁, μ₂) to wheel torques within a limit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.control.torque import TorqueDrive
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import MAGELLAN_PRO
from tests.builders import full
from tests.dynamic import PAPER_BODY, wide_torque

TICK = 0.01
HEAVY = Inertia(MAGELLAN_PRO, 18.2, 0.39375, wheel_inertia=0.0074, joint_friction=0.05)
values = st.floats(-5.0, 5.0)
rates = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))


def one(value):
    return np.array([float(value)])


def command(drive, push, jerk, spin, rate=(3.0, 4.0), tick=TICK):
    return drive.command(one(push), one(jerk), one(spin), np.array([rate]), tick)


@given(values, values, values)
def test_torques_ramp_with_mu1_and_turn_with_mu2(push, jerk, spin):
    """(21)–(23): both ends of the ramp by hand; the memory is μ₁ at its end."""
    got, memory, saturated = command(wide_torque(1), push, jerk, spin)
    turn = 0.39375 * spin / 0.1624
    for torque, mu1 in ((got.wheel_torque_start, push), (got.wheel_torque_end, push + jerk * TICK)):
        expected = 0.0825 / 2.0 * np.array([[18.2 * mu1 - turn, 18.2 * mu1 + turn]])
        np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-14)
    assert not saturated[0]
    assert memory.acceleration[0] == got.acceleration[0] == push + jerk * TICK
    assert got.yaw_acceleration[0] == spin


@given(values, values, values, rates)
def test_wheel_inertia_and_joint_friction_are_compensated(push, jerk, spin, rate):
    got = command(wide_torque(1, HEAVY), push, jerk, spin, rate)[0]
    mass = 18.2 + 2.0 * 0.0074 / 0.0825**2
    turn = (0.39375 + 2.0 * 0.0074 * (0.1624 / 0.0825) ** 2) * spin / 0.1624
    for torque, mu1 in ((got.wheel_torque_start, push), (got.wheel_torque_end, push + jerk * TICK)):
        driving = 0.0825 / 2.0 * np.array([mass * mu1 - turn, mass * mu1 + turn])
        np.testing.assert_allclose(torque[0], driving + 0.05 * np.sign(rate), rtol=0, atol=1e-13)


@given(values, values, values, rates, st.floats(0.01, 0.5))
def test_limit_scales_both_wheels_together_and_the_memory_follows(push, jerk, spin, rate, limit):
    drive = TorqueDrive(HEAVY, full(1, limit), full(1, 0.05))
    got, memory, saturated = command(drive, push, jerk, spin, rate)
    free = command(wide_torque(1, HEAVY), push, jerk, spin, rate)[0]
    peak = max(np.abs(free.wheel_torque_start).max(), np.abs(free.wheel_torque_end).max())
    assert saturated[0] == (peak > limit)
    for name in ("wheel_torque_start", "wheel_torque_end"):
        torque, wanted = getattr(got, name), getattr(free, name)
        assert np.abs(torque).max() <= limit * (1.0 + 1e-12)
        np.testing.assert_allclose(
            torque, wanted * min(1.0, limit / max(peak, 1e-300)), rtol=1e-12, atol=1e-15
        )
    reached, turned = HEAVY.accelerations(got.wheel_torque_end, np.array([rate]))
    assert memory.acceleration[0] == pytest.approx(reached[0], abs=1e-12)
    assert got.yaw_acceleration[0] == pytest.approx(turned[0], abs=1e-10)


def test_motor_at_its_limit_does_not_wind_up():
    """Asked for more and more for a second, μ₁ stays at what the motors give, and comes down at once."""
    drive = TorqueDrive(PAPER_BODY, full(1, 0.5), full(1, 0.05))
    most = 2.0 * 0.5 / (0.0825 * 18.2)
    push = 0.0
    for _ in range(100):
        got, memory, _ = command(drive, push, 50.0, 0.0)
        push = memory.acceleration[0]
    assert push == pytest.approx(most, rel=1e-12)
    got, memory, saturated = command(drive, push, -10.0, 0.0)
    assert memory.acceleration[0] == pytest.approx(most - 0.1, rel=1e-12)
    assert not saturated[0]
    np.testing.assert_allclose(got.wheel_torque_start, [[0.5, 0.5]], rtol=1e-12)


def test_limits_of_worlds_are_their_own():
    drive = TorqueDrive(PAPER_BODY, np.array([0.1, 1.0, math.inf]), full(3, 0.05))
    got, _, saturated = drive.command(full(3, 1.0), full(3, 0.0), full(3, 0.0), np.ones((3, 2)), TICK)
    assert saturated.tolist() == [True, False, False]
    whole = 0.0825 / 2.0 * 18.2
    np.testing.assert_allclose(got.wheel_torque_end[:, 0], [0.1, whole, whole], rtol=1e-13)
