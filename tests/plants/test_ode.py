import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipctl.plants.ode import KinematicOde
from slipctl.theory.robot import MAGELLAN_PRO, WheelGeometry
from slipctl.theory.slip import NoSlip, ProportionalSlip, SinusoidalSlip, measure_slip
from slipctl.tick import SpeedCommand, Status
from tests.builders import full, ode_plant, start_of

FRACTIONS = np.array([[0.3, -0.2, 0.5], [-0.4, 0.35, -0.6], [0.1, 0.6, 1.5]])
PERIODS = np.array([0.9, 1.7, 0.33])
STARTS = start_of(
    position=np.array([[0.5, -1.0], [2.0, 3.0], [-1.0, 0.2]]),
    heading=np.array([2.1, -3.0, 0.4]),
    forward_speed=np.array([0.3, 1.2, -0.4]),
    yaw_rate=np.array([0.2, -1.0, 3.0]),
)


def hold(state, acceleration, turn, tick):
    """Return the command that holds (ū₁, ū₂) from a state over a tick."""
    speed = state.forward_speed + acceleration * tick
    return SpeedCommand(acceleration, speed, turn, MAGELLAN_PRO.wheel_rates(speed, turn))


def swinging():
    return SinusoidalSlip(*FRACTIONS, period=PERIODS)


def radau(time, span, y0, inputs):
    """Integrate (29) with sinusoidal slip, written out once more, for one world over a held input.

    States x, y, θ, v; `inputs` are the world's index and (ū₁, ū₂).
    """
    world, u1, u2 = inputs
    a_t, a_s, a_w = FRACTIONS[:, world]

    def rhs(t, y):
        swing = math.sin(2.0 * math.pi * t / PERIODS[world])
        _, _, angle, v = y
        v_t, v_s, w_s = a_t * swing * v, a_s * swing * v, a_w * swing * v
        return [
            (v + v_t) * math.cos(angle) + v_s * math.sin(angle),
            (v + v_t) * math.sin(angle) - v_s * math.cos(angle),
            u2 + w_s,
            u1,
        ]

    return solve_ivp(rhs, (time, time + span), y0, method="Radau", rtol=1e-12, atol=1e-14).y[:, -1]


def test_held_inputs_against_radau_at_100_hz():
    """Random holds, slip and starts that are not the paper's; 1e-6 is promised, quadrature does better."""
    tick, ticks = 0.01, 150
    rng = np.random.default_rng(7)
    accelerations, turns = rng.uniform(-2.0, 2.0, (ticks, 3)), rng.uniform(-3.0, 3.0, (ticks, 3))
    plant = ode_plant(swinging(), 3)
    state = plant.start(STARTS)
    exact = np.column_stack([STARTS.position, STARTS.heading, STARTS.forward_speed])
    worst = 0.0
    for k in range(ticks):
        state = plant.step(state, hold(state, accelerations[k], turns[k], tick), tick)
        for world in range(3):
            held = (world, accelerations[k, world], turns[k, world])
            exact[world] = radau(k * tick, tick, exact[world], held)
        reached = np.column_stack([state.position, state.heading, state.forward_speed])
        worst = max(worst, np.abs(reached - exact).max())
    assert worst < 1e-7  # measured 3.1e-8
    assert np.abs(exact[:, :2] - STARTS.position).max() > 0.2  # it went somewhere
    assert state.time == pytest.approx(ticks * tick)


def test_a_tick_converges_with_fourth_order():
    """One held input over several substeps; the finest step stands in for the truth."""
    span, u1, u2 = 0.8, np.array([0.5, -1.0, 1.5]), np.array([1.0, -2.0, 0.5])

    def end(steps):
        plant, h = ode_plant(swinging(), 3), span / steps
        state = plant.start(STARTS)
        for _ in range(steps):
            state = plant.step(state, hold(state, u1, u2, h), h)
        return np.column_stack([state.position, state.heading])

    truth = end(4096)
    errors = [np.abs(end(steps) - truth).max() for steps in (64, 128, 256)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 4.0) < 0.2).all(), orders


def test_circle_without_slip_in_closed_form():
    v, w, tick, ticks = 0.7, 1.3, 0.01, 500
    plant = ode_plant(NoSlip(1), 1)
    state = plant.start(start_of(np.array([[1.0, 2.0]]), np.array([0.4]), full(1, v), full(1, w)))
    for k in range(1, ticks + 1):
        state = plant.step(state, hold(state, np.zeros(1), full(1, w), tick), tick)
        angle = 0.4 + w * k * tick
        x = 1.0 + v / w * (math.sin(angle) - math.sin(0.4))
        y = 2.0 - v / w * (math.cos(angle) - math.cos(0.4))
        np.testing.assert_allclose(state.position, [[x, y]], rtol=0, atol=1e-10)
        assert state.heading[0] == pytest.approx(angle, abs=1e-12)


def test_straight_line_with_constant_acceleration_in_closed_form():
    """x = (1 + v_t/v)(v t + u t²/2) and, to the right, y = −(v_s/v)(v t + u t²/2)."""
    plant = ode_plant(ProportionalSlip(full(1, 0.25), full(1, 0.5), np.zeros(1)), 1)
    state = plant.start(start_of(np.zeros((1, 2)), np.zeros(1), full(1, 0.2), np.zeros(1)))
    for _ in range(100):
        state = plant.step(state, hold(state, full(1, 0.3), np.zeros(1), 0.02), 0.02)
    way = 0.2 * 2.0 + 0.3 * 2.0
    np.testing.assert_allclose(state.position, [[1.25 * way, -0.5 * way]], rtol=1e-13)


def test_wheels_roll_as_far_as_they_are_told():
    """∫(v ∓ bw)dt/r with radius and track of each world, whatever slips; the first world rolls backwards."""
    robots = WheelGeometry(np.array([0.0825, 0.1]), np.array([0.1624, 0.2]))
    speed, turn, tick = np.array([-0.2, 0.3]), np.array([0.8, -0.5]), 0.02
    plant = KinematicOde(robots, ProportionalSlip(full(2, 0.4), full(2, 0.4), full(2, 0.4)), full(2, 50.0))
    state = plant.start(start_of(np.zeros((2, 2)), np.zeros(2), speed, np.zeros(2)))
    for _ in range(100):
        state = plant.step(state, hold(state, full(2, 0.1), turn, tick), tick)
    way, swung = speed * 2.0 + 0.1 * 2.0, robots.half_track * turn * 2.0
    expected = np.stack([way - swung, way + swung], axis=-1) / np.array([[0.0825], [0.1]])
    np.testing.assert_allclose(plant.observe(state).wheel_angle, expected, rtol=1e-12)


def test_slip_on_a_straight_command_bends_the_path_to_the_side_of_the_yaw_slip():
    """w_s = κ v alone is a circle of curvature κ, to the left."""
    plant = ode_plant(ProportionalSlip(np.zeros(1), np.zeros(1), full(1, 2.0)), 1)
    state = plant.start(start_of(np.zeros((1, 2)), np.zeros(1), full(1, 0.5), np.zeros(1)))
    for _ in range(100):
        state = plant.step(state, hold(state, np.zeros(1), np.zeros(1), 0.01), 0.01)
    expected = [[math.sin(1.0) / 2.0, (1.0 - math.cos(1.0)) / 2.0]]
    np.testing.assert_allclose(state.position, expected, rtol=0, atol=1e-10)


def test_observed_motion_is_that_of_one_instant():
    """Velocity and heading rate contain the slip of this instant, and measuring gives it back."""
    plant = ode_plant(swinging(), 3)
    state = plant.start(STARTS)
    for _ in range(7):
        state = plant.step(state, hold(state, full(3, 0.4), full(3, -0.8), 0.03), 0.03)
    motion = plant.observe(state)
    law = swinging().affine(state.time).at(state.forward_speed)
    slip = measure_slip(motion)
    for name in ("longitudinal", "lateral", "yaw"):
        np.testing.assert_allclose(getattr(slip, name), getattr(law, name), rtol=0, atol=1e-14)
    speed, turn = MAGELLAN_PRO.body_rates(motion.wheel_rate)
    np.testing.assert_allclose(speed, state.forward_speed, rtol=1e-14)
    np.testing.assert_allclose(turn, [-0.8] * 3, rtol=1e-13)
    np.testing.assert_array_equal(motion.forward_speed, state.forward_speed)
    np.testing.assert_array_equal(motion.position, state.position)
    angle = np.arctan2(motion.heading_vector[:, 1], motion.heading_vector[:, 0])
    np.testing.assert_allclose(np.exp(1j * angle), np.exp(1j * state.heading), rtol=0, atol=1e-14)
    assert np.abs(law.lateral).min() > 1e-3


def test_observed_velocity_is_the_derivative_of_the_position():
    plant, h = ode_plant(swinging(), 3), 1e-4
    state = plant.start(STARTS)
    before = state.position
    middle = plant.step(state, hold(state, full(3, 0.4), full(3, -0.8), h), h)
    after = plant.step(middle, hold(middle, full(3, 0.4), full(3, -0.8), h), h)
    motion = plant.observe(middle)
    np.testing.assert_allclose((after.position - before) / (2.0 * h), motion.velocity, rtol=0, atol=1e-6)
    np.testing.assert_allclose(
        (after.heading - state.heading) / (2.0 * h), motion.heading_rate, rtol=0, atol=1e-6
    )


def test_slip_acts_from_the_first_instant():
    plant = ode_plant(ProportionalSlip(full(1, 0.4), full(1, 0.4), full(1, 0.4)), 1)
    motion = plant.observe(plant.start(start_of(np.zeros((1, 2)), np.zeros(1), full(1, 0.15), full(1, 0.1))))
    np.testing.assert_allclose(motion.velocity, [[0.21, -0.06]], rtol=1e-14)
    assert motion.heading_rate[0] == pytest.approx(0.1 + 0.06)
    assert motion.yaw_rate[0] == 0.1


def test_speed_reached_is_the_commanded_one_and_the_way_there_is_its_mean():
    """Also where the wheels start elsewhere than where the law believes, as they do from rest."""
    plant = ode_plant(NoSlip(1), 1)
    state = plant.start(start_of(np.zeros((1, 2)), np.zeros(1), np.zeros(1), np.zeros(1)))
    command = SpeedCommand(
        full(1, 1.0), full(1, 0.06), np.zeros(1), np.zeros((1, 2))
    )  # memory 0.05, tick 0.01
    state = plant.step(state, command, 0.01)
    assert state.forward_speed[0] == 0.06
    assert state.position[0, 0] == pytest.approx(0.5 * 0.06 * 0.01, rel=1e-12)


def run(plant, start, command, ticks, tick=0.01):
    states = [plant.start(start)]
    for _ in range(ticks):
        states.append(plant.step(states[-1], command, tick))
    return states


def straight(worlds, speed):
    return SpeedCommand(np.zeros(worlds), speed, np.zeros(worlds), np.zeros((worlds, 2)))


def test_world_that_left_the_arena_stays_there_and_the_others_do_not_notice():
    speed = np.array([1.0, 0.1])
    start = start_of(np.zeros((2, 2)), np.zeros(2), speed, np.zeros(2))
    plant = KinematicOde(MAGELLAN_PRO, NoSlip(2), np.array([0.495, 0.495]))
    states = run(plant, start, straight(2, speed), 100)
    status = np.stack([state.status for state in states])
    first = int(np.argmax(status[:, 0] != Status.RUNNING))
    assert first == 50  # at 0.5 m
    assert (status[first:, 0] == Status.LEFT_THE_ARENA).all()
    assert (status[:, 1] == Status.RUNNING).all()
    assert states[first - 1].position[0, 0] == pytest.approx(0.49)
    for state in states[first:]:
        np.testing.assert_array_equal(state.position[0], states[first].position[0])
        assert state.heading[0] == states[first].heading[0]
    alone = KinematicOde(MAGELLAN_PRO, NoSlip(1), np.array([0.495]))
    one = run(
        alone, start_of(np.zeros((1, 2)), np.zeros(1), speed[1:], np.zeros(1)), straight(1, speed[1:]), 100
    )
    for many, single in zip(states, one, strict=True):
        np.testing.assert_array_equal(many.position[1], single.position[0])


def test_arena_is_measured_from_the_worlds_origin():
    start = start_of(np.array([[3.0, 4.0], [-3.0, -4.0]]), np.zeros(2), full(2, 0.1), np.zeros(2))
    plant = KinematicOde(MAGELLAN_PRO, NoSlip(2), np.array([5.0005, 5.0005]))
    state = run(plant, start, straight(2, full(2, 0.1)), 1)[-1]
    assert list(state.status) == [Status.LEFT_THE_ARENA, Status.RUNNING]  # one drives outwards, one inwards


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
def test_world_that_diverged_says_so_and_the_others_do_not_notice(broken):
    plant = ode_plant(swinging(), 3)
    good = np.array([0.2, 0.3, 0.4])
    bad = np.array([0.2, broken, 0.4])
    reference = run(plant, STARTS, straight(3, good), 2)
    state = plant.step(reference[0], straight(3, bad), 0.01)
    assert list(state.status) == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    later = plant.step(state, straight(3, good), 0.01)
    assert list(later.status) == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    for world in (0, 2):
        np.testing.assert_array_equal(later.position[world], reference[2].position[world])
        assert later.heading[world] == reference[2].heading[world]
    for ended in (state, later):  # at the last finite state
        np.testing.assert_array_equal(ended.position[1], STARTS.position[1])
        assert ended.forward_speed[1] == STARTS.forward_speed[1]
        assert np.isfinite(plant.observe(ended).velocity).all()


def test_world_whose_distance_overflows_diverged_though_no_arena_ends():
    """Everything else of it is finite, and no distance is beyond an infinite one."""
    plant = KinematicOde(MAGELLAN_PRO, NoSlip(2), full(2, np.inf))
    start = start_of(np.zeros((2, 2)), np.zeros(2), full(2, 0.1), np.zeros(2))
    state = plant.step(plant.start(start), straight(2, np.array([1e300, 0.1])), 0.01)
    assert list(state.status) == [Status.DIVERGED, Status.RUNNING]
    np.testing.assert_array_equal(state.position[0], [0.0, 0.0])
    assert state.position[1, 0] == pytest.approx(1e-3)


def test_kinematic_model_has_no_bodies():
    plant = ode_plant(NoSlip(3), 3)
    assert plant.details(plant.start(STARTS)) is None


def test_state_of_another_slip_law_is_seen_with_ones_own():
    state = ode_plant(NoSlip(3), 3).start(STARTS)
    plant = ode_plant(ProportionalSlip(*FRACTIONS), 3)
    own, expected = plant.with_own_slip(state), plant.start(STARTS)
    assert not np.array_equal(state.velocity, expected.velocity)
    motion, wanted = plant.observe(own), plant.observe(expected)
    np.testing.assert_array_equal(motion.velocity, wanted.velocity)
    np.testing.assert_array_equal(motion.heading_rate, wanted.heading_rate)
    np.testing.assert_array_equal(motion.wheel_rate, wanted.wheel_rate)
    command = straight(3, np.array([0.3, 0.4, 0.5]))
    after, wanted = plant.step(own, command, 0.05), plant.step(expected, command, 0.05)
    np.testing.assert_array_equal(after.position, wanted.position)
    np.testing.assert_array_equal(after.heading, wanted.heading)


def test_what_follows_from_a_state_is_the_same_whether_all_worlds_move_or_not():
    """A step that stops one world works out the rest anew, one that stops none takes it from its stages."""
    plant = ode_plant(swinging(), 3)
    start = plant.start(STARTS)
    command = straight(3, np.array([0.2, 0.3, 0.4]))
    arena = np.array([50.0, 1e-3, 50.0])
    all_move = plant.step(start, command, 0.02)
    two_move = KinematicOde(MAGELLAN_PRO, swinging(), arena).step(start, command, 0.02)
    assert list(two_move.status) == [Status.RUNNING, Status.LEFT_THE_ARENA, Status.RUNNING]
    for name in ("velocity", "yaw_slip", "wheel_rate", "heading_vector", "position", "wheel_angle"):
        np.testing.assert_array_equal(getattr(two_move, name), getattr(all_move, name))
