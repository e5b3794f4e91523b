"""A recording is written and read back: what the viewer shows is what was simulated."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest

from slipctl.shape import Shape
from slipctl.view import RecordingError, RunInfo, write_recording
from tests.view.reading import Recording, rrd
from tests.view.signals import join, signals
from tests.view.world import GLYPHS, INFO, NOMINAL, ROBUST, ROOT


@pytest.fixture(scope="module")
def table() -> pa.Table:
    return join(signals(0, robust=False), signals(1))


@pytest.fixture(scope="module")
def path(table: pa.Table, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("recording") / "world.rrd", table, [NOMINAL, ROBUST], INFO)


@pytest.fixture(scope="module")
def recording(path: Path) -> Recording:
    return Recording(path)


def rows_of(table: pa.Table, run: int) -> pa.Table:
    return table.filter(pc.field("run") == run)


def nanoseconds(table: pa.Table) -> np.ndarray:
    return np.array([round(time * 1e9) for time in table["time"].to_pylist()])


@pytest.mark.parametrize("run", [0, 1])
def test_every_column_comes_back_bit_for_bit_at_its_times(
    table: pa.Table, recording: Recording, run: int
) -> None:
    rows, root = rows_of(table, run), ("/runs/nominal_kinematic", ROOT)[run]
    checked = 0
    for name in rows.column_names:
        if name in ("run", "time") or rows[name].null_count == len(rows):
            continue
        times, values = recording.rows(f"{root}/{name.replace('.', '/')}", "Scalars:scalars")
        expected = (
            rows[name].cast(pa.uint8()).cast(pa.float64()) if rows[name].type == pa.bool_() else rows[name]
        )
        assert np.array_equal(times, nanoseconds(rows)), name
        assert np.array_equal(np.array(values).view(np.int64), expected.to_numpy().view(np.int64)), name
        checked += 1
    assert checked > 50


def test_times_are_rounded_not_truncated(table: pa.Table) -> None:
    time = np.array(rows_of(table, 1)["time"].to_pylist())
    assert np.any(
        np.floor(time * 1e9).astype(int) != nanoseconds(rows_of(table, 1))
    )  # else this proves nothing


def test_the_robot_is_where_it_was_in_single_precision(table: pa.Table, recording: Recording) -> None:
    rows = rows_of(table, 1)
    times, places = recording.rows(f"{ROOT}/robot/base", "Transform3D:translation")
    _, turns = recording.rows(f"{ROOT}/robot/base", "Transform3D:quaternion")
    kept = np.isin(nanoseconds(rows), times)
    assert np.array_equal(times, nanoseconds(rows)[::2])  # 100 Hz recorded, 50 Hz drawn
    for value, names in (
        (places, ("motion.position.x", "motion.position.y", "body.height")),
        # Rerun's order is x, y, z, w
        (turns, tuple(f"body.quaternion.{part}" for part in "xyzw")),
    ):
        expected = np.stack([rows[name].to_numpy() for name in names], axis=1)[kept]
        assert np.array_equal(np.array(value, dtype=np.float32), expected.astype(np.float32)), names


def test_wheels_turn_about_the_axle_and_sit_beside_the_base(table: pa.Table, recording: Recording) -> None:
    rows = rows_of(table, 1)
    for side, sign in (("left", 1), ("right", -1)):
        _, turns = recording.rows(f"{ROOT}/robot/base/{side}_wheel", "Transform3D:quaternion")
        _, places = recording.rows(f"{ROOT}/robot/base/{side}_wheel", "Transform3D:translation")
        angle = rows[f"wheel.angle.{side}"].to_numpy()[::2]
        x, y, z, w = np.array(turns).T
        assert np.allclose(np.sin(2 * np.arctan2(y, w)), np.sin(angle), atol=1e-5)
        assert np.allclose(np.cos(2 * np.arctan2(y, w)), np.cos(angle), atol=1e-5)
        assert not np.any([x, z])
        assert np.allclose(places, [0, sign * 0.1624, 0], atol=1e-6)


def test_slip_arrow_points_where_the_robot_slips(table: pa.Table, recording: Recording) -> None:
    rows = rows_of(table, 1)
    _, vectors = recording.rows(f"{ROOT}/robot/base/arrows/slip", "Arrows3D:vectors")
    forward, left = rows["slip.longitudinal"].to_numpy()[::2], -rows["slip.lateral"].to_numpy()[::2]
    scale = 1.0  # the largest of 1, 2, 5 · 10ⁿ that keeps the arrow under half a metre
    assert np.allclose(
        np.array(vectors)[:, :2], scale * np.stack([forward, left], axis=1), rtol=1e-6, atol=1e-7
    )
    page = recording.static("/info/summary", "TextDocument:text")
    assert "Slip arrow 1 m per m/s" in page


def test_trail_is_the_path_in_pieces_without_gaps(table: pa.Table, recording: Recording) -> None:
    rows = rows_of(table, 1)
    times, pieces = recording.rows(f"{ROOT}/trail", "LineStrips3D:strips")
    for before, after in pairwise(pieces):
        assert before[-1] == after[0]
    drawn = np.array([pieces[0][0], *(point for piece in pieces for point in piece[1:])])[:, :2]
    path = np.stack([rows[f"motion.position.{axis}"].to_numpy()[::2] for axis in "xy"], axis=1)
    assert np.array_equal(drawn, path.astype(np.float32))
    assert times[-1] == nanoseconds(rows)[-1]


def test_units_stand_in_the_names(table: pa.Table, recording: Recording) -> None:
    for name, unit in (
        ("error.position", "m"),
        ("wheel.torque.left", "N·m"),
        ("decision.robust_gain", "m/s²"),
    ):
        legend = recording.static(f"{ROOT}/{name.replace('.', '/')}", "SeriesLines:names")
        assert legend.endswith(f"[{unit}]")
        assert name.split(".", 1)[1] in legend
        assert table.schema.field(name).metadata[b"unit"].decode() == unit
    assert recording.static(f"{ROOT}/wheel/sliding/left", "SeriesLines:names") == "robust sliding.left"


def test_derived_series(table: pa.Table, recording: Recording) -> None:
    rows = rows_of(table, 1)
    bound = 0.4 * np.abs(rows["motion.forward_speed"].to_numpy())
    assert np.array_equal(recording.rows(f"{ROOT}/slip/bound/upper", "Scalars:scalars")[1], bound)
    assert np.array_equal(recording.rows(f"{ROOT}/slip/bound/lower", "Scalars:scalars")[1], -bound)
    norm = np.hypot(*(rows[f"decision.nominal_input.{axis}"].to_numpy() for axis in "xy"))
    assert np.allclose(
        recording.rows(f"{ROOT}/decision/nominal_input/norm", "Scalars:scalars")[1], norm, rtol=1e-15
    )
    assert "/runs/nominal_kinematic/slip/bound/upper" not in recording.entities
    assert "/runs/nominal_kinematic/decision/robust_input/norm" not in recording.entities


def test_null_columns_are_left_out(recording: Recording) -> None:
    assert f"{ROOT}/decision/robust_gain" in recording.entities
    assert "/runs/nominal_kinematic/decision/robust_gain" not in recording.entities
    assert "/runs/nominal_kinematic/state/guarantee" not in recording.entities


def test_layout_and_one_timeline(recording: Recording) -> None:
    assert len(recording.reader.blueprints()) == 1
    assert recording.timelines() == {"sim_time"}
    layout = recording.reader.stream(store=recording.reader.blueprints()[0]).to_chunks()
    names = {
        name
        for chunk in layout
        for batch in [chunk.to_record_batch()]
        for column in batch.schema.names
        if column.endswith((":display_name", ":name"))
        for cell in batch.column(column).to_pylist()
        for name in cell or []
    }
    tabs = {"Slip & wheels · nominal", "Slip & wheels · robust", "Guarantee · robust"}
    assert {"Overview", "Tracking", "Run info", *tabs} <= names
    assert "Guarantee · nominal" not in names
    assert not set("".join(names)) - GLYPHS
    assert "Position error [m]" in " ".join(names)


def test_identity_and_properties(recording: Recording) -> None:
    (store,) = recording.reader.recordings()
    assert store.recording_id == "friction-sweep-0123456789ab-friction-0_1"
    run = next(chunk for chunk in recording.chunks if chunk.entity_path.endswith("/run") and chunk.is_static)
    row = run.to_record_batch().to_pylist()[0]
    assert row["varied.ground.friction"] == [0.1]
    assert row["robust_kinematic.rms_position_error"] == [0.001]
    assert row["nominal_kinematic.status"] == ["completed"]
    assert "nominal_kinematic.x" not in row


def test_a_busy_machine_writes_the_same_recording(
    table: pa.Table, path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from slipctl.view import recording

    written = recording.log_series

    def late(*arguments: Any) -> int:
        time.sleep(0.7)  # longer than Rerun waits for more to put into a chunk
        return written(*arguments)

    monkeypatch.setattr(recording, "log_series", late)
    slow = write_recording(tmp_path / "slow.rrd", table, [NOMINAL, ROBUST], INFO)
    assert rrd("compare", path, slow) == 0


def test_files_of_the_same_run_are_equal_and_sound(table: pa.Table, path: Path, tmp_path: Path) -> None:
    again = write_recording(tmp_path / "again.rrd", table, [NOMINAL, ROBUST], INFO)
    assert rrd("compare", path, again) == 0
    assert rrd("verify", path) == 0
    error = table["error.position"].to_numpy().copy()
    error[7] += 1e-3
    column = table.schema.get_field_index("error.position")
    other = table.set_column(column, table.schema.field(column), pa.array(error))
    assert rrd("compare", path, write_recording(tmp_path / "other.rrd", other, [NOMINAL, ROBUST], INFO)) == 1


def test_a_thousand_rows_a_second_are_thinned_and_the_page_says_so(tmp_path: Path) -> None:
    table = signals(1, duration=0.503, tick=0.001, mujoco=False)
    recording = Recording(write_recording(tmp_path / "fast.rrd", table, [ROBUST], INFO))
    times, values = recording.rows(f"{ROOT}/error/position", "Scalars:scalars")
    rows = [*range(0, 504, 5), 503]
    assert np.array_equal(times, nanoseconds(table)[rows])
    assert np.array_equal(values, table["error.position"].to_numpy()[rows])
    assert "every 5th row" in recording.static("/info/summary", "TextDocument:text")


def test_a_plant_without_bodies_gets_a_disc_on_wheels_that_turn(tmp_path: Path) -> None:
    table = signals(1, duration=1.0, mujoco=False)
    recording = Recording(write_recording(tmp_path / "flat.rrd", table, [ROBUST], {}))
    _, places = recording.rows(f"{ROOT}/robot/base", "Transform3D:translation")
    _, turns = recording.rows(f"{ROOT}/robot/base", "Transform3D:quaternion")
    heading = table["motion.heading"].to_numpy()[::2]
    assert np.allclose(np.array(places)[:, 2], 0.0825)
    assert np.allclose(
        turns, np.stack([0 * heading, 0 * heading, np.sin(heading / 2), np.cos(heading / 2)], 1)
    )
    _, wheel = recording.rows(f"{ROOT}/robot/base/left_wheel", "Transform3D:quaternion")
    rate = table["wheel.rate.left"].to_numpy()[0]
    assert 2 * np.arcsin(wheel[1][1]) == pytest.approx(0.02 * rate, rel=0.05)
    assert not any("traction" in entity for entity in recording.entities)


def test_a_run_that_ended_early(tmp_path: Path) -> None:
    whole, short = signals(0), signals(1).slice(0, 120)
    lost = RunInfo(1, "robust_kinematic", "robust_kinematic", status="left_the_arena", end_time=1.19)
    recording = Recording(write_recording(tmp_path / "short.rrd", join(whole, short), [NOMINAL, lost], INFO))
    times, labels = recording.rows(f"{ROOT}/robot/base/label", "Points3D:labels")
    assert (times.tolist(), labels) == ([0, 1_190_000_000], ["robust", "robust: left the arena"])
    times, events = recording.rows(f"{ROOT}/events", "TextLog:text")
    assert (times[-1], events[-1]) == (1_190_000_000, "robust: ended: left the arena")
    assert recording.rows(f"{ROOT}/error/position", "Scalars:scalars")[0][-1] == 1_190_000_000
    assert len(recording.rows("/reference/target", "Transform3D:translation")[0]) == 201


def test_rows_that_are_not_finite_leave_the_robot_where_it_was(tmp_path: Path) -> None:
    table = signals(1)
    broken = table["motion.position.x"].to_numpy().copy()
    broken[300:] = np.nan
    column = table.schema.get_field_index("motion.position.x")
    table = table.set_column(column, table.schema.field(column), pa.array(broken))
    recording = Recording(write_recording(tmp_path / "nan.rrd", table, [ROBUST], INFO))
    times, places = recording.rows(f"{ROOT}/robot/base", "Transform3D:translation")
    assert times[-1] == 2_980_000_000
    assert np.all(np.isfinite(places))
    assert np.isnan(recording.rows(f"{ROOT}/motion/position/x", "Scalars:scalars")[1][-1])


def test_shapes_are_tinted_and_translated(tmp_path: Path) -> None:
    turn, red, black = np.array([np.sqrt(0.5), np.sqrt(0.5), 0, 0]), np.array([0.8, 0.1, 0.1, 1]), np.zeros(4)
    shapes = [
        Shape("base", "cylinder", np.array([0.2, 0.05, 0]), np.array([0, 0, 0.1]), turn, red),
        Shape("left_wheel", "box", np.array([0.01, 0.02, 0.03]), np.zeros(3), turn, black),
        Shape("base", "plane", np.ones(3), np.zeros(3), turn, black),
        Shape("base", "capsule", np.array([0.1, 0.3, 0]), np.array([0, 0, 1.0]), turn, red),
    ]
    recording = Recording(write_recording(tmp_path / "shapes.rrd", signals(1), [ROBUST], INFO, shapes))
    hull = f"{ROOT}/robot/base/body/shape_0"
    assert recording.static(hull, "Cylinders3D:lengths") == pytest.approx(0.1)
    assert recording.static(hull, "Cylinders3D:radii") == pytest.approx(0.2)
    assert recording.static(hull, "Cylinders3D:colors") == 0x009E73FF
    assert recording.static(hull, "Cylinders3D:quaternions") == pytest.approx(
        [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    )
    assert recording.static(f"{ROOT}/robot/base/left_wheel/shape_0", "Boxes3D:colors") == 0x000000FF
    assert f"{ROOT}/robot/base/body/shape_1" not in recording.entities
    # a quarter turn about x lays the capsule's axis along -y, so it starts at +y
    start = recording.static(f"{ROOT}/robot/base/body/shape_2", "Capsules3D:translations")
    assert start == pytest.approx([0, 0.3, 1.0], abs=1e-6)


def test_rerun_switched_off_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(RecordingError, match="RERUN=off"):
        write_recording(tmp_path / "off.rrd", signals(1, duration=0.1), [ROBUST], INFO)
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_recorded_is_refused(tmp_path: Path) -> None:
    table = signals(1, duration=0.1)
    with pytest.raises(RecordingError, match="no runs"):
        write_recording(tmp_path / "a.rrd", table, [], INFO)
    with pytest.raises(RecordingError, match="unique"):
        write_recording(tmp_path / "a.rrd", table, [ROBUST, ROBUST], INFO)
    with pytest.raises(RecordingError, match="no rows of run 0"):
        write_recording(tmp_path / "a.rrd", table, [NOMINAL], INFO)
    with pytest.raises(RecordingError, match=r"motion\.heading"):
        write_recording(tmp_path / "a.rrd", table.drop_columns(["motion.heading"]), [ROBUST], INFO)
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match="cannot write"):
        write_recording(tmp_path / "file" / "a.rrd", table, [ROBUST], INFO)
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


FULL_DISK = """
import resource, sys
from pathlib import Path
from slipctl.view import RecordingError, RunInfo, write_recording
from tests.view.signals import signals
resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))
try:
    write_recording(Path(sys.argv[1]), signals(1), [RunInfo(1, "robust")], {})
except RecordingError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
def test_a_disk_that_fills_up_is_said_and_leaves_nothing(tmp_path: Path) -> None:
    told = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(tmp_path / "a.rrd")],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        cwd=Path(__file__).parents[2],
    )
    assert told.stdout.startswith(f"cannot write {tmp_path / 'a.rrd'}: ")
    assert list(tmp_path.iterdir()) == []
