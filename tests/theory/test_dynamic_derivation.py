"""(20)–(27), (31)–(34) and (61)–(63) derived a second time from (16), (22), (29) and (31)."""

import math
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from slipctl.theory.dynamic import Inertia, drift, invert_dynamics, slip_terms
from slipctl.theory.robot import MAGELLAN_PRO, WheelGeometry
from slipctl.tick import Array, Slip
from tests.theory.paper import (
    A_25,
    B_12,
    B_13_INVERSE,
    C_33,
    C_BELOW_61,
    C_CORRECTED,
    D_34,
    D_BELOW_61,
    DYNAMIC,
    DYNAMIC_NO_SLIP,
    FLAT,
    FORWARD,
    INPUT,
    KINEMATIC,
    LEFT,
    NO_SLIP,
    b,
    c,
    ddvs,
    different,
    dvs,
    dvt,
    dws,
    h,
    iz,
    m,
    mu1,
    mu1bar,
    mu2bar,
    r,
    rate,
    s,
    same,
    tau_l,
    tau_r,
    u1bar,
    u2bar,
    v,
    vs,
    vt,
    w,
    ws,
)


def third_derivative(model):
    return rate(rate(rate(FLAT, model), model), model)


TORQUES = sympy.Matrix([mu1bar, mu2bar])
RATES = sympy.Matrix([u1bar, u2bar])
SPAN = sympy.Matrix([[c, 0], [s, 0], [0, 1]])  # S of (5)
MASSES = sympy.diag(m, m, iz)  # M of (17)
PUSH = sympy.Matrix([[c, c], [s, s], [b, -b]]) / r  # E of (18)
SHARE = (SPAN.T * MASSES * SPAN).inv() * SPAN.T  # (SᵀMS)⁻¹Sᵀ


def test_third_derivative_without_slip_is_a_plus_b_mu():
    """(24) and (25), read as third derivatives."""
    assert same(third_derivative(DYNAMIC_NO_SLIP), A_25 + B_12 * TORQUES)


def test_corrected_inverse_makes_three_integrators():
    """(26) with (27) as μ̄ = B⁻¹(v − A)."""
    assert same(A_25 + B_12 * (B_13_INVERSE * (INPUT - A_25)), INPUT)


def test_kinematic_slip_terms():
    """(32)–(34) from (29)."""
    second = rate(rate(FLAT, KINEMATIC), KINEMATIC)
    assert same(second, B_12 * RATES + C_33 + D_34 * RATES)
    assert not any(C_33.subs(NO_SLIP))
    assert not any(D_34.subs(NO_SLIP))


def test_kinematic_uncertainty():
    """(35)–(37): with (13), F̈ = v + DB⁻¹v + C."""
    commanded = B_13_INVERSE * INPUT
    second = rate(rate(FLAT, KINEMATIC), KINEMATIC).subs(
        {u1bar: commanded[0], u2bar: commanded[1]}, simultaneous=True
    )
    assert same(second, INPUT + D_34 * B_13_INVERSE * INPUT + C_33)


def test_dynamic_slip_terms():
    """(61) from (31), with D as printed and the corrected C."""
    assert same(third_derivative(DYNAMIC), A_25 + B_12 * TORQUES + C_CORRECTED + D_BELOW_61 * TORQUES)
    assert not any(C_CORRECTED.subs(NO_SLIP))


def test_dynamic_uncertainty():
    """(62)–(64): with the corrected (27), F⃛ = v + DB⁻¹v + (C − DB⁻¹A)."""
    commanded = B_13_INVERSE * (INPUT - A_25)
    third = third_derivative(DYNAMIC).subs({mu1bar: commanded[0], mu2bar: commanded[1]}, simultaneous=True)
    e = D_BELOW_61 * B_13_INVERSE
    assert same(third, INPUT + e * INPUT + (C_CORRECTED - e * A_25))
    assert different(third, INPUT + e * INPUT + (C_BELOW_61 - e * A_25))


def test_identities_of_the_slipping_plant():
    """Ḟ = V t − v_s n; F̈ = μ₁ t + (VΩ − v̇_s) n; V̇ = μ₁ − v_sΩ; Ω̇ = μ̄₂, whatever ẇ_s."""
    turn, speed = w + ws, v + vt
    first = rate(FLAT, DYNAMIC)
    second = rate(first, DYNAMIC)
    assert same(first, speed * FORWARD - vs * LEFT)
    assert same(second, mu1 * FORWARD + (speed * turn - dvs) * LEFT)
    assert same(rate(sympy.Matrix([speed, turn]), DYNAMIC), sympy.Matrix([mu1 - vs * turn, mu2bar]))
    expected = (mu1bar - (speed * turn - dvs) * turn) * FORWARD + (
        speed * mu2bar + 2 * mu1 * turn - vs * turn**2 - ddvs
    ) * LEFT
    assert same(rate(second, DYNAMIC), expected)
    assert dws not in rate(second, DYNAMIC).applyfunc(sympy.expand).free_symbols


def test_wheel_torques_to_accelerations():
    """(20) and (21) from (16)–(18): the constraint forces drop out."""
    f = SHARE * PUSH
    expected = sympy.Matrix([(tau_r + tau_l) / (m * r), (tau_r - tau_l) * b / (iz * r)])
    assert same(f * sympy.Matrix([tau_r, tau_l]), expected)
    assert (sympy.Matrix([[s, -c, 0]]) * SPAN).applyfunc(sympy.simplify) == sympy.zeros(1, 2)


def test_slip_in_the_equations_of_motion():
    """(30c) to (31d) and (31f): ν̇ = fτ − (SᵀMS)⁻¹SᵀM δ̇."""
    delta = sympy.Matrix([vt * c + vs * s, vt * s - vs * c, ws])
    lost = SHARE * MASSES * rate(delta, DYNAMIC)
    assert same(lost, sympy.Matrix([dvt + vs * (w + ws), dws]))


# the package against the same symbols

values = st.floats(-2.0, 2.0)
speeds = st.floats(0.05, 2.0)
headings = st.floats(-math.pi, math.pi)


def one(number: float) -> Array:
    return np.array([float(number)])


def lift(*numbers: float) -> Any:
    return tuple(np.array([float(number)]) for number in numbers)


TERMS = sympy.lambdify(
    (v, w, mu1, h, vt, vs, ws, dvs, ddvs), [list(A_25), list(C_CORRECTED), D_BELOW_61], modules="numpy"
)


@given(st.tuples(speeds, values, values, headings), st.tuples(*[values] * 5))
def test_package_has_the_derived_matrices(state, slip):
    speed, turn, push, angle = state
    a, c_matrix, d_matrix = TERMS(*state, *slip)
    cosine, sine = lift(math.cos(angle), math.sin(angle))
    np.testing.assert_allclose(
        drift(one(speed), one(turn), one(push), cosine, sine)[0], a, rtol=0, atol=1e-13
    )
    known = one(speed), one(turn), one(push)
    rates = one(slip[3]), one(slip[4])
    got = slip_terms(*known, Slip(*lift(*slip[:3])), *rates, cosine, sine)
    np.testing.assert_allclose(got[0][0], c_matrix, rtol=0, atol=1e-12)
    np.testing.assert_allclose(got[1][0], d_matrix, rtol=0, atol=1e-14)


@given(speeds, values, values, headings, values, values)
def test_package_inverts_the_dynamic_map(speed, turn, push, angle, jerk, spin):
    """B⁻¹(v − A) of v = A + B μ̄ is μ̄, forwards and back."""
    cosine, sine = lift(math.cos(angle), math.sin(angle))
    a = drift(one(speed), one(turn), one(push), cosine, sine)
    across = speed * spin
    flat = a + np.stack([cosine * jerk - sine * across, sine * jerk + cosine * across], axis=-1)
    got = invert_dynamics(one(speed), cosine, sine, flat, a)
    scale = 1.0 + np.abs(flat).max()
    assert got[0][0] == pytest.approx(jerk, abs=1e-14 * scale)
    assert got[1][0] == pytest.approx(spin, abs=1e-14 * scale / speed)


TORQUE_LAW = sympy.lambdify(
    (m, iz, r, b, tau_l, tau_r),
    list((SHARE * PUSH * sympy.Matrix([tau_r, tau_l])).subs(h, 0.7)),
    modules="numpy",
)


@given(st.tuples(*[st.floats(0.1, 5.0)] * 4), values, values)
def test_package_has_the_derived_torques(body, left, right):
    mass, inertia, radius, half = body
    expected = TORQUE_LAW(*body, left, right)
    model = Inertia(WheelGeometry(radius, half), mass, inertia)
    got = model.accelerations(np.array([[left, right]]), np.ones((1, 2)))
    for one, other in zip(got, expected, strict=True):
        assert one[0] == pytest.approx(other, rel=1e-11, abs=1e-11)


def test_geometry_of_table_two():
    assert (MAGELLAN_PRO.wheel_radius, MAGELLAN_PRO.half_track) == (0.0825, 0.1624)
