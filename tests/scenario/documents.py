"""Scenario files as tables, and what reading them says."""

from __future__ import annotations

import copy
from typing import Any

from slipctl.scenario import Problem, ScenarioError, read

PAPER: dict[str, Any] = {
    "name": "paper",
    "tick": 0.001,
    "robot": {"model": "magellan_pro", "drive": "wheel_speed", "speed_limit": 2.0, "yaw_rate_limit": 5.0},
    "plant": {"kind": "kinematic_ode", "arena": 20.0},
    "slip": {"kind": "proportional", "longitudinal": 0.4, "lateral": 0.4, "yaw": 0.4},
    "reference": {
        "kind": "point_to_point",
        "duration": 20.0,
        "start": {"x": 0.0, "y": 0.0, "heading_deg": 90.0, "speed": 0.15},
        "goal": {"x": 1.2, "y": 1.5, "heading_deg": 90.0, "speed": 0.15},
    },
    "controller": [
        {"kind": "nominal_kinematic", "pole": -0.5, "speed_floor": 0.02},
        {
            "kind": "robust_kinematic",
            "label": "robust",
            "pole": -0.5,
            "slip_bound": 0.4,
            "boundary_layer": 0.02,
            "uncertainty": "paper",
        },
    ],
}

EIGHT: dict[str, Any] = {
    "name": "eight",
    "description": "A figure-eight on the floor",
    "seed": 3,
    "tick": 0.01,
    "duration": 4.0,
    "robot": {"model": "magellan_pro", "drive": "wheel_speed", "torque_limit": 3.0},
    "plant": {"kind": "mujoco", "timestep": 0.001, "arena": 10.0},
    "ground": {"friction": 0.5, "film": 100.0, "slope_deg": 3.0, "downhill_deg": 180.0},
    "reference": {
        "kind": "figure_eight",
        "length": 2.0,
        "speed": 1.0,
        "laps": 2,
        "x": 0.1,
        "heading_deg": 5.0,
    },
    "start": {"at_rest": True, "x_offset": 0.01, "y_offset": 0.02, "heading_offset_deg": 3.0},
    "sensing": {"pose": "true", "velocity": "true"},
    "controller": [{"kind": "nominal_kinematic", "pole": -2.0}],
    "sweep": {"ground.friction": [0.1, 0.2], "seed": {"from": 0, "to": 2, "count": 3}},
}


TORQUE: dict[str, Any] = {
    "name": "torque",
    "tick": 0.005,
    "robot": {"model": "magellan_pro", "drive": "wheel_torque", "torque_limit": 3.0},
    "plant": {"kind": "mujoco", "timestep": 0.001, "arena": 10.0},
    "ground": {"friction": 0.5},
    "reference": {
        "kind": "point_to_point",
        "duration": 20.0,
        "start": {"heading_deg": 90.0, "speed": 0.15, "yaw_rate": 0.1, "acceleration": 0.01},
        "goal": {
            "x": 1.2,
            "y": 1.5,
            "heading_deg": 90.0,
            "speed": 0.15,
            "yaw_rate": -0.1,
            "acceleration": 0.02,
        },
    },
    "controller": [
        {"kind": "nominal_dynamic", "pole": -0.5},
        {
            "kind": "robust_dynamic",
            "pole": -0.5,
            "slip_bound": 0.3,
            "boundary_layer": 0.005,
            "uncertainty": "proportional",
            "speed_floor": 0.02,
            "believes": {"wheel_radius": 0.08, "half_track": 0.17, "mass": 20.0, "yaw_inertia": 0.3},
        },
    ],
}

EXPERIMENT: dict[str, Any] = {
    "name": "experiment",
    "tick": 0.05,
    "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
    "plant": {"kind": "mujoco"},
    "reference": {"kind": "line", "speed": 0.2, "distance": 2.0},
    "sensing": {
        "pose": "odometry_camera",
        "velocity": "differentiated",
        "camera_rate": 3.0,
        "camera_position_noise": 0.003,
        "camera_heading_noise_deg": 0.5,
        "camera_delay": 0.12,
        "camera_gain": 0.8,
        "position_noise": 0.001,
        "heading_noise_deg": 0.1,
        "velocity_noise": 0.01,
        "yaw_rate_noise": 0.02,
        "pose_delay": 0.05,
        "velocity_delay": 0.1,
    },
    "controller": [{"kind": "nominal_kinematic", "pole": -0.5, "believes": {"half_track": 0.2}}],
}

SCALED: dict[str, Any] = {
    **PAPER,
    "name": "scaled",
    "reference": {**PAPER["reference"], "time_scaling": True},
    "controller": [
        {"kind": "nominal_kinematic", "pole": -0.5},
        {"kind": "nominal_kinematic", "label": "floor", "pole": -0.5, "time_scaled": False},
    ],
}


def changed(document: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Return a copy with dotted keys set; None takes a key out. Numbers index arrays."""
    result = copy.deepcopy(document)
    for key, value in changes.items():
        *parents, last = [int(part) if part.isdigit() else part for part in key.split(".")]
        table: Any = result
        for part in parents:
            table = table.setdefault(part, {}) if isinstance(part, str) else table[part]
        if value is None:
            del table[last]
        else:
            table[last] = value
    return result


def refused(document: dict[str, Any]) -> list[Problem]:
    """Read a document and return its problems; none where it is accepted."""
    try:
        read(document)
    except ScenarioError as error:
        return list(error.problems)
    return []


def only(document: dict[str, Any]) -> Problem:
    """Return the one problem of a document."""
    problems = refused(document)
    assert len(problems) == 1, [str(problem) for problem in problems]
    return problems[0]


def leaves(table: Any, prefix: str = "") -> list[tuple[str, Any]]:
    """Return dotted keys and values of everything that is no table and no array of tables."""
    if isinstance(table, dict):
        return [leaf for key, value in table.items() for leaf in leaves(value, f"{prefix}{key}.")]
    if isinstance(table, list) and table and isinstance(table[0], dict):
        return [leaf for index, value in enumerate(table) for leaf in leaves(value, f"{prefix}{index}.")]
    return [(prefix.rstrip("."), table)]
