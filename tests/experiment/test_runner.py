"""Running scenarios: folders, bytes, batching, early ends and interruptions."""

from __future__ import annotations

import json
import math
import shlex
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from slipctl import scenario as files
from slipctl.experiment import resume, run
from slipctl.experiment.folder import OutputError
from slipctl.experiment.record import RecordChoiceError, worlds_to_record
from slipctl.guarantee import METRIC_UNITS
from slipctl.metrics import UNITS

LAWS = [
    {"kind": "nominal_kinematic", "pole": -2.0},
    {
        "kind": "robust_kinematic",
        "pole": -2.0,
        "slip_bound": 0.4,
        "boundary_layer": 0.05,
        "uncertainty": "independent",
    },
]


def small(**tables) -> files.Scenario:
    """Return a short circle on MuJoCo, or what the tables make of it."""
    raw = {
        "name": "small",
        "tick": 0.01,
        "duration": 0.5,
        "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
        "plant": {"kind": "mujoco"},
        "reference": {"kind": "circle", "speed": 0.5, "radius": 1.0},
        "controller": LAWS,
    } | tables
    return files.read({key: value for key, value in raw.items() if value is not None})


ODE = {
    "plant": {"kind": "kinematic_ode"},
    "slip": {"kind": "proportional", "longitudinal": 0.2, "lateral": 0.1},
}
SWEEP = {"sweep": {"ground.friction": [0.05, 0.3, 0.4, 0.5, 0.8]}}


def test_tables_have_one_row_per_run_in_grid_order():
    result = run(small(sweep={"ground.friction": [0.3, 0.8], "reference.speed": [0.4, 0.6]}))
    assert result.metrics["run"].to_pylist() == list(range(8))
    assert result.metrics["world"].to_pylist() == [0, 0, 1, 1, 2, 2, 3, 3]
    assert result.metrics["controller"].to_pylist() == ["nominal_kinematic", "robust_kinematic"] * 4
    assert result.metrics["ground.friction"].to_pylist() == [0.3] * 4 + [0.8] * 4
    assert result.metrics["reference.speed"].to_pylist() == [0.4, 0.4, 0.6, 0.6] * 2
    assert result.folder is None
    for name, unit in UNITS.items():
        assert result.metrics.schema.field(name).metadata == {b"unit": unit.encode()}


def test_machine_output_is_the_contract():
    result = run(small(**SWEEP))
    output = json.loads(json.dumps(result.json(), allow_nan=False))
    head = {"scenario", "scenario_id", "model_id", "versions", "folder", "failures"}
    assert set(output) == head | {"runs"}
    assert (output["folder"], output["failures"]) == (None, [])
    assert output["scenario"] == "small"
    assert output["scenario_id"].startswith("sha256:")
    assert output["model_id"].startswith("sha256:")
    assert {"slipctl", "mujoco"} <= set(output["versions"])
    first = output["runs"][0]
    assert set(first) == {"controller", "varied", "seed", "status", "metrics", "guarantee", "recording"}
    assert first["varied"] == {"ground.friction": 0.05}
    assert set(first["metrics"]) == set(UNITS)
    assert first["metrics"]["guarantee_fraction"] is None
    assert first["recording"] is None
    assert set(first["guarantee"]) == {"first_violation", *METRIC_UNITS}
    assert set(first["guarantee"].values()) == {None}
    robust = output["runs"][1]
    assert robust["metrics"]["guarantee_fraction"] is not None
    assert robust["guarantee"]["calm_tick"] > 0.0


def folder_of(scenario: files.Scenario, out: Path, **options) -> Path:
    folder = run(scenario, out=out, record="none", **options).folder
    assert folder is not None
    return folder


def parquet_bytes(folder) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.parquet"))}


@pytest.mark.parametrize("tables", [SWEEP, ODE | {"sweep": {"slip.longitudinal": [0.0, 0.1, 0.3]}}])
def test_bytes_do_not_depend_on_batches_or_threads(tables, tmp_path, monkeypatch):
    whole = parquet_bytes(folder_of(small(**tables), tmp_path, threads=1))
    assert set(whole) == {"metrics.parquet", "signals.parquet"}
    for largest, threads in ((1, 1), (2, 2), (64, 3)):
        monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", largest)
        assert parquet_bytes(folder_of(small(**tables), tmp_path, threads=threads)) == whole


def test_a_world_of_a_grid_equals_the_same_world_alone():
    grid = run(small(**SWEEP))
    alone = run(small(ground={"friction": 0.4}))
    row = grid.metrics.filter([value == 0.4 for value in grid.metrics["ground.friction"].to_pylist()])
    for name in UNITS:
        assert row[name].to_pylist() == alone.metrics[name].to_pylist()


def test_folders_are_whole_and_never_overwritten(tmp_path):
    scenario = small(**ODE)
    folders = [folder_of(scenario, tmp_path) for _ in range(3)]
    assert [folder.name for folder in folders] == ["small", "small-2", "small-3"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["small", "small-2", "small-3"]
    manifest = json.loads((folders[0] / "manifest.json").read_text())
    assert manifest["scenario"] == "small"
    assert manifest["runs"] == 2
    assert manifest["interrupted"] is False
    assert files.read(manifest["scenario_file"]) == scenario
    assert pq.read_table(folders[0] / "metrics.parquet").equals(pq.read_table(folders[1] / "metrics.parquet"))


def test_an_output_folder_that_is_a_file_is_refused(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("mine")
    with pytest.raises(OutputError, match="cannot write to the output folder"):
        run(small(**ODE), out=blocked)
    assert blocked.read_text() == "mine"


def test_a_failure_at_the_end_loses_no_chunk(tmp_path, monkeypatch):
    def broken(*arguments):
        raise RuntimeError("planted")

    with monkeypatch.context() as planted:
        planted.setattr("slipctl.experiment.finish.write_metrics", broken)
        with pytest.raises(RuntimeError, match="planted"):
            run(small(**ODE), out=tmp_path)
    (left,) = tmp_path.iterdir()
    assert left.name == "small.unfinished"
    assert resume(left).folder == tmp_path / "small"
    assert [path.name for path in tmp_path.iterdir()] == ["small"]


def test_ctrl_c_without_a_folder_keeps_what_has_finished(monkeypatch):
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 1)

    def stop(done: int, total: int, text: str) -> None:
        if done > total // 2:
            raise KeyboardInterrupt

    result = run(small(**SWEEP), progress=stop)
    assert result.interrupted
    finished = result.metrics["run"].to_pylist()
    assert finished == list(range(len(finished)))
    assert 0 < len(finished) < 10
    whole = run(small(**SWEEP))
    for name in UNITS:
        assert result.metrics[name].to_pylist() == whole.metrics[name].to_pylist()[: len(finished)]
    assert set(result.signals["run"].to_pylist()) == set(finished)


def test_ctrl_c_before_anything_finished_is_passed_on(tmp_path):
    def stop(done: int, total: int, text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(small(**ODE), out=tmp_path, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_a_robot_that_leaves_the_arena_ends_early_and_is_measured_until_then():
    tables = ODE | {
        "plant": {"kind": "kinematic_ode", "arena": 0.5},
        "reference": {"kind": "line", "speed": 0.5, "distance": 5.0},
        "duration": 3.0,
    }
    result = run(small(**tables))
    for row in result.metrics.to_pylist():
        assert row["status"] == "left_the_arena"
        assert 0.8 < row["end_time"] < 1.1
        signals = result.run_signals(row["run"])
        assert signals.num_rows == round(row["end_time"] / 0.01) + 1
        assert signals["motion.position.x"].to_numpy().max() < 0.5
        assert row["final_position_error"] == signals["error.position"].to_numpy()[-1]


def test_starts_as_the_scenario_says():
    result = run(small(start={"x_offset": 0.02, "y_offset": -0.01, "heading_offset_deg": 10.0}))
    first = result.run_signals(0).slice(0, 1).to_pylist()[0]
    assert first["motion.position.x"] == pytest.approx(0.02, abs=1e-12)
    assert first["motion.position.y"] == pytest.approx(-0.01, abs=1e-12)
    assert first["motion.heading"] == pytest.approx(math.radians(10.0), abs=1e-9)
    assert first["motion.forward_speed"] == pytest.approx(0.5, abs=1e-9)
    at_rest = run(small(start={"at_rest": True})).run_signals(0).slice(0, 1).to_pylist()[0]
    assert at_rest["motion.forward_speed"] == pytest.approx(0.0, abs=1e-9)
    assert math.hypot(at_rest["motion.velocity.x"], at_rest["motion.velocity.y"]) < 1e-9


def test_a_swept_controller_key_reaches_that_controller_only():
    result = run(small(**ODE, sweep={"controller.robust_kinematic.boundary_layer": [0.02, 0.2]}))
    nominal = [row for row in result.metrics.to_pylist() if row["controller"] == "nominal_kinematic"]
    robust = [row for row in result.metrics.to_pylist() if row["controller"] == "robust_kinematic"]
    assert nominal[0]["rms_position_error"] == nominal[1]["rms_position_error"]
    assert robust[0]["rms_position_error"] < robust[1]["rms_position_error"]


def test_machine_output_says_what_failed_and_how_to_run_it_alone():
    result = run(small(**ODE))
    failed = {"world": 3, "controller": "a", "varied": {}, "seed": 0, "failure": "ValueError: no"}
    assert replace(result, failures=(failed,)).json()["failures"] == [{**failed, "replay": None}]
    told = replace(result, failures=(failed,), folder=Path("my runs") / "small").json()
    assert told["folder"] == "my runs/small"
    (entry,) = told["failures"]
    assert shlex.split(entry.pop("replay")) == ["slipctl", "run", str(Path("my runs/small")), "--world", "3"]
    assert entry == failed


def test_which_worlds_are_recorded():
    metrics = run(small(**ODE, sweep={"slip.longitudinal": [0.0, 0.4, 0.2]})).metrics
    assert worlds_to_record("none", metrics)[0] == []
    assert worlds_to_record("all", metrics) == ([0, 1, 2], "3 recordings: one per world")
    chosen, note = worlds_to_record("worst:2", metrics)
    assert chosen == [1, 2]
    assert note.startswith("2 recordings of 3 worlds")
    assert worlds_to_record("failed", metrics) == ([], "0 recordings of 3 worlds: every run completed")
    place = metrics.column_names.index("status")
    for run_index, world in ((0, 0), (5, 2)):
        statuses = metrics["status"].to_pylist()
        statuses[run_index] = "tipped"
        tipped = metrics.set_column(place, metrics.schema.field("status"), pa.array(statuses))
        assert worlds_to_record("worst:1", tipped)[0] == [world]
        assert worlds_to_record("failed", tipped) == (
            [world],
            "1 recording of 3 worlds: those that did not complete",
        )
    with pytest.raises(RecordChoiceError, match="worst:N"):
        worlds_to_record("wurst:1", metrics)


def test_beyond_a_few_worlds_the_worst_are_recorded():
    metrics = run(small(**ODE, sweep={"seed": list(range(30))})).metrics
    chosen, note = worlds_to_record("auto", metrics)
    assert chosen == list(range(8))  # all are alike: the first ones
    assert note == (
        "8 recordings of 30 worlds: those that ended early, then the largest errors (more with record all)"
    )
    assert len(worlds_to_record("all", metrics)[0]) == 30
    few = metrics.slice(0, 24 * len(metrics) // 30)
    assert worlds_to_record("auto", few) == (list(range(24)), "24 recordings: one per world")
