"""Monte Carlo against the exact dynamic plant: is ‖η‖ ≤ ρ, and how much slack is there?"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from slipctl.theory.robust_dynamic import (
    DynamicBound,
    DynamicState,
    GeneralDynamicBound,
    PaperDynamicBound,
    ProportionalDynamicBound,
)
from slipctl.tick import Array

Complex = Any  # arrays; numpy's stubs do not follow which operations are complex

SAMPLES = 100_000


@dataclass(frozen=True)
class States:
    """What a law knows; the heading is 0, so that complex numbers are (forward, left)."""

    v: Array
    w: Array
    mu1: Array
    nominal: Complex  # v̂

    @property
    def drift(self) -> Complex:
        return -self.v * self.w**2 + 2j * self.w * self.mu1

    @property
    def known(self) -> DynamicState:
        jerk = (self.nominal - self.drift).real
        return DynamicState(self.v, self.w, self.mu1, np.abs(self.nominal), jerk)


def partly(rng: np.random.Generator) -> Array:
    """Return factors in [−1, 1], four in five of them at an end."""
    ends = rng.choice([-1.0, 1.0], SAMPLES)
    return np.where(rng.uniform(size=SAMPLES) < 0.8, ends, rng.uniform(-1.0, 1.0, SAMPLES))


def states(rng: np.random.Generator) -> States:
    """Return states and nominal inputs over several decades, a third of the inputs along the axes."""
    direction = rng.uniform(-math.pi, math.pi, SAMPLES)
    direction[::3] = rng.integers(0, 4, len(direction[::3])) * math.pi / 2.0
    return States(
        v=10.0 ** rng.uniform(-2.0, 0.5, SAMPLES),
        w=10.0 ** rng.uniform(-3.0, 1.0, SAMPLES) * rng.choice([-1.0, 1.0], SAMPLES),
        mu1=10.0 ** rng.uniform(-3.0, 1.0, SAMPLES) * rng.choice([-1.0, 1.0], SAMPLES),
        nominal=10.0 ** rng.uniform(-3.0, 2.0, SAMPLES) * np.exp(1j * direction),
    )


def corrective(rng: np.random.Generator, nominal: Complex, rho: Array) -> Complex:
    """Return admissible Δv, ‖Δv‖ ≤ ρ: anything, or all of it along v̂, against it, or along an axis."""
    anything = rho * np.sqrt(rng.uniform(size=SAMPLES)) * np.exp(2j * math.pi * rng.uniform(size=SAMPLES))
    along = rho * np.exp(1j * np.angle(nominal))
    axis = rho * np.exp(0.5j * math.pi * rng.integers(0, 4, SAMPLES))
    return np.choose(rng.integers(0, 4, SAMPLES), [anything, along, along, axis])


def inputs(at: States, flat_input: Complex) -> tuple[Array, Array]:
    """Return (μ̄₁, μ̄₂), the corrected (27)."""
    rest = flat_input - at.drift
    return rest.real, rest.imag / at.v


def third(
    at: States, bars: tuple[Array, Array], slip: Complex, yaw_slip: Array, rates: tuple[Array, Array]
) -> Complex:
    """Return F⃛ of (31); `slip` is v_t − i v_s and `rates` are v̇_s and v̈_s."""
    turn, speed, (jerk, spin) = at.w + yaw_slip, at.v + slip.real, bars
    along = jerk - (speed * turn - rates[0]) * turn
    across = speed * spin + 2.0 * at.mu1 * turn + slip.imag * turn**2 - rates[1]
    return along + 1j * across


def proportional_ratio(
    rng: np.random.Generator, bound: DynamicBound, alpha: Array, signs: tuple[float, ...] | None = None
) -> Array:
    """Return ‖η‖/ρ where v_t and v_s are constant fractions of v, at most α, and |w_s| ≤ α|v|.

    With `signs` the fractions of v_t, v_s and w_s are all at their limits, with those signs.
    """
    at = states(rng)
    rho = bound(at.known)
    flat_input = at.nominal + corrective(rng, at.nominal, rho)
    a_t, a_s, a_w = (alpha * (partly(rng) if signs is None else signs[k]) for k in range(3))
    jerk, spin = inputs(at, flat_input)
    turn = at.w + a_w * at.v
    # (31d): v̇ (1 + a_t) = μ₁ − a_s v Ω, once more differentiated for v̈
    rate = (at.mu1 - a_s * at.v * turn) / (1.0 + a_t)
    acceleration = (jerk - a_s * (rate * turn + at.v * spin)) / (1.0 + a_t)
    got = third(at, (jerk, spin), (a_t - 1j * a_s) * at.v, a_w * at.v, (a_s * rate, a_s * acceleration))
    return np.abs(got - flat_input) / rho


def general_ratio(rng: np.random.Generator, bound: GeneralDynamicBound) -> Array:
    """Return ‖η‖/ρ where every quantity takes any value within its own bound."""
    at = states(rng)
    rho = bound(at.known)
    flat_input = at.nominal + corrective(rng, at.nominal, rho)
    jerk, spin = inputs(at, flat_input)
    most = bound.coupling_bound * (np.abs(jerk) + np.abs(at.v * spin)) + bound.lateral_slip_acceleration_bound
    slip = bound.slip_bound * at.v * partly(rng) - 1j * bound.lateral_slip_bound * partly(rng)
    rates = (bound.lateral_slip_rate_bound * partly(rng), most * partly(rng))
    yaw_slip = bound.yaw_slip_bound * partly(rng)
    return np.abs(third(at, (jerk, spin), slip, yaw_slip, rates) - flat_input) / rho


def general_bound(rng: np.random.Generator, coupled: bool) -> GeneralDynamicBound:
    """Return bounds over several decades whose small gain is below 0.95."""
    k4 = rng.uniform(0.0, 0.45, SAMPLES) if coupled else np.zeros(SAMPLES)
    alpha = rng.uniform(0.0, 1.0, SAMPLES) * (np.sqrt(0.95**2 - k4**2) - k4)
    return GeneralDynamicBound(
        slip_bound=alpha,
        yaw_slip_bound=size(rng),
        lateral_slip_bound=size(rng),
        lateral_slip_rate_bound=size(rng),
        lateral_slip_acceleration_bound=size(rng),
        coupling_bound=k4,
    )


def size(rng: np.random.Generator) -> Array:
    return 10.0 ** rng.uniform(-3.0, 0.5, SAMPLES)


ANY = (0.01, 0.49)
AT_SECTION_FIVE_B = (0.3, 0.3)
SIGNS = [(a, b, c) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)]


@pytest.mark.parametrize("alphas", [ANY, AT_SECTION_FIVE_B, (0.1, 0.1), (0.45, 0.45)])
def test_proportional_gain_covers_the_uncertainty_and_no_more(alphas):
    rng = np.random.default_rng(1)
    alpha = rng.uniform(alphas[0], alphas[1], SAMPLES)
    ratio = proportional_ratio(rng, ProportionalDynamicBound(alpha), alpha)
    assert 0.99 < ratio.max() <= 1.0 + 1e-9


@pytest.mark.parametrize("signs", SIGNS)
def test_proportional_gain_covers_every_sign(signs):
    """Negative v_t is the worst: it makes the wheels speed up more for the same v̇."""
    alpha = np.full(SAMPLES, 0.3)
    ratio = proportional_ratio(np.random.default_rng(2), ProportionalDynamicBound(alpha), alpha, signs)
    assert ratio.max() <= 1.0 + 1e-9
    assert ratio.max() > (0.99 if signs[0] < 0.0 else 0.94)


@pytest.mark.parametrize("coupled", [True, False])
def test_general_gain_covers_the_uncertainty_and_no_more(coupled):
    """With k₄ > 0, and with k₄ = 0, which is (81)."""
    rng = np.random.default_rng(1)
    ratio = general_ratio(rng, general_bound(rng, coupled))
    assert 0.99 < ratio.max() <= 1.0 + 1e-9


def test_sampler_would_notice_a_gain_that_is_two_per_cent_short():
    rng = np.random.default_rng(1)
    alpha = rng.uniform(ANY[0], ANY[1], SAMPLES)
    assert (proportional_ratio(rng, ProportionalDynamicBound(alpha), alpha) / 0.98).max() > 1.01
    assert (general_ratio(rng, general_bound(rng, True)) / 0.98).max() > 1.01


@pytest.mark.parametrize(
    "name",
    [
        "slip_bound",
        "yaw_slip_bound",
        "lateral_slip_bound",
        "lateral_slip_rate_bound",
        "lateral_slip_acceleration_bound",
        "coupling_bound",
    ],
)
def test_every_number_of_the_general_form_is_needed(name):
    """A gain that believes one of its six bounds to be a tenth smaller is too small somewhere."""

    class Trusting(GeneralDynamicBound):
        def __call__(self, state: DynamicState) -> Array:
            return GeneralDynamicBound(**{**vars(self), name: 0.9 * getattr(self, name)})(state)

    rng = np.random.default_rng(1)
    ratio = general_ratio(rng, Trusting(**vars(general_bound(rng, True))))
    assert ratio.max() > 1.03


@pytest.mark.parametrize("signs", SIGNS)
def test_paper_gain_is_exceeded_whatever_the_signs(signs):
    """Over all admissible states without limit: the printed C has no term in w_s, so Φ has none either."""
    alpha = np.full(SAMPLES, 0.3)
    ratio = proportional_ratio(np.random.default_rng(1), PaperDynamicBound(alpha), alpha, signs)
    assert ratio.max() > 100.0


def test_paper_gain_is_zero_where_the_uncertainty_is_not():
    """Straight ahead at constant speed with the paper's own slip: v̂ = 0, w = μ₁ = 0, so ρ = 0.

    Ω = w_s = αv: η = −(v + v_t)Ω² along t and −v_sΩ² − v̈_s to the left, with v̇ = −v_sΩ/(1 + α).
    """
    alpha, v, nothing = 0.3, 0.15, np.zeros(1)
    state = DynamicState(np.array([v]), nothing, nothing, nothing, nothing)
    assert PaperDynamicBound(np.array([alpha]))(state)[0] == 0.0
    w_s = alpha * v
    rate = -alpha * v * w_s / (1.0 + alpha)
    acceleration = -alpha * rate * w_s / (1.0 + alpha)
    along = alpha * rate * w_s - (1.0 + alpha) * v * w_s**2
    uncertainty = math.hypot(along, alpha * v * w_s**2 + alpha * acceleration)
    assert uncertainty == pytest.approx(4.5e-4, rel=0.1)
    rigorous = ProportionalDynamicBound(np.array([alpha]))(state)[0]
    assert uncertainty < rigorous


# closed forms


def one(value: float) -> Array:
    return np.array([value])


def test_gains_by_hand():
    """α = 0.3, v = 0.2, w = −0.5, μ₁ = 0.1, ‖v̂‖ = 0.4, first component of B⁻¹(v̂ − A) −0.25."""
    state = DynamicState(one(0.2), one(-0.5), one(0.1), one(0.4), one(-0.25))
    along = 0.3 * 0.1 * 0.5 + 0.3 * 0.2 * 0.25
    across = 0.3 * 0.2 * 0.25 + 1.3 * 0.2 * 0.3 * 0.1 + 0.3 * 0.25 + 2.0 * 0.3 * 0.5 * 0.1
    assert PaperDynamicBound(one(0.3))(state)[0] == pytest.approx((0.12 + along + across) / 0.7, rel=1e-13)

    # X1 = 0.06, Ωb = 0.56, kb = 3/7, N22 = 0.3 + 0.09/1.3, vdb = (0.1 + 0.06·0.56)/0.7, q = kb √1.16
    q, n22, vdb = 3.0 / 7.0 * math.sqrt(1.16), 0.3 + 0.09 / 1.3, 0.1336 / 0.7
    pa = 0.3 * vdb * 0.56 + 0.06 * 0.56**2 + 0.2 * (2.0 * 0.5 * 0.06 + 0.06**2)
    pl = 3.0 / 7.0 * (0.2 * 0.25 + 0.3 * vdb * 0.56) + 2.0 * n22 * 0.05 + 0.06 * 0.56**2 + 2.0 * 0.1 * 0.06
    assert q == pytest.approx(0.4616, abs=5e-5)
    expected = (q * 0.4 + math.hypot(pa, pl)) / (1.0 - q)
    assert ProportionalDynamicBound(one(0.3))(state)[0] == pytest.approx(expected, rel=1e-13)

    # ξ₁ … ξ₄ = 0.1, 0.02, 0.03, 0.04 and k₄ = 0.05: Ωb = 0.6, q = √(0.05² + 0.35²)
    bound = GeneralDynamicBound(one(0.3), one(0.1), one(0.02), one(0.03), one(0.04), one(0.05))
    pa = 0.03 * 0.6 + 0.06 * 0.36 + 0.2 * (0.1 + 0.01)
    pl = 0.04 + 0.02 * 0.36 + 0.02 + 0.6 * 0.05 + 0.05 * (0.05 + 0.1)
    q = math.hypot(0.05, 0.35)
    assert bound(state)[0] == pytest.approx((q * 0.4 + math.hypot(pa, pl)) / (1.0 - q), rel=1e-13)


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.3, 0.49])
def test_small_gain_of_the_proportional_form_is_that_of_the_worse_sign(alpha):
    """At rest ρ = q ‖v̂‖/(1 − q), with q the norm of what μ̄ feels for the worse of v_t = ±αv."""
    rest = DynamicState(one(0.0), one(0.0), one(0.0), one(1.0), one(0.0))
    rho = ProportionalDynamicBound(one(alpha))(rest)[0]
    norms = [math.hypot(a / (1.0 + a), a + a * a / (1.0 + a)) for a in (alpha, -alpha)]
    assert rho / (1.0 + rho) == pytest.approx(max(norms), rel=1e-12)


@pytest.mark.parametrize("signs", SIGNS)
def test_gains_do_not_know_signs(signs):
    state = DynamicState(*(one(value) for value in (0.2, 0.5, 0.1, 0.4, 0.25)))
    flipped = replace(
        state,
        forward_speed=signs[0] * state.forward_speed,
        yaw_rate=signs[1] * state.yaw_rate,
        acceleration=signs[2] * state.acceleration,
    )
    bounds = (
        PaperDynamicBound(one(0.3)),
        ProportionalDynamicBound(one(0.3)),
        GeneralDynamicBound(*(one(value) for value in (0.3, 0.1, 0.02, 0.03, 0.04, 0.05))),
    )
    for bound in bounds:
        assert bound(flipped)[0] == bound(state)[0] > 0.0


@pytest.mark.parametrize("count", [2, 37])
def test_gains_of_one_robot_have_the_bits_of_its_row_among_many(count):
    """One robot's are worked out with Python's numbers."""
    rng = np.random.default_rng(5)
    known = rng.uniform(0.01, 0.4, (6, count))
    states = rng.normal(size=(5, count))
    for form, parameters in ((PaperDynamicBound, 1), (ProportionalDynamicBound, 1), (GeneralDynamicBound, 6)):
        many = form(*known[:parameters])(DynamicState(*states))
        assert many.shape == (count,)
        for world in range(count):
            row = slice(world, world + 1)
            alone = form(*known[:parameters, row])(DynamicState(*states[:, row]))
            assert alone.tobytes() == many[row].tobytes()


@pytest.mark.parametrize(
    "bound", [lambda a: PaperDynamicBound(2.0 * a), ProportionalDynamicBound], ids=["paper", "proportional"]
)
def test_a_gain_is_infinite_at_the_end_of_its_range_for_one_robot_and_for_many(bound):
    for count in (1, 2):
        state = DynamicState(*(np.full(count, value) for value in (0.2, 0.5, 0.1, 0.4, 0.25)))
        with np.errstate(divide="ignore"):
            assert bound(np.full(count, 0.5))(state).tolist() == [np.inf] * count


def test_proportional_gain_loses_its_meaning_at_one_half():
    """Where v_s follows v, v̈_s contains the control: (70) would allow α < 1, the small gain ends at 1/2."""
    state = DynamicState(*(one(value) for value in (0.2, 0.5, 0.1, 0.4, 0.25)))
    assert ProportionalDynamicBound(one(0.5 - 1e-6))(state)[0] > 1e4
    assert ProportionalDynamicBound(one(0.5 + 1e-6))(state)[0] < -1e4
    assert 0.0 < PaperDynamicBound(one(0.9))(state)[0] < np.inf
