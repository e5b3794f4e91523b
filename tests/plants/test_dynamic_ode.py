import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipctl.plants.dynamic_ode import DynamicOde
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import NoSlip, ProportionalSlip, SeriesSlip, SinusoidalSlip, measure_slip
from slipctl.tick import Start, Status, TorqueCommand
from tests.builders import full
from tests.dynamic import PAPER_BODY, dynamic_plant

FRACTIONS = np.array([[0.3, -0.2, 0.5], [-0.4, 0.35, -0.6], [0.1, 0.6, 1.5]])
PERIODS = np.array([0.9, 1.7, 0.33])
STARTS = Start(
    position=np.array([[0.5, -1.0], [2.0, 3.0], [-1.0, 0.2]]),
    heading=np.array([2.1, -3.0, 0.4]),
    forward_speed=np.array([0.3, 1.2, -0.4]),
    yaw_rate=np.array([0.2, -1.0, 3.0]),
    forward_acceleration=np.array([0.1, -0.3, 0.2]),
)
M, I_Z, R, B = 18.2, 0.39375, 0.0825, 0.1624


def swinging():
    return SinusoidalSlip(*FRACTIONS, period=PERIODS)


def ramp(first, last):
    """Return a command of torques alone: what the law thinks is none of the plant's business."""
    unknown = np.full(len(first), np.nan)
    return TorqueCommand(unknown, unknown, first, last)


def coast(worlds):
    return ramp(np.zeros((worlds, 2)), np.zeros((worlds, 2)))


def still(worlds, forward_speed=0.0, yaw_rate=0.0):
    zero = np.zeros(worlds)
    return Start(np.zeros((worlds, 2)), zero, full(worlds, forward_speed), full(worlds, yaw_rate), zero)


def radau(time, span, y0, world, first, last):
    """Integrate (31) with sinusoidal slip over one ramp of torques, for one world.

    States x, y, θ, v, w, unlike the plant's; (31d) and (31f) are solved for v̇ and ẇ, in which
    v̇_t = ḟ_t v + f_t v̇ and likewise for w_s. Torques are left, right.
    """
    a_t, a_s, a_w = FRACTIONS[:, world]
    frequency = 2.0 * math.pi / PERIODS[world]

    def rhs(t, y):
        swing, swing_rate = math.sin(frequency * t), frequency * math.cos(frequency * t)
        _, _, angle, v, w = y
        v_t, v_s, w_s = a_t * swing * v, a_s * swing * v, a_w * swing * v
        left, right = first + (last - first) * (t - time) / span
        mu1, mu2 = (right + left) / (M * R), (right - left) * B / (I_Z * R)
        turn = w + w_s
        v_rate = (mu1 - a_t * swing_rate * v - v_s * turn) / (1.0 + a_t * swing)
        return [
            (v + v_t) * math.cos(angle) + v_s * math.sin(angle),
            (v + v_t) * math.sin(angle) - v_s * math.cos(angle),
            turn,
            v_rate,
            mu2 - a_w * (swing_rate * v + swing * v_rate),
        ]

    return solve_ivp(rhs, (time, time + span), y0, method="Radau", rtol=1e-12, atol=1e-14).y[:, -1]


def test_ramped_torques_against_radau_at_100_hz():
    """Random ramps, slip and starts that are not the paper's; 1e-6 is promised, RK4 does better."""
    tick, ticks = 0.01, 100
    rng = np.random.default_rng(7)
    torques = np.cumsum(rng.uniform(-0.15, 0.15, (ticks + 1, 3, 2)), axis=0)
    plant = dynamic_plant(swinging(), 3)
    state = plant.start(STARTS)
    exact = np.column_stack([STARTS.position, STARTS.heading, STARTS.forward_speed, STARTS.yaw_rate])
    worst = 0.0
    for k in range(ticks):
        state = plant.step(state, ramp(torques[k], torques[k + 1]), tick)
        for world in range(3):
            exact[world] = radau(
                k * tick, tick, exact[world], world, torques[k, world], torques[k + 1, world]
            )
        motion = plant.observe(state)
        reached = [motion.position, state.heading, motion.forward_speed, motion.yaw_rate]
        worst = max(worst, np.abs(np.column_stack(reached) - exact).max())
    assert worst < 1e-6
    assert np.abs(exact[:, :2] - STARTS.position).max() > 0.2  # it went somewhere
    assert np.abs(np.diff(torques, axis=0)).max() > 0.1  # ramps, not holds
    assert state.time == pytest.approx(ticks * tick)


def test_runge_kutta_converges_with_fourth_order():
    """One ramp over several substeps; the finest step stands in for the truth."""
    span = 0.8
    first, last = (
        np.array([[0.4, 0.6], [-0.5, -0.4], [0.3, -0.3]]),
        np.array([[0.2, 0.9], [0.1, 0.3], [0.0, 0.5]]),
    )

    def end(steps):
        plant, h = dynamic_plant(swinging(), 3), span / steps
        state = plant.start(STARTS)
        for k in range(steps):
            at = [first + (last - first) * (j / steps) for j in (k, k + 1)]
            state = plant.step(state, ramp(*at), h)
        return np.column_stack([state.position, state.heading, state.body_speed])

    truth = end(4096)
    errors = [np.abs(end(steps) - truth).max() for steps in (64, 128, 256)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 4.0) < 0.2).all(), orders


def test_straight_line_with_ramped_torque_in_closed_form():
    """τ = τ₀ + τ′t on both wheels: x = (v₀ + …)t + 2(τ₀t²/2 + τ′t³/6)/(m r)."""
    plant = dynamic_plant(NoSlip(1), 1)
    state = plant.start(still(1, forward_speed=0.2))
    for k in range(100):
        at = [np.full((1, 2), 0.1 + 0.05 * 0.02 * j) for j in (k, k + 1)]
        state = plant.step(state, ramp(*at), 0.02)
    way = 0.2 * 2.0 + 2.0 / (M * R) * (0.1 * 2.0**2 / 2.0 + 0.05 * 2.0**3 / 6.0)
    np.testing.assert_allclose(state.position, [[way, 0.0]], rtol=1e-13, atol=0)
    assert plant.observe(state).wheel_angle[0] == pytest.approx([way / R, way / R], rel=1e-13)


def test_turn_on_the_spot_in_closed_form():
    """(21): more torque on the right wheel turns left, θ = b(τ_r − τ_l)t²/(2 r I_z)."""
    plant = dynamic_plant(NoSlip(1), 1)
    state = plant.start(still(1))
    for _ in range(50):
        state = plant.step(state, ramp(np.array([[-0.02, 0.02]]), np.array([[-0.02, 0.02]])), 0.02)
    assert state.heading[0] == pytest.approx(B * 0.04 / (R * I_Z) / 2.0, rel=1e-13)
    assert np.abs(state.position).max() < 1e-15


def test_coasting_with_proportional_slip_keeps_what_31_keeps():
    """Without torque Ω stays and V̇ = −v_sΩ, so that v = v₀ exp(−f_sΩt/(1 + f_t))."""
    plant = dynamic_plant(ProportionalSlip(full(1, 0.25), full(1, 0.5), full(1, 0.2)), 1)
    start = still(1, forward_speed=0.4, yaw_rate=0.6)
    state = plant.start(start)
    for _ in range(100):
        state = plant.step(state, coast(1), 0.01)
    turn = 0.6 + 0.2 * 0.4
    assert state.heading_rate[0] == pytest.approx(turn, rel=1e-14)
    speed = 0.4 * math.exp(-0.5 / 1.25 * turn)  # v̇ = −0.5 v Ω/1.25
    motion = plant.observe(state)
    assert motion.forward_speed[0] == pytest.approx(speed, rel=1e-9)
    assert motion.yaw_rate[0] == pytest.approx(turn - 0.2 * speed, rel=1e-9)


def test_observed_motion_is_that_of_one_instant():
    """Velocity, rates and heading contain the slip of this instant, and measuring gives it back."""
    plant = dynamic_plant(swinging(), 3)
    state = plant.start(STARTS)
    torque = np.array([[0.3, 0.5], [-0.2, 0.1], [0.4, -0.3]])
    for _ in range(7):
        state = plant.step(state, ramp(torque, torque), 0.03)
    motion = plant.observe(state)
    law = swinging().affine(state.time).at(motion.forward_speed)
    slip = measure_slip(motion)
    for name in ("longitudinal", "lateral", "yaw"):
        np.testing.assert_allclose(getattr(slip, name), getattr(law, name), rtol=0, atol=1e-14)
    speed, turn = MAGELLAN_PRO.body_rates(motion.wheel_rate)
    np.testing.assert_allclose(speed, motion.forward_speed, rtol=1e-13)
    np.testing.assert_allclose(turn, motion.yaw_rate, rtol=1e-13)
    assert np.abs(law.lateral).min() > 1e-3


@pytest.mark.parametrize("kind", ["swinging", "series"])
def test_observed_velocity_and_acceleration_are_derivatives(kind):
    """Central differences of position and velocity, with the torque held at what was last in force."""
    h, worlds = 1e-3, 3
    times = np.array([0.0, 0.5, 1.0])
    tables = [np.array([row, row[::-1], row]) * 0.2 for row in FRACTIONS]
    law = swinging() if kind == "swinging" else SeriesSlip(times, *tables)
    plant = dynamic_plant(law, worlds)
    state = plant.start(STARTS)
    torque = np.array([[0.3, 0.5], [-0.2, 0.1], [0.4, -0.3]])
    for _ in range(9):
        state = plant.step(state, ramp(torque, torque), 0.01)
    seen = []
    for _ in range(5):
        seen.append(plant.observe(state))
        state = plant.step(state, ramp(torque, torque), h)
    stencil = (1.0 / 12.0, -2.0 / 3.0, 0.0, 2.0 / 3.0, -1.0 / 12.0)

    def slope(name):
        return sum(weight * getattr(motion, name) for weight, motion in zip(stencil, seen, strict=True)) / h

    middle = seen[2]
    assert middle.acceleration is not None
    np.testing.assert_allclose(slope("position"), middle.velocity, rtol=0, atol=1e-7)
    np.testing.assert_allclose(slope("velocity"), middle.acceleration, rtol=0, atol=1e-6)
    np.testing.assert_allclose(slope("wheel_angle"), middle.wheel_rate, rtol=0, atol=1e-6)
    assert np.abs(middle.acceleration).max() > 0.1


def test_acceleration_at_the_start_is_the_planned_push_with_slip():
    """F̈ = μ₁t + (VΩ − v̇_s)n with v̇ = (μ₁ − v_sΩ)/(1 + f): f = 0.3, v = 0.15, w = 0.2, μ₁ = 0.1, by hand."""
    plant = dynamic_plant(ProportionalSlip(*(full(1, 0.3) for _ in range(3))), 1)
    start = Start(np.zeros((1, 2)), np.zeros(1), full(1, 0.15), full(1, 0.2), full(1, 0.1))
    motion = plant.observe(plant.start(start))
    turn = 0.2 + 0.045
    lateral_rate = 0.3 * (0.1 - 0.045 * turn) / 1.3
    np.testing.assert_allclose(motion.velocity, [[0.195, -0.045]], rtol=1e-14)
    assert motion.acceleration is not None
    np.testing.assert_allclose(motion.acceleration, [[0.1, 0.195 * turn - lateral_rate]], rtol=1e-13)
    np.testing.assert_allclose(
        [motion.forward_speed[0], motion.yaw_rate[0], motion.heading_rate[0]], [0.15, 0.2, turn]
    )


def test_wheel_inertia_and_axle_friction_take_their_share():
    """A robot with heavy wheels and rubbing axles: v̇ = (2τ/r − 2 J_f/r)/(m + 2J/r²)."""
    body = Inertia(MAGELLAN_PRO, M, I_Z, wheel_inertia=0.02, joint_friction=0.05)
    plant = dynamic_plant(NoSlip(1), 1, body=body)
    state = plant.start(still(1, forward_speed=0.3))
    pull = np.full((1, 2), 0.2)
    for _ in range(100):
        state = plant.step(state, ramp(pull, pull), 0.01)
    rate = 2.0 * (0.2 - 0.05) / R / (M + 2.0 * 0.02 / R**2)
    assert state.body_speed[0] == pytest.approx(0.3 + rate, rel=1e-12)


def run(plant, start, command, ticks, tick=0.01):
    states = [plant.start(start)]
    for _ in range(ticks):
        states.append(plant.step(states[-1], command, tick))
    return states


def test_world_that_left_the_arena_stays_there_and_the_others_do_not_notice():
    start = Start(np.zeros((2, 2)), np.zeros(2), np.array([1.0, 0.1]), np.zeros(2), np.zeros(2))
    plant = DynamicOde(PAPER_BODY, NoSlip(2), full(2, 0.495))
    states = run(plant, start, coast(2), 100)
    status = np.stack([state.status for state in states])
    first = int(np.argmax(status[:, 0] != Status.RUNNING))
    assert first == 50  # at 0.5 m
    assert (status[first:, 0] == Status.LEFT_THE_ARENA).all()
    assert (status[:, 1] == Status.RUNNING).all()
    for state in states[first:]:
        np.testing.assert_array_equal(state.position[0], states[first].position[0])
        np.testing.assert_array_equal(state.wheel_angle[0], states[first].wheel_angle[0])
    assert states[-1].position[1, 0] == pytest.approx(0.1)


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("end", ["start", "end"])
def test_world_that_diverged_says_so_and_the_others_do_not_notice(broken, end):
    plant = dynamic_plant(swinging(), 3)
    good = np.full((3, 2), 0.1)
    bad = good.copy()
    bad[1, 0] = broken
    reference = run(plant, STARTS, ramp(good, good), 2)
    command = ramp(bad, good) if end == "start" else ramp(good, bad)
    state = plant.step(reference[0], command, 0.01)
    assert list(state.status) == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    later = plant.step(state, ramp(good, good), 0.01)
    assert list(later.status) == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    for world in (0, 2):
        np.testing.assert_array_equal(later.position[world], reference[2].position[world])
        assert later.heading_rate[world] == reference[2].heading_rate[world]
    for ended in (state, later):  # at the last finite state
        np.testing.assert_array_equal(ended.position[1], STARTS.position[1])
        motion = plant.observe(ended)
        assert motion.acceleration is not None
        assert np.isfinite([motion.velocity, motion.acceleration]).all()


def test_dynamic_model_has_no_bodies():
    plant = dynamic_plant(NoSlip(3), 3)
    assert plant.details(plant.start(STARTS)) is None
