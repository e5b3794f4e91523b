"""Worlds that ended their worker processes are tried once more, and cost nothing if it was the machine."""

from __future__ import annotations

import errno
import json
import os
from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from slipctl.cli import main
from slipctl.experiment import Interrupted, resume, run
from slipctl.experiment.chunk import ENDED, ended_its_process, lost, merged, simulate_chunk
from slipctl.experiment.errors import ResumeError, StillDeadly, StorageError
from slipctl.experiment.executors import Finished, sparing
from slipctl.experiment.executors.in_process import InProcess
from slipctl.experiment.executors.local_workers import LocalWorkers
from slipctl.experiment.plan import Chunk, make_plan
from tests import deadly
from tests.sweeps import WORLDS, moment, parquet_bytes, swept

DEAD = deadly.DEADLY_WORLD


@pytest.fixture(autouse=True)
def three_worlds_a_chunk(monkeypatch):
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 3)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes where no worker dies."""
    return parquet_bytes(swept(tmp_path_factory.mktemp("whole")))


@dataclass(frozen=True)
class Mortal:
    """Gives what workers give, without processes: one world is lost as long as a file is there."""

    mark: Path

    def run(self, setup, todo, files, progress):
        for chunk in todo:
            parts = []
            for world in chunk.worlds:
                alone = Chunk(chunk.index, [world])
                dies = world == DEAD and self.mark.exists()
                parts.append(lost(setup.plan, alone, "2 of them") if dies else simulate_chunk(setup, alone))
            yield Finished(chunk, merged(chunk, parts))


@pytest.fixture
def ill(tmp_path, monkeypatch):
    """Let one world be lost as long as the returned file is there."""
    mark = tmp_path / "ill"
    mark.touch()
    monkeypatch.setattr("slipctl.experiment.runner.choose", lambda *_: Mortal(mark))
    return mark


def set_aside(out: Path, **options) -> Path:
    """Return a run folder in which one world was set aside."""
    result = run(moment(), out=out, **{"record": "none", "keep_going": True, **options})
    assert [entry["world"] for entry in result.failures] == [DEAD] * 2
    assert result.folder is not None
    return result.folder


def content(folder: Path) -> dict[str, bytes]:
    """Return every file of a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("signals", ["all", "sampled", "none"])
def test_a_finished_sweep_is_completed_beside_itself(signals, tmp_path, ill):
    ill.unlink()
    options = {"signals": signals, "record": "worst:2"}
    whole = swept(tmp_path / "whole", **options)
    ill.touch()
    out = tmp_path / "runs"
    left = set_aside(out, **options)
    assert {"plan.json", "manifest.json"} < set(names(left))
    assert "chunks" not in names(left)
    before = content(left)
    ill.unlink()
    again = resume(left)
    assert again.folder is not None
    assert again.folder == out / "moment-2"
    assert (again.failures, again.manifest["resumed"]) == ((), True)
    assert content(left) == before
    assert names(out) == ["moment", "moment-2"]
    assert names(again.folder) == names(whole)
    assert parquet_bytes(again.folder) == parquet_bytes(whole)
    with pytest.raises(ResumeError, match="is finished: there is nothing to go on with"):
        resume(again.folder)


def test_a_retry_that_fails_changes_nothing(tmp_path, ill, capsys):
    left = set_aside(tmp_path / "runs")
    before = content(left)
    with pytest.raises(StillDeadly, match=r"ended them again; .*moment is as it was"):
        resume(left)
    assert names(tmp_path / "runs") == ["moment"]
    assert content(left) == before
    assert main(["sweep", "--resume", str(left), "--json"]) == 3
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == f"worlds that had ended their worker processes ended them again; {left} is as it was\n"


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def without_its_last_run(path: Path) -> None:
    table = pq.read_table(path)
    pq.write_table(table.slice(0, table.num_rows - 1), path)


def backwards(path: Path) -> None:
    table = pq.read_table(path)
    pq.write_table(table.take(list(reversed(range(table.num_rows)))), path)


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("metrics.parquet", Path.unlink),
        ("metrics.parquet", cut),
        ("metrics.parquet", without_its_last_run),
        ("metrics.parquet", backwards),
        ("signals.parquet", Path.unlink),
        ("signals.parquet", cut),
        ("signals.parquet", backwards),
        ("manifest.json", cut),
    ],
)
def test_damaged_results_are_not_copied(name, damage, tmp_path, ill, capsys):
    left = set_aside(tmp_path / "runs")
    damage(left / name)
    before = content(left)
    assert main(["sweep", "--resume", str(left)]) == 2
    said = capsys.readouterr().err
    assert f"{left / name} cannot be read: " in said
    assert "Traceback" not in said
    assert names(tmp_path / "runs") == ["moment"]
    assert content(left) == before


def test_where_nothing_can_be_written_beside_it_that_is_said(tmp_path, ill, capsys, monkeypatch):
    left = set_aside(tmp_path / "runs")

    def forbidden(*_):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("slipctl.experiment.store._new_folder", forbidden)
    assert main(["sweep", "--resume", str(left)]) == 2
    assert capsys.readouterr().err == (
        f"{left} cannot be copied to be gone on with: nothing can be written into {left.parent} "
        f"({os.strerror(errno.EACCES)}); copy the run folder to where that is allowed, and name the copy\n"
    )


def test_what_a_killed_process_left_in_the_run_folder_is_removed(tmp_path, ill, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("slipctl.experiment.store.tidy", lambda folder: None)  # killed before
        left = set_aside(tmp_path / "runs")
    assert "chunks" in names(left)
    with pytest.raises(StillDeadly):
        resume(left)
    assert names(left) == ["manifest.json", "metrics.parquet", "plan.json", "signals.parquet"]


def test_the_steps_of_a_piece_are_those_of_its_worlds():
    scenario = moment(sweep={"duration": [0.2, 0.3, 0.5, 0.7]})
    kept = {"record": "none", "signals": "none", "keep_going": True, "workers": 1}
    plan = make_plan(scenario, {}, worlds=None, **kept)
    assert [plan.steps(chunk) for chunk in plan.chunks()] == [2 * 100, 2 * 70]
    assert [plan.steps(Chunk(0, [world])) for world in range(3)] == [2 * 20, 2 * 30, 2 * 50]
    plan = make_plan(scenario, {}, worlds=[1, 2, 3], **kept)
    assert plan.steps(Chunk(0, [1, 3])) == 2 * 100


@pytest.mark.parametrize("well", [True, False])
def test_going_on_with_an_unfinished_sweep_tries_them_again(well, tmp_path, ill, whole):
    def stop(done, total, text):
        if text.startswith(f"world {DEAD} "):  # the first of its chunk, which is on the disk
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as stopped:
        run(moment(), out=tmp_path / "runs", record="none", progress=stop)
    left = stopped.value.folder
    before = content(left)
    if well:
        ill.unlink()
        asked = []
        result = resume(left, progress=lambda done, total, text: asked.append((done, total, text)))
        assert result.folder is not None
        assert result.failures == ()
        assert parquet_bytes(result.folder) == whole
        done, total, text = asked[-1]
        assert (done, text) == (total, f"world {DEAD + 1} to {DEAD + 1} of {WORLDS}")
    else:
        assert before
        result = resume(left)
        assert [entry["world"] for entry in result.failures] == [DEAD] * 2
    assert names(tmp_path / "runs") == ["moment"]


def test_what_a_run_raised_stands(tmp_path, ill, whole, monkeypatch):
    from slipctl.experiment import retry

    left = set_aside(tmp_path / "runs")
    # as if another run had raised, which no worker of these tests does
    told = json.loads((left / "manifest.json").read_text(encoding="utf-8"))
    raised = {**told["failures"][0], "world": 7, "failure": "ValueError: planted (law.py:1)"}
    told["failures"].append(raised)
    (left / "manifest.json").write_text(json.dumps(told), encoding="utf-8")
    table = pq.read_table(left / "metrics.parquet")
    statuses = table["status"].to_pylist()
    statuses[14] = "failed"
    place = table.schema.get_field_index("status")
    pq.write_table(table.set_column(place, table.schema.field(place), [statuses]), left / "metrics.parquet")
    tried = []
    original = retry.put_in

    def seen(plan, store, again):
        tried.append(list(again.chunk.worlds))
        return original(plan, store, again)

    monkeypatch.setattr("slipctl.experiment.runner.put_in", seen)
    ill.unlink()
    again = resume(left)
    assert tried == [[DEAD]]
    assert [entry["failure"] for entry in again.failures] == [raised["failure"]]
    assert again.failures[0]["world"] == 7
    assert again.folder is not None
    assert not (again.folder / "plan.json").exists()
    for name in ("ValueError: ended 2", "OSError", None):
        assert not ended_its_process(name)
    assert ended_its_process(f"{ENDED}2 worker processes")


def test_interrupted_at_any_moment_the_finished_sweep_stays(tmp_path, ill, whole):
    out = tmp_path / "runs"
    left = set_aside(out)
    before = content(left)
    ill.unlink()

    def stop(done, total, text):
        raise KeyboardInterrupt

    with pytest.raises(Interrupted) as stopped:
        resume(left, progress=stop)
    assert stopped.value.folder == out / "moment.unfinished"
    assert content(left) == before
    folder = resume(stopped.value.folder).folder
    assert folder is not None
    assert folder == out / "moment-2"
    assert parquet_bytes(folder) == whole
    assert content(left) == before


def test_a_full_disk_at_any_moment_leaves_the_finished_sweep(tmp_path, ill, whole, monkeypatch):
    out = tmp_path / "runs"
    left = set_aside(out)
    before = content(left)
    ill.unlink()
    flush, calls, fails_at = os.fsync, 0, 0

    def counted(descriptor):
        nonlocal calls
        calls += 1
        if calls == fails_at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        flush(descriptor)

    monkeypatch.setattr("slipctl.experiment.durable.os.fsync", counted)
    copying = 2 * 2 * 4  # a file and its folder, of rows and of signals, of four chunks
    for fails_at in (1, 3, copying, copying + 2, copying + 4):
        calls = 0
        with pytest.raises(StorageError) as said:
            resume(left)
        assert content(left) == before
        if (out / "moment.unfinished").exists():
            assert fails_at > copying
            assert f"--resume {out / 'moment.unfinished'}" in str(said.value)
            fails_at = 0
            folder = resume(out / "moment.unfinished").folder
            assert folder is not None
            assert parquet_bytes(folder) == whole
        else:
            assert fails_at <= copying + 2
            assert "disk" in str(said.value)
            assert "--resume" not in str(said.value)


def test_real_workers_that_die_while_the_machine_is_ill(tmp_path, whole, monkeypatch):
    mark = tmp_path / "ill"
    mark.touch()
    monkeypatch.setenv(deadly.MARK, str(mark))
    workers = LocalWorkers(2, simulate=deadly.die_while_ill)
    monkeypatch.setattr("slipctl.experiment.runner.choose", lambda *_: workers)
    left = set_aside(tmp_path / "runs")
    before = content(left)
    with pytest.raises(StillDeadly):
        resume(left)
    mark.unlink()
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole
    assert content(left) == before


def test_the_command_says_how_to_try_again_and_does_it_in_a_worker(tmp_path, ill, whole, capsys, monkeypatch):
    left = set_aside(tmp_path / "runs")
    from slipctl.cli.outcome import report
    from slipctl.experiment.result import Result

    manifest = json.loads((left / "manifest.json").read_text(encoding="utf-8"))
    result = Result(
        left,
        pq.read_table(left / "metrics.parquet"),
        manifest,
        ("slip.longitudinal", "seed"),
        "",
        "",
        tuple(manifest["failures"]),
    )
    assert report(result, json_output=False, quiet=True) == 0
    assert capsys.readouterr().err.splitlines()[-1] == (
        "1 world ended its worker processes; if the machine was to blame, put that right and try again: "
        f"slipctl sweep --resume {left}"
    )
    monkeypatch.undo()  # the workers of this package, one process asked for
    assert main(["sweep", "--resume", str(left), "--quiet"]) == 0
    assert parquet_bytes(tmp_path / "runs" / "moment-2") == whole


def test_a_world_that_may_end_its_process_is_never_in_this_one():
    assert sparing(InProcess(3)) == LocalWorkers(1, 3)
    assert sparing(InProcess()) == LocalWorkers(1, os.cpu_count())
    two = LocalWorkers(2)
    assert sparing(two) is two
