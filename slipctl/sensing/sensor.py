"""The sensor of the loop: from the true motion to the one a controller sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipctl.sensing.camera import Localisation, OdometryCamera, rotated
from slipctl.sensing.delay import DelayLine, Ticks, whole_ticks
from slipctl.sensing.noise import Stream, white
from slipctl.sensing.odometry import direction
from slipctl.sensing.settings import AccelerationSource, Sensing, VelocitySource
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array, Motion


@dataclass(frozen=True)
class SensorMemory:
    """What the sensor remembers from tick to tick; never changed, only replaced.

    Attributes
    ----------
    localisation : Localisation or None
        None where the pose is the true one.
    position : (N, 2) array
        The position handed out last [m].
    pose, velocity, acceleration : DelayLine or None
        Measurements on their way; None where nothing is late.
    fix : (N,) bool array
        Whether a camera fix arrived at the tick that was measured last.
    """

    localisation: Localisation | None
    position: Array
    pose: DelayLine | None
    velocity: DelayLine | None
    acceleration: DelayLine | None
    fix: NDArray[np.bool_]


@dataclass(frozen=True)
class Channel:
    """What happens to a signal on its way to the controller: noise, then delay.

    Attributes
    ----------
    noise : (T + 1, N, 2) array or None
        Added by tick; None for none.
    delay : (N,) int array
        In ticks. Before a first value could have arrived, the first value is what arrives.
    """

    noise: Array | None
    delay: Ticks

    def noisy(self, k: int, value: Array) -> Array:
        """Return (N, 2) values with the noise of tick `k`."""
        return value if self.noise is None else value + self.noise[k]

    def pass_on(self, line: DelayLine | None, k: int, value: Array) -> tuple[DelayLine | None, Array]:
        """Return the line with a measurement (N, components) of tick `k` in it, and what arrives."""
        if not self.delay.any():
            return None, value
        line = DelayLine.filled(value, int(self.delay.max())) if line is None or k == 0 else line.push(value)
        return line, line.at(self.delay)


@dataclass(frozen=True)
class MotionSensor:
    """Sensors of N worlds; `build` makes one.

    In this order, each from what stands before it:

    1. *Pose*: the true one, or `OdometryCamera`'s; white noise on x, y and heading; delay.
    2. *Velocity*: ``true``; ``odometry``, the wheels' v along the heading of step 1, which is blind to slip;
       or ``differentiated``, the difference of the positions of step 1 at this tick and the one before, over
       the tick: half a tick late, and a camera fix that moves the estimate by d reads as d/tick for one tick.
       At the first row, where there is no difference, the odometry's. Then white noise; delay.
    3. *Acceleration*: ``true``; ``imu``, the specific force F̈ − g in the frame of the body plus white noise,
       turned by the heading of step 1, so on a slope it contains what gravity the slope adds; or ``model``,
       None: the law computes its own. Noise comes in the body's frame for the IMU, else in the world's;
       delay.
    4. *Heading rate*: the gyro's, with white noise.

    Wheel angles and rates are the encoders', without error.

    Attributes
    ----------
    velocity_source, acceleration_source : str
    camera : OdometryCamera or None
        None for the true pose.
    pose, velocity, acceleration : Channel
    heading_noise : (T + 1, N, 2) array or None
        Cosine and sine of the error of the heading.
    yaw_rate_noise : (T + 1, N, 1) array or None
        [rad/s].
    gravity : (N, 2) array
        Along the ground, world x, y [m/s²].
    tick : float
        [s].
    radius_ratio : float or (N,) array
        What the odometry believes the wheels' radius to be, in shares of the true one.
    """

    velocity_source: VelocitySource
    acceleration_source: AccelerationSource
    camera: OdometryCamera | None
    pose: Channel
    velocity: Channel
    acceleration: Channel
    heading_noise: Array | None
    yaw_rate_noise: Array | None
    gravity: Array
    tick: float
    radius_ratio: float | Array = 1.0

    @classmethod
    def build(
        cls,
        sensing: Sensing,
        geometry: WheelGeometry,
        seeds: Sequence[int],
        rows: int,
        tick: float,
        radius_ratio: float | Array = 1.0,
    ) -> MotionSensor:
        """Draw all noise and return the sensor.

        Parameters
        ----------
        sensing : Sensing
        geometry : WheelGeometry
            What the odometry reckons with.
        seeds : sequence of int
            One per world, not negative. A world's noise depends on its own seed only: not on the other
            worlds, on the length of the run, or on what the controller does.
        rows : int
            T + 1.
        tick : float
            [s].
        radius_ratio : float or (N,) array
            The radius in `geometry` in shares of the true one.
        """
        noise, delays = sensing.noise, sensing.delays

        def channel(stream: Stream, deviation: Array, delay: Array) -> Channel:
            return Channel(white(seeds, stream, deviation, rows, 2), whole_ticks(delay, tick))

        turns = white(seeds, Stream.HEADING, noise.heading, rows, 1)
        return cls(
            velocity_source=sensing.velocity,
            acceleration_source=sensing.acceleration,
            camera=OdometryCamera.build(sensing.camera, geometry, seeds, rows, tick)
            if sensing.pose == "odometry_camera"
            else None,
            pose=channel(Stream.POSITION, noise.position, delays.pose),
            velocity=channel(Stream.VELOCITY, noise.velocity, delays.velocity),
            acceleration=channel(Stream.ACCELERATION, noise.acceleration, delays.acceleration),
            heading_noise=None if turns is None else np.stack([direction(row[:, 0]) for row in turns]),
            yaw_rate_noise=white(seeds, Stream.YAW_RATE, noise.yaw_rate, rows, 1),
            gravity=sensing.gravity,
            tick=tick,
            radius_ratio=radius_ratio,
        )

    def start(self, motion: Motion) -> SensorMemory:
        """Return the memory of a robot that knows where it starts.

        Raises
        ------
        ValueError
            Where an IMU should measure an acceleration that the plant does not tell.
        """
        if self.acceleration_source == "imu" and motion.acceleration is None:
            raise ValueError("an IMU needs a plant that tells its acceleration")
        return SensorMemory(
            localisation=None if self.camera is None else self.camera.start(motion),
            position=motion.position,
            pose=None,
            velocity=None,
            acceleration=None,
            fix=np.zeros(len(motion.position), dtype=bool),
        )

    def measure(self, memory: SensorMemory, k: int, motion: Motion) -> tuple[SensorMemory, Motion]:
        """Return what is remembered, and the motion as it is seen at row `k`; `k` goes up one by one."""
        localisation, position, heading = None, motion.position, motion.heading_vector
        if self.camera is not None and memory.localisation is not None:
            localisation = self.camera.update(memory.localisation, k, motion)
            position, heading = localisation.position, direction(localisation.heading)
        position = self.pose.noisy(k, position)
        if self.heading_noise is not None:
            heading = rotated(self.heading_noise[k], heading)
        pose_line, pose = self.pose.pass_on(memory.pose, k, np.concatenate([position, heading], axis=-1))
        position, heading = pose[:, :2], pose[:, 2:]

        velocity = self.velocity.noisy(k, self._velocity(memory, k, motion, position, heading))
        velocity_line, velocity = self.velocity.pass_on(memory.velocity, k, velocity)
        acceleration, acceleration_line = self._acceleration(k, motion, heading), None
        if acceleration is not None:
            acceleration_line, acceleration = self.acceleration.pass_on(memory.acceleration, k, acceleration)
        heading_rate = motion.heading_rate
        if self.yaw_rate_noise is not None:
            heading_rate = heading_rate + self.yaw_rate_noise[k, :, 0]

        fix = memory.fix if localisation is None else localisation.fix
        after = SensorMemory(localisation, position, pose_line, velocity_line, acceleration_line, fix)
        return after, replace(
            motion,
            position=position,
            velocity=velocity,
            heading_vector=heading,
            heading_rate=heading_rate,
            acceleration=acceleration,
        )

    def _velocity(
        self, memory: SensorMemory, k: int, motion: Motion, position: Array, heading: Array
    ) -> Array:
        if self.velocity_source == "true":
            return motion.velocity
        if self.velocity_source == "odometry" or k == 0:
            return (motion.forward_speed * self.radius_ratio)[:, None] * heading
        return (position - memory.position) / self.tick

    def _acceleration(self, k: int, motion: Motion, heading: Array) -> Array | None:
        if self.acceleration_source == "model" or motion.acceleration is None:
            return None
        if self.acceleration_source == "true":
            return self.acceleration.noisy(k, motion.acceleration)
        back = motion.heading_vector * np.array([1.0, -1.0])
        force = rotated(back, motion.acceleration - self.gravity)
        return rotated(heading, self.acceleration.noisy(k, force))
