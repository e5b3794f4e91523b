"""What stands where in MuJoCo's state rows and sensor readings, and what it says in slipctl's words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipctl.pairs import pair
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import WHEELS, Array, BodyPose, Motion, WheelContact

SLIDING_SHARE = 0.98
"""Share of μN from which a wheel counts as sliding (assumed); MuJoCo does not tell stick from slide."""


@dataclass(frozen=True)
class MujocoState:
    """Everything MuJoCo integrates, and what its sensors read in the last physics step.

    Attributes
    ----------
    rows : (N, nstate) array
        The engine's ``mjSTATE_INTEGRATION`` of every world.
    sensors : (N, nsensordata) array
        Forces belong to the last physics step, so they are one physics step older than the pose.
    acceleration : (N, 2) array
        Of the body origin, mean over the last tick, world x, y [m/s²]; at the start the planned one. The
        acceleration of the last physics step alone would miss the jolt with which a moving floor changes its
        direction at every tick, and a dynamic law would settle 4 mm beside its path.
    time : float
        [s].
    status : (N,) int8 array
        Values of `Status`. A world that tipped or left keeps the state in which it did; one that diverged
        keeps the last good one.
    friction : (N, 2) array
        Under the left and right wheel in the last physics step [1].
    """

    rows: Array
    sensors: Array
    acceleration: Array
    time: float
    status: NDArray[np.int8]
    friction: Array


@dataclass(frozen=True)
class Motor:
    """The wheel motors as compiled: torque = gain·command + damping·rate, within the limit.

    Attributes
    ----------
    gain, damping, limit : (2,) arrays
        Left, right; damping is −kv for a servo and 0 for a torque motor [N·m·s/rad]; limit [N·m].
    """

    gain: Array
    damping: Array
    limit: Array

    @classmethod
    def of(cls, model: Any) -> Motor:
        """Return the motors of a compiled ``MjModel``."""
        wheels = [model.actuator(f"{side}_wheel") for side in WHEELS]
        limits = [w.forcerange[1] if model.actuator_forcelimited[w.id] else np.inf for w in wheels]
        return cls(
            gain=np.array([w.gainprm[0] for w in wheels]),
            damping=np.array([w.biasprm[2] for w in wheels]),
            limit=np.array(limits),
        )

    @cached_property
    def servo(self) -> bool:
        """Whether the motors are told a wheel rate; else a torque."""
        return bool((self.damping != 0.0).all())

    def acted(self, sensed: Array, command: Array, wheel_rate: Array) -> Array:
        """Return the torque that acted over a physics step [N·m], all arrays (2, N).

        The sensor reads the torque at the step's beginning; the implicit integrator applies the one at its
        end, unless the limit held it. The difference, kv·step·(wheel acceleration), is a quarter of what
        speeds a Magellan Pro up.
        """
        gain, damping, limit = self._upright
        driven = gain * command + damping * wheel_rate
        at_end = np.minimum(np.maximum(driven, -limit), limit)
        return np.where(np.abs(sensed) < limit, at_end, sensed)

    @cached_property
    def _upright(self) -> tuple[Array, Array, Array]:
        return self.gain[:, None], self.damping[:, None], self.limit[:, None]


@dataclass(frozen=True)
class Columns:
    """Columns of a state row and of the sensor readings.

    Attributes
    ----------
    position, quaternion, velocity : slice
        Of the base: x, y, z [m]; w, x, y, z; world x and y rates [m/s].
    yaw_rate : int
        About the body's own vertical [rad/s].
    wheel_angle, wheel_rate : slice
        Left, right [rad], [rad/s].
    force : list of slice
        Sensors: force of the floor on the left, right wheel, world x, y, z [N].
    torque : slice
        Sensors: left, right [N·m].
    forward : slice
        Sensors: world x, y of the body's forward axis at the instant of the forces.
    control : slice
        Commands of the left, right wheel.
    motor : Motor
    """

    position: slice
    quaternion: slice
    velocity: slice
    yaw_rate: int
    wheel_angle: slice
    wheel_rate: slice
    force: list[slice]
    torque: slice
    forward: slice
    control: slice
    motor: Motor

    @classmethod
    def of(cls, batch: Any) -> Columns:
        """Return the columns of a ``mujoco.batch.Batch``."""

        def offset(name: str) -> int:
            view, state = batch.bind(name), batch.state
            return (view.ctypes.data - state.ctypes.data) // state.itemsize

        model, qpos, qvel, ctrl = batch.model, offset("qpos"), offset("qvel"), offset("ctrl")
        root = model.body("base").jntadr[0]
        q, v = qpos + int(model.jnt_qposadr[root]), qvel + int(model.jnt_dofadr[root])
        axles = [model.joint(f"{side}_axle") for side in WHEELS]
        forces = [int(model.sensor(f"{side}_tyre_force").adr[0]) for side in WHEELS]
        forward = int(model.sensor("forward").adr[0])
        return cls(
            position=slice(q, q + 3),
            quaternion=slice(q + 3, q + 7),
            velocity=slice(v, v + 2),
            yaw_rate=v + 5,
            wheel_angle=_two(*(qpos + int(axle.qposadr[0]) for axle in axles)),
            wheel_rate=_two(*(qvel + int(axle.dofadr[0]) for axle in axles)),
            force=[slice(adr, adr + 3) for adr in forces],
            torque=_two(*(int(model.sensor(f"{side}_wheel_torque").adr[0]) for side in WHEELS)),
            forward=slice(forward, forward + 2),
            control=slice(ctrl, ctrl + 2),
            motor=Motor.of(model),
        )

    def motion(self, state: MujocoState, geometry: WheelGeometry) -> Motion:
        """Return the motion, from positions and velocities: what MuJoCo derives is one step older."""
        rows = state.rows
        w, x, y, z = (rows[:, self.quaternion.start + i] for i in range(4))
        wheel_rate = rows[:, self.wheel_rate]
        forward_speed, yaw_rate = geometry.body_rates(wheel_rate)
        return Motion(
            position=rows[:, self.position.start : self.position.start + 2],
            velocity=rows[:, self.velocity],
            heading_vector=unit(w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z)),
            heading_rate=rows[:, self.yaw_rate],
            wheel_rate=wheel_rate,
            wheel_angle=rows[:, self.wheel_angle],
            forward_speed=forward_speed,
            yaw_rate=yaw_rate,
            acceleration=state.acceleration,
        )

    def pose(self, rows: Array) -> BodyPose:
        """Return where the robot's bodies are."""
        return BodyPose(
            height=rows[:, self.position.start + 2],
            quaternion=rows[:, self.quaternion],
        )

    def contact(self, rows: Array, sensors: Array, friction: Array) -> WheelContact:
        """Return what the sensors say of the wheels on ground of a friction (N, 2)."""
        told = sensors.T[self.told]
        x, y, normal, (c, s) = told[0:2], told[2:4], told[4:6], told[6:8]
        length = np.sqrt(c * c + s * s)
        length[length == 0.0] = 1.0
        c, s = c / length, s / length
        tangential = np.sqrt(x * x + y * y)
        return WheelContact(
            torque=self.motor.acted(told[8:10], rows.T[self.control], rows.T[self.wheel_rate]).T,
            normal_force=normal.T,
            longitudinal_force=(c * x + s * y).T,
            lateral_force=(c * y - s * x).T,
            sliding=(tangential > SLIDING_SHARE * friction.T * normal).T,
        )

    @cached_property
    def told(self) -> NDArray[np.intp]:
        """Readings of a contact: x, y and z of both forces, left and right; forward x, y; both torques."""
        left, right = (force.start for force in self.force)
        forces = [first + axis for axis in range(3) for first in (left, right)]
        torque = self.torque.start
        return np.array(
            [*forces, self.forward.start, self.forward.start + 1, torque, torque + self.torque.step]
        )

    def upright(self, rows: Array) -> Array:
        """Return the cosine of the body's tilt (N,)."""
        x, y = rows[:, self.quaternion.start + 1], rows[:, self.quaternion.start + 2]
        return 1.0 - 2.0 * (x * x + y * y)

    def distance(self, rows: Array) -> Array:
        """Return the distance from the world's origin (N,) [m]."""
        x, y = rows[:, self.position.start], rows[:, self.position.start + 1]
        return np.sqrt(x * x + y * y)


def _two(left: int, right: int) -> slice:
    """Return both columns, left first, as a view: a list of two would be copied at every tick."""
    step = right - left
    return slice(left, right + step if right + step >= 0 else None, step)


def unit(x: Array, y: Array) -> Array:
    """Return the vectors (x, y), (N,) each, as (N, 2) of length one; zero stays zero."""
    length = np.sqrt(x * x + y * y)
    return pair(x, y) / np.where(length > 0.0, length, 1.0)[:, None]


def ahead(motion: Motion, time: float) -> tuple[Array, Array]:
    """Return where robots will be and head after a moment [s], to first order: positions, heading vectors.

    The floor's surface moves one way during a tick while the robot turns; aimed at the middle of the tick it
    is right on average.
    """
    c, s = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
    turn = motion.heading_rate * time
    return motion.position + motion.velocity * time, unit(c - turn * s, s + turn * c)


def turned(heading: float, quaternion: Array) -> list[float]:
    """Return the orientation at rest, turned by a heading [rad] about the vertical; w, x, y, z."""
    c, s = math.cos(heading / 2.0), math.sin(heading / 2.0)
    w, x, y, z = quaternion.tolist()
    return [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]
