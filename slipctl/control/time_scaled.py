"""Any kinematic law, in the time of its path instead of the clock's: no floor, from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from slipctl.control.drive import DriveLimits, SpeedMemory
from slipctl.pairs import pair
from slipctl.theory.time_scale import PathRatio, path_velocity
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, SpeedCommand, Start


class KinematicLaw(Protocol):
    """A law that commands a speed and remembers it."""

    def start(self, start: Start) -> SpeedMemory:
        """Return the memory at the start."""
        ...

    def update(
        self, memory: SpeedMemory, reference: Reference, motion: Motion, tick: float | Array
    ) -> Decision[SpeedCommand]:
        """Decide the command of one tick."""
        ...


@dataclass(frozen=True)
class PathMemory:
    """What a law in path time remembers.

    Attributes
    ----------
    law : SpeedMemory
        The prolonged state is ṽ [m/s].
    ratio : PathRatio
        dF/dτ in units of ṽ as measured last.
    """

    law: SpeedMemory
    ratio: PathRatio


@dataclass(frozen=True)
class TimeScaledLaw:
    """A kinematic law in path time: it sees derivatives by τ, and a tick lasts Δτ.

    Attributes
    ----------
    law : KinematicLaw
        Its drive is `drive.unlimited()`: it keeps the floor, which is now one of ṽ.
    drive : DriveLimits
        The limits in real time; the floor is that of ṽ.
    """

    law: KinematicLaw
    drive: DriveLimits

    def start(self, start: Start) -> PathMemory:
        """Return the memory at the start: the planned ṽ, and rolling without slip.

        Raises
        ------
        ValueError
            If the path has no time of its own.
        """
        if start.path_speed is None:
            raise ValueError("a law in path time needs a path with a time of its own")
        rolling = pair(np.ones_like(start.path_speed), np.zeros_like(start.path_speed))
        law = self.law.start(replace(start, forward_speed=start.path_speed))
        return PathMemory(law, PathRatio.of(rolling))

    def update(
        self, memory: PathMemory, reference: Reference, motion: Motion, tick: float
    ) -> Decision[SpeedCommand]:
        """Decide the command of one tick.

        The wheels reach τ̇ṽ at the end of the tick, exactly 0 where τ̇ is, and the yaw rate is the mean of
        τ̇u₂, so that the robot turns by u₂Δτ.

        Raises
        ------
        ValueError
            If the path has no time of its own.
        """
        path = reference.path_time
        if path is None:
            raise ValueError("a law in path time needs a path with a time of its own")
        speed = memory.law.forward_speed
        velocity, ratio = path_velocity(
            motion.velocity, motion.heading_vector, path.rate, speed, memory.ratio
        )
        passed = path.elapsed_after - path.elapsed
        in_path_time = Reference(reference.position, path.velocity, path.acceleration, reference.jerk)
        seen = _with_velocity(motion, velocity)
        if np.count_nonzero(passed) == passed.size:
            inner = self.law.update(memory.law, in_path_time, seen, passed)
        else:
            # Δτ is 0 at the end; only du/dτ = Δṽ/Δτ suffers, which nobody asks for
            with np.errstate(divide="ignore", invalid="ignore"):
                inner = self.law.update(memory.law, in_path_time, seen, passed)

        before, wanted = speed * path.rate, inner.memory.forward_speed * path.rate_after
        command, limited = self.drive.reach(
            wanted, before, None, (wanted - before) / tick, inner.command.yaw_rate * (passed / tick), tick
        )
        kept, saturated = inner.memory.forward_speed, inner.trace.saturated
        if np.count_nonzero(limited):
            # as in real time, what is remembered is what was commanded, and never below the floor
            acts = limited & (path.rate_after > 0.0)
            reached = np.divide(
                command.forward_speed, path.rate_after, out=np.zeros(wanted.shape), where=acts
            )
            kept = np.where(acts, np.maximum(reached, self.drive.speed_floor), kept)
            saturated = saturated | limited
        why = inner.trace
        trace = DecisionTrace(
            why.nominal_input,
            why.robust_input,
            saturated,
            why.robust_gain,
            why.weighted_error,
            path_speed=speed,
            path_velocity=velocity,
        )
        return Decision(command, PathMemory(SpeedMemory(kept), ratio), trace)


def _with_velocity(motion: Motion, velocity: Array) -> Motion:
    """Return the motion with another velocity; `dataclasses.replace` takes four times as long."""
    return Motion(
        motion.position,
        velocity,
        motion.heading_vector,
        motion.heading_rate,
        motion.wheel_rate,
        motion.wheel_angle,
        motion.forward_speed,
        motion.yaw_rate,
        motion.acceleration,
    )
