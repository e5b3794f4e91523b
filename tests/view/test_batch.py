"""Many recordings: the same files whether this process writes them or workers do."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from slipctl.shape import Shape
from slipctl.view import RecordingError, RunInfo, Theorem, WorldRecording, batch, write_recordings
from tests.view.reading import Recording, rrd
from tests.view.signals import join, signals

TABLE = join(*(signals(run, duration=0.5) for run in range(4)))
SHAPES = [Shape("base", "sphere", np.array([0.1, 0, 0]), np.zeros(3), np.array([1.0, 0, 0, 0]), np.ones(4))]

ROOT = Path(__file__).resolve().parents[2]


def worlds(count: int) -> list[WorldRecording]:
    return [
        WorldRecording(
            f"friction-{world}.rrd",
            tuple(
                RunInfo(
                    2 * world + place,
                    label,
                    label,
                    metrics={"rms": np.float64(0.5), "guarantee_fraction": np.float64(1.0)},
                    slip_bound=0.4,
                    theorem=Theorem("independent", 0.4, 0.05),
                    guarantee=dict.fromkeys(("error_bound", "alarm_time")),
                )
                for place, label in enumerate(("nominal", "robust"))
            ),
            {"scenario": "sweep", "varied": {"ground.friction": np.float64(world)}, "seed": np.int64(3)},
        )
        for world in range(count)
    ]


def test_workers_write_what_this_process_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pq.write_table(TABLE, tmp_path / "signals.parquet")
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    seen: list[tuple[int, int]] = []
    first = write_recordings(here, TABLE, worlds(2), SHAPES)
    monkeypatch.setattr(batch, "IN_PROCESS", 1)
    before = threading.active_count()
    second = write_recordings(
        there,
        tmp_path / "signals.parquet",
        worlds(2),
        SHAPES,
        threads=2,
        progress=lambda *now: seen.append(now),
    )
    assert threading.active_count() == before
    assert [path.name for path in second] == ["friction-0.rrd", "friction-1.rrd"]
    for one, other in zip(first, second, strict=True):
        assert rrd("compare", one, other) == 0
    assert rrd("compare", *second) == 1
    assert seen[-1] == (2, 2)
    assert sorted(path.name for path in there.iterdir()) == ["friction-0.rrd", "friction-1.rrd"]


def test_each_world_gets_its_own_runs(tmp_path: Path) -> None:
    pq.write_table(TABLE, tmp_path / "signals.parquet")
    _, second = write_recordings(tmp_path, tmp_path / "signals.parquet", worlds(2), None)
    _, values = Recording(second).rows("/runs/robust/error/position", "Scalars:scalars")
    expected = signals(3, duration=0.5)["error.position"].to_pylist()
    assert values == expected


def test_row_groups_are_read_once_wherever_they_cut_the_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = len(TABLE) // 4
    pq.write_table(TABLE, tmp_path / "signals.parquet", row_group_size=rows + 7)
    read: list[int] = []
    original = pq.ParquetFile.read_row_group

    def counted(file: pq.ParquetFile, group: int) -> pa.Table:
        read.append(group)
        return original(file, group)

    monkeypatch.setattr(pq.ParquetFile, "read_row_group", counted)
    (tmp_path / "file").mkdir()
    (tmp_path / "table").mkdir()
    one = write_recordings(tmp_path / "file", tmp_path / "signals.parquet", worlds(2), SHAPES)
    assert read == [0, 1, 2, 3]  # the second ends in the third run, which is of the other world
    other = write_recordings(tmp_path / "table", TABLE, worlds(2), SHAPES)
    assert [rrd("compare", *pair) for pair in zip(one, other, strict=True)] == [0, 0]


def test_a_file_that_does_not_say_where_runs_are_is_read_whole(tmp_path: Path) -> None:
    pq.write_table(TABLE, tmp_path / "signals.parquet", row_group_size=30, write_statistics=False)
    (tmp_path / "table").mkdir()
    backwards = worlds(2)[::-1]
    one = write_recordings(tmp_path, tmp_path / "signals.parquet", backwards, SHAPES)
    other = write_recordings(tmp_path / "table", TABLE, backwards, SHAPES)
    assert [rrd("compare", *pair) for pair in zip(one, other, strict=True)] == [0, 0]


@pytest.mark.parametrize(("count", "shares"), [(4, [2, 2]), (7, [3, 3, 1])])
def test_workers_get_equal_shares_but_no_more_than_a_process_may(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int, shares: list[int]
) -> None:
    given: list[int] = []
    monkeypatch.setattr(batch, "IN_PROCESS", 3)
    monkeypatch.setattr(batch, "PER_WORKER", 3)
    monkeypatch.setattr(batch, "_work", lambda jobs, *_: given.extend(size for _, size in jobs))
    write_recordings(tmp_path, TABLE, worlds(count), SHAPES, threads=2)
    assert given == shares


def test_a_recording_of_the_caller_s_own_goes_on(tmp_path: Path) -> None:
    """Rerun's clean-up ends whatever no Python object holds, the global recording among it."""
    code = (
        "import sys, rerun as rr\n"
        "rr.init('own', recording_id='own')\n"
        "memory = rr.memory_recording()\n"
        "from pathlib import Path\n"
        "from tests.view.test_batch import TABLE, worlds, write_recordings\n"
        "write_recordings(Path(sys.argv[1]), TABLE, worlds(2))\n"
        "rr.log('still/there', rr.TextLog('here'))\n"
        "sys.exit(rr.get_recording_id() != 'own' or b'still/there' not in memory.drain_as_bytes())\n"
    )
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path)], cwd=ROOT, check=False).returncode == 0


TASKS = Path("/proc/self/task")


@pytest.mark.skipif(not TASKS.exists(), reason="the system does not list a process's threads")
def test_a_recording_leaves_no_more_than_four_threads_and_a_worker_half(tmp_path: Path) -> None:
    write_recordings(tmp_path, TABLE, worlds(2), SHAPES)
    before = len(list(TASKS.iterdir()))
    for _ in range(5):
        write_recordings(tmp_path, TABLE, worlds(2), SHAPES)
    assert len(list(TASKS.iterdir())) - before <= 4 * 10
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from slipctl.view.recording import end_threads\n"
        "from tests.view.test_batch import TABLE, TASKS, worlds, write_recordings\n"
        "write_recordings(Path(sys.argv[1]), TABLE, worlds(1))\n"
        "before = len(list(TASKS.iterdir()))\n"
        "for _ in range(5):\n"
        "    write_recordings(Path(sys.argv[1]), TABLE, worlds(2))\n"
        "end_threads()\n"
        "print(len(list(TASKS.iterdir())) - before)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    left = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert int(left) <= 2 * 10 + 2  # those of the last one may be about to end


def test_a_worker_s_complaint_is_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "IN_PROCESS", 1)
    with pytest.raises(RecordingError, match="no rows of run 4"):
        write_recordings(tmp_path, TABLE, worlds(3), SHAPES, threads=1)
    assert all(path.suffix == ".rrd" for path in tmp_path.iterdir())


def test_what_workers_say_does_not_hold_them_up(tmp_path: Path) -> None:
    """Rerun says a lot where the environment asks for it: more than a pipe holds that nobody reads."""
    code = (
        "import os, sys\n"
        "from pathlib import Path\n"
        "from tests.view.test_batch import TABLE, batch, worlds, write_recordings\n"
        "batch.IN_PROCESS = 1\n"
        "write_recordings(Path(sys.argv[1]), TABLE, 12 * worlds(2), threads=1)\n"
    )
    environment = {**os.environ, "RUST_LOG": "trace"}
    command = [sys.executable, "-c", code, str(tmp_path)]
    assert subprocess.run(command, cwd=ROOT, env=environment, timeout=60, check=False).returncode == 0


def test_a_worker_ends_with_the_process_that_waits_for_it(tmp_path: Path) -> None:
    pq.write_table(TABLE, tmp_path / "signals.parquet")
    many = [WorldRecording(f"{k}.rrd", worlds(1)[0].runs, worlds(1)[0].info) for k in range(400)]
    job = tmp_path / "job.json"
    job.write_text(batch._encode(tmp_path, tmp_path / "signals.parquet", many, None), encoding="utf-8")
    command = [sys.executable, "-m", "slipctl.view", str(job)]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE) as worker:
        assert worker.stdin is not None
        worker.stdin.close()  # as the system does where the other end was killed
        assert worker.wait(60) != 0
    assert len(list(tmp_path.glob("*.rrd"))) < len(many)


def test_nothing_is_left_beside_the_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pq.write_table(TABLE, tmp_path / "signals.parquet")
    folder = tmp_path / "folder"
    folder.mkdir()
    monkeypatch.setattr(batch, "IN_PROCESS", 1)
    seen: list[str] = []

    def killed(*_: object) -> None:
        seen.extend(path.name for path in folder.iterdir())  # all that a killed process would leave
        (folder / "friction-1.rrd.part").write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(batch, "_work", killed)
    with pytest.raises(KeyboardInterrupt):
        write_recordings(folder, tmp_path / "signals.parquet", worlds(2))
    assert seen == []
    assert list(folder.iterdir()) == []


def test_workers_import_what_this_process_imports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rerun.py").write_text("raise SystemExit('a file of the user')", encoding="utf-8")
    monkeypatch.setattr(batch, "IN_PROCESS", 1)
    monkeypatch.chdir(tmp_path)
    assert all(path.is_file() for path in write_recordings(tmp_path, TABLE, worlds(2), threads=1))


def test_the_signals_are_closed_where_a_recording_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pq.write_table(TABLE, tmp_path / "signals.parquet")
    opened: list[pq.ParquetFile] = []
    original = pq.ParquetFile.read_row_group

    def noted(file: pq.ParquetFile, group: int) -> pa.Table:
        opened.append(file)
        return original(file, group)

    monkeypatch.setattr(pq.ParquetFile, "read_row_group", noted)
    with pytest.raises(RecordingError) as failure:  # it holds the frames, and what they hold
        write_recordings(tmp_path, tmp_path / "signals.parquet", worlds(3), SHAPES)
    assert "no rows of run 4" in str(failure.value)
    assert all(file.closed for file in opened)
    assert opened
