import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.control.drive import DriveLimits
from slipctl.theory.robot import MAGELLAN_PRO
from tests.builders import full

TICK = 0.01
HALF_TRACK = MAGELLAN_PRO.half_track


def limits(worlds=1, speed=2.5, turn=6.0, floor=0.05):
    return DriveLimits(MAGELLAN_PRO, full(worlds, speed), full(worlds, turn), full(worlds, floor))


def command(drive, commanded, acceleration, turn, tick=TICK):
    answer, memory, saturated = drive.command(
        *(np.array([float(x)]) for x in (commanded, acceleration, turn)), tick
    )
    return answer, float(memory[0]), bool(saturated[0])


@given(st.floats(0.06, 1.0), st.floats(-0.5, 0.5), st.floats(-5.9, 5.9))
def test_inside_its_limits_the_drive_does_exactly_what_it_is_told(commanded, acceleration, turn):
    answer, memory, saturated = command(limits(), commanded, acceleration, turn)
    assert not saturated
    assert answer.forward_acceleration[0] == acceleration
    assert answer.yaw_rate[0] == turn
    assert answer.forward_speed[0] == memory == commanded + acceleration * TICK
    np.testing.assert_array_equal(
        answer.wheel_rate, MAGELLAN_PRO.wheel_rates(answer.forward_speed, answer.yaw_rate)
    )


@given(st.floats(0.05, 2.5), st.floats(-1e4, 1e4), st.floats(-1e3, 1e3))
def test_no_command_goes_past_a_limit(commanded, acceleration, turn):
    answer, memory, saturated = command(limits(), commanded, acceleration, turn)
    speed, yaw_rate = answer.forward_speed[0], answer.yaw_rate[0]
    assert 0.0 < speed <= 2.5
    assert abs(yaw_rate) <= 6.0
    assert 0.05 <= memory <= 2.5
    rim = np.abs(answer.wheel_rate[0]) * MAGELLAN_PRO.wheel_radius
    assert rim.max() <= 2.5 * (1.0 + 1e-14)
    changed = speed != commanded + acceleration * TICK or yaw_rate != turn
    assert saturated == changed


@given(st.floats(0.05, 2.5), st.floats(-1e4, 1e4), st.floats(-1e3, 1e3))
def test_acceleration_leads_from_the_remembered_speed_to_the_commanded_one(commanded, acceleration, turn):
    answer, _, _ = command(limits(), commanded, acceleration, turn)
    reached = commanded + answer.forward_acceleration[0] * TICK
    assert reached == pytest.approx(answer.forward_speed[0], abs=1e-14)


def test_speed_stops_at_the_floor():
    answer, memory, saturated = command(limits(), 0.06, -100.0, 0.0)
    assert answer.forward_speed[0] == memory == 0.05
    assert answer.forward_acceleration[0] == pytest.approx(-1.0)
    assert saturated


def test_speed_stops_at_the_limit():
    answer, memory, saturated = command(limits(), 2.49, 100.0, 0.0)
    assert answer.forward_speed[0] == memory == 2.5
    assert answer.forward_acceleration[0] == pytest.approx(1.0)
    assert saturated


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_yaw_rate_stops_at_its_limit_on_either_side(side):
    answer, _, saturated = command(limits(), 0.5, 0.0, side * 50.0)
    assert answer.yaw_rate[0] == side * 6.0
    assert answer.forward_speed[0] == 0.5
    assert saturated


def test_wheels_beyond_the_limit_are_scaled_together_so_that_the_path_keeps_its_curvature():
    answer, memory, saturated = command(limits(turn=20.0), 2.0, 0.0, 10.0)
    speed, turn = answer.forward_speed[0], answer.yaw_rate[0]
    assert turn / speed == pytest.approx(10.0 / 2.0, rel=1e-14)
    assert speed + HALF_TRACK * turn == pytest.approx(2.5, rel=1e-14)  # the outer rim
    assert memory == speed < 2.0
    assert saturated


def test_scaling_below_the_floor_leaves_the_floor_in_the_memory():
    """The wheels get what they can do; the law must never divide by less than the floor."""
    answer, memory, saturated = command(limits(turn=100.0), 0.06, 0.0, 40.0)
    assert answer.forward_speed[0] == pytest.approx(0.06 * 2.5 / (0.06 + HALF_TRACK * 40.0))
    assert memory == 0.05
    assert saturated


def test_without_limits_only_the_floor_is_left():
    drive = limits(worlds=2, speed=0.2, turn=0.1).unlimited()
    answer, memory, saturated = drive.command(full(2, 0.06), np.array([1e4, -1e4]), full(2, 1e3), TICK)
    assert answer.forward_speed.tolist() == memory.tolist() == [100.06, 0.05]
    assert answer.yaw_rate.tolist() == [1e3, 1e3]
    assert saturated.tolist() == [False, True]
    np.testing.assert_array_equal(
        answer.wheel_rate, MAGELLAN_PRO.wheel_rates(answer.forward_speed, answer.yaw_rate)
    )


def test_a_speed_may_be_reached_without_a_floor():
    """Backwards as well, and as fast as the limit says; a drive without limits as fast as it is told."""
    wanted, before, turn = np.array([-0.4, -3.0]), np.array([-0.3, -2.4]), np.zeros(2)
    answer, saturated = limits(2).reach(wanted, before, None, (wanted - before) / TICK, turn, TICK)
    assert answer.forward_speed.tolist() == [-0.4, -2.5]
    np.testing.assert_allclose(answer.forward_acceleration, [-10.0, -10.0], rtol=1e-12)
    assert saturated.tolist() == [False, True]
    free = limits(2).unlimited().reach(wanted, before, None, (wanted - before) / TICK, turn, TICK)
    assert free[0].forward_speed.tolist() == [-0.4, -3.0]
    assert not free[1].any()


def test_memory_does_not_wind_up():
    """After a hundred ticks against the limit the first braking tick already shows."""
    drive, memory = limits(), 2.4
    for _ in range(100):
        _, memory, saturated = command(drive, memory, 50.0, 0.0)
        assert saturated
    assert memory == 2.5
    answer, memory, saturated = command(drive, memory, -10.0, 0.0)
    assert answer.forward_speed[0] == memory == pytest.approx(2.4)
    assert not saturated


def test_every_world_has_its_own_limits():
    drive = DriveLimits(MAGELLAN_PRO, np.array([1.0, 2.0]), np.array([3.0, 0.5]), np.array([0.05, 0.1]))
    answer, memory, saturated = drive.command(
        np.array([0.9, 0.9]), np.array([50.0, 50.0]), np.full(2, 0.6), TICK
    )
    assert answer.forward_speed[0] + HALF_TRACK * answer.yaw_rate[0] == pytest.approx(1.0)
    assert (answer.forward_speed[1], answer.yaw_rate[1]) == (pytest.approx(1.4), 0.5)
    np.testing.assert_array_equal(memory, answer.forward_speed)
    assert saturated.all()


def test_a_command_that_is_no_number_counts_as_saturated_and_stays_in_its_world():
    answer, memory, saturated = limits(2).command(full(2, 0.5), np.array([np.nan, 1.0]), np.zeros(2), TICK)
    assert np.isnan(memory[0])
    assert saturated[0]
    assert (answer.forward_speed[1], memory[1], saturated[1]) == (0.51, 0.51, False)
    answer, _, saturated = limits(2).command(full(2, 0.5), np.ones(2), np.array([0.0, np.nan]), TICK)
    assert np.isnan(answer.yaw_rate[1])
    assert saturated.tolist() == [False, True]
