"""Both kinematic laws, one tick at a time."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.control.drive import SpeedMemory
from slipctl.control.flat import flat_errors, nominal_input
from slipctl.theory.flatness import apply_decoupling
from slipctl.theory.robust import UNCERTAINTIES
from slipctl.tick import Motion, Reference
from tests.builders import full, nominal_law, robust_law, start_of, wide_drive

TICK = 0.01
components = st.floats(-2.0, 2.0)
headings = st.floats(-math.pi, math.pi)
speeds = st.floats(0.05, 2.0)


def pair(x, y):
    return np.array([[float(x), float(y)]])


def reference(position=(0, 0), velocity=(0, 0), acceleration=(0, 0)):
    return Reference(pair(*position), pair(*velocity), pair(*acceleration), pair(0, 0))


def motion(position=(0, 0), velocity=(0, 0), heading=0.0):
    """Return a motion whose wheel-derived fields are no numbers: the law must go by its own memory."""
    unknown = np.full(1, np.nan)
    vector = pair(math.cos(heading), math.sin(heading))
    nothing = pair(np.nan, np.nan)
    return Motion(
        pair(*position), pair(*velocity), vector, unknown, nothing, nothing, unknown, unknown, nothing
    )


def start_at(speed):
    return start_of(pair(0, 0), np.zeros(1), np.array([speed]), np.zeros(1))


def laws():
    pole = full(1, -0.5)
    yield nominal_law(pole)
    for uncertainty in UNCERTAINTIES.values():
        yield robust_law(pole, full(1, 0.4), full(1, 0.02), uncertainty.bound)


def test_errors_are_actual_minus_desired():
    e1, e2 = flat_errors(reference((1, 2), (3, 4)), motion((1.5, 1.0), (2.0, 4.25)))
    np.testing.assert_array_equal(e1, [[0.5, -1.0]])
    np.testing.assert_array_equal(e2, [[-1.0, 0.25]])


def test_nominal_input_by_hand():
    """(43) with K₁ = 4, K₂ = 3: (1 − 4·0.5 + 3·1, 2 + 4·1 − 3·0.25)."""
    e1, e2 = pair(0.5, -1.0), pair(-1.0, 0.25)
    answer = nominal_input(reference(acceleration=(1, 2)), e1, e2, pair(4.0, 4.0), pair(3.0, 3.0))
    np.testing.assert_array_equal(answer, [[2.0, 5.25]])


@given(components, components, components, components, headings, speeds)
def test_without_slip_the_flat_input_is_the_acceleration(x, y, vx, vy, heading, speed):
    """B (ū₁, ū₂) = v̂ + Δv for what was commanded, with the remembered speed in B."""
    for law in laws():
        there = motion((x, y), (vx, vy), heading)
        decision = law.update(
            SpeedMemory(np.array([speed])), reference(acceleration=(0.1, -0.2)), there, TICK
        )
        if decision.trace.saturated[0]:
            continue
        c, s = np.array([math.cos(heading)]), np.array([math.sin(heading)])
        command = decision.command
        got = apply_decoupling(np.array([speed]), c, s, command.forward_acceleration, command.yaw_rate)
        wanted = decision.trace.nominal_input + decision.trace.robust_input
        np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-13 * (1.0 + np.abs(wanted).max()))
        np.testing.assert_array_equal(decision.memory.forward_speed, command.forward_speed)


def test_on_the_reference_every_law_is_feedforward():
    """No error: Δv = 0 and (ū₁, ū₂) are those of the plan, (10)."""
    plan = reference((1, 2), (0.3, 0.4), (0.1, -0.2))
    on_it = motion((1, 2), (0.3, 0.4), math.atan2(0.4, 0.3))
    for law in laws():
        decision = law.update(SpeedMemory(np.array([0.5])), plan, on_it, TICK)
        assert not decision.trace.robust_input.any()
        assert decision.command.forward_acceleration[0] == pytest.approx((0.3 * 0.1 - 0.4 * 0.2) / 0.5)
        assert decision.command.yaw_rate[0] == pytest.approx((0.3 * -0.2 - 0.4 * 0.1) / 0.25)


def test_robot_behind_accelerates_and_robot_to_the_right_turns_left():
    ahead = reference((1.0, 0.0), (0.5, 0.0))
    for law in laws():
        behind = law.update(SpeedMemory(full(1, 0.5)), ahead, motion((0.9, 0.0), (0.5, 0.0)), TICK).command
        right = law.update(SpeedMemory(full(1, 0.5)), ahead, motion((1.0, -0.1), (0.5, 0.0)), TICK).command
        assert behind.forward_acceleration[0] > 0.02
        assert behind.yaw_rate[0] == 0.0
        assert right.yaw_rate[0] > 0.04
        assert right.wheel_rate[0, 1] > right.wheel_rate[0, 0]


@given(components, components, components, components, headings, speeds)
def test_robust_law_is_the_nominal_one_plus_its_corrective_term(x, y, vx, vy, heading, speed):
    """Traced by hand at pole −0.5: JᵀPe = 2 e₁ + 2.5 e₂, K = (0.25, 1)."""
    rho_of = UNCERTAINTIES["independent"].bound
    law = robust_law(full(1, -0.5), full(1, 0.4), full(1, 0.02), rho_of)
    decision = law.update(
        SpeedMemory(np.array([speed])), reference(), motion((x, y), (vx, vy), heading), TICK
    )
    trace = decision.trace
    assert trace.weighted_error is not None
    assert trace.robust_gain is not None
    w = np.array([2.0 * x + 2.5 * vx, 2.0 * y + 2.5 * vy])
    nominal = -np.array([0.25 * x + vx, 0.25 * y + vy])
    np.testing.assert_allclose(trace.weighted_error[0], w, rtol=0, atol=1e-14)
    np.testing.assert_allclose(trace.nominal_input[0], nominal, rtol=0, atol=1e-14)
    phi = 0.4 * speed**2 * math.hypot(0.4, 1.4)
    rho = (0.8 * math.hypot(*nominal) + phi) / 0.2
    assert trace.robust_gain[0] == pytest.approx(rho, rel=1e-12)
    np.testing.assert_allclose(
        trace.robust_input[0], -rho * w / max(math.hypot(*w), 0.02), rtol=0, atol=1e-11 * (1.0 + rho)
    )


def test_paper_gain_uses_the_forward_part_of_the_nominal_input():
    """û₁ = t·v̂: full for a robot along v̂, none for one across it."""
    law = robust_law(full(1, -0.5), full(1, 0.4), full(1, 0.02))
    plan = reference(acceleration=(0.3, 0.0))
    gain = {}
    for name, heading in (("along", 0.0), ("across", math.pi / 2.0), ("against", math.pi)):
        trace = law.update(SpeedMemory(full(1, 0.5)), plan, motion(heading=heading), TICK).trace
        assert trace.robust_gain is not None
        gain[name] = trace.robust_gain[0]
    assert gain["along"] - gain["across"] == pytest.approx(2.0 * 0.4 * 0.3 / 0.2, rel=1e-12)
    assert gain["against"] == pytest.approx(gain["along"], rel=1e-12)


def test_memory_starts_at_the_planned_speed_and_never_below_the_floor():
    for law in laws():
        floor = law.drive.speed_floor[0]
        assert law.start(start_at(0.7)).forward_speed[0] == 0.7
        assert law.start(start_at(0.0)).forward_speed[0] == floor > 0.0


def test_nominal_law_has_no_gain_to_trace():
    trace = (
        nominal_law(full(1, -0.5)).update(SpeedMemory(full(1, 0.5)), reference(), motion((1, 1)), TICK).trace
    )
    assert trace.robust_gain is None
    assert trace.weighted_error is None
    assert not trace.robust_input.any()


def test_saturation_is_traced():
    drive = wide_drive(1)
    law = nominal_law(
        full(1, -0.5), type(drive)(drive.geometry, drive.speed_limit, full(1, 0.1), drive.speed_floor)
    )
    trace = law.update(SpeedMemory(full(1, 0.5)), reference(), motion((0.0, -5.0)), TICK).trace
    assert trace.saturated[0]
