"""The robust law: nominal law and corrective term, (42) with (47) or (59)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from slipctl.control.drive import DriveLimits, SpeedMemory
from slipctl.control.flat import flat_errors, nominal_input, steer
from slipctl.pairs import for_both
from slipctl.theory.robust import UncertaintyBound, corrective_input, norm
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, SpeedCommand, Start


@dataclass(frozen=True)
class RobustKinematic:
    """The paper's robust kinematic law, for any number of worlds.

    Attributes
    ----------
    drive : DriveLimits
    gains : (N, 2) array
        K₁ [1/s²], K₂ [1/s].
    weights : (N, 2) array
        P₁₂ and P₂₂ of the Lyapunov matrix, so that JᵀPe = P₁₂e₁ + P₂₂e₂.
    slip_bound : (N,) array
        α [1].
    boundary_layer : (N,) array
        ε; 0 is the discontinuous law (47).
    bound : UncertaintyBound
        ρ as a function.
    """

    drive: DriveLimits
    gains: Array
    weights: Array
    slip_bound: Array
    boundary_layer: Array
    bound: UncertaintyBound

    def start(self, start: Start) -> SpeedMemory:
        """Return the memory at the start: the planned speed, never below the floor."""
        return self.drive.start(start)

    def update(
        self, memory: SpeedMemory, reference: Reference, motion: Motion, tick: float | Array
    ) -> Decision[SpeedCommand]:
        """Decide the command of one tick."""
        position_error, velocity_error = flat_errors(reference, motion)
        (first_gain, second_gain), (first_weight, second_weight) = self._columns
        nominal = nominal_input(reference, position_error, velocity_error, first_gain, second_gain)
        weighted = first_weight * position_error + second_weight * velocity_error
        along = motion.heading_vector * nominal
        gain = self.bound(self.slip_bound, memory.forward_speed, norm(nominal), along[:, 0] + along[:, 1])
        corrective = corrective_input(weighted, gain, self.boundary_layer)
        command, memory, saturated = steer(self.drive, memory, motion, nominal + corrective, tick)
        return Decision(command, memory, DecisionTrace(nominal, corrective, saturated, gain, weighted))

    @cached_property
    def _columns(self) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        return for_both(self.gains), for_both(self.weights)
