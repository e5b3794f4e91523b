"""The robust dynamic law: nominal law and corrective term, (67) with (73)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from slipctl.control.flat_dynamic import flat_errors, model_drift, steer, weighted_sum
from slipctl.control.torque import PushMemory, TorqueDrive
from slipctl.pairs import for_both
from slipctl.theory.robust import corrective_input, norm
from slipctl.theory.robust_dynamic import DynamicBound, DynamicState
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, Start, TorqueCommand


@dataclass(frozen=True)
class RobustDynamic:
    """The paper's robust dynamic law, for any number of worlds.

    Attributes
    ----------
    drive : TorqueDrive
    gains : (N, 3) array
        K₁ [1/s³], K₂ [1/s²], K₃ [1/s].
    weights : (N, 3) array
        P₁₃, P₂₃, P₃₃ of the Lyapunov matrix, so that JᵀPe = P₁₃e₁ + P₂₃e₂ + P₃₃e₃.
    boundary_layer : (N,) array
        ε; 0 is the discontinuous law.
    bound : DynamicBound
        ρ as a function.
    """

    drive: TorqueDrive
    gains: Array
    weights: Array
    boundary_layer: Array
    bound: DynamicBound

    def start(self, start: Start) -> PushMemory:
        """Return the memory at the start."""
        return self.drive.start(start)

    def update(
        self, memory: PushMemory, reference: Reference, motion: Motion, tick: float
    ) -> Decision[TorqueCommand]:
        """Decide the command of one tick."""
        errors = flat_errors(reference, motion, memory)
        gains, weights = self._columns
        nominal = reference.jerk - weighted_sum(gains, errors)
        weighted = weighted_sum(weights, errors)
        model = model_drift(motion, memory)
        along = motion.heading_vector * (nominal - model)
        gain = self.bound(
            DynamicState(
                forward_speed=motion.forward_speed,
                yaw_rate=motion.yaw_rate,
                acceleration=memory.acceleration,
                nominal=norm(nominal),
                nominal_jerk=along[:, 0] + along[:, 1],
            )
        )
        corrective = corrective_input(weighted, gain, self.boundary_layer)
        command, memory, saturated = steer(self.drive, memory, motion, nominal + corrective, model, tick)
        return Decision(command, memory, DecisionTrace(nominal, corrective, saturated, gain, weighted))

    @cached_property
    def _columns(self) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        return for_both(self.gains), for_both(self.weights)
