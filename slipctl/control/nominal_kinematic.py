"""The nominal law: exact linearisation of the kinematic model and two poles, (43) with (13)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipctl.control.drive import DriveLimits, SpeedMemory
from slipctl.control.flat import flat_errors, nominal_input, steer
from slipctl.pairs import for_both
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, SpeedCommand, Start


@dataclass(frozen=True)
class NominalKinematic:
    """The paper's nominal kinematic law, for any number of worlds.

    Attributes
    ----------
    drive : DriveLimits
    gains : (N, 2) array
        K₁ [1/s²], K₂ [1/s].
    """

    drive: DriveLimits
    gains: Array

    def start(self, start: Start) -> SpeedMemory:
        """Return the memory at the start: the planned speed, never below the floor."""
        return self.drive.start(start)

    def update(
        self, memory: SpeedMemory, reference: Reference, motion: Motion, tick: float | Array
    ) -> Decision[SpeedCommand]:
        """Decide the command of one tick."""
        position_error, velocity_error = flat_errors(reference, motion)
        nominal = nominal_input(reference, position_error, velocity_error, *self._gains)
        command, memory, saturated = steer(self.drive, memory, motion, nominal, tick)
        return Decision(command, memory, DecisionTrace(nominal, np.zeros(nominal.shape), saturated))

    @cached_property
    def _gains(self) -> tuple[Array, ...]:
        return for_both(self.gains)
