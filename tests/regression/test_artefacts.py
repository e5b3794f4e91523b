"""Recordings of what failed: which worlds, what is written, what is said where something is missing."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from slipctl import experiment
from slipctl.cli import main
from slipctl.regression import Finding, Verdict, baseline_file, check, record, record_failing
from slipctl.regression.artefacts import WORLDS, failing_worlds
from slipctl.regression.baseline.tracks import tracks_file
from slipctl.scenario import load, scenario_id, worlds
from tests.fakes import SHORT_SCENARIO
from tests.view.reading import Recording

SWEPT = (
    SHORT_SCENARIO.replace("distance = 0.2", "distance = 0.1")
    + """
[[controller]]
kind = "robust_kinematic"
pole = -1.0
slip_bound = 0.1
boundary_layer = 0.05
uncertainty = "independent"

[start]
y_offset = 0.05

[sweep]
"start.x_offset" = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]
"""
)
WORSE = Finding(
    "line", "nominal_kinematic", {"start.x_offset": 0.0}, 0, "rms_position_error", 1.0, 1.1, 0.0,
    Verdict.WORSE, unit="m",
)  # fmt: skip


def about(offset: float, share: float = 0.1, **changes: object) -> Finding:
    return replace(WORSE, varied={"start.x_offset": offset}, current=1.0 + share, **changes)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scenario of six worlds with its baseline."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "line.toml").write_text(SWEPT, encoding="utf-8")
    record(str(folder / "line.toml"), "for a test")
    return folder


@pytest.fixture
def line(recorded: Path, tmp_path: Path) -> Path:
    shutil.copytree(recorded, tmp_path / "own")
    return tmp_path / "own" / "line.toml"


@pytest.fixture
def slower(monkeypatch: pytest.MonkeyPatch) -> None:
    """A weaker gain, as a change of the code would bring it: the scenario stays what it is."""
    real = experiment.run

    def run(scenario, **options):
        laws = tuple(law.model_copy(update={"pole": 0.9 * law.pole}) for law in scenario.controller)
        return real(scenario.model_copy(update={"controller": laws}), **options)

    monkeypatch.setattr(experiment, "run", run)


@pytest.fixture(scope="module")
def grid(recorded):
    return worlds(load(recorded / "line.toml"))


def test_the_worst_come_first(grid):
    findings = [about(0.01, 0.1), about(0.03, 0.3), about(0.02, 0.2)]
    assert failing_worlds(grid, findings) == [3, 2, 1]


def test_a_status_comes_before_any_number(grid):
    status = about(0.05, metric="status", verdict=Verdict.STATUS_CHANGED)
    assert failing_worlds(grid, [about(0.01, 99.0), status]) == [5, 1]


def test_a_world_is_recorded_once_and_only_so_many_are(grid):
    every = [about(offset, metric=metric) for offset in (0.0, 0.01, 0.02, 0.03, 0.04) for metric in "ab"]
    assert failing_worlds(grid, every) == list(range(WORLDS))


def test_what_does_not_fail_is_not_recorded(grid):
    assert failing_worlds(grid, [replace(WORSE, verdict=v) for v in Verdict if not v.failed]) == []


def test_another_seed_is_another_world(grid):
    assert failing_worlds(grid, [replace(WORSE, seed=7)]) == []
    assert failing_worlds(grid, [replace(WORSE, seed=None)]) == [0]


def test_the_mean_of_all_runs_calls_for_none(grid):
    mean = replace(WORSE, varied={}, seed=None, current=99.0, interval=(90.0, 100.0))
    assert failing_worlds(grid, [mean, about(0.03)]) == [3]


def test_a_claim_about_all_worlds_calls_for_the_first(grid):
    claim = replace(WORSE, varied={}, seed=None, claim="x", verdict=Verdict.CLAIM_FAILED)
    assert failing_worlds(grid, [claim]) == [0]


def test_what_failed_is_recorded_now_and_beside_the_baseline(line, slower, tmp_path):
    report = check(str(line))
    assert report.failed
    scenario = load(line)
    made = record_failing(scenario, report.findings, tmp_path / "out", baseline_file(str(line), scenario))
    assert made is not None
    assert made.folder == tmp_path / "out" / "line"
    assert made.notes == ()
    names = sorted(path.name for path in made.folder.iterdir())
    assert len([name for name in names if name.endswith("-against-baseline.rrd")]) == WORLDS
    assert len(names) == 2 * WORLDS
    assert made.command == f"slipctl view {made.folder.as_posix()}"
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["line"]


def test_a_recording_holds_what_the_baseline_held_and_what_is_now(line, slower, tmp_path):
    scenario, path = load(line), baseline_file(str(line), load(line))
    made = record_failing(scenario, [about(0.03)], tmp_path / "out", path)
    assert made is not None
    kept = pq.read_table(
        tracks_file(path), filters=[("world", "=", 3), ("controller", "=", "nominal_kinematic")]
    )
    recording = Recording(made.folder / "x_offset-0_03-against-baseline.rrd")
    _, values = recording.rows("/baseline/nominal_kinematic/error/position", "Scalars:scalars")
    assert values == [float(value) for value in kept["error.position"].to_pylist()]
    _, now = recording.rows("/runs/nominal_kinematic/error/position", "Scalars:scalars")
    result = experiment.run(scenario)  # with the weaker gain
    (run,) = [
        row["run"]
        for row in result.metrics.to_pylist()
        if row["world"] == 3 and row["controller"] == "nominal_kinematic"
    ]
    assert now == result.run_signals(run)["error.position"].to_pylist()
    assert now != values
    assert not any("robust" in entity for entity in recording.entities)
    (store,) = Recording(made.folder / "x_offset-0_03.rrd").reader.recordings()
    assert scenario_id(scenario).removeprefix("sha256:")[:12] in store.recording_id


def test_a_claim_that_failed_shows_every_law_of_its_world(line, slower, tmp_path):
    claim = about(0.02, claim="robust better than nominal", verdict=Verdict.CLAIM_FAILED)
    made = record_failing(load(line), [claim], tmp_path, baseline_file(str(line), load(line)))
    assert made is not None
    entities = Recording(made.folder / "x_offset-0_02-against-baseline.rrd").entities
    for label in ("nominal_kinematic", "robust_kinematic"):
        assert {f"/runs/{label}/trail", f"/baseline/{label}/trail"} <= entities


def test_nothing_is_overwritten(line, tmp_path):
    folders = [record_failing(load(line), [WORSE], tmp_path / "out") for _ in range(3)]
    assert [made and made.folder.name for made in folders] == ["line", "line-2", "line-3"]


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:100])


def other_scenario(path: Path) -> None:
    table = pq.read_table(path)
    pq.write_table(table.replace_schema_metadata({"scenario_id": "sha256:other"}), path)


def no_columns(path: Path) -> None:
    pq.write_table(pa.table({"world": [0]}), path)


def no_rows(path: Path) -> None:
    table = pq.read_table(path)
    pq.write_table(table.slice(0, 0), path)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (Path.unlink, "is not there"),
        (cut, "cannot be read"),
        (other_scenario, "is of another scenario"),
        (no_columns, "cannot be read"),
        (no_rows, "does not hold the run"),
    ],
)
def test_without_tracks_there_is_the_normal_recording_and_one_line(line, tmp_path, damage, said):
    path = baseline_file(str(line), load(line))
    damage(tracks_file(path))
    made = record_failing(load(line), [WORSE, about(0.01)], tmp_path / "out", path, update="this command")
    assert made is not None
    assert sorted(entry.name for entry in made.folder.iterdir()) == ["x_offset-0_0.rrd", "x_offset-0_01.rrd"]
    (note,) = made.notes
    assert said in note
    assert note.endswith("only the recordings of now; the tracks are made by this command")
    assert "\n" not in note


def test_where_nothing_failed_nothing_is_written(line, tmp_path):
    assert record_failing(load(line), [replace(WORSE, verdict=Verdict.SAME)], tmp_path / "out") is None
    assert not (tmp_path / "out").exists()


def test_an_interrupted_recording_leaves_nothing(line, tmp_path, monkeypatch):
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.view.write_recording", stop)
    with pytest.raises(KeyboardInterrupt):
        record_failing(load(line), [WORSE], tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


def test_the_command_opens_what_was_recorded(line, slower, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    opened: list[str] = []
    monkeypatch.setattr("slipctl.view.open_viewer", lambda paths: opened.extend(map(Path.as_posix, paths)))
    assert main(["check", str(line)]) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    command = said.removeprefix("line: look at what failed: ").split()
    assert command == ["slipctl", "view", "runs/check/line"]
    assert main(command[1:]) == 0
    assert opened == sorted(path.as_posix() for path in Path("runs/check/line").glob("*.rrd"))
    assert len(opened) == 2 * WORLDS
