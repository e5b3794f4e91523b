"""Both dynamic laws, one tick at a time."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.control.flat_dynamic import flat_errors
from slipctl.control.torque import PushMemory, TorqueDrive
from slipctl.theory.dynamic import drift
from slipctl.theory.flatness import apply_decoupling
from slipctl.tick import Motion, Reference, Start
from tests.builders import full
from tests.dynamic import BOUNDS, PAPER_BODY, nominal_dynamic, robust_dynamic, wide_torque

TICK = 0.01
components = st.floats(-2.0, 2.0)
headings = st.floats(-math.pi, math.pi)
speeds = st.floats(0.1, 2.0)
vectors = st.tuples(components, components)


def pair(x, y):
    return np.array([[float(x), float(y)]])


def reference(position=(0, 0), velocity=(0, 0), acceleration=(0, 0), jerk=(0, 0)):
    return Reference(pair(*position), pair(*velocity), pair(*acceleration), pair(*jerk))


def motion(position=(0, 0), velocity=(0, 0), acceleration=(0, 0), heading=0.0, v=0.5, w=0.0):
    """Return a motion; the laws go by the wheels' v and w, and must not look at heading rate or angles."""
    speed, turn = full(1, v), full(1, w)
    return Motion(
        position=pair(*position),
        velocity=pair(*velocity),
        heading_vector=pair(math.cos(heading), math.sin(heading)),
        heading_rate=full(1, math.nan),
        wheel_rate=PAPER_BODY.geometry.wheel_rates(speed, turn),
        wheel_angle=pair(math.nan, math.nan),
        forward_speed=speed,
        yaw_rate=turn,
        acceleration=None if acceleration is None else pair(*acceleration),
    )


def laws():
    pole = full(1, -0.5)
    yield nominal_dynamic(pole)
    for bound in BOUNDS.values():
        yield robust_dynamic(pole, full(1, 0.005), bound(full(1, 0.3)))


def pushing(value):
    return PushMemory(full(1, value))


def test_errors_are_actual_minus_desired():
    plan = reference((1, 2), (3, 4), (5, 6))
    errors = flat_errors(plan, motion((1.5, 1.0), (2.0, 4.25), (5.25, 5.5)), pushing(9.0))
    np.testing.assert_array_equal(np.stack(errors)[:, 0], [[0.5, -1.0], [-1.0, 0.25], [0.25, -0.5]])


def test_without_a_measured_acceleration_the_model_stands_in():
    """μ₁t + v w n, facing +y: μ₁ = 0.3, v w = 0.5·0.4."""
    there = motion(acceleration=None, heading=math.pi / 2.0, v=0.5, w=0.4)
    e3 = flat_errors(reference(acceleration=(0.1, 0.1)), there, pushing(0.3))[2]
    np.testing.assert_allclose(e3, [[-0.2 - 0.1, 0.3 - 0.1]], rtol=0, atol=1e-15)


def test_nominal_input_by_hand():
    """(68) at pole −0.5: F⃛_d − 0.125 e₁ − 0.75 e₂ − 1.5 e₃."""
    for law in laws():
        there = motion((0.5, -1.0), (-1.0, 0.25), (0.25, -0.5))
        trace = law.update(pushing(0.1), reference(jerk=(1, 2)), there, TICK).trace
        expected = [1.0 - 0.0625 + 0.75 - 0.375, 2.0 + 0.125 - 0.1875 + 0.75]
        np.testing.assert_allclose(trace.nominal_input[0], expected, rtol=1e-14)


@given(vectors, vectors, vectors, headings, speeds, components, components)
def test_without_slip_the_flat_input_is_the_third_derivative(e1, e2, e3, heading, v, w, push):
    """A + B μ̄ = v̂ + Δv for what was commanded, with the wheels' v and w and the law's μ₁ in A and B."""
    c, s = np.array([math.cos(heading)]), np.array([math.sin(heading)])
    for law in laws():
        there = motion(e1, e2, e3, heading, v, w)
        decision = law.update(pushing(push), reference(jerk=(0.1, -0.2)), there, TICK)
        command, trace = decision.command, decision.trace
        jerk = (command.acceleration - push) / TICK
        got = drift(full(1, v), full(1, w), full(1, push), c, s) + apply_decoupling(
            full(1, v), c, s, jerk, command.yaw_acceleration
        )
        wanted = trace.nominal_input + trace.robust_input
        np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-11 * (1.0 + np.abs(wanted).max()))
        assert not trace.saturated[0]
        np.testing.assert_array_equal(decision.memory.acceleration, command.acceleration)


def test_on_the_reference_every_law_is_feedforward():
    """No error: Δv = 0, the torques are the plan's: none on a circle, m r μ₁/2 on a straight line."""
    v, w = 0.5, 0.4
    circle = reference((0, 0), (v, 0), (0, v * w), (-v * w**2, 0))
    straight = reference((0, 0), (v, 0), (0.2, 0), (0.3, 0))
    for law in laws():
        on_it = motion((0, 0), (v, 0), (0, v * w), v=v, w=w)
        decision = law.update(pushing(0.0), circle, on_it, TICK)
        assert not decision.trace.robust_input.any()
        np.testing.assert_allclose(decision.command.wheel_torque_end, [[0.0, 0.0]], rtol=0, atol=1e-15)
        decision = law.update(pushing(0.2), straight, motion((0, 0), (v, 0), (0.2, 0), v=v), TICK)
        for name, mu1 in (("wheel_torque_start", 0.2), ("wheel_torque_end", 0.203)):
            np.testing.assert_allclose(
                getattr(decision.command, name), [[0.0825 * 9.1 * mu1] * 2], rtol=1e-12
            )


@given(vectors, vectors, vectors, headings, speeds, components, components)
def test_robust_law_is_the_nominal_one_plus_its_corrective_term(e1, e2, e3, heading, v, w, push):
    """Traced by hand: JᵀPe = 4 e₁ + 9.8125 e₂ + 6.875 e₃, ρ from ‖v̂‖, v, w, μ₁ and t·(v̂ − A)."""
    for name, build in BOUNDS.items():
        law = robust_dynamic(full(1, -0.5), full(1, 0.005), build(full(1, 0.3)))
        trace = law.update(pushing(push), reference(), motion(e1, e2, e3, heading, v, w), TICK).trace
        assert trace.weighted_error is not None
        assert trace.robust_gain is not None
        first, second, third = (np.array(e) for e in (e1, e2, e3))
        weighted = 4.0 * first + 9.8125 * second + 6.875 * third
        nominal = -(0.125 * first + 0.75 * second + 1.5 * third)
        np.testing.assert_allclose(trace.weighted_error[0], weighted, rtol=0, atol=1e-12)
        np.testing.assert_allclose(trace.nominal_input[0], nominal, rtol=0, atol=1e-13)
        length, speed = math.hypot(*nominal), abs(v)
        if name == "paper":
            jerk = nominal @ [math.cos(heading), math.sin(heading)] + v * w**2  # −t·A = v w²
            along = 0.3 * abs(push * w) + 0.3 * speed * w**2
            across = (
                0.3 * speed * w**2 + 1.3 * speed * 0.3 * abs(push) + 0.3 * abs(jerk) + 0.6 * abs(w * push)
            )
            rho = (0.3 * length + along + across) / 0.7
            assert trace.robust_gain[0] == pytest.approx(rho, rel=1e-10, abs=1e-12)
        rho = trace.robust_gain[0]
        np.testing.assert_allclose(
            trace.robust_input[0],
            -rho * weighted / max(math.hypot(*weighted), 0.005),
            rtol=0,
            atol=1e-10 * (1.0 + rho),
        )


def test_robot_behind_pushes_and_robot_to_the_right_turns_left():
    ahead = reference((1.0, 0.0), (0.5, 0.0))
    for law in laws():
        behind = law.update(pushing(0.0), ahead, motion((0.9, 0.0), (0.5, 0.0)), TICK).command
        right = law.update(pushing(0.0), ahead, motion((1.0, -0.1), (0.5, 0.0)), TICK).command
        assert behind.acceleration[0] > 1e-4
        assert behind.yaw_acceleration[0] == 0.0
        assert right.yaw_acceleration[0] > 0.02
        assert right.wheel_torque_end[0, 1] > right.wheel_torque_end[0, 0]


def test_slow_robot_divides_by_the_floor():
    """μ₂ = n·(v̂ − A)/max(v, floor)."""
    drive = TorqueDrive(PAPER_BODY, full(1, 1e6), full(1, 0.05))
    turns = {}
    for v in (0.1, 0.05, 0.02, 0.0, -0.1):
        law = nominal_dynamic(full(1, -0.5), drive)
        turns[v] = law.update(
            pushing(0.0), reference(jerk=(0, 0.4)), motion(v=v), TICK
        ).command.yaw_acceleration[0]
    assert turns[0.1] == pytest.approx(4.0)
    assert turns[0.05] == turns[0.02] == turns[0.0] == turns[-0.1] == pytest.approx(8.0)


def test_memory_starts_at_what_the_motors_push_already():
    start = Start(pair(0, 0), np.zeros(1), full(1, 0.3), np.zeros(1), full(1, 0.7))
    for law in laws():
        assert law.start(start).acceleration[0] == 0.7


def test_nominal_law_has_no_gain_to_trace():
    trace = nominal_dynamic(full(1, -0.5)).update(pushing(0.0), reference(), motion((1, 1)), TICK).trace
    assert trace.robust_gain is None
    assert trace.weighted_error is None
    assert not trace.robust_input.any()


def test_saturation_is_traced_and_remembered():
    for law in laws():
        limited = replace(law, drive=replace(wide_torque(1), torque_limit=full(1, 0.1)))
        decision = limited.update(pushing(0.0), reference(), motion((-5.0, -5.0)), TICK)
        assert decision.trace.saturated[0]
        assert np.abs(decision.command.wheel_torque_end).max() == pytest.approx(0.1)
        assert decision.memory.acceleration[0] == decision.command.acceleration[0]
