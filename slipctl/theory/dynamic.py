"""The dynamic model: flat maps (15)–(27), slip dynamics (31), slip terms (61)–(63), and wheel torques.

Symbols as in the paper; t = (cos θ, sin θ), n = (−sin θ, cos θ), V = v + v_t and Ω = w + w_s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipctl.pairs import last_axis, pair
from slipctl.theory.flatness import invert_decoupling
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array, Slip


def drift(forward_speed: Array, yaw_rate: Array, acceleration: Array, cosine: Array, sine: Array) -> Array:
    """Return A of (25): what F⃛ is without any input.

    Parameters
    ----------
    forward_speed, yaw_rate, acceleration : (N,) arrays
        v [m/s], w [rad/s] and μ₁ [m/s²].
    cosine, sine : (N,) arrays
        The heading vector.

    Returns
    -------
    (N, 2) array
        [m/s³]; the left-hand side of the printed (24) has F̈ where F⃛ is meant.
    """
    along = -forward_speed * yaw_rate * yaw_rate
    across = 2.0 * yaw_rate * acceleration
    return pair(along * cosine - across * sine, along * sine + across * cosine)


def invert_dynamics(
    forward_speed: Array, cosine: Array, sine: Array, flat_input: Array, drift: Array
) -> tuple[Array, Array]:
    """Return (μ̄₁, μ̄₂) = B⁻¹(v − A).

    The printed (27), B⁻¹v − A, does not give F⃛ = v.

    Parameters
    ----------
    forward_speed, cosine, sine : (N,) arrays
        v [m/s], away from zero, and the heading vector.
    flat_input, drift : (N, 2) arrays
        v and A [m/s³].

    Returns
    -------
    jerk, yaw_acceleration : (N,) arrays
        μ̄₁ [m/s³] and μ̄₂ = μ₂ [rad/s²] (the printed second item of (23) has ū₂ where μ̄₂ is meant).
    """
    return invert_decoupling(forward_speed, cosine, sine, flat_input - drift)


def slip_terms(
    forward_speed: Array,
    yaw_rate: Array,
    acceleration: Array,
    slip: Slip,
    lateral_rate: Array,
    lateral_acceleration: Array,
    cosine: Array,
    sine: Array,
) -> tuple[Array, Array]:
    """Return the corrected C and the D of (61).

    The printed C uses θ̇ := w, although (31c) has θ̇ = w + w_s. Along t: v̇_sΩ − v_tΩ² − v(2ww_s + w_s²);
    along n: −(v̈_s + v_sΩ² − 2μ₁w_s). ẇ_s cancels, which is what Assumption 4.6 expects.

    Parameters
    ----------
    forward_speed, yaw_rate, acceleration : (N,) arrays
        v [m/s], w [rad/s] and μ₁ [m/s²].
    slip : Slip
    lateral_rate, lateral_acceleration : (N,) arrays
        v̇_s [m/s²] and v̈_s [m/s³].
    cosine, sine : (N,) arrays
        The heading vector.

    Returns
    -------
    C : (N, 2) array
        [m/s³].
    D : (N, 2, 2) array
        Multiplies (μ̄₁, μ̄₂).
    """
    v_t, v_s, w_s = slip.longitudinal, slip.lateral, slip.yaw
    turn = yaw_rate + w_s
    along = lateral_rate * turn - v_t * turn * turn - forward_speed * (2.0 * yaw_rate * w_s + w_s * w_s)
    across = -(lateral_acceleration + v_s * turn * turn - 2.0 * acceleration * w_s)
    c_matrix = np.stack([along * cosine - across * sine, along * sine + across * cosine], axis=-1)
    zero = np.zeros_like(cosine)
    d_matrix = np.stack(
        [np.stack([zero, -v_t * sine], axis=-1), np.stack([zero, v_t * cosine], axis=-1)], axis=-2
    )
    return c_matrix, d_matrix


@dataclass(frozen=True)
class Inertia:
    """What resists the wheel torques.

    Attributes
    ----------
    geometry : WheelGeometry
        r and b.
    mass : float or (N,) array
        m of the whole robot [kg]; one per world for what controllers believe.
    yaw_inertia : float or (N,) array
        I_z of the whole robot about the axle midpoint [kg·m²].
    wheel_inertia : float or (N,) array
        Spin inertia of one wheel with its motor, J [kg·m²]. The paper neglects it (0).
    joint_friction : float or (N,) array
        Coulomb friction of one axle [N·m]; the paper has none (0).
    """

    geometry: WheelGeometry
    mass: float | Array
    yaw_inertia: float | Array
    wheel_inertia: float | Array = 0.0
    joint_friction: float | Array = 0.0

    @property
    def effective_mass(self) -> float | Array:
        """Mass that a forward acceleration feels, m + 2J/r² (rolling) [kg]."""
        return self.mass + 2.0 * self.wheel_inertia / self.geometry.wheel_radius**2

    @property
    def effective_yaw_inertia(self) -> float | Array:
        """Inertia that a yaw acceleration feels, I_z + 2Jb²/r² (rolling) [kg·m²]."""
        ratio = self.geometry.half_track / self.geometry.wheel_radius
        return self.yaw_inertia + 2.0 * self.wheel_inertia * ratio * ratio

    @cached_property
    def _constants(self) -> tuple[Array, ...]:
        """Return both effective inertias, both times r, b and r/2, which depend on the body alone.

        They are arrays, which numpy would make of numbers anew in every operation.
        """
        mass, yaw_inertia = self.effective_mass, self.effective_yaw_inertia
        radius, half_track = self.geometry.wheel_radius, self.geometry.half_track
        numbers = mass, yaw_inertia, radius * mass, radius * yaw_inertia, half_track, radius / 2.0
        return tuple(np.asarray(number) for number in numbers)

    @cached_property
    def _rubs(self) -> bool:
        """Whether any axle rubs."""
        return bool(np.any(self.joint_friction))

    def torques(self, acceleration: Array, yaw_acceleration: Array, wheel_rate: Array) -> Array:
        """Return wheel torques (N, 2), left and right [N·m]; (K, N, 2) for (K, N) accelerations.

        τ_{r,l} = (r/2)(m μ₁ ± I_z μ₂/b), the inverse of (21) with f of (20), plus what axle friction takes.

        Parameters
        ----------
        acceleration, yaw_acceleration : (N,) arrays
            μ₁ [m/s²] and μ₂ [rad/s²].
        wheel_rate : (N, 2) array
            Left, right [rad/s]; its sign says against which way the axles rub.
        """
        mass, yaw_inertia, _, _, half_track, half = self._constants
        push = mass * acceleration
        turn = yaw_inertia * yaw_acceleration / half_track
        sides = np.array((push - turn, push + turn))
        sides *= half
        if self._rubs:
            sides[0] += self.joint_friction * np.sign(wheel_rate[..., 0])
            sides[1] += self.joint_friction * np.sign(wheel_rate[..., 1])
        return last_axis(sides)

    def accelerations(self, torque: Array, wheel_rate: Array) -> tuple[Array, Array]:
        """Return (μ₁, μ₂) of wheel torques (N, 2), left and right [N·m], (21); the inverse of `torques`."""
        _, _, radius_mass, radius_inertia, half_track, _ = self._constants
        left, right = torque[..., 0], torque[..., 1]
        if self._rubs:
            left = left - self.joint_friction * np.sign(wheel_rate[..., 0])
            right = right - self.joint_friction * np.sign(wheel_rate[..., 1])
        return (left + right) / radius_mass, (right - left) * half_track / radius_inertia
