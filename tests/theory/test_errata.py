"""The paper's errata in symbols: each printed form shown wrong, each corrected form shown right.

`docs/errata.md` names these tests. What only a closed loop can show is in `test_errata_of_the_control.py`.
"""

import math
from typing import Any

import numpy as np
import pytest
import sympy

from slipctl.theory.dynamic import Inertia, drift, invert_dynamics, slip_terms
from slipctl.theory.flatness import apply_decoupling, flat_to_state, state_to_flat
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.tick import Array, Slip
from tests.theory.paper import (
    A_25,
    B_12,
    B_13_INVERSE,
    C_BELOW_61,
    C_CORRECTED,
    D_BELOW_61,
    DYNAMIC,
    DYNAMIC_NO_SLIP,
    FLAT,
    INPUT,
    KINEMATIC_NO_SLIP,
    ddvs,
    ddvt,
    difference,
    different,
    dvs,
    dvt,
    dws,
    h,
    mu1,
    mu1bar,
    mu2bar,
    rate,
    same,
    u2bar,
    v,
    vs,
    vt,
    w,
    ws,
)

INPUTS = sympy.Matrix([mu1bar, mu2bar])


def one(number: float) -> Array:
    return np.array([float(number)])


def lift(*numbers: float) -> Any:
    return tuple(np.array([float(number)]) for number in numbers)


@pytest.mark.parametrize("degrees", [20.0, 110.0, -110.0, -160.0, 170.0])
def test_equation_9_needs_the_quadrant(degrees):
    """tan⁻¹(Ḟ₂/Ḟ₁) is off by π wherever the robot heads to −x; atan2 with v > 0 is not."""
    heading = math.radians(degrees)
    velocity, acceleration = state_to_flat(one(0.4), one(heading), one(0.1), one(-0.2))
    printed = math.atan(velocity[0, 1] / velocity[0, 0])
    assert abs(printed - heading) == pytest.approx(math.pi if abs(degrees) > 90.0 else 0.0, abs=1e-12)
    assert flat_to_state(velocity, acceleration)[1][0] == pytest.approx(heading, abs=1e-12)


def test_equation_23_means_the_new_input_mu2():
    """(22) says ẇ = μ̄₂ and (19b) with (21) says ẇ = μ₂; ū₂ is w itself by (8), another quantity."""
    assert DYNAMIC_NO_SLIP[w] == mu2bar
    assert KINEMATIC_NO_SLIP[h] == u2bar
    assert DYNAMIC_NO_SLIP[h] == w  # so ū₂ = w, whose rate is μ̄₂
    body = Inertia(MAGELLAN_PRO, 18.2, 0.39375)
    _, yaw_acceleration = body.accelerations(np.array([[-0.1, 0.1]]), np.zeros((1, 2)))
    assert yaw_acceleration[0] == pytest.approx(0.2 * 0.1624 / (0.0825 * 0.39375), rel=1e-13)  # ẇ of (19b)


def test_equations_24_26_are_third_derivatives():
    """F̈ contains no input at all; F⃛ is A + Bμ̄."""
    second = rate(rate(FLAT, DYNAMIC_NO_SLIP), DYNAMIC_NO_SLIP)
    assert not second.free_symbols & {mu1bar, mu2bar}
    assert different(second, A_25 + B_12 * INPUTS)
    assert same(rate(second, DYNAMIC_NO_SLIP), A_25 + B_12 * INPUTS)


def test_equations_61_62_are_third_derivatives():
    second = rate(rate(FLAT, DYNAMIC), DYNAMIC)
    right = A_25 + B_12 * INPUTS + C_CORRECTED + D_BELOW_61 * INPUTS
    assert not second.free_symbols & {mu1bar, mu2bar}
    assert different(second, right)
    assert same(rate(second, DYNAMIC), right)


def test_equations_65_68_need_the_desired_third_derivative():
    """ė₃ = F⃛ − F⃛_d is what the last row of (65) must say; F̈_d there leaves a quintic plan behind at once."""
    t = sympy.Symbol("t")
    plan = sympy.Rational(3, 10) * t + t**5 / 50
    e3_rate_printed = plan.diff(t, 3) - plan.diff(t, 2)  # F⃛ = v = F̈_d, on the plan, less F⃛_d
    assert sympy.simplify(e3_rate_printed) != 0
    k1, k2, k3 = sympy.Rational(1, 8), sympy.Rational(3, 4), sympy.Rational(3, 2)
    e = sympy.Function("e")(t)
    actual = plan + e
    v_hat = plan.diff(t, 3) - k1 * e - k2 * e.diff(t) - k3 * e.diff(t, 2)
    error_dynamics = sympy.expand(actual.diff(t, 3) - v_hat)
    root = sympy.Symbol("s")
    polynomial = error_dynamics.subs(e, sympy.exp(root * t)).doit() / sympy.exp(root * t)
    assert sympy.expand(polynomial - (root + sympy.Rational(1, 2)) ** 3) == 0


def test_equation_27_subtracts_the_drift_before_inverting():
    """Printed B⁻¹v − A gives F⃛ = v + (1 − B) A; corrected B⁻¹(v − A) gives F⃛ = v."""
    printed, corrected = B_13_INVERSE * INPUT - A_25, B_13_INVERSE * (INPUT - A_25)
    assert different(A_25 + B_12 * printed, INPUT)
    assert same(A_25 + B_12 * printed, INPUT + A_25 - B_12 * A_25)
    assert same(A_25 + B_12 * corrected, INPUT)

    c, s = math.cos(0.7), math.sin(0.7)
    flat_input, a = np.array([[0.3, -0.2]]), drift(one(0.4), one(0.5), one(0.3), one(c), one(s))
    jerk, spin = invert_dynamics(one(0.4), one(c), one(s), flat_input, a)
    got = a + apply_decoupling(one(0.4), one(c), one(s), jerk, spin)
    np.testing.assert_allclose(got, flat_input, rtol=0, atol=1e-15)


def test_equation_27_with_its_units():
    """The printed difference is not even of one kind: B⁻¹ v is (m/s³, rad/s²), A is (m/s³, m/s³)."""
    length = sympy.Symbol("length", positive=True)
    lengths = {symbol: length * symbol for symbol in (v, mu1, *INPUT.free_symbols)}

    def rescaled(matrix):
        return matrix.subs(lengths, simultaneous=True)

    yaw_part = rescaled(B_13_INVERSE * INPUT)[1]
    assert sympy.simplify(yaw_part - (B_13_INVERSE * INPUT)[1]) == 0  # rad/s²: lengths drop out
    assert sympy.simplify(rescaled(A_25)[1] - length * A_25[1]) == 0
    corrected = B_13_INVERSE * (INPUT - A_25)
    assert sympy.simplify(rescaled(corrected)[1] - corrected[1]) == 0


def test_c_below_equation_61_takes_the_yaw_rate_for_the_heading_rate():
    """Printed C is what (31) gives with θ̇ := w, against (31c), but with ẇ = μ̄₂ − ẇ_s kept."""
    third = rate(rate(rate(FLAT, DYNAMIC), DYNAMIC), DYNAMIC)
    rest = A_25 + B_12 * INPUTS + D_BELOW_61 * INPUTS
    assert different(third, rest + C_BELOW_61)
    assert same(third, rest + C_CORRECTED)

    without = dict(DYNAMIC)
    without[h], without[mu1], without[w] = w, mu1bar, mu2bar - dws
    without[v] = mu1 - dvt - vs * w
    mistaken = rate(rate(rate(FLAT, without), without), without)
    assert same(mistaken, rest + C_BELOW_61)


def test_c_below_equation_61_is_right_without_yaw_slip():
    straight = {ws: 0, dws: 0}
    assert same(C_BELOW_61.subs(straight), C_CORRECTED.subs(straight))
    assert difference(C_BELOW_61.subs({ws: 0}), C_CORRECTED.subs({ws: 0})) > 1e-3  # ẇ_s alone: not


def test_corrected_c_is_free_of_the_yaw_slips_acceleration():
    """Assumption 4.6 bounds w_s, v_s, v̇_s, v̈_s and no ẇ_s: enough for the corrected C only."""
    assert dws in C_BELOW_61.free_symbols
    assert C_CORRECTED.free_symbols == {v, w, mu1, h, vt, vs, dvs, ddvs, ws}


def test_d_below_equation_61_is_right():
    third = rate(rate(rate(FLAT, DYNAMIC), DYNAMIC), DYNAMIC)
    assert same(third.jacobian([mu1bar, mu2bar]), B_12 + D_BELOW_61)


def test_package_uses_the_corrected_c():
    values = {v: 0.4, w: -0.6, mu1: 0.2, h: 0.7, vt: 0.1, vs: -0.15, ws: 0.3, dvs: 0.2, ddvs: -0.4, dws: 0.9}
    slip = Slip(one(values[vt]), one(values[vs]), one(values[ws]))
    facing: tuple[Array, Array] = lift(math.cos(0.7), math.sin(0.7))
    got = slip_terms(one(0.4), one(-0.6), one(0.2), slip, one(values[dvs]), one(values[ddvs]), *facing)[0][0]
    corrected, printed = (
        np.array(matrix.subs(values | {ddvt: 0}), dtype=float).ravel() for matrix in (C_CORRECTED, C_BELOW_61)
    )
    np.testing.assert_allclose(got, corrected, rtol=1e-13)
    assert np.hypot(*(got - printed)) > 0.1
