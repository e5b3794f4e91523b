"""Recorded columns: names, shapes, derived errors, and the table they become."""

from __future__ import annotations

import math

import numpy as np
import pyarrow.parquet as pq
import pytest

from slipctl.recording import LAW_COLUMNS, UNITS, Recorder, signal_tables, with_errors, with_plan
from slipctl.simulate import simulate
from tests import builders


@pytest.fixture(scope="module")
def recorded():
    """Return the columns of two short worlds under the robust law, and their ending."""
    references = builders.rows_of(builders.table_one(2), 0.01, 0.5)
    recorder = Recorder(len(references.position), 2)
    law = builders.robust_law(np.array([-0.5, -0.8]), np.array([0.4, 0.3]), np.array([0.02, 0.05]))
    plant = builders.ode_plant(builders.paper_slip(2), 2)
    start = builders.planned_start(references)
    rows = []

    def write(k, row):
        recorder.write(k, row)
        rows.append(row)

    ending = simulate(plant, law, references, start, 0.01, write)
    return recorder.columns(), ending, rows


def test_columns_hold_what_the_rows_held_bit_for_bit(recorded):
    columns, _, rows = recorded
    columns = with_errors(columns)
    for k, row in enumerate(rows):
        for world in range(2):
            assert columns["motion.position.x"][world, k] == row.motion.position[world, 0]
            assert columns["motion.velocity.y"][world, k] == row.motion.velocity[world, 1]
            assert columns["wheel.rate.left"][world, k] == row.motion.wheel_rate[world, 0]
            assert columns["wheel.rate_command.right"][world, k] == row.decision.command.wheel_rate[world, 1]
            assert columns["slip.lateral"][world, k] == row.slip.lateral[world]
            assert columns["decision.robust_gain"][world, k] == row.decision.trace.robust_gain[world]


def test_errors_follow_from_their_definitions():
    angle = 0.3
    tangent = np.array([math.cos(angle), math.sin(angle)])
    left = np.array([-math.sin(angle), math.cos(angle)])
    # 2 m ahead and 0.5 m to the left of the reference, heading 0.1 rad too far left, across the ±π cut or not
    for turn in (0.1, 0.1 + 2.0 * math.pi):
        heading = angle + turn

        def cell(value: float) -> np.ndarray:
            return np.array([[value]])

        offset = 2.0 * tangent + 0.5 * left
        columns = with_errors(
            {
                "reference.position.x": cell(1.0),
                "reference.position.y": cell(-1.0),
                "reference.velocity.x": cell(0.4 * tangent[0]),
                "reference.velocity.y": cell(0.4 * tangent[1]),
                "reference.acceleration.x": cell(0.2 * left[0]),
                "reference.acceleration.y": cell(0.2 * left[1]),
                "motion.position.x": cell(1.0 + offset[0]),
                "motion.position.y": cell(-1.0 + offset[1]),
                "motion.heading_vector.x": cell(math.cos(heading)),
                "motion.heading_vector.y": cell(math.sin(heading)),
                # 0.03 m/s of slip forward and 0.04 m/s to the left
                "motion.velocity.x": cell(0.05 * math.cos(heading) - 0.04 * math.sin(heading)),
                "motion.velocity.y": cell(0.05 * math.sin(heading) + 0.04 * math.cos(heading)),
                "motion.forward_speed": cell(0.02),
                "motion.heading_rate": cell(0.7),
                "motion.yaw_rate": cell(0.5),
            }
        )
        assert columns["error.position"][0, 0] == pytest.approx(math.hypot(2.0, 0.5))
        assert columns["error.cross_track"][0, 0] == pytest.approx(0.5)
        assert columns["error.heading"][0, 0] == pytest.approx(0.1)
        assert columns["reference.forward_speed"][0, 0] == pytest.approx(0.4)
        assert columns["reference.yaw_rate"][0, 0] == pytest.approx(0.5)
        assert columns["slip.longitudinal"][0, 0] == pytest.approx(0.03)
        assert columns["slip.lateral"][0, 0] == pytest.approx(-0.04)
        assert columns["slip.yaw"][0, 0] == pytest.approx(0.2)
        # 0.05 m/s of slip over the least speed of 0.05 m/s
        assert columns["slip.ratio"][0, 0] == pytest.approx(1.0)
        assert "motion.heading_vector.x" not in columns


def test_the_table_survives_a_file_with_units_and_bits(recorded, tmp_path):
    columns, ending, _ = recorded
    columns = with_errors(columns)
    table = signal_tables([3, 7], columns, ending.last_row.tolist(), 0.01)[1]
    pq.write_table(table, tmp_path / "signals.parquet")
    back = pq.read_table(tmp_path / "signals.parquet")
    assert back.num_rows == 51
    assert set(back["run"].to_pylist()) == {7}
    assert back["time"].to_numpy().tobytes() == (np.arange(51) * 0.01).tobytes()
    for name in back.column_names[2:]:
        assert back.schema.field(name).metadata == {b"unit": UNITS[name].encode()}
        if name in columns and not name.startswith("guarantee."):
            assert np.array_equal(back[name].to_numpy(), columns[name][1])


def test_flat_inputs_of_a_dynamic_law_are_jerks(recorded):
    columns, ending, _ = recorded
    columns = with_errors(columns)
    for torque, unit in ((False, "m/s²"), (True, "m/s³")):
        more = {"decision.acceleration": columns["slip.yaw"]} if torque else {}
        table = signal_tables([0, 1], columns | more, ending.last_row.tolist(), 0.01)[1]
        for name in ("decision.nominal_input.x", "decision.robust_input.y", "decision.robust_gain"):
            assert table.schema.field(name).metadata == {b"unit": unit.encode()}
        covered = columns | more | {"guarantee.uncertainty_covered": columns["slip.yaw"] > 0.0}
        table = signal_tables([0, 1], covered, ending.last_row.tolist(), 0.01)[1]
        assert table.schema.field("guarantee.uncertainty_covered").metadata == {b"unit": b"bool"}
        assert table.schema.field("reference.acceleration.x").metadata == {b"unit": "m/s²".encode()}


def test_rows_after_the_end_are_left_out_and_missing_law_columns_are_null(recorded):
    columns, _, _ = recorded
    columns = {name: values for name, values in with_errors(columns).items() if name not in LAW_COLUMNS}
    table = signal_tables([0, 1], columns, [50, 12], 0.01)[1]
    assert table.num_rows == 13
    assert table["decision.robust_gain"].null_count == 13
    assert "wheel.torque.left" not in table.column_names


def test_blocks_of_any_size_make_the_same_columns(recorded, monkeypatch):
    columns, _, rows = recorded
    for block in (8, 16, 50, 51, 1000):
        # never less than eight rows at once
        monkeypatch.setattr("slipctl.recording.recorder.ROWS_AT_ONCE", 2 * block)
        recorder = Recorder(len(rows), 2)
        for k, row in enumerate(rows):
            recorder.write(k, row)
        again = recorder.columns()
        assert list(again) == list(columns)
        for name, values in again.items():
            assert values.tobytes() == columns[name].tobytes(), name
            assert values.flags.c_contiguous


def test_a_recording_that_stops_early_keeps_what_came(recorded, monkeypatch):
    columns, _, rows = recorded
    monkeypatch.setattr("slipctl.recording.recorder.ROWS_AT_ONCE", 16)
    recorder = Recorder(len(rows), 2)
    for k, row in enumerate(rows[:21]):
        recorder.write(k, row)
    for name, values in recorder.columns().items():
        assert np.array_equal(values[:, :21], columns[name][:, :21])
        assert not values[:, 21:].any()


def test_tables_of_a_batch_are_those_of_each_world_alone(recorded):
    columns, _, _ = recorded
    columns = with_errors(columns)
    columns["guarantee.uncertainty"] = columns["slip.ratio"].copy()
    columns["guarantee.held"] = columns["slip.ratio"] > 0.3
    last_rows = [50, 12]
    together = signal_tables([4, 9], columns, last_rows, 0.01)
    for world, table in enumerate(together):
        own = {name: values[world : world + 1].copy() for name, values in columns.items()}
        assert table.equals(signal_tables([[4, 9][world]], own, [last_rows[world]], 0.01)[0])
        told = table["guarantee.held"].to_pylist()
        assert told[-1] is None
        assert told[:-1] == columns["guarantee.held"][world, : last_rows[world]].tolist()
        assert table["guarantee.uncertainty"].null_count == 1


def test_what_follows_from_a_shared_path_is_shared_and_the_same():
    path = np.random.default_rng(3).uniform(0.1, 0.5, (4, 9))
    names = [f"reference.{name}.{axis}" for name in ("velocity", "acceleration") for axis in "xy"]
    shared = {name: np.broadcast_to(row, (3, 9)) for name, row in zip(names, path, strict=True)}
    own = {name: values.copy() for name, values in shared.items()}
    for rate in ({}, {"reference.path_rate": np.linspace(0.0, 1.0, 27).reshape(3, 9)}):
        together, apart = with_plan(shared | rate), with_plan(own | rate)
        assert together["reference.heading"].strides[0] == 0
        for name, values in apart.items():
            assert np.array_equal(together[name], values), name
