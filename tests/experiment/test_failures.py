"""Worlds that diverge, raise or end their process: the rest goes on, and what failed can be run again."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from slipctl.cli import main
from slipctl.cli.exits import Exit, explain
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.experiment import chunk as chunks
from slipctl.experiment import resume, run
from slipctl.experiment.assemble import read_robot
from slipctl.experiment.batch import run_batch
from slipctl.experiment.errors import ResumeError, WorkerError
from slipctl.experiment.executors.local_workers import LocalWorkers
from slipctl.experiment.executors.suspects import Suspects
from slipctl.experiment.own import KnownRobot
from slipctl.experiment.plan import make_plan
from slipctl.experiment.replay import replay_command, scenario_of
from slipctl.metrics import UNITS
from slipctl.theory.robust import chain_gains
from tests import deadly
from tests.fakes import SHORT_SCENARIO
from tests.sweeps import ON_MUJOCO, WORLDS, moment, parquet_bytes, swept


@pytest.fixture
def broken(monkeypatch):
    """Make some runs raise; returns the set of (world, place of the controller) that do."""
    bad: set[tuple[int, int]] = set()

    def raising(grid, indices, robot, threads, progress, laws=None, *, positions, **options):
        places = iter(positions)
        runs = run_batch(grid, indices, robot, threads, progress, laws, positions=positions, **options)
        while True:
            place = next(places, None)
            if any((world, place) in bad for world in indices):
                raise ValueError(f"planted\nin {min(world for world in indices if (world, place) in bad)}")
            finished = next(runs, None)
            if finished is None:
                return
            yield finished

    monkeypatch.setattr(chunks, "run_batch", raising)
    return bad


def rows(folder: Path) -> list[dict]:
    return pq.read_table(folder / "metrics.parquet").to_pylist()


@pytest.mark.parametrize("tables", [{}, ON_MUJOCO], ids=["ode", "mujoco"])
def test_a_run_that_raises_is_found_and_the_rest_goes_on(tables, tmp_path, broken):
    scenario = moment(**tables)
    whole = rows(swept(tmp_path, scenario))
    signals = pq.read_table(tmp_path / "moment" / "signals.parquet")
    broken |= {(1, 0), (4, 1), (5, 0), (5, 1)}
    result = run(scenario, out=tmp_path, record="none", keep_going=True)
    assert result.folder is not None
    failed = [3 - 1, 9, 10, 11]
    for before, now in zip(whole, rows(result.folder), strict=True):
        if now["run"] not in failed:
            assert now == before
            continue
        assert now["status"] == "failed"
        assert {now[name] for name in (*UNITS, "end_time", "first_violation")} == {None}
        for name in ("run", "world", "controller", "kind", "seed", *result.varied):
            assert now[name] == before[name]
    kept = pq.read_table(result.folder / "signals.parquet")
    assert kept.equals(signals.filter([run not in failed for run in signals["run"].to_pylist()]))
    assert [(entry["world"], entry["controller"]) for entry in result.failures] == [
        (1, "nominal_kinematic"),
        (4, "robust_kinematic"),
        (5, "nominal_kinematic"),
        (5, "robust_kinematic"),
    ]
    assert all("ValueError: planted in" in entry["failure"] for entry in result.failures)
    assert all(" (test_failures.py:" in entry["failure"] for entry in result.failures)
    assert all(" < chunk.py:" in entry["failure"] for entry in result.failures)
    manifest = json.loads((result.folder / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["failures"] == list(result.failures)
    assert manifest["statuses"]["failed"] == 4


def test_what_raises_ends_the_experiment_unless_told_to_go_on(tmp_path, broken):
    broken.add((4, 1))
    with pytest.raises(ValueError, match="planted"):
        run(moment())
    with pytest.raises(ValueError, match="planted"):
        run(moment(), out=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_what_was_finished_before_a_defect_is_kept(tmp_path, broken, monkeypatch):
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 3)
    broken.add((7, 0))
    with pytest.raises(ValueError, match="planted") as said:
        run(moment(), out=tmp_path)
    left = tmp_path / "moment.unfinished"
    assert said.value.__notes__ == [f"what is finished is kept; go on: slipctl sweep --resume {left}"]
    assert len(list(left.glob("chunks/*.arrow"))) == 2


@pytest.mark.parametrize("lacking", [MemoryError("planted"), OSError(24, "Too many open files")])
def test_what_the_machine_lacks_is_not_said_of_the_worlds(lacking, tmp_path, monkeypatch, capsys):
    whole = swept(tmp_path / "whole")
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 3)

    def short_of(grid, indices, *rest, **options):
        if 7 in indices:
            raise lacking
        return run_batch(grid, indices, *rest, **options)

    left = tmp_path / "moment.unfinished"
    with monkeypatch.context() as patch:
        patch.setattr(chunks, "run_batch", short_of)
        with pytest.raises(WorkerError, match="worlds 6 to 8 could not be simulated on this machine") as said:
            run(moment(), out=tmp_path, record="none", keep_going=True)
    assert explain(said.value) == Exit.NOT_JUDGED
    assert f"go on: slipctl sweep --resume {left}" in capsys.readouterr().err
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == parquet_bytes(whole)


def test_the_command_says_what_failed_and_how_to_run_it_again(tmp_path, broken, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    broken.add((1, 0))
    Path("short.toml").write_text(SHORT_SCENARIO, encoding="utf-8")
    arguments = ["sweep", "short.toml", "--over", "seed=1,2,3", "--record", "none", "--json"]
    assert main(arguments) == 0
    said = capsys.readouterr()
    statuses = [entry["status"] for entry in json.loads(said.out)["runs"]]
    assert statuses.count("failed") == 1
    folder = Path("runs/short")
    lines = said.err.splitlines()
    assert lines[0].endswith("runs ended early: 1 failed")
    assert lines[1].startswith("world 1 (")
    assert "failed: ValueError: planted in 1" in lines[1]
    assert lines[2] == f"  run it alone: slipctl run {folder} --world 1"
    assert main(["run", str(folder), "--world", "1", "--json"]) == 3
    said_alone = capsys.readouterr()
    assert said_alone.out == ""
    assert "Traceback" in said_alone.err
    assert "raise ValueError" in said_alone.err
    assert [path.name for path in Path("runs").iterdir()] == ["short"]
    broken.clear()
    assert main(["run", str(folder), "--world", "1", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["scenario_id"] == json.loads(said.out)["scenario_id"]
    assert {entry["status"] for entry in again["runs"]} == {"completed"}
    assert {entry["varied"]["seed"] for entry in again["runs"]} == {2}
    assert {Path(entry["recording"]).exists() for entry in again["runs"]} == {True}


def test_where_every_run_fails_nothing_can_be_judged(tmp_path, broken, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    broken |= {(0, 0), (1, 0)}
    Path("short.toml").write_text(SHORT_SCENARIO, encoding="utf-8")
    assert main(["sweep", "short.toml", "--over", "seed=1,2", "--json"]) == 3
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines()[-1] == "no run could be simulated"
    manifest = json.loads(Path("runs/short/manifest.json").read_text(encoding="utf-8"))
    assert manifest["statuses"] == {"failed": 2}


@pytest.mark.parametrize("record", ["failed", "all", "auto", "worst:5"])
def test_recordings_that_are_said_to_be_there_are_there(record, tmp_path, broken):
    broken |= {(1, 0), (1, 1), (2, 0)}
    result = run(moment(), out=tmp_path, record=record, keep_going=True)
    assert result.folder is not None
    written = {path.name for path in result.folder.glob("*.rrd")}
    assert written == {name for name in result.metrics["recording"].to_pylist() if name}
    assert result.recording_note.startswith(
        f"{len(written)} recording{'s' * (len(written) != 1)} of {WORLDS} "
    )
    assert len(written) == {"failed": 1, "worst:5": 5}.get(record, WORLDS - 1)
    assert result.recording_note.endswith("; nothing to show of 1 whose every run failed")


def test_a_world_of_a_run_folder_is_replayed_bit_for_bit(tmp_path):
    scenario = moment(**ON_MUJOCO)
    folder = swept(tmp_path, scenario, signals="sampled")
    assert scenario_of(folder) == scenario
    assert replay_command(folder, 3) == f"slipctl run {folder} --world 3"
    again = run(scenario_of(folder), out=tmp_path, worlds=[3])
    assert again.metrics.drop_columns(["recording"]).to_pylist() == [
        {key: value for key, value in row.items() if key != "recording"} for row in rows(folder)[6:8]
    ]
    everything = run(scenario)
    assert again.run_signals(7).equals(everything.run_signals(7))


def test_a_replay_of_what_has_changed_is_refused(tmp_path):
    folder = swept(tmp_path)
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    manifest["scenario_given"]["tick"] = 0.02
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    with pytest.raises(ResumeError, match="is of another scenario"):
        scenario_of(folder)
    with pytest.raises(ResumeError, match="is no run folder"):
        scenario_of(tmp_path)


def test_a_world_that_ends_early_has_a_status_and_the_others_are_the_same(tmp_path):
    before = rows(swept(tmp_path, moment(sweep={"plant.arena": [50.0, 40.0]})))
    now = rows(swept(tmp_path, moment(sweep={"plant.arena": [50.0, 0.1, 40.0]}), keep_going=True))
    assert [row["status"] for row in now] == [*["completed"] * 2, *["left_the_arena"] * 2, *["completed"] * 2]
    assert {row["status"] for row in before} == {"completed"}
    numbers = [name for name in now[0] if name not in ("run", "world")]
    for old, new in ((0, 0), (1, 1), (2, 4), (3, 5)):
        assert [before[old][name] for name in numbers] == [now[new][name] for name in numbers]


@pytest.fixture
def workers(monkeypatch):
    """Let two local workers do with chunks what the returned function is told."""

    def choose(simulate):
        monkeypatch.setattr("slipctl.experiment.runner.choose", lambda *_: LocalWorkers(2, simulate=simulate))
        monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 3)

    return choose


@pytest.mark.parametrize("to_disk", [True, False])
def test_a_worker_that_dies_once_costs_nothing(to_disk, tmp_path, workers, monkeypatch):
    scenario = moment()
    whole = swept(tmp_path, scenario)
    mark = tmp_path / "mark"
    monkeypatch.setenv(deadly.MARK, str(mark))
    workers(deadly.die_once)
    if to_disk:
        assert parquet_bytes(swept(tmp_path, scenario)) == parquet_bytes(whole)
    else:
        result = run(scenario)
        assert result.metrics.to_pylist() == rows(whole)
        assert result.signals.equals(pq.read_table(whole / "signals.parquet"))
    assert mark.exists()


def test_a_chunk_that_always_ends_its_worker_is_reported_and_the_rest_goes_on(tmp_path, workers):
    scenario = moment()
    whole = rows(swept(tmp_path, scenario))
    workers(deadly.die_always)
    result = run(scenario, out=tmp_path, record="none")
    assert result.folder is not None
    dead = range(deadly.DEADLY * 3, deadly.DEADLY * 3 + 3)
    for before, now in zip(whole, rows(result.folder), strict=True):
        if now["world"] in dead:
            assert now["status"] == "failed"
        else:
            assert now == before
    assert len(whole) == 2 * WORLDS
    assert [entry["world"] for entry in result.failures] == [world for world in dead for _ in range(2)]
    assert {entry["failure"] for entry in result.failures} == {
        "ended 2 worker processes, alone in each (with exit status 9)"
    }


@pytest.mark.parametrize("to_disk", [True, False])
def test_a_world_that_ends_its_worker_takes_no_other_with_it(to_disk, tmp_path, workers):
    scenario = moment()
    whole = swept(tmp_path, scenario)
    workers(deadly.die_of_one_world)
    result = run(scenario, out=tmp_path if to_disk else None, record="none")
    assert [entry["world"] for entry in result.failures] == [deadly.DEADLY_WORLD] * 2
    alive = [row["world"] != deadly.DEADLY_WORLD for row in rows(whole)]
    before = pq.read_table(whole / "metrics.parquet").filter(alive)
    assert result.metrics.filter(alive).to_pylist() == before.to_pylist()
    signals = pq.read_table(whole / "signals.parquet")
    places = [run // 2 != deadly.DEADLY_WORLD for run in signals["run"].to_pylist()]
    kept = pq.read_table(result.folder / "signals.parquet") if result.folder else result.signals
    assert kept.equals(signals.filter(places))


def test_pieces_are_halved_until_the_deadly_worlds_are_alone():
    plan = make_plan(moment(), {}, record="none", signals="none", worlds=None, keep_going=True, workers=1)
    robot = read_robot(plan.scenario)
    (chunk,) = plan.chunks()
    deadly_ones, suspects, starts = {2, 3, 11}, Suspects(plan), 0
    waiting, whole = [chunk], None
    while waiting:
        piece = waiting.pop()
        starts += 1
        if deadly_ones & set(piece.worlds):
            waiting += suspects.ended(piece, "planted")
        else:
            suspects.done(piece, chunks.simulate_chunk(chunks.Setup(plan, robot), piece))
        whole = suspects.finished(chunk.index)
    assert whole is not None
    assert whole.output is not None
    told = whole.output.metrics.to_pylist()
    assert [row["run"] for row in told] == list(range(2 * WORLDS))
    assert {row["world"] for row in told if row["status"] == "failed"} == deadly_ones
    assert starts <= 2 + 2 * 3 * 4 + 3


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"workers": 0}, "workers: found 0, allowed are whole numbers from 1"),
        ({"workers": 1.5}, "workers: found 1.5"),
        ({"threads": 0}, "threads: found 0"),
        ({"threads": True}, "threads: found True"),
        ({"dask": ""}, "dask: found ''"),
        ({"dask": "tcp://host:8786", "workers": 2}, "workers and dask: give one of them"),
    ],
)
def test_processes_that_cannot_be_are_refused_before_anything_is_written(options, said, tmp_path):
    with pytest.raises(ValueError, match=said):
        run(moment(), out=tmp_path, **options)
    assert list(tmp_path.iterdir()) == []


def mine(known: KnownRobot) -> NominalKinematic:
    return NominalKinematic(known.speed_drive(), chain_gains(np.full(known.worlds, -2.0), 2))


def test_own_laws_stay_in_this_process():
    with pytest.raises(WorkerError, match=r"own laws \(mine\) run in this process only"):
        run(moment(), workers=2, laws={"mine": mine})
