"""The overhead camera of Section VI: when it looks, what it sees, and how a fix corrects the odometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipctl.sensing.delay import DelayLine, Ticks, ticks_until
from slipctl.sensing.noise import Stream, phases, white
from slipctl.sensing.odometry import OdometryPose, advance, direction
from slipctl.sensing.settings import CameraSettings
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array, Motion

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Localisation:
    """Where the robot believes to be: a rigid motion that carries the odometry into the world.

    The estimated pose is offset + R(turn) · (reckoned position) and turn + (reckoned heading).

    Attributes
    ----------
    odometry : OdometryPose
        Dead reckoning since the start.
    offset : (N, 2) array
        [m].
    turn : (N,) array
        [rad].
    past : DelayLine
        Reckoned and true x, y, heading of this and past ticks, for the frames that are under way.
    fix : (N,) bool array
        Whether a fix arrived at this tick.
    """

    odometry: OdometryPose
    offset: Array
    turn: Array
    past: DelayLine
    fix: Flags

    @property
    def heading(self) -> Array:
        """Estimated heading (N,), not wrapped [rad]."""
        return self.turn + self.odometry.heading

    @property
    def position(self) -> Array:
        """Estimated position (N, 2) [m]."""
        return self.offset + rotated(direction(self.turn), self.odometry.position)


@dataclass(frozen=True)
class OdometryCamera:
    """Dead reckoning, corrected by camera fixes.

    **Frames.** The camera runs freely: at t = 0 it is anywhere in its period (drawn from the world's seed),
    and frame j is exposed at the first tick at or after (j − phase)/rate, j = 1, 2, …; at most one frame per
    tick. A frame shows the pose at its exposure plus white noise, and arrives `delay` later.

    **Fusion.** The estimate starts at the true pose (the robot stood under the camera). When a frame z of the
    instant t₀ arrives, the estimate *of that instant* (today's estimate less the odometry since t₀) is moved
    by `gain` times its difference to z, in position and, wrapped, in heading; then the odometry since t₀ is
    put on top again, turned with the corrected heading. With gain 1 the estimate is the fix plus the odometry
    since: the plainest reading of "used to correct the robot's own odometry drift" in Section VI, which does
    not give a rule.

    Attributes
    ----------
    geometry : WheelGeometry
    gain : (N,) array
    frames : (T + 1, N) int array
        Number of the frame that is exposed at a tick; 0 for none.
    noise : (F, N, 3) array or None
        Of frame j: x, y [m], heading [rad].
    delay : (N,) int array
        In ticks.
    """

    geometry: WheelGeometry
    gain: Array
    frames: NDArray[np.int64]
    noise: Array | None
    delay: Ticks

    @classmethod
    def build(
        cls, settings: CameraSettings, geometry: WheelGeometry, seeds: Sequence[int], rows: int, tick: float
    ) -> OdometryCamera:
        """Draw frames and noise of all worlds for `rows` ticks of `tick` [s]."""
        times = np.arange(rows) * tick
        shown = np.floor(times[:, None] * settings.rate + phases(seeds)).astype(np.int64)
        new = np.zeros_like(shown, dtype=bool)
        new[1:] = shown[1:] > shown[:-1]
        count = int(shown.max()) + 1
        axes = [
            white(seeds, Stream.CAMERA, deviation, count, 3)
            for deviation in (settings.position_noise, settings.heading_noise)
        ]
        noise = None
        if any(part is not None for part in axes):
            position, heading = (np.zeros((count, len(seeds), 3)) if part is None else part for part in axes)
            noise = np.concatenate([position[..., :2], heading[..., 2:]], axis=-1)
        return cls(geometry, settings.gain, np.where(new, shown, 0), noise, ticks_until(settings.delay, tick))

    def start(self, motion: Motion) -> Localisation:
        """Return the localisation of a robot that knows where it starts."""
        heading = _angle(motion.heading_vector)
        odometry = OdometryPose(motion.position, heading, motion.wheel_angle)
        nothing = np.zeros_like(heading)
        past = DelayLine.filled(_seen(odometry, motion.position, heading), int(self.delay.max()))
        return Localisation(
            odometry, np.zeros_like(motion.position), nothing, past, np.zeros(len(heading), dtype=bool)
        )

    def update(self, before: Localisation, k: int, motion: Motion) -> Localisation:
        """Return the localisation at tick `k`, from the true motion at that tick."""
        odometry = advance(before.odometry, motion.wheel_angle, self.geometry)
        past = before.past
        if k > 0:
            past = past.push(_seen(odometry, motion.position, _angle(motion.heading_vector)))
        exposed = k - self.delay
        frame = np.where(exposed > 0, self.frames[np.maximum(exposed, 0), np.arange(len(exposed))], 0)
        after = replace(before, odometry=odometry, past=past, fix=frame > 0)
        return self._corrected(after, frame) if after.fix.any() else after

    def _corrected(self, now: Localisation, frame: NDArray[np.int64]) -> Localisation:
        then = now.past.at(self.delay)
        reckoned, reckoned_heading = then[:, :2], then[:, 2]
        position, heading = then[:, 3:5], then[:, 5]
        if self.noise is not None:
            noise = self.noise[frame, np.arange(len(frame))]
            position, heading = position + noise[:, :2], heading + noise[:, 2]
        believed = now.offset + rotated(direction(now.turn), reckoned)
        difference = [
            math.remainder(angle, 2.0 * math.pi) for angle in (heading - now.turn - reckoned_heading)
        ]
        turn = now.turn + self.gain * np.array(difference)
        corrected = believed + self.gain[:, None] * (position - believed)
        offset = corrected - rotated(direction(turn), reckoned)
        return replace(
            now, turn=np.where(now.fix, turn, now.turn), offset=np.where(now.fix[:, None], offset, now.offset)
        )


def rotated(heading_vector: Array, vector: Array) -> Array:
    """Return vectors (N, 2) turned by the angles whose cosines and sines are given (N, 2)."""
    c, s = heading_vector[:, 0], heading_vector[:, 1]
    x, y = vector[:, 0], vector[:, 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _angle(heading_vector: Array) -> Array:
    return np.array([math.atan2(sine, cosine) for cosine, sine in heading_vector.tolist()])


def _seen(odometry: OdometryPose, position: Array, heading: Array) -> Array:
    return np.column_stack([odometry.position, odometry.heading, position, heading])
