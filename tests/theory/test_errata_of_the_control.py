"""The paper's errata about bounds, stability and what a closed loop does.

Each printed claim is shown wrong, each corrected one right; `docs/errata.md` names these tests.
"""

import functools
import itertools
import math

import numpy as np
import pytest
import sympy
from scipy.linalg import expm

from slipctl.theory.robust import chain_gains, corrective_input, lyapunov_matrix
from slipctl.theory.robust_dynamic import DynamicState, ProportionalDynamicBound
from tests.builders import (
    PAPER_LAYER,
    PAPER_POLE,
    PAPER_SLIP,
    full,
    nominal_law,
    ode_plant,
    paper_slip,
    robust_law,
    rows_of,
    table_one,
    track,
)
from tests.theory.paper import (
    B_12,
    B_13_INVERSE,
    D_34,
    D_BELOW_61,
    dws,
    h,
    mu1,
    mu1bar,
    mu2bar,
    rate,
    v,
    vs,
    vt,
    w,
    ws,
    x,
    y,
)

TICK = 0.01


@functools.cache
def section_five_a(pole=None):
    """Run V-A: the robust law, or the nominal law at a pole."""
    one = full(1, PAPER_POLE if pole is None else pole)
    law = nominal_law(one) if pole else robust_law(one, full(1, PAPER_SLIP), full(1, PAPER_LAYER))
    return track(ode_plant(paper_slip(), 1), law, rows_of(table_one(), TICK, 20.0), TICK)


def test_equation_45_is_met_with_equality_by_the_papers_own_slip():
    """(83) has |v_t| + |v_s| = 2α|v| at all times; ≤ is all that (52) needs."""
    run = section_five_a()
    used = np.abs(run.stack("slip", "longitudinal")) + np.abs(run.stack("slip", "lateral"))
    allowed = 2.0 * PAPER_SLIP * np.abs(run.stack("motion", "forward_speed"))
    np.testing.assert_allclose(used, allowed, rtol=1e-12)  # so the printed < never holds
    largest = norm_of(D_34 * B_13_INVERSE, {vt: PAPER_SLIP * v, vs: PAPER_SLIP * v})
    assert largest == pytest.approx(math.sqrt(2.0) * PAPER_SLIP, rel=1e-12)
    assert largest <= 2.0 * PAPER_SLIP < 1.0


def norm_of(matrix, slip):
    number = matrix.subs(slip, simultaneous=True).subs({v: 0.3, h: 0.7, w: 0.5})
    return np.linalg.norm(np.array(number, dtype=float), 2)


def test_equation_47_has_no_boundary_layer():
    """Its ε plays no part: Δv has length ρ however small JᵀPe is, and jumps at 0; (59) does neither."""
    rho, layer = np.array([0.5, 0.5]), 0.02
    w_vector = np.array([[1e-9, 0.0], [-1e-9, 0.0]])
    discontinuous = corrective_input(w_vector, rho, np.zeros(2))
    continuous = corrective_input(w_vector, rho, np.full(2, layer))
    np.testing.assert_allclose(discontinuous, [[-0.5, 0.0], [0.5, 0.0]], rtol=1e-12)
    np.testing.assert_allclose(continuous, -0.5 / layer * w_vector, rtol=1e-12)


def test_theorem_4_3_cannot_be_global():
    """The inputs come from B⁻¹, and det B = v: nothing is defined at v = 0, so no claim holds from there."""
    assert sympy.simplify(B_12.det() - v) == 0
    assert sympy.simplify(B_13_INVERSE * B_12 - sympy.eye(2)) == sympy.zeros(2)
    assert B_13_INVERSE.subs({h: 0, v: sympy.Rational(1, 1000)})[1, 1] == 1000


def test_slip_rates_of_section_five_a_contain_the_corrective_term():
    """Printed: |v̇_t| ≤ α‖v̂‖. True: v̇_t = αū₁ with ū₁ = t·(v̂ + Δv), seven times as much at the start."""
    run = section_five_a()
    slip = run.stack("slip", "longitudinal")[:, 0]
    slip_rate = np.diff(slip) / TICK
    nominal = np.hypot(*run.stack("decision", "trace", "nominal_input")[:-1, 0].T)
    excess = np.abs(slip_rate) / (PAPER_SLIP * nominal)
    assert excess[0] > 5.0
    assert (excess[:15] > 1.0).all()  # 0.15 s
    facing = run.stack("motion", "heading_vector")[:-1, 0]
    whole = run.stack("decision", "trace", "nominal_input") + run.stack("decision", "trace", "robust_input")
    along = (facing * whole[:-1, 0]).sum(axis=1)
    np.testing.assert_allclose(slip_rate, PAPER_SLIP * along, rtol=0, atol=1e-12)


def proportional_model(a_t, a_s):
    """(31) where v_t = a_t v and v_s = a_s v with constant fractions; (31d) solved for v̇."""
    turn = w + ws
    c, s = sympy.cos(h), sympy.sin(h)
    return {
        x: v * ((1 + a_t) * c + a_s * s),
        y: v * ((1 + a_t) * s - a_s * c),
        h: turn,
        v: (mu1 - a_s * v * turn) / (1 + a_t),
        mu1: mu1bar,
        w: mu2bar - dws,
        ws: dws,
    }


def control_gain(a_t, a_s):
    """Return ‖E‖ with F⃛ = (I + E) v + …, where v̈_s contains the control."""
    model = proportional_model(a_t, a_s)
    third = rate(rate(rate(sympy.Matrix([x, y]), model), model), model)
    assert dws not in third.applyfunc(sympy.expand).free_symbols
    return norm_of(third.jacobian([mu1bar, mu2bar]) * B_13_INVERSE - sympy.eye(2), {})


def worst_control_gain(alpha):
    return max(control_gain(alpha * i, alpha * j) for i, j in itertools.product((-1.0, 1.0), repeat=2))


def test_equation_70_allows_too_much_slip():
    """Printed α < 1; but where v_s follows v the control returns in v̈_s with a gain of 1 at α = 1/2."""
    assert norm_of(D_BELOW_61 * B_13_INVERSE, {vt: 0.6 * v}) == pytest.approx(0.6)  # (75), v_s left out
    assert worst_control_gain(0.5) == pytest.approx(1.0, rel=1e-12)
    assert worst_control_gain(0.6) > 1.4  # allowed by (70), and no Δv is large enough
    assert worst_control_gain(0.3) == pytest.approx(0.4616, abs=5e-5)
    one = np.ones(1)
    gains = [
        ProportionalDynamicBound(full(1, a))(DynamicState(one, one, one, one, one))[0] for a in (0.49, 0.51)
    ]
    assert gains[0] > 0.0 > gains[1]


# (99): with P, ε and ρ of about what Section V-A has

RHO, LAYER = 0.08, 0.02
GAINS = chain_gains(np.array([-0.5]), 2)[0]
P = lyapunov_matrix(GAINS)
CLOSED = np.array([[0.0, 1.0], [-GAINS[0], -GAINS[1]]])
PRINTED_RADIUS = math.sqrt(LAYER / 2.0) * RHO
RADIUS = math.sqrt(LAYER * RHO / 2.0)


def worst_rate(e):
    """Return V̇ of (95) for errors (K, 2) along one axis, with the worst η, in line with JᵀPe."""
    weighted = np.abs(e @ P[:, 1])
    return -(e**2).sum(axis=1) + 2.0 * RHO * (weighted - np.minimum(weighted**2 / LAYER, weighted))


def errors_between(least, most, count=20_000):
    rng = np.random.default_rng(5)
    angle, radius = rng.uniform(0.0, 2.0 * math.pi, count), rng.uniform(least, most, count)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def test_equation_99_has_the_gain_inside_the_root():
    """V̇ < 0 holds for every ‖e‖ > √(ερ/(2λ_min)), and not for every ‖e‖ > ρ√(ε/(2λ_min)) as printed."""
    assert PRINTED_RADIUS < 0.3 * RADIUS
    assert (worst_rate(errors_between(RADIUS, 10.0 * RADIUS)) < 0.0).all()
    assert (worst_rate(errors_between(PRINTED_RADIUS, RADIUS)) > 0.0).any()


def test_equation_99_is_about_a_level_set_and_not_a_ball():
    """The ball is left again even where η = −Δv exactly; the smallest level set around it is not."""
    growth = np.linalg.eigh((CLOSED + CLOSED.T) / 2.0)
    assert growth.eigenvalues[-1] > 0.0
    start = RADIUS * growth.eigenvectors[:, -1]
    path = np.array([expm(CLOSED * t) @ start for t in np.linspace(0.0, 20.0, 401)])
    assert np.hypot(*path.T).max() > 1.02 * RADIUS
    level = np.linalg.eigvalsh(P)[-1] * RADIUS**2
    assert np.einsum("ki,ij,kj->k", path, P, path).max() <= level
    on_level = errors_between(1.0, 1.0)
    on_level *= np.sqrt(level / np.einsum("ki,ij,kj->k", on_level, P, on_level))[:, None]
    assert (np.hypot(*on_level.T) > RADIUS * (1.0 - 1e-12)).all()
    assert (worst_rate(1.0001 * on_level) < 0.0).all()


def ultimate_bound(rho):
    """Return the bound on |e₁| of the corrected (99): √(λ_max(P) R² (P⁻¹)₁₁) with R² = ερ/2 [m]."""
    return math.sqrt(np.linalg.eigvalsh(P)[-1] * LAYER * rho / 2.0 * np.linalg.inv(P)[0, 0])


def test_equation_99_needs_the_largest_gain():
    """ρ grows from 0.017 to 0.26 m/s² along the path of V-A: a bound is one for the supremum only."""
    assert 1e3 * ultimate_bound(RHO) == pytest.approx(59.7, abs=0.05)
    run = section_five_a()
    rho = run.stack("decision", "trace", "robust_gain")[500:]
    assert rho.max() > 5.0 * rho.min()
    assert run.position_error[500:].max() < 1e-3 < ultimate_bound(rho.max())


@pytest.mark.parametrize("pole", [-0.5, -1.0, -2.0, -4.0])
def test_higher_gains_keep_the_error_ultimately_bounded_too(pole):
    """The paper says they cannot guarantee it. They do, by small gain, for |σ| < 1/1.1547.

    From η to v̂ the loop is −(p² + 2ps)/(s + p)², whose largest gain does not depend on p; η = σv + …;
    from η to e₁ it is 1/(s + p)² with the non-negative impulse response t e^{−pt}, of area 1/p².
    """
    frequency = -pole * np.logspace(-3.0, 3.0, 20_001)
    loop = (pole**2 - 2.0 * pole * 1j * frequency) / (1j * frequency - pole) ** 2
    assert np.abs(loop).max() == pytest.approx(1.1547, abs=1e-4)
    assert np.abs(loop).max() * math.sqrt(2.0) * PAPER_SLIP < 1.0

    run = section_five_a(pole)
    velocity = run.stack("motion", "velocity")[:, 0]
    flat_input = run.stack("decision", "trace", "nominal_input")[:-1, 0]
    uncertainty = np.hypot(*(np.diff(velocity, axis=0) / TICK - flat_input).T)
    after = round((4.0 - 8.0 / pole) / TICK)  # the start is forgotten, e^{−8}
    largest = run.position_error[after:, 0].max()
    assert 0.3 * uncertainty[after // 2 :].max() / pole**2 < largest < uncertainty.max() / pole**2


def test_higher_gains_reduce_the_error():
    errors = [section_five_a(pole).position_error[1200:, 0].max() for pole in (-0.5, -1.0, -2.0, -4.0)]
    assert all(nxt < 0.4 * one for one, nxt in itertools.pairwise(errors))
    assert errors[-1] < 1e-3
