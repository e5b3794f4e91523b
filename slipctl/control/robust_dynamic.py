"""The robust dynamic law: nominal law and corrective term, (67) with (73)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipctl.control.flat_dynamic import decide, flat_errors, model_drift, weighted_sum
from slipctl.control.torque import PushMemory, TorqueDrive
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
        nominal = reference.jerk - weighted_sum(self.gains, errors)
        weighted = weighted_sum(self.weights, errors)
        c, s = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
        model = model_drift(motion, memory)
        beyond = nominal - model
        gain = self.bound(
            DynamicState(
                forward_speed=motion.forward_speed,
                yaw_rate=motion.yaw_rate,
                acceleration=memory.acceleration,
                nominal=norm(nominal),
                nominal_jerk=c * beyond[:, 0] + s * beyond[:, 1],
            )
        )
        corrective = corrective_input(weighted, gain, self.boundary_layer)
        trace = DecisionTrace(nominal, corrective, np.zeros(len(gain), dtype=bool), gain, weighted)
        return decide(self.drive, memory, motion, nominal + corrective, model, trace, tick)
