"""From the `[sensing]` tables of a batch to its sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from slipctl.experiment.assemble.stack import World, gather
from slipctl.sensing.sensor import MotionSensor
from slipctl.sensing.settings import CameraSettings, Delays, Noise, Sensing
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array


def sees_the_truth(worlds: Sequence[World]) -> bool:
    """Whether the controllers of a scenario see the true motion, at once and without noise.

    Decided for all worlds of a scenario together, so that they have the same columns: where a key of the
    sensing is swept, none does.
    """
    if any(key.startswith("sensing.") for key in worlds[0].varied):
        return False
    sensing = worlds[0].scenario.sensing
    imperfect = (
        getattr(sensing, name)
        for name in type(sensing).model_fields
        if name.endswith(("_delay", "_noise", "_noise_deg")) and not name.startswith("camera_")
    )
    sources = (sensing.pose, sensing.velocity, sensing.acceleration)
    return set(sources) == {"true"} and not any(imperfect)


def sensor(
    worlds: Sequence[World], geometry: WheelGeometry, rows: int, radius_ratio: float | Array = 1.0
) -> MotionSensor:
    """Return the sensor of a batch under one controller.

    Parameters
    ----------
    worlds : sequence of World
        Those of the batch, with the same tick and the same sources of each signal.
    geometry : WheelGeometry
        What the controller believes.
    rows : int
        T + 1.
    radius_ratio : float or (N,) array
        The wheel radius that it believes in shares of the true one.
    """

    def each(name: str) -> Array:
        # the camera's rate is not given where there is no camera
        return gather(worlds, lambda scenario: getattr(scenario.sensing, name) or 0.0)

    first = worlds[0].scenario
    sensing = Sensing(
        pose=first.sensing.pose,
        velocity=first.sensing.velocity,
        acceleration=first.sensing.acceleration,
        camera=CameraSettings(
            rate=each("camera_rate"),
            position_noise=each("camera_position_noise"),
            heading_noise=np.radians(each("camera_heading_noise_deg")),
            delay=each("camera_delay"),
            gain=each("camera_gain"),
        ),
        noise=Noise(
            position=each("position_noise"),
            heading=np.radians(each("heading_noise_deg")),
            velocity=each("velocity_noise"),
            acceleration=each("acceleration_noise"),
            yaw_rate=each("yaw_rate_noise"),
        ),
        delays=Delays(each("pose_delay"), each("velocity_delay"), each("acceleration_delay")),
        gravity=gravity(worlds),
    )
    seeds = [world.seed for world in worlds]
    return MotionSensor.build(sensing, geometry, seeds, rows, first.tick, radius_ratio)


def gravity(worlds: Sequence[World]) -> Array:
    """Return the part of gravity along the floor, (N, 2) world x, y [m/s²]; none but on MuJoCo's floor."""
    if worlds[0].scenario.plant.kind != "mujoco":
        return np.zeros((len(worlds), 2))
    from slipctl.theory.robot import GRAVITY

    grounds = [world.scenario.ground for world in worlds]
    slopes = [(math.radians(ground.slope_deg), math.radians(ground.downhill_deg)) for ground in grounds]
    return np.array(
        [
            (GRAVITY * math.sin(slope) * math.cos(way), GRAVITY * math.sin(slope) * math.sin(way))
            for slope, way in slopes
        ]
    )
