"""Sweeps that are done in a moment, for the tests of what happens to sweeps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from slipctl import scenario as files
from slipctl.experiment import run

TABLES: dict[str, Any] = {
    "name": "moment",
    "tick": 0.01,
    "duration": 0.7,
    "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
    "plant": {"kind": "kinematic_ode"},
    "slip": {"kind": "proportional", "longitudinal": 0.2, "lateral": 0.1},
    "reference": {"kind": "circle", "speed": 0.5, "radius": 1.0},
    "controller": [
        {"kind": "nominal_kinematic", "pole": -2.0},
        {
            "kind": "robust_kinematic",
            "pole": -2.0,
            "slip_bound": 0.4,
            "boundary_layer": 0.05,
            "uncertainty": "independent",
        },
    ],
    "sweep": {"slip.longitudinal": [0.0, 0.1, 0.3], "seed": [1, 2, 3, 4]},
}

ON_MUJOCO = {
    "plant": {"kind": "mujoco"},
    "slip": None,
    "duration": 0.3,
    "sweep": {"ground.friction": [0.3, 0.8], "reference.radius": [1.0, 2.0, 3.0]},
}

WORLDS = 12


def moment(**tables: Any) -> files.Scenario:
    """Return a sweep of twelve short worlds, or what the tables make of it."""
    return files.read({key: value for key, value in (TABLES | tables).items() if value is not None})


def swept(out: Path, scenario: files.Scenario | None = None, **options: Any) -> Path:
    """Run a sweep into a folder and return the run folder."""
    folder = run(scenario or moment(), out=out, **{"record": "none", **options}).folder
    assert folder is not None
    return folder


def parquet_bytes(folder: Path) -> dict[str, bytes]:
    """Return the content of the Parquet files of a run folder."""
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.parquet"))}
