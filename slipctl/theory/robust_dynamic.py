"""Uncertainty bounds ρ of the robust dynamic law, (75)–(81), corrected.

Symbols as in the paper. kb, q, Φ and the rest are derived; none of them is printed. All arrays are (N,).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from slipctl.theory.robust import largest_calm_tick
from slipctl.tick import Array


@dataclass(frozen=True)
class DynamicState:
    """What a bound may look at, of the model that the law believes in.

    Attributes
    ----------
    forward_speed, yaw_rate, acceleration : (N,) arrays
        v [m/s], w [rad/s] and μ₁ [m/s²].
    nominal : (N,) array
        ‖v̂‖ [m/s³].
    nominal_jerk : (N,) array
        First component of B⁻¹(v̂ − A) [m/s³].
    """

    forward_speed: Array
    yaw_rate: Array
    acceleration: Array
    nominal: Array
    nominal_jerk: Array


DynamicBound = Callable[[DynamicState], Array]
"""From a state to ρ (N,) [m/s³]."""


Number = TypeVar("Number", float, Array)
"""One robot's, or those of many."""


def _length(x: Any, y: Any) -> Any:
    """Return √(x² + y²) of two `Number`."""
    squared = x * x + y * y
    return math.sqrt(squared) if isinstance(squared, float) else np.sqrt(squared)


class _Bound(ABC):
    """What the bounds share: a formula that is one for numbers and for arrays, which round alike.

    For one robot, Python's numbers take a tenth of the time of arrays that hold one number each, and a bound
    has some forty operations.
    """

    def __call__(self, state: DynamicState) -> Array:
        """Return ρ (N,) [m/s³]."""
        seen = state.forward_speed, state.yaw_rate, state.acceleration, state.nominal, state.nominal_jerk
        if len(state.nominal) == 1:
            try:
                return np.array([self._gain(self._numbers, *(array.item() for array in seen))])
            except ZeroDivisionError:
                pass  # at the end of a bound's range numpy knows an infinity
        return self._gain(self._constants, *seen)

    @cached_property
    def _numbers(self) -> tuple[float, ...]:
        return tuple(np.asarray(constant).item() for constant in self._constants)

    @cached_property
    @abstractmethod
    def _constants(self) -> tuple[Array, ...]:
        """Return what depends on the parameters alone."""

    @abstractmethod
    def _gain(
        self, constants: tuple[Number, ...], v: Number, w: Number, mu1: Number, nominal: Number, jerk: Number
    ) -> Number:
        """Return ρ from the constants and the fields of a state."""


@dataclass(frozen=True)
class PaperDynamicBound(_Bound):
    """ρ of (81) with a Φ from the printed C and the nominal μ̄₁; **not** rigorous.

    Φ is not printed; assumed |v̇_s|, |ẇ_s| ≤ α|μ₁|, |v̈_s| ≤ α|μ̄̂₁|, |w_s| unused as in the printed C. On the
    paper's path ‖η‖ exceeds this ρ by up to 5 % for other signs of the slip than the paper's; over all states
    there is no limit, because ρ = 0 where v̂ = w = μ₁ = 0, whatever w_s does. Tests show both.

    Attributes
    ----------
    slip_bound : (N,) array
        α < 1/2 [1] ((70) allows 1, which is not enough where v_s follows v).
    """

    slip_bound: Array

    @cached_property
    def _constants(self) -> tuple[Array, ...]:
        """Return α, 1 + α, 2α and 1 − α."""
        a = self.slip_bound
        return a, 1.0 + a, 2.0 * a, 1.0 - a

    def _gain(
        self, constants: tuple[Number, ...], v: Number, w: Number, mu1: Number, nominal: Number, jerk: Number
    ) -> Number:
        a, more_a, twice_a, less_a = constants
        speed, turn, push = abs(v), abs(w), abs(mu1)
        bent = a * speed * turn * turn
        along = a * push * turn + bent
        across = bent + more_a * speed * a * push + a * abs(jerk) + twice_a * turn * push
        return (a * nominal + along + across) / less_a


@dataclass(frozen=True)
class ProportionalDynamicBound(_Bound):
    """Rigorous ρ for |v_t|, |v_s| ≤ α|v| with constant fractions of unknown sign, and |w_s| ≤ α|v|.

    Attributes
    ----------
    slip_bound : (N,) array
        α < 1/2 [1]: there q reaches 1.
    """

    slip_bound: Array

    @cached_property
    def _constants(self) -> tuple[Array, ...]:
        """Return α, 2α, kb, α·kb, 2n₂₂, q, 1 − α and 1 − q."""
        a = self.slip_bound
        kb = a / (1.0 - a)
        # the worse sign of v_t: for q it is negative ((q/a)² of the other is less by 8a³/(1 − a²)²), for what
        # multiplies 2wμ₁ positive (a(1 + 2a)/(1 + a) against a(1 − 2a)/(1 − a))
        rest = 1.0 - 2.0 * a
        n22, q = a + a * a / (1.0 + a), kb * np.sqrt(1.0 + rest * rest)
        return a, 2.0 * a, kb, kb * a, 2.0 * n22, q, 1.0 - a, 1.0 - q

    def _gain(
        self, constants: tuple[Number, ...], v: Number, w: Number, mu1: Number, nominal: Number, jerk: Number
    ) -> Number:
        a, twice_a, kb, a_kb, twice_n22, q, less_a, less_q = constants
        speed, turn, push = abs(v), abs(w), abs(mu1)
        yaw_slip, twice_yaw_slip = a * speed, twice_a * speed  # |w_s|, and |v_t| and |v_s| as well
        turn_bound = turn + yaw_slip
        speed_rate = (push + yaw_slip * turn_bound) / less_a
        turned = yaw_slip * (turn_bound * turn_bound)
        along = a * speed_rate * turn_bound + turned + speed * (turn * twice_yaw_slip + yaw_slip * yaw_slip)
        across = (
            kb * speed * turn * turn
            + twice_n22 * turn * push
            + a_kb * speed_rate * turn_bound
            + turned
            + push * twice_yaw_slip
        )
        return (q * nominal + _length(along, across)) / less_q


@dataclass(frozen=True)
class GeneralDynamicBound(_Bound):
    """Rigorous ρ for Assumption 4.6 with known numbers, and |v̈_s| ≤ k₄(|μ̄₁| + |vμ̄₂|) + ξ₄.

    Attributes
    ----------
    slip_bound : (N,) array
        α of |v_t| ≤ α|v| [1].
    yaw_slip_bound, lateral_slip_bound, lateral_slip_rate_bound, lateral_slip_acceleration_bound : (N,) arrays
        ξ₁ [rad/s], ξ₂ [m/s], ξ₃ [m/s²], ξ₄ [m/s³].
    coupling_bound : (N,) array
        k₄ [1]; 0 is (81).
    """

    slip_bound: Array
    yaw_slip_bound: Array
    lateral_slip_bound: Array
    lateral_slip_rate_bound: Array
    lateral_slip_acceleration_bound: Array
    coupling_bound: Array

    @cached_property
    def _constants(self) -> tuple[Array, ...]:
        """Return α, 2α, k₄, ξ₁, 2ξ₁, ξ₁², ξ₂, ξ₃, ξ₄, q and 1 − q."""
        a, k4, xi1 = self.slip_bound, self.coupling_bound, self.yaw_slip_bound
        others = self.lateral_slip_bound, self.lateral_slip_rate_bound, self.lateral_slip_acceleration_bound
        q = np.sqrt(k4 * k4 + (a + k4) * (a + k4))
        return a, 2.0 * a, k4, xi1, 2.0 * xi1, xi1 * xi1, *others, q, 1.0 - q

    def _gain(
        self, constants: tuple[Number, ...], v: Number, w: Number, mu1: Number, nominal: Number, jerk: Number
    ) -> Number:
        a, twice_a, k4, xi1, twice_xi1, squared_xi1, xi2, xi3, xi4, q, less_q = constants
        speed, turn, push = abs(v), abs(w), abs(mu1)
        turn_bound = turn + xi1
        squared = turn_bound * turn_bound
        twice_push = push + push
        along = xi3 * turn_bound + a * speed * squared + speed * (turn * twice_xi1 + squared_xi1)
        across = (
            xi4
            + xi2 * squared
            + twice_push * xi1
            + twice_a * turn * push
            + k4 * (speed * turn * turn + twice_push * turn)
        )
        return (q * nominal + _length(along, across)) / less_q


def largest_calm_dynamic_tick(
    boundary_layer: Array, robust_gain: Array, lyapunov_corner: Array, slip: Any
) -> Array:
    """Return the tick above which the boundary layer of a dynamic law chatters under a hold.

    With constant slip fractions the control reaches F⃛ through I + E, whose eigenvalues are 1 along the
    heading and |1+σ|²/Re(1+σ) across it: the kinematic threshold holds across, and the one without slip along
    (derived; not in the paper). A robot that slips backwards chatters along its heading first.

    Parameters
    ----------
    boundary_layer, robust_gain, lyapunov_corner : arrays
        ε, ρ [m/s³], P₃₃.
    slip : complex array
        σ = (v_t − i v_s)/v.

    Returns
    -------
    array
        [s]; infinite where ρ = 0.
    """
    known = boundary_layer, robust_gain, lyapunov_corner
    return np.minimum(largest_calm_tick(*known, slip), largest_calm_tick(*known, np.zeros_like(slip)))
