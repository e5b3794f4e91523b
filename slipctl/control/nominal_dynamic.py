"""The nominal dynamic law: exact linearisation of the dynamic model and three poles, (68) with (27)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipctl.control.flat_dynamic import flat_errors, model_drift, steer, weighted_sum
from slipctl.control.torque import PushMemory, TorqueDrive
from slipctl.pairs import for_both
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, Start, TorqueCommand


@dataclass(frozen=True)
class NominalDynamic:
    """The paper's nominal dynamic law, for any number of worlds.

    Attributes
    ----------
    drive : TorqueDrive
    gains : (N, 3) array
        K₁ [1/s³], K₂ [1/s²], K₃ [1/s].
    """

    drive: TorqueDrive
    gains: Array

    def start(self, start: Start) -> PushMemory:
        """Return the memory at the start."""
        return self.drive.start(start)

    def update(
        self, memory: PushMemory, reference: Reference, motion: Motion, tick: float
    ) -> Decision[TorqueCommand]:
        """Decide the command of one tick."""
        nominal = reference.jerk - weighted_sum(self._gains, flat_errors(reference, motion, memory))
        model = model_drift(motion, memory)
        command, memory, saturated = steer(self.drive, memory, motion, nominal, model, tick)
        return Decision(command, memory, DecisionTrace(nominal, np.zeros(nominal.shape), saturated))

    @cached_property
    def _gains(self) -> tuple[Array, ...]:
        return for_both(self.gains)
