"""The robot at rest, and what follows from it in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipctl.theory.robot import GRAVITY, WheelGeometry
from slipctl.tick import Array


@dataclass(frozen=True)
class Rest:
    """The robot at rest.

    Attributes
    ----------
    qpos : array
    geometry : WheelGeometry
        Radius down to the contact points, and half track [m].
    inertia : (nv, nv) array
        ``mj_fullM``.
    load : (2,) array
        On the wheels [N].
    caster, caster_depth : (C,) arrays
        Load [N] and depth [m] of whatever else touches the floor.
    caster_place : (C, 3) array
        Of their centres, from the body origin, body axes [m].
    wheel_depth : (2,) array
        How deep the tyres are pressed in [m].
    centre : (3,) array
        Of mass, from the body origin [m].
    height : float
        Of the centre of mass above the floor [m].
    mass, wheel_inertia, spin_inertia : float
        [kg]; of one wheel with what is geared to it, of both wheels without [kg·m²].
    """

    qpos: Array
    geometry: WheelGeometry
    inertia: Array
    load: Array
    caster: Array
    caster_place: Array
    wheel_depth: Array
    centre: Array
    height: float
    mass: float
    wheel_inertia: float
    spin_inertia: float
    caster_depth: Array

    @property
    def radius(self) -> float:
        """Rolling radius at rest [m]."""
        return float(self.geometry.wheel_radius)

    @property
    def half_track(self) -> float:
        """Half the distance between the wheels [m]."""
        return float(self.geometry.half_track)

    @property
    def pitching(self) -> float:
        """Moment on the casters per acceleration: m·h, and what spins the wheels up [N·m/(m/s²)]."""
        return self.mass * self.height + self.spin_inertia / self.radius

    @property
    def spring(self) -> float:
        """Σ k l² of the casters about the axle, k the load over the depth [N·m/rad]."""
        return float((self.caster / self.caster_depth * self.caster_place[:, 0] ** 2).sum())

    @property
    def pitch_stiffness(self) -> float:
        """What is left of it where centre of mass and casters swing about the axle [N·m/rad]."""
        tips = self.mass * GRAVITY * self.centre[2] - (self.caster * self.caster_place[:, 2]).sum()
        return self.spring - float(tips)

    @property
    def share(self) -> float:
        """Share of the weight on the wheels [1]."""
        return float(self.load.sum() / (self.mass * GRAVITY))

    def loads(
        self, ahead: float = 0.0, left: float = 0.0, spin: float = 0.0, gravity: float = GRAVITY
    ) -> Array:
        """Return what a steady acceleration [m/s²] leaves on the wheels, left and right, and the casters [N].

        The robot as a rigid body on linear springs, each as stiff as its load over its depth at rest. What
        would have to pull has lifted and carries nothing.

        Parameters
        ----------
        ahead, left : float
            Of the robot [m/s²].
        spin : float
            Acceleration of the wheels [rad/s²].
        gravity : float
            Towards the ground [m/s²].
        """
        half = self.half_track
        x = np.concatenate([[0.0, 0.0], self.caster_place[:, 0]])
        y = np.concatenate([[half, -half], self.caster_place[:, 1]])
        at_rest = np.concatenate([self.load, self.caster])
        stiffness = at_rest / np.concatenate([self.wheel_depth, self.caster_depth])
        weight, moment = self.mass * gravity, self.mass * self.height
        wanted = np.array(
            [
                weight,
                weight * self.centre[0] - moment * ahead - self.spin_inertia * spin,
                weight * self.centre[1] - moment * left,
            ]
        )
        shape = np.stack([np.ones_like(x), x, y])
        standing = np.ones(len(x), dtype=bool)
        while True:
            matrix = ((shape * (stiffness * standing))[:, None, :] * shape[None, :, :]).sum(axis=2)
            # a robot of wheels alone balances: least squares lets it
            missing = wanted - (shape * (at_rest * standing)).sum(axis=1)
            sunk = np.linalg.lstsq(matrix, missing, rcond=None)[0]
            load = standing * (at_rest + stiffness * (sunk[:, None] * shape).sum(axis=0))
            if (load >= 0.0).all():
                return load
            standing &= load > 0.0

    def sliding(self, friction: float, ahead: float, left: float) -> float:
        """Return the deceleration of a slide in a direction (ahead, left) of length one [m/s²]: μ N / m."""
        loss = 0.0
        for _ in range(50):
            loss = friction * float(self.loads(-loss * ahead, -loss * left)[:2].sum()) / self.mass
        return loss

    def sideways(self, friction: float, load: Array) -> float:
        """Return the largest lateral acceleration that wheels under these loads can give [m/s²].

        Where the centre of mass is not over the axle, part of each wheel's friction must keep the robot from
        turning, and only what the friction circle leaves is lateral.
        """
        gain = 0.0
        for _ in range(50):
            turning = 0.5 * self.mass * gain * float(self.centre[0]) / self.half_track
            left = np.maximum((friction * load[:2]) ** 2 - turning**2, 0.0)
            gain = float(np.sqrt(left).sum()) / self.mass
        return gain

    def nose_up(self, acceleration: float) -> float:
        """Return the pitch that a steady acceleration [m/s²] of the wheels gives [rad]."""
        change = self.loads(acceleration, 0.0, acceleration / self.radius) - self.loads()
        far = int(np.argmax(np.abs(self.caster_place[:, 0])))
        caster = change[2 + far] * self.caster_depth[far] / self.caster[far]
        wheel = float((change[:2] * self.wheel_depth / self.load).mean())
        return float(wheel - caster) / float(self.caster_place[far, 0]) * self.spring / self.pitch_stiffness

    def torque(self, acceleration: float) -> float:
        """Return the torque of each wheel that gives a robot in grip an acceleration [N·m]."""
        return 0.5 * acceleration * (self.mass * self.radius + 2.0 * self.wheel_inertia / self.radius)

    def grip_limit(self, friction: float) -> float:
        """Return the acceleration that torques can give at most before the wheels spin [m/s²]."""
        gain = 0.0
        for _ in range(50):
            gain = friction * float(self.loads(gain, 0.0, gain / self.radius)[:2].sum()) / self.mass
        return gain

    def spinning(self, friction: float, torque: float) -> float:
        """Return the acceleration with spinning wheels, μ N / m; torques [N·m] load the casters [m/s²]."""
        gain = 0.0
        for _ in range(50):
            spin = (torque - 0.5 * self.mass * gain * self.radius) / self.wheel_inertia
            gain = friction * float(self.loads(gain, 0.0, spin)[:2].sum()) / self.mass
        return gain
