"""A law that is wrong about its robot: what it measures from the wheels, and what its commands do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array, Decision, Motion, Reference, SpeedCommand, Start


class TrackingLaw(Protocol):
    """Any law."""

    def start(self, start: Start) -> Any:
        """Return the memory at the start."""
        ...

    def update(self, memory: Any, reference: Reference, motion: Motion, tick: float) -> Decision[Any]:
        """Decide the command of one tick."""
        ...


@dataclass(frozen=True)
class BelievingLaw:
    """A law whose geometry is not that of the robot.

    The law itself is built with what it believes: it turns speeds into wheel rates, or accelerations into
    torques, with that. Here v and w become those that it reckons from the true wheel rates, and its command
    becomes one of the true robot: the wheels do as they are told, and the speeds are those they then have.
    Where belief and truth agree, no bit changes.

    Attributes
    ----------
    law : TrackingLaw
    believed, true : WheelGeometry
    """

    law: TrackingLaw
    believed: WheelGeometry
    true: WheelGeometry

    def start(self, start: Start) -> Any:
        """Return the memory of the law at the start: it believes to be where the plan starts."""
        return self.law.start(start)

    def update(self, memory: Any, reference: Reference, motion: Motion, tick: float) -> Decision[Any]:
        """Decide the command of one tick [s]."""
        along, turning = self._shares
        # made by hand: `dataclasses.replace` takes four times as long
        seen = Motion(
            motion.position,
            motion.velocity,
            motion.heading_vector,
            motion.heading_rate,
            motion.wheel_rate,
            motion.wheel_angle,
            motion.forward_speed / along,
            motion.yaw_rate / turning,
            motion.acceleration,
        )
        decision = self.law.update(memory, reference, seen, tick)
        command = decision.command
        if not isinstance(command, SpeedCommand):
            return decision
        true = SpeedCommand(
            command.forward_acceleration * along,
            command.forward_speed * along,
            command.yaw_rate * turning,
            command.wheel_rate,
        )
        return Decision(true, decision.memory, decision.trace)

    @cached_property
    def _shares(self) -> tuple[float | Array, float | Array]:
        """Return true v per believed v, and true w per believed w, of the same wheel rates."""
        along = self.true.wheel_radius / self.believed.wheel_radius
        return along, along * (self.believed.half_track / self.true.half_track)
