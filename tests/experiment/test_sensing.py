"""Scenarios with a `[sensing]` table: columns, the same bytes in any batch, the same luck for every law."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from slipctl import scenario as files
from slipctl.experiment import run
from slipctl.simulate import Row, simulate
from tests.builders import full, nominal_law, ode_plant, paper_slip, planned_start, rows_of, table_one
from tests.sensing.worlds import TICK, everything, sensor_of

LAWS = [
    {"kind": "nominal_kinematic", "pole": -2.0},
    {
        "kind": "robust_kinematic",
        "pole": -2.0,
        "slip_bound": 0.2,
        "boundary_layer": 0.1,
        "uncertainty": "paper",
    },
]
CAMERA = {
    "pose": "odometry_camera",
    "velocity": "odometry",
    "camera_rate": 7.0,
    "camera_position_noise": 0.003,
    "camera_heading_noise_deg": 0.5,
    "camera_delay": 0.04,
    "position_noise": 0.001,
    "velocity_noise": 0.002,
    "velocity_delay": 0.02,
}
SLIPPERY = {"ground": {"friction": 0.5, "film": 50.0}}


def small(**tables: Any) -> files.Scenario:
    """Return a short circle on a film under sensors, or what the tables make of it."""
    raw = {
        "name": "small",
        "tick": 0.02,
        "duration": 0.6,
        "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
        "plant": {"kind": "mujoco"},
        "reference": {"kind": "circle", "speed": 0.5, "radius": 1.0},
        "sensing": CAMERA,
        "controller": LAWS,
    }
    return files.read(raw | tables)


def parquet_bytes(scenario: files.Scenario, out: Path, threads: int) -> dict[str, bytes]:
    folder = run(scenario, out=out, record="none", threads=threads).folder
    assert folder is not None
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.parquet"))}


SEEDS = {"seed": [3, 1, 4, 5, 9]}
GRIDS = {
    "mujoco": SLIPPERY | {"sweep": SEEDS},
    "ode": {
        "plant": {"kind": "kinematic_ode"},
        "slip": {"kind": "proportional", "longitudinal": 0.2, "lateral": 0.1},
        "sweep": SEEDS,
    },
    "some worlds see the truth": SLIPPERY
    | {"sensing": {}, "sweep": {"sensing.position_noise": [0.0, 0.01], "sensing.pose_delay": [0.0, 0.04]}},
}


@pytest.mark.parametrize("tables", GRIDS.values(), ids=GRIDS.keys())
def test_bytes_do_not_depend_on_batches_or_threads(
    tables: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = parquet_bytes(small(**tables), tmp_path, 1)
    for largest, threads in ((1, 1), (2, 2), (64, 3)):
        monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", largest)
        assert parquet_bytes(small(**tables), tmp_path, threads) == whole


def test_worlds_have_their_own_luck_and_laws_share_it() -> None:
    result = run(small(**GRIDS["mujoco"]))

    def column(name: str, run_index: int) -> np.ndarray:
        return result.run_signals(run_index)[name].to_numpy(zero_copy_only=False)

    fixes = [column("sensed.fix", index) for index in range(10)]
    for world in range(5):
        np.testing.assert_array_equal(fixes[2 * world], fixes[2 * world + 1])
    assert len({tuple(rows) for rows in fixes}) > 1
    # laws start alike, so what they see first is the same to the last bit
    for world in range(5):
        assert column("sensed.position.x", 2 * world)[0] == column("sensed.position.x", 2 * world + 1)[0]
    assert len({column("sensed.position.x", 2 * world)[0] for world in range(5)}) == 5


def test_errors_are_those_of_the_true_motion() -> None:
    result = run(small(**SLIPPERY))
    signals = {
        name: result.run_signals(0)[name].to_numpy(zero_copy_only=False)
        for name in result.signals.schema.names
    }
    for source, agrees in (("motion", True), ("sensed", False)):
        error = np.hypot(
            signals[f"{source}.position.x"] - signals["reference.position.x"],
            signals[f"{source}.position.y"] - signals["reference.position.y"],
        )
        assert np.allclose(error, signals["error.position"], atol=1e-12) is agrees


def test_columns_of_the_sensor_are_there_only_with_a_sensor() -> None:
    with_sensor = run(small()).signals.schema
    names = {name for name in with_sensor.names if name.startswith("sensed.")}
    assert names == {
        f"sensed.{name}"
        for name in ("position.x", "position.y", "heading", "velocity.x", "velocity.y", "fix")
    }
    assert with_sensor.field("sensed.velocity.x").metadata == {b"unit": b"m/s"}
    assert with_sensor.field("sensed.heading").metadata == {b"unit": b"rad"}
    without = run(small(sensing={"pose": "true"})).signals.schema
    assert not [name for name in without.names if name.startswith("sensed.")]


def closed_loop(sensor: Any) -> list[Row]:
    rows: list[Row] = []
    references = rows_of(table_one(), TICK, 5.0)
    simulate(
        ode_plant(paper_slip(), 1),
        nominal_law(full(1, -0.5)),
        references,
        planned_start(references),
        TICK,
        lambda _, row: rows.append(row),
        sensor=sensor,
    )
    return rows


def test_perfect_senses_change_no_bit_of_a_run() -> None:
    for bare, sensed in zip(closed_loop(None), closed_loop(sensor_of(1, 101)), strict=True):
        assert bare.sensed is None
        assert bare.motion.position.tobytes() == sensed.motion.position.tobytes()
        assert bare.decision.command.wheel_rate.tobytes() == sensed.decision.command.wheel_rate.tobytes()


def test_the_law_acts_on_what_is_sensed_and_the_row_keeps_the_truth() -> None:
    row = closed_loop(everything_but_the_imu())[50]
    assert row.sensed is not None
    off = row.sensed.motion.position - row.motion.position
    assert np.abs(off).min() > 1e-5
    error = row.sensed.motion.position - row.reference.position
    speed_error = row.sensed.motion.velocity - row.reference.velocity
    gains = nominal_law(full(1, -0.5)).gains
    expected = row.reference.acceleration - gains[:, :1] * error - gains[:, 1:] * speed_error
    np.testing.assert_allclose(row.decision.trace.nominal_input, expected, rtol=1e-12)


def everything_but_the_imu() -> Any:
    return replace(everything(1, [2], 101), acceleration_source="model")
