"""Interrupted, killed, out of disk: what is finished is kept, and going on ends in the same bytes."""

from __future__ import annotations

import errno
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from slipctl import scenario as files
from slipctl.cli import main
from slipctl.experiment import Interrupted, resume, run
from slipctl.experiment.errors import ResumeError, StorageError
from slipctl.experiment.folder import OutputError
from slipctl.experiment.machine import SOURCE
from slipctl.experiment.plan import Chunk
from slipctl.experiment.store import CHECKSUM, Store, checksum
from tests.sweeps import WORLDS, moment, parquet_bytes, swept

KILLS = int(os.environ.get("SLIPCTL_TEST_KILLS", "2"))
"""How often a sweep is killed at a random moment."""

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def two_worlds_a_chunk(monkeypatch):
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 2)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes without an interruption."""
    return parquet_bytes(swept(tmp_path_factory.mktemp("whole")))


def stop_after(share: float, error: type[BaseException] = KeyboardInterrupt):
    def progress(done: int, total: int, text: str) -> None:
        if done > share * total:
            raise error

    return progress


def interrupted(out: Path, share: float = 0.6, **options) -> Path:
    """Interrupt a sweep and return the unfinished folder."""
    with pytest.raises(Interrupted) as stop:
        run(moment(), out=out, **{"record": "none", **options}, progress=stop_after(share))
    assert 0 < stop.value.done < stop.value.total == WORLDS
    return stop.value.folder


def signed(path: Path, content: dict) -> None:
    """Write a plan file as if it had been begun so."""
    path.write_text(json.dumps({**content, CHECKSUM: checksum(content)}), encoding="utf-8")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_ctrl_c_keeps_finished_chunks_and_resume_ends_in_the_same_bytes(tmp_path, whole):
    left = interrupted(tmp_path)
    assert names(tmp_path) == ["moment.unfinished"]
    assert len(list((left / "chunks").glob("*.arrow"))) == 3
    finished = resume(left)
    folder = finished.folder
    assert folder is not None
    assert folder == tmp_path / "moment"
    assert finished.manifest["resumed"]
    assert not run(moment()).manifest["resumed"]
    assert names(tmp_path) == ["moment"]
    assert names(folder) == ["manifest.json", "metrics.parquet", "signals.parquet"]
    assert parquet_bytes(folder) == whole


def test_finished_chunks_are_not_simulated_again(tmp_path, whole, monkeypatch):
    left = interrupted(tmp_path)
    from slipctl.experiment.executors import in_process

    asked = []
    original = in_process.simulate_chunk

    def counted(setup, chunk, *rest):
        asked.append(chunk.index)
        return original(setup, chunk, *rest)

    monkeypatch.setattr(in_process, "simulate_chunk", counted)
    folder = resume(left).folder
    assert folder is not None
    assert asked == [3, 4, 5]
    assert parquet_bytes(folder) == whole


def test_it_can_be_interrupted_again_and_again(tmp_path, whole):
    left = interrupted(tmp_path, 0.2)
    for share in (0.4, 0.7, 0.9):
        with pytest.raises(Interrupted) as stop:
            resume(left, progress=stop_after(share))
        assert stop.value.folder == left
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_the_rest_may_be_done_by_others(tmp_path, whole):
    folder = resume(interrupted(tmp_path, 0.3), workers=2).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_manifests_are_equal_but_for_the_time(tmp_path):
    manifests = []
    for folder in (swept(tmp_path / "a", record="worst:1"), resume(interrupted(tmp_path / "b")).folder):
        assert folder is not None
        manifests.append(json.loads((folder / "manifest.json").read_text(encoding="utf-8")))
        for key in ("finished", "wall_time", "resumed", "recordings"):
            del manifests[-1][key]
    assert manifests[0] == manifests[1]


def test_an_interruption_before_the_first_chunk_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt) as stop:
        run(moment(), out=tmp_path, progress=stop_after(-1.0))
    assert not isinstance(stop.value, Interrupted)
    assert names(tmp_path) == []


def test_going_on_never_removes_the_folder(tmp_path, whole, monkeypatch):
    left = interrupted(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(Store, "metrics", lambda *_: None)
        with pytest.raises(Interrupted):  # before the first chunk of this time, and with every chunk unread
            resume(left, progress=stop_after(-1.0))
    for path in (left / "chunks").iterdir():
        path.unlink()
    with pytest.raises(Interrupted) as stop:
        resume(left, progress=stop_after(-1.0))
    assert (stop.value.done, names(tmp_path)) == (0, ["moment.unfinished"])
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_a_disk_that_cannot_be_read_is_not_an_empty_one(tmp_path, whole, monkeypatch):
    left = interrupted(tmp_path)
    before = names(left / "chunks")

    def failing(path):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_bytes", failing)
        with pytest.raises(OSError, match=os.strerror(errno.EIO)) as said:
            resume(left)
    assert said.value.__notes__ == [f"what is finished is kept; go on: slipctl sweep --resume {left}"]
    assert names(left / "chunks") == before
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_unfinished_folders_are_never_overwritten(tmp_path, whole):
    first, second = interrupted(tmp_path), interrupted(tmp_path)
    assert (first.name, second.name) == ("moment.unfinished", "moment.unfinished-2")
    folders = [resume(second).folder, resume(first).folder]
    assert folders == [tmp_path / "moment", tmp_path / "moment-2"]
    assert all(parquet_bytes(folder) == whole for folder in folders if folder is not None)


def test_an_interruption_while_recordings_are_written(tmp_path, whole, monkeypatch):
    from slipctl.experiment import conclude

    original = conclude.record_worlds

    def stopped(folder, *rest):
        (folder / "half.rrd").write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(conclude, "record_worlds", stopped)
    with pytest.raises(Interrupted) as stop:
        run(moment(), out=tmp_path, record="worst:1")
    assert stop.value.done == stop.value.total == WORLDS
    monkeypatch.setattr(conclude, "record_worlds", original)
    folder = resume(stop.value.folder).folder
    assert folder is not None
    recordings = [path.name for path in folder.glob("*.rrd")]
    assert len(recordings) == 1
    assert recordings != ["half.rrd"]
    signals = parquet_bytes(folder)["signals.parquet"]
    assert signals == whole["signals.parquet"]


def test_recordings_that_fail_are_a_note_not_the_loss_of_the_results(tmp_path, whole, monkeypatch, capsys):
    from slipctl.experiment import conclude

    def failing(folder, *rest):
        table = pq.read_table(folder / "metrics.parquet")
        assert table.num_rows == 2 * WORLDS
        (folder / "half.rrd").write_bytes(b"half")
        raise RuntimeError("planted")

    monkeypatch.setattr(conclude, "record_worlds", failing)
    result = run(moment(), out=tmp_path, record="worst:1")
    assert result.folder is not None
    assert names(result.folder) == ["manifest.json", "metrics.parquet", "signals.parquet"]
    assert parquet_bytes(result.folder) == whole
    told = json.loads((result.folder / "manifest.json").read_text(encoding="utf-8"))
    assert told["recordings"] == "no recordings: writing them failed (RuntimeError: planted)"
    assert capsys.readouterr().err == told["recordings"] + "\n"


def full(*arguments):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_disk_that_is_full_at_any_moment_loses_nothing(tmp_path, whole, monkeypatch):
    """Let each flush to the disk in turn find it full; then make room and go on."""
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 6)
    flush = os.fsync
    calls = 0

    def counted(descriptor):
        nonlocal calls
        calls += 1
        if calls == fails_at:
            full()
        flush(descriptor)

    monkeypatch.setattr("slipctl.experiment.durable.os.fsync", counted)
    fails_at = 0
    swept(tmp_path / "counted")
    total = calls
    assert total > 2 * 2 * 2  # two chunks of two files, each with its folder
    for number in range(1, total + 1):
        out = tmp_path / str(number)
        calls, fails_at = 0, number
        with pytest.raises((StorageError, OSError)) as said:
            run(moment(), out=out, record="none")
        fails_at = 0
        left = list(out.iterdir())
        if (out / "moment").is_dir():  # renamed already: only the flush of the name was left
            assert parquet_bytes(out / "moment") == whole
            continue
        assert isinstance(said.value, StorageError)
        assert "disk" in str(said.value)
        assert "full" in str(said.value)
        if left == []:
            assert "nothing was begun" in str(said.value)
            continue
        assert f"--resume {left[0]}" in str(said.value)
        assert not list(left[0].rglob("*.part"))
        folder = resume(left[0]).folder
        assert folder is not None
        assert parquet_bytes(folder) == whole


@pytest.mark.skipif(os.name == "nt", reason="Windows has no limit on the size of a file")
def test_a_file_that_may_not_grow_is_a_message_and_exit_3(tmp_path):
    code = (
        "import resource, sys\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))\n"
        "from slipctl.cli import main\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    scenario = write(tmp_path)
    command = [sys.executable, "-c", code, "run", str(scenario), "--out", str(tmp_path / "runs"), "--quiet"]
    ended = subprocess.run(command, env=environment(), capture_output=True, text=True, check=False)
    assert ended.returncode == 3
    left = tmp_path / "runs" / "moment.unfinished"
    assert ended.stderr.splitlines() == [
        f"the disk is full; what is finished is kept in {left}",
        f"make room, then go on: slipctl sweep --resume {left}",
    ]
    folder = resume(left).folder
    assert folder is not None
    assert pq.read_table(folder / "metrics.parquet").num_rows == 2 * 3072


def test_half_written_and_foreign_chunks_are_not_read(tmp_path, whole):
    left = interrupted(tmp_path)
    chunks = left / "chunks"
    (chunks / "000004.arrow.99-ab.part").write_bytes(b"half")
    truncated = chunks / "000001.arrow"
    truncated.write_bytes(truncated.read_bytes()[:-20])
    signals = chunks / "000002.signals"
    signals.write_bytes(signals.read_bytes()[:1000])
    # a whole chunk of other worlds, and one of another scenario
    (chunks / "000005.arrow").write_bytes((chunks / "000000.arrow").read_bytes())
    other = pa.ipc.open_file(chunks / "000000.arrow").read_all()
    foreign = other.replace_schema_metadata({**(other.schema.metadata or {}), b"scenario_id": b"sha256:0"})
    with pa.ipc.new_file(chunks / "000000.arrow", foreign.schema) as writer:
        writer.write_table(foreign)
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


@pytest.mark.parametrize("ending", ["arrow", "signals"])
def test_a_damaged_byte_anywhere_in_a_chunk_is_found(ending, tmp_path, whole):
    left = interrupted(tmp_path)
    path = left / "chunks" / f"000001.{ending}"
    content = path.read_bytes()
    store = Store.open(left)
    chunk = Chunk(1, range(2, 4))
    assert store.whole(chunk)
    rows = store.metrics(chunk)
    assert rows is not None
    step = 17 if ending == "arrow" else 997
    for place in range(0, len(content), step):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x41]) + content[place + 1 :])
        # what is found whole must be the same: nothing is read of the bytes that fill gaps
        if store.whole(chunk):
            assert ending == "arrow"
            assert rows.equals(store.metrics(chunk))
    path.write_bytes(content)
    store.close()


def test_signals_that_are_gone_or_changed_are_made_again(tmp_path, whole):
    left = interrupted(tmp_path)
    (left / "chunks" / "000000.signals").unlink()
    changed = left / "chunks" / "000002.signals"
    content = bytearray(changed.read_bytes())
    content[len(content) // 2] ^= 1
    changed.write_bytes(content)
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_chunks_with_other_options_are_not_taken(tmp_path, whole):
    left, other = interrupted(tmp_path), interrupted(tmp_path / "other", signals="none")
    (left / "chunks" / "000000.arrow").write_bytes((other / "chunks" / "000000.arrow").read_bytes())
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_signals_that_vanish_at_the_end_are_told_and_gone_on_with(tmp_path, whole, monkeypatch):
    from slipctl.experiment import conclude

    original = conclude.joined

    def meddle(tables):
        (tmp_path / "moment.unfinished" / "chunks" / "000003.signals").unlink()
        return original(tables)

    with monkeypatch.context() as patch:
        patch.setattr(conclude, "joined", meddle)
        with pytest.raises(StorageError, match=r"000003\.signals cannot be read any more") as said:
            run(moment(), out=tmp_path, record="none")
    left = tmp_path / "moment.unfinished"
    assert f"--resume {left}" in str(said.value)
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_an_edited_plan_is_refused(tmp_path):
    left = interrupted(tmp_path)
    plan = left / "plan.json"
    for key, value in (("keep_going", True), ("signals", "sampled"), ("worlds", [0])):
        content = json.loads(plan.read_text(encoding="utf-8"))
        plan.write_text(json.dumps(content | {key: value}), encoding="utf-8")
        with pytest.raises(ResumeError, match="was edited or damaged since it was begun"):
            resume(left)
        plan.write_text(json.dumps(content), encoding="utf-8")  # how it is laid out does not matter
    assert resume(left).folder == tmp_path / "moment"


def test_two_processes_never_go_on_with_the_same_folder(tmp_path, whole):
    left = interrupted(tmp_path)
    code = (
        "import sys; from pathlib import Path; from slipctl.experiment.store import Store\n"
        "store = Store.open(Path(sys.argv[1])); print('held', flush=True); sys.stdin.read()"
    )
    holder = subprocess.Popen(
        [sys.executable, "-c", code, str(left)],
        env=environment(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    with pytest.raises(ResumeError, match="another process is at work on it"):
        resume(left)
    holder.kill()
    holder.communicate()
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole


def test_what_cannot_be_locked_is_gone_on_with_and_told(tmp_path, whole, monkeypatch, capsys):
    left = interrupted(tmp_path)

    def unsupported(file):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("slipctl.experiment.lock._take", unsupported)
    folder = resume(left).folder
    assert folder is not None
    assert parquet_bytes(folder) == whole
    assert capsys.readouterr().err.startswith(f"{left} cannot be locked (No locks available): let no other")


def test_a_folder_may_be_named_from_within(tmp_path, whole, monkeypatch):
    left = interrupted(tmp_path)
    monkeypatch.chdir(left)
    folder = resume(".").folder
    assert folder is not None
    assert folder == tmp_path.resolve() / "moment"
    assert parquet_bytes(folder) == whole


@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError(errno.EIO, "planted")])
def test_what_stops_it_after_the_last_step_says_all_is_there(error, tmp_path, whole, monkeypatch, capsys):
    def stopped(folder):
        raise error

    monkeypatch.setattr("slipctl.experiment.store.tidy", stopped)
    arguments = ["run", str(write(tmp_path, moment())), "--out", str(tmp_path), "--record", "none", "--quiet"]
    assert main(arguments) == (130 if isinstance(error, KeyboardInterrupt) else 3)
    said = capsys.readouterr().err
    assert "the run folder is" in said
    assert str(tmp_path / "moment") in said
    assert "nothing was written" not in said
    assert "--resume" not in said
    assert parquet_bytes(tmp_path / "moment") == whole


def test_a_running_sweep_is_not_gone_on_with(tmp_path):
    refused = []

    def meddle(done, total, text):
        if not refused:
            with pytest.raises(ResumeError, match="another process is at work on it"):
                Store.open(tmp_path / "moment.unfinished")
            refused.append(True)

    swept(tmp_path, progress=meddle)
    assert refused


def test_other_versions_are_refused_in_one_line(tmp_path, monkeypatch):
    left = interrupted(tmp_path)
    plan = left / "plan.json"
    content = json.loads(plan.read_text(encoding="utf-8"))
    now = content["versions"]["mujoco"]
    content["versions"]["mujoco"] = "3.0.0"
    signed(plan, content)
    before = names(left / "chunks")
    with pytest.raises(ResumeError) as said:
        resume(left)
    assert str(said.value) == f"{left} was begun with other versions: here mujoco is {now}, needed is 3.0.0"
    assert names(left / "chunks") == before


def test_another_source_of_slipctl_is_refused(tmp_path, monkeypatch):
    left = interrupted(tmp_path)
    now = json.loads((left / "plan.json").read_text(encoding="utf-8"))["versions"][SOURCE]
    monkeypatch.setattr("slipctl.experiment.machine.source", lambda: "sha256:0")
    with pytest.raises(ResumeError, match=f"here slipctl source is sha256:0, needed is {now}"):
        resume(left)


def test_another_family_of_processor_is_told(tmp_path, whole, capsys):
    left = interrupted(tmp_path)
    content = json.loads((left / "plan.json").read_text(encoding="utf-8"))
    content["machine"]["family"] = "abacus 1"
    signed(left / "plan.json", content)
    chunks = left / "chunks"
    for path in chunks.iterdir():
        path.unlink()  # of another plan
    folder = resume(left).folder
    assert folder is not None
    told = capsys.readouterr().err
    assert told.startswith(f"{left} was begun on another family of processor (abacus 1, here ")
    assert parquet_bytes(folder) == whole


def test_what_a_death_between_the_last_two_steps_left_is_removed(tmp_path, whole):
    left = interrupted(tmp_path)
    plan = (left / "plan.json").read_text(encoding="utf-8")
    folder = resume(left).folder
    assert folder is not None
    (folder / "plan.json").write_text(plan, encoding="utf-8")
    (folder / "chunks").mkdir()
    with pytest.raises(ResumeError, match="is finished: there is nothing to go on with"):
        resume(folder)
    assert names(folder) == ["manifest.json", "metrics.parquet", "signals.parquet"]
    assert parquet_bytes(folder) == whole


def test_another_scenario_or_model_is_refused(tmp_path):
    slip = tmp_path / "slip.parquet"
    columns = {name: [0.0, 0.1] for name in ("longitudinal", "lateral", "yaw")}
    pq.write_table(pa.table({"time": [0.0, 9.0], **columns}), slip)
    scenario = moment(slip={"kind": "series", "file": str(slip)}, sweep={"seed": list(range(12))})
    with pytest.raises(Interrupted) as stop:
        run(scenario, out=tmp_path / "runs", progress=stop_after(0.5))
    left = stop.value.folder
    pq.write_table(pa.table({"time": [0.0, 8.0], **columns}), slip)
    with pytest.raises(ResumeError, match=r"begun with another scenario: sha256:.* a file .* has changed"):
        resume(left)
    pq.write_table(pa.table({"time": [0.0, 9.0], **columns}), slip)
    content = json.loads((left / "plan.json").read_text(encoding="utf-8"))
    signed(left / "plan.json", {**content, "model_id": "sha256:0"})
    with pytest.raises(ResumeError, match="begun with another model: sha256:0 then"):
        resume(left)
    signed(left / "plan.json", content)
    assert resume(left).folder == tmp_path / "runs" / "moment"


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", '{"format": 9}', '{"format": 1}'])
def test_a_plan_that_is_none_is_refused(content, tmp_path):
    (tmp_path / "plan.json").write_text(content)
    with pytest.raises(ResumeError, match=r"plan\.json"):
        resume(tmp_path)


def test_what_is_no_unfinished_sweep_says_which_there_are(tmp_path):
    left = interrupted(tmp_path)
    with pytest.raises(ResumeError) as said:
        resume(tmp_path / "other")
    assert (
        str(said.value)
        == f"{tmp_path / 'other'} is no unfinished sweep: it has no plan.json; there is {left}"
    )
    finished = resume(left).folder
    assert finished is not None
    with pytest.raises(ResumeError, match="is finished"):
        resume(finished)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="cannot write to the output folder"):
        run(moment(), out=tmp_path / "file")


def test_own_laws_cannot_be_gone_on_with(tmp_path):
    from slipctl.control.nominal_kinematic import NominalKinematic
    from slipctl.theory.robust import chain_gains

    def law(known):
        import numpy as np

        return NominalKinematic(known.speed_drive(), chain_gains(np.full(known.worlds, -2.0), 2))

    with pytest.raises(Interrupted) as stop:
        run(moment(), out=tmp_path, laws={"mine": law}, progress=stop_after(0.5))
    with pytest.raises(ResumeError, match=r"own laws \(mine\)"):
        resume(stop.value.folder)


RESULTS = ["manifest.json", "metrics.parquet", "signals.parquet"]

LONGER = {"sweep": {"slip.longitudinal": [0.0, 0.1, 0.3], "seed": list(range(1024))}}


def write(folder: Path, scenario: files.Scenario | None = None) -> Path:
    """Write the sweep of 3072 worlds, six chunks, or another scenario as a file."""
    scenario = scenario or moment(**LONGER)
    lines = []

    def table(name: str, values: dict, brackets: tuple[str, str] = ("[", "]")) -> None:
        if name:
            lines.append(f"{brackets[0]}{name}{brackets[1]}")
        lines.extend(f"{json.dumps(key)} = {json.dumps(value)}" for key, value in values.items())

    given = files.given(scenario)
    table("", {key: value for key, value in given.items() if not isinstance(value, dict | list)})
    for key, value in given.items():
        if isinstance(value, dict):
            table(key, value)
    for entry in given["controller"]:
        table("controller", entry, ("[[", "]]"))
    path = folder / "moment.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert files.worlds(files.load(path)) == files.worlds(scenario)
    return path


def environment() -> dict[str, str]:
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    return {**os.environ, "PYTHONPATH": paths}


def sweep(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "slipctl.cli", "sweep", *arguments],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("workers", ["1", "2"])
def test_killed_at_random_moments_and_gone_on_with(workers, tmp_path, monkeypatch):
    monkeypatch.undo()  # chunks as large as a user's
    scenario = write(tmp_path)
    options = [str(scenario), "--record", "none", "--quiet", "--workers", workers]
    out = tmp_path / "whole"
    unfinished = "moment.unfinished"
    process = sweep(*options, "--out", str(out))
    while not (out / unfinished).exists() and process.poll() is None:
        time.sleep(0.005)
    begun = time.monotonic()
    assert process.wait() == 0, process.stderr
    lasts = time.monotonic() - begun
    whole = parquet_bytes(out / "moment")
    seed = random.randrange(2**32)
    print("seed", seed)
    moments = random.Random(seed)
    killed = 0
    for number in range(KILLS):
        out = tmp_path / str(number)
        process = sweep(*options, "--out", str(out))
        while not (out / unfinished / "plan.json").exists() and process.poll() is None:
            time.sleep(0.002)
        time.sleep(moments.uniform(0.0, lasts))
        process.kill()
        process.communicate()
        if (out / unfinished).exists():
            killed += 1
            assert not (out / "moment").exists()
            again = sweep("--resume", str(out / unfinished), "--quiet", "--workers", workers)
            _, said = again.communicate()
            assert (again.returncode, said) == (0, "")
        assert names(out) == ["moment"]
        assert parquet_bytes(out / "moment") == whole
        if names(out / "moment") != RESULTS:  # killed between its last two steps
            again = sweep("--resume", str(out / "moment"))
            again.communicate()
            assert again.returncode == 2
        assert names(out / "moment") == RESULTS
    assert killed or KILLS < 5, "every kill came too late to test anything"


@pytest.mark.skipif(os.name == "nt", reason="Windows sends Ctrl-C to a whole console")
@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_on_the_command_line_is_exit_130_and_says_how_to_go_on(workers, tmp_path):
    scenario = write(tmp_path)
    out = tmp_path / "runs"
    left = out / "moment.unfinished"
    options = ["--out", str(out), "--record", "none", "--workers", workers]
    process = subprocess.Popen(
        [sys.executable, "-m", "slipctl.cli", "sweep", str(scenario), "--json", *options],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # a group of its own, as on a terminal
    )
    while not list(left.glob("chunks/*.arrow")) and process.poll() is None:
        time.sleep(0.002)
    os.killpg(process.pid, signal.SIGINT)
    said, complained = process.communicate()
    if process.returncode == 0:
        pytest.skip("it was faster than Ctrl-C")
    assert process.returncode == 130
    assert said == ""
    begun, kept, go_on = complained.splitlines()
    assert begun == f"what is finished is kept; if this stops: slipctl sweep --resume {left}"
    assert kept.startswith("interrupted; ")
    assert kept.endswith(f" of 3072 worlds are kept in {left}")
    assert go_on == f"go on: slipctl sweep --resume {left}"
    again = sweep("--resume", str(left), "--json")
    printed, _ = again.communicate()
    assert again.returncode == 0
    assert len(json.loads(printed)["runs"]) == 2 * 3072
