"""The robot in PyBullet: a URDF of the numbers MuJoCo compiled, and Bullet's nearest settings."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pybullet  # pyright: ignore[reportMissingImports]

from slipctl.theory.robot import GRAVITY, WheelGeometry
from slipctl.tick import Array, Motion
from tests.engine.robot import Robot

ITERATIONS = 200
"""Sweeps of the solver per step; Bullet's default is 50, and 1000 change slip by less than 1 %."""


def _link(
    name: str, mass: float, com: float, inertia: tuple[float, ...], collision: str, contact: str
) -> str:
    ixx, iyy, izz = inertia
    return f"""
  <link name="{name}">
    <contact><rolling_friction value="0"/><spinning_friction value="0"/>{contact}</contact>
    <inertial><origin xyz="0 0 {com!r}"/><mass value="{mass!r}"/>
      <inertia ixx="{ixx!r}" iyy="{iyy!r}" izz="{izz!r}" ixy="0" ixz="0" iyz="0"/></inertial>{collision}
  </link>"""


def _ball(radius: float, x: float = 0.0, z: float = 0.0) -> str:
    return f"""
    <collision><origin xyz="{x!r} 0 {z!r}"/><geometry><sphere radius="{radius!r}"/></geometry></collision>"""


def urdf(robot: Robot, friction: float) -> str:
    """Return the robot as URDF, base frame at the axle midpoint, contacts in Bullet's own extension."""
    tyre, caster = robot.tyre, robot.caster
    reach = robot.caster_reach
    # Bullet's contact on the wheel lies on its surface, so the geometric radius is the one it rolls on
    axle_height = robot.wheel_radius - tyre.depth
    caster_z = robot.caster_radius - caster.depth - axle_height
    soft = '<lateral_friction value="{}"/><stiffness value="{!r}"/><damping value="{!r}"/>'
    parts = [
        _link(
            "base",
            robot.base_mass,
            robot.base_com,
            tuple(robot.base_inertia.tolist()),
            _ball(robot.caster_radius, reach, caster_z) + _ball(robot.caster_radius, -reach, caster_z),
            soft.format(0.0, caster.stiffness, caster.damping),
        )
    ]
    cross = robot.wheel_cross_inertia
    for side, y in (("left", robot.half_track), ("right", -robot.half_track)):
        parts.append(
            _link(
                f"{side}_wheel",
                robot.wheel_mass,
                0.0,
                (cross, robot.wheel_inertia, cross),
                _ball(robot.wheel_radius),
                soft.format(friction, tyre.stiffness, tyre.damping),
            )
        )
        parts.append(
            f"""
  <joint name="{side}_axle" type="continuous">
    <parent link="base"/><child link="{side}_wheel"/><origin xyz="0 {y!r} 0"/><axis xyz="0 1 0"/>
    <dynamics damping="0" friction="0"/>
  </joint>"""
        )
    return f'<?xml version="1.0"?>\n<robot name="magellan_pro">{"".join(parts)}\n</robot>\n'


@dataclass
class Bullet:
    """One robot in one PyBullet world; a context manager, because such a world must be closed.

    Attributes
    ----------
    robot : Robot
    friction : float
    timestep : float
        [s].
    cone : bool
        Friction cone, or else Bullet's pyramid.
    """

    robot: Robot
    friction: float
    timestep: float = 0.001
    cone: bool = True

    def __enter__(self) -> Bullet:
        self._client = pybullet.connect(pybullet.DIRECT)
        self._call("setGravity", 0.0, 0.0, -GRAVITY)
        self._call(
            "setPhysicsEngineParameter",
            fixedTimeStep=self.timestep,
            numSolverIterations=ITERATIONS,
            solverResidualThreshold=0.0,  # always all iterations
            numSubSteps=0,
            enableConeFriction=int(self.cone),
            restitutionVelocityThreshold=1e9,
        )
        shape = self._call("createCollisionShape", pybullet.GEOM_PLANE)
        floor = self._call("createMultiBody", 0.0, shape)
        # Bullet adds the dampings of both bodies and multiplies their frictions
        self._call(
            "changeDynamics", floor, -1, lateralFriction=1.0, rollingFriction=0.0, spinningFriction=0.0,
            restitution=0.0,
        )  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(urdf(self.robot, self.friction), encoding="utf-8")
            self._body = self._call("loadURDF", str(path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        for link in (-1, 0, 1):
            self._call("changeDynamics", self._body, link, linearDamping=0.0, angularDamping=0.0,
                       jointDamping=0.0, maxJointVelocity=1e6, restitution=0.0)  # fmt: skip
        self._add_armature()
        return self

    def _add_armature(self) -> None:
        """Give the wheels the armature that Bullet's joints do not have.

        It is added to their inertia about the axle and taken off the base's, so that the whole robot pitches
        as in MuJoCo. Not in the URDF, which must hold the inertia of something that could be built.
        """
        robot = self.robot
        base = robot.base_inertia - np.array([0.0, 2.0 * robot.wheel_armature, 0.0])
        self._call("changeDynamics", self._body, -1, localInertiaDiagonal=base.tolist())
        wheel = (
            robot.wheel_cross_inertia,
            robot.wheel_inertia + robot.wheel_armature,
            robot.wheel_cross_inertia,
        )
        for link in (0, 1):
            self._call("changeDynamics", self._body, link, localInertiaDiagonal=wheel)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pybullet.disconnect(self._client)

    def _call(self, name: str, *arguments: Any, **named: Any) -> Any:
        return getattr(pybullet, name)(*arguments, physicsClientId=self._client, **named)

    def start(self, heading: float, velocity: Array, yaw_rate: float, wheel_rate: Array) -> None:
        """Put the robot at rest height on the origin, with a world velocity (2,) and wheel rates (2,)."""
        height = self.robot.wheel_radius - self.robot.tyre.depth + self.robot.base_com
        turned = (0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0))
        self._call("resetBasePositionAndOrientation", self._body, (0.0, 0.0, height), turned)
        self._call("resetBaseVelocity", self._body, (*velocity.tolist(), 0.0), (0.0, 0.0, yaw_rate))
        for wheel in (0, 1):
            self._call("resetJointState", self._body, wheel, 0.0, float(wheel_rate[wheel]))

    def step(self, wheel_rate: Array, steps: int) -> None:
        """Drive the wheels (2,) at speeds [rad/s], within the torque limit, for a number of steps."""
        for wheel in (0, 1):
            self._call("setJointMotorControl2", self._body, wheel, pybullet.VELOCITY_CONTROL,
                       targetVelocity=float(wheel_rate[wheel]), force=self.robot.torque_limit)  # fmt: skip
        for _ in range(steps):
            self._call("stepSimulation")

    def observe(self) -> Motion:
        """Return the motion of the axle midpoint, worlds (1,)."""
        (x, y, _), quaternion = self._call("getBasePositionAndOrientation", self._body)
        (vx, vy, _), omega = self._call("getBaseVelocity", self._body)
        axes = np.array(pybullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3)
        # Bullet's base is the centre of mass, the axle is below it
        arm = -self.robot.base_com * axes[:, 2]
        vx += omega[1] * arm[2] - omega[2] * arm[1]
        vy += omega[2] * arm[0] - omega[0] * arm[2]
        heading = axes[:2, 0] / math.hypot(*axes[:2, 0])
        joints = [self._call("getJointState", self._body, wheel) for wheel in (0, 1)]
        rates = np.array([[joint[1] for joint in joints]])
        forward, yaw = WheelGeometry(self.robot.wheel_radius, self.robot.half_track).body_rates(rates)
        return Motion(
            position=np.array([[x + arm[0], y + arm[1]]]),
            velocity=np.array([[vx, vy]]),
            heading_vector=heading[None],
            heading_rate=np.array([float(np.dot(axes[:, 2], omega))]),
            wheel_rate=rates,
            wheel_angle=np.array([[joint[0] for joint in joints]]),
            forward_speed=forward,
            yaw_rate=yaw,
            acceleration=None,
        )

    def pitch_rate(self) -> float:
        """Return the body's rate about its left axis, nose down [rad/s]; for a robot heading along x."""
        return float(self._call("getBaseVelocity", self._body)[1][1])

    def load(self) -> Array:
        """Return the normal forces of the left and right wheel and of the casters together, (3,) [N]."""
        total = np.zeros(3)
        for point in self._call("getContactPoints", self._body):
            total[{0: 0, 1: 1, -1: 2}[point[3]]] += point[9]
        return total
