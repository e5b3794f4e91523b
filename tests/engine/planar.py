"""Sliding in three degrees of freedom: what the direction of friction explains of the engines' difference.

The wheels turn as commanded, loads shift as in equilibrium, friction is at its limit from `CREEP` on. What is
left to choose is where it points: against the slip, or where Bullet's solver settles.
"""

from __future__ import annotations

import math

import numpy as np

from slipctl.theory.robot import GRAVITY, MAGELLAN_PRO
from slipctl.tick import Motion
from tests.engine.compare import Track, world_velocity
from tests.engine.drives import ON_WHEELS, TICK, Drive
from tests.engine.robot import Robot

CREEP = 1e-3
"""Slip velocity below which friction is viscous, for want of a stick phase [m/s]."""

STEPS = 200
"""Explicit steps per tick: friction below `CREEP` is stiff."""


def planar(robot: Robot, drive: Drive, like_bullet: bool) -> Track:
    """Return the track of a drive whose friction points against the slip, or as in Bullet.

    Bullet's solver corrects each of two friction directions, the world's x and y, by the slip velocity over
    the contact's inverse mass A in that direction, then shortens the pair of forces to the cone. Repeated,
    that settles at forces in the ratio (v_x/A_x) : (v_y/A_y) and not v_x : v_y.
    """
    mass, height, b, r = robot.mass, robot.com_height, robot.half_track, robot.wheel_radius
    yields = robot.inverse_mass
    vx, vy = world_velocity(drive).tolist()
    x = y = 0.0
    heading, turn, shift = drive.heading, drive.yaw_rate, 0.0
    step = TICK / STEPS
    motions = []
    for rates in drive.wheel_rate.tolist():
        for _ in range(STEPS):
            c, s = math.cos(heading), math.sin(heading)
            force_x = force_y = moment = across = 0.0
            # in the world's axes, as Bullet's friction directions are
            yield_x = yields[0] * c * c + yields[1] * s * s if like_bullet else 1.0
            yield_y = yields[0] * s * s + yields[1] * c * c if like_bullet else 1.0
            for side, rate in zip((1.0, -1.0), rates, strict=True):
                along = -turn * side * b - r * rate
                slip_x, slip_y = vx + along * c, vy + along * s
                load = 0.5 * ON_WHEELS * mass * GRAVITY + side * shift
                aim_x, aim_y = slip_x / yield_x, slip_y / yield_y
                size = math.sqrt(aim_x * aim_x + aim_y * aim_y)
                speed = math.sqrt(slip_x * slip_x + slip_y * slip_y)
                push = -drive.friction * load * min(1.0, speed / CREEP) / size if size else 0.0
                fx, fy = push * aim_x, push * aim_y
                force_x, force_y = force_x + fx, force_y + fy
                moment -= side * b * (fx * c + fy * s)
                across += fy * c - fx * s
            # a push to the left unloads the left wheel
            shift = -across * height / (2.0 * b)
            vx, vy = vx + step * force_x / mass, vy + step * force_y / mass
            turn += step * moment / robot.yaw_inertia
            x, y, heading = x + step * vx, y + step * vy, heading + step * turn
        wheels = np.array([rates])
        forward, yaw = MAGELLAN_PRO.body_rates(wheels)
        motions.append(
            Motion(
                position=np.array([[x, y]]),
                velocity=np.array([[vx, vy]]),
                heading_vector=np.array([[math.cos(heading), math.sin(heading)]]),
                heading_rate=np.array([turn]),
                wheel_rate=wheels,
                wheel_angle=np.zeros((1, 2)),
                forward_speed=forward,
                yaw_rate=yaw,
                acceleration=None,
            )
        )
    return Track.of(motions)
