"""A law that is wrong about its robot: what it measures from the wheels, and what its commands do."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
        along, turning = self._shares()
        seen = replace(motion, forward_speed=motion.forward_speed / along, yaw_rate=motion.yaw_rate / turning)
        decision = self.law.update(memory, reference, seen, tick)
        command = decision.command
        if not isinstance(command, SpeedCommand):
            return decision
        return replace(
            decision,
            command=replace(
                command,
                forward_acceleration=command.forward_acceleration * along,
                forward_speed=command.forward_speed * along,
                yaw_rate=command.yaw_rate * turning,
            ),
        )

    def _shares(self) -> tuple[float | Array, float | Array]:
        """Return true v per believed v, and true w per believed w, of the same wheel rates."""
        along = self.true.wheel_radius / self.believed.wheel_radius
        return along, along * (self.believed.half_track / self.true.half_track)
