"""Torque motors on MuJoCo: what they give, and where they stop giving."""

import math
from dataclasses import replace

import numpy as np
import pytest

from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.standstill import inertia
from slipctl.tick import Start, TorqueCommand
from tests.plants.driving import command, full, ground, start

TICK = 0.01


def motors(**options):
    return MujocoPlant.build(ground=ground(), speed_drive=False, **options)


def torques(first, last=None):
    """Return a command of torques alone, left and right."""
    last = first if last is None else last
    unknown = full(1, math.nan)
    return TorqueCommand(unknown, unknown, np.array([first], float), np.array([last], float))


def go(plant, state, what, ticks):
    for _ in range(ticks):
        state = plant.step(state, what, TICK)
    return state


def body(plant):
    return inertia(plant.batch.model, plant._wheels)


def test_inertia_of_the_compiled_robot():
    """Table II, and a wheel with its armature; the model file has no axle friction."""
    known = body(motors())
    assert known.mass == pytest.approx(18.2, rel=1e-12)
    assert known.yaw_inertia == pytest.approx(0.39375, rel=1e-9)
    assert 0.003 < known.wheel_inertia < 0.02
    assert known.joint_friction == 0.0


@pytest.mark.parametrize(
    ("pair", "push", "spin"),
    [
        ((0.3, 0.3), 1.0, 0.0),
        ((-0.05, 0.05), 0.0, 1.0),
        ((-0.4, -0.4), -1.0, 0.0),
        ((0.02, -0.02), 0.0, -1.0),
    ],
)
def test_robot_speeds_up_as_its_inertia_says(pair, push, spin):
    """(21) with the wheels' inertia, to 1e-4 once the body has pitched; without it 12 % would be missing."""
    plant = motors()
    known = body(plant)
    state = go(plant, plant.start(start(forward_speed=0.3, yaw_rate=0.0)), torques(pair), 60)
    before = plant.observe(state)
    after = plant.observe(go(plant, state, torques(pair), 40))
    wanted = known.accelerations(np.array([pair]), before.wheel_rate)
    got = (after.forward_speed - before.forward_speed) / 0.4, (after.heading_rate - before.heading_rate) / 0.4
    for one, other, sign in zip(got, wanted, (push, spin), strict=True):
        assert one[0] == pytest.approx(other[0], rel=1e-4, abs=1e-4)
        assert np.sign(round(one[0], 3)) == sign
    heavier = replace(known, wheel_inertia=0.0).accelerations(np.array([pair]), before.wheel_rate)
    assert max(abs(h[0] / g[0] - 1.0) for h, g in zip(heavier, got, strict=True) if abs(g[0]) > 1e-3) > 0.03


def test_ramp_acts_as_its_mean():
    plant = motors()
    begin = plant.start(start(forward_speed=0.3))
    ramped = plant.step(begin, torques((0.1, 0.0), (0.3, 0.4)), TICK)
    held = plant.step(begin, torques((0.2, 0.2)), TICK)
    np.testing.assert_allclose(ramped.rows, held.rows, rtol=0, atol=1e-12)
    np.testing.assert_allclose(plant.details(held)[1].torque, [[0.2, 0.2]], rtol=1e-12)


def test_observed_acceleration_is_the_change_of_the_velocity():
    plant = motors()
    state = go(plant, plant.start(start(forward_speed=0.5, yaw_rate=0.8)), torques((0.1, 0.3)), 20)
    step = plant.batch.model.opt.timestep
    later = plant.step(state, torques((0.1, 0.3)), step)
    change = (plant.observe(later).velocity - plant.observe(state).velocity) / step
    acceleration = plant.observe(later).acceleration
    assert acceleration is not None
    np.testing.assert_allclose(acceleration, change, rtol=0, atol=1e-9)
    assert np.hypot(*acceleration[0]) > 0.3


def test_acceleration_at_the_start_is_the_planned_one():
    plant = motors()
    planned = Start(np.zeros((1, 2)), full(1, 0.4), full(1, 0.5), full(1, 0.3), full(1, 0.2))
    acceleration = plant.observe(plant.start(planned)).acceleration
    assert acceleration is not None
    c, s = math.cos(0.4), math.sin(0.4)
    np.testing.assert_allclose(acceleration, [[0.2 * c - 0.15 * s, 0.2 * s + 0.15 * c]], rtol=1e-12)


def test_torque_is_limited_in_both_directions():
    plant = motors(torque_limit=0.5)
    state = plant.start(start(forward_speed=0.3))
    for sign in (1.0, -1.0):
        limited = plant.step(state, torques((sign * 3.0, sign * 0.2)), TICK)
        np.testing.assert_array_equal(plant.details(limited)[1].torque, [[sign * 0.5, sign * 0.2]])
        at_limit = plant.step(state, torques((sign * 0.5, sign * 0.2)), TICK)
        np.testing.assert_array_equal(plant.observe(limited).velocity, plant.observe(at_limit).velocity)


def test_motor_does_not_push_a_wheel_beyond_its_rate_limit():
    """The robot comes to the limit and stays there, to what a tick and the pitching body add."""
    limit = 8.0
    plant = motors(wheel_rate_limit=limit)
    state = go(plant, plant.start(start(forward_speed=0.5)), torques((1.0, 1.0)), 300)
    rate = plant.observe(state).wheel_rate
    assert (np.abs(rate - limit) < 0.3).all()
    free = motors()
    unlimited = free.observe(
        go(free, free.start(start(forward_speed=0.5)), torques((1.0, 1.0)), 300)
    ).wheel_rate
    assert (unlimited > 2.0 * limit).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_motor_brakes_a_wheel_beyond_its_rate_limit(sign):
    plant = motors(wheel_rate_limit=5.0)
    state = plant.start(start(forward_speed=sign * 0.6))
    braked = plant.step(state, torques((-sign * 0.5, -sign * 0.5)), TICK)
    assert (plant.details(braked)[1].torque == -sign * 0.5).all()
    pushed = plant.step(state, torques((sign * 0.5, sign * 0.5)), TICK)
    assert (plant.details(pushed)[1].torque == 0.0).all()


def test_rate_limit_is_of_each_wheel():
    plant = motors(wheel_rate_limit=7.0)
    state = plant.start(start(forward_speed=0.5, yaw_rate=1.0))  # 4.1 and 8.0 rad/s
    torque = plant.details(plant.step(state, torques((0.3, 0.3)), TICK))[1].torque
    np.testing.assert_array_equal(torque, [[0.3, 0.0]])


def test_command_of_the_other_drive_is_refused():
    plant = motors()
    with pytest.raises(TypeError, match="SpeedCommand"):
        plant.step(plant.start(start()), command(full(1, 0.3), full(1, 0.0)), TICK)
    servos = MujocoPlant.build(ground=ground())
    with pytest.raises(TypeError, match="TorqueCommand"):
        servos.step(servos.start(start()), torques((0.1, 0.1)), TICK)
