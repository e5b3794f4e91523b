"""``run`` and ``sweep``: exit statuses and what stands on which stream."""

import json
import os
import sys
from pathlib import Path

import pytest

from slipctl.cli import main
from slipctl.experiment import Interrupted
from slipctl.experiment.errors import ClusterError
from tests.fakes import SHORT_SCENARIO, FakeResult, payload, run_entry

RUNS = [run_entry("nominal_kinematic"), run_entry("robust_kinematic", rms=0.0004, status="tipped")]


@pytest.fixture
def engine(monkeypatch):
    """Replaces the engine; returns the list of calls, and gives what ``answer`` holds."""

    class Engine:
        def __init__(self):
            self.calls = []
            self.answer = FakeResult(payload(RUNS), Path("runs/friction-sweep"))

        def run(self, scenario, **options):
            self.calls.append((scenario, options))
            if isinstance(self.answer, BaseException):
                raise self.answer
            return self.answer

    engine = Engine()
    monkeypatch.setattr("slipctl.experiment.run", engine.run)
    return engine


def test_a_run_shows_its_table_recordings_and_folder(engine, capsys):
    assert main(["run", "friction-sweep"]) == 0
    out, err = capsys.readouterr()
    assert "nominal_kinematic" in out
    assert "0.40" in out
    assert "tipped at 3.2 s" in out
    assert "2 recordings: one per world · runs/friction-sweep" in out
    assert err == "1 of 2 runs ended early: 1 tipped\n"


def test_json_is_exactly_one_object_on_standard_output(engine, capsys):
    assert main(["run", "friction-sweep", "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == payload(RUNS)
    assert "ended early" in err


def test_quiet_prints_nothing_of_a_good_run(engine, capsys):
    engine.answer = FakeResult(payload(RUNS[:1]), Path("runs/x"))
    assert main(["run", "friction-sweep", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_options_reach_the_engine(engine, tmp_path):
    arguments = ["run", "friction-sweep", "--out", str(tmp_path), "--record", "worst:3", "--threads", "2"]
    assert main(arguments) == 0
    scenario, options = engine.calls[0]
    assert scenario.name == "friction-sweep"
    assert options["out"] == tmp_path
    assert options["record"] == "worst:3"
    assert options["threads"] == 2


def test_the_default_folder_is_runs(engine):
    assert main(["run", "friction-sweep"]) == 0
    assert engine.calls[0][1]["out"] == Path("runs")


def test_sweep_takes_several_grids(engine):
    over = ["--over", "start.x_offset=0,0.1", "--over", "start.y_offset=0:0.2:3"]
    assert main(["sweep", "paper-kinematic", *over]) == 0
    (scenario, _), *_ = engine.calls
    assert {axis.key: list(axis) for axis in scenario.sweep} == {
        "start.x_offset": [0.0, 0.1],
        "start.y_offset": [0.0, 0.1, 0.2],
    }


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "frictionsweep"], 'did you mean "friction-sweep"'),
        (["run", "no/such/file.toml"], "no such file"),
        (["run", "friction-sweep", "--record", "best"], "'best'"),
        (["run", "friction-sweep", "--signals", "some"], "'some'"),
        (["run", "friction-sweep", "--workers", "0"], "--workers"),
        (["run", "no-such-run", "--world", "1"], "nor a shipped scenario"),
        (["run", ".", "--world", "1"], "no run folder"),
        (["sweep"], "FILE|NAME"),
        (["sweep", "friction-sweep", "--workers", "2", "--dask", "tcp://host:1"], "--workers and --dask"),
        (["sweep", "friction-sweep", "--resume", "runs/x"], "FILE|NAME: not with --resume"),
        (["sweep", "--resume", "no/such/folder"], "no/such/folder is no unfinished sweep"),
        (
            ["sweep", "--resume", "runs/x", "--record", "all", "--out", "y"],
            "--out, --record: not with --resume",
        ),
        (["run", "friction-sweep", "--threads", "0"], "--threads"),
        (["run", "friction-sweep", "--threads", "two"], "--threads"),
        (["run", "friction-sweep", "--recrod", "all"], "--record"),
        (["run"], "FILE|NAME"),
        (["rum", "friction-sweep"], "'run'"),
        (["sweep", "paper-kinematic", "--over", "start.x_offset"], "start.x_offset"),
        (["sweep", "paper-kinematic", "--over", "start.x_ofset=1,2"], "start.x_offset"),
        (["sweep", "paper-kinematic", "--over", "start.x_offset=1,two"], "1,two"),
        (["sweep", "paper-kinematic", "--over", "start.x_offset=1,2", "--over", "start.x_offset=3"], "twice"),
        (["sweep", "paper-kinematic", "--over", "start.x_offset=0:1:1000000000000"], "1,000,000,000,000"),
    ],
)
def test_wrong_input_is_a_message_and_exit_2(engine, capsys, monkeypatch, arguments, said):
    monkeypatch.setenv("COLUMNS", "200")
    assert main([*arguments, "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert "Traceback" not in err
    assert engine.calls == []


def test_a_run_folder_without_a_world_is_told_how_to_run_one(engine, capsys, tmp_path):
    (tmp_path / "manifest.json").write_text("{}", encoding="utf-8")
    assert main(["run", str(tmp_path)]) == 2
    assert capsys.readouterr().err == (
        f"{tmp_path} is a run folder: run one of its worlds again with --world N\n"
    )
    assert engine.calls == []


def test_an_output_folder_that_cannot_be_written_is_exit_2(tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")
    arguments = [
        "run",
        "paper-kinematic",
        "--record",
        "none",
        "--out",
        str(tmp_path / "file" / "runs"),
        "--json",
    ]
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert str(tmp_path / "file") in err
    assert "Traceback" not in err


def test_an_interrupted_run_says_where_the_finished_worlds_are_and_how_to_go_on(engine, capsys):
    engine.answer = Interrupted(Path("runs/friction-sweep.unfinished"), 64, 200)
    assert main(["run", "friction-sweep", "--json"]) == 130
    assert capsys.readouterr() == (
        "",
        "interrupted; 64 of 200 worlds are kept in runs/friction-sweep.unfinished\n"
        "go on: slipctl sweep --resume runs/friction-sweep.unfinished\n",
    )


def test_options_of_a_sweep_reach_the_engine(engine):
    assert main(["sweep", "friction-sweep", "--signals", "sampled", "--dask", "tcp://host:8786"]) == 0
    options = engine.calls[0][1]
    assert (options["signals"], options["dask"], options["workers"]) == ("sampled", "tcp://host:8786", 1)
    assert (options["keep_going"], options["keep_failed_rows"]) == (True, False)
    assert options["worlds"] is None
    assert main(["sweep", "friction-sweep", "--workers", "3", "--record", "failed", "--world", "7"]) == 0
    options = engine.calls[1][1]
    assert (options["workers"], options["record"], options["worlds"]) == (3, "failed", [7])
    # what is raised in the one world is to be seen, with the rows before
    assert (options["keep_going"], options["keep_failed_rows"]) == (False, True)


def test_one_world_alone_shows_a_defect_as_what_it_is(engine):
    assert main(["run", "paper-kinematic"]) == 0
    options = engine.calls[0][1]
    assert (options["keep_going"], options["keep_failed_rows"]) == (False, True)


def test_going_on_gives_the_folder_and_who_is_to_work(engine, capsys, tmp_path, monkeypatch):
    left = tmp_path / "friction-sweep.unfinished"
    left.mkdir()
    monkeypatch.setattr("slipctl.experiment.resume", engine.run)
    assert main(["sweep", "--resume", str(left), "--workers", "2", "--json"]) == 0
    folder, options = engine.calls[0]
    assert folder == left
    assert (options["workers"], options["dask"], options["threads"]) == (2, None, None)
    assert json.loads(capsys.readouterr().out) == payload(RUNS)


def test_going_on_with_what_is_finished_says_where_it_is(tmp_path, capsys):
    left = tmp_path / "x.unfinished"
    for age, name in enumerate(("x-2", "x", "xy", "x-3-old")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "manifest.json").write_text("{}", encoding="utf-8")
        os.utime(tmp_path / name / "manifest.json", (1000.0 + age, 1000.0 + age))
    assert main(["sweep", "--resume", str(left)]) == 2
    assert capsys.readouterr().err == f"{left} is finished already: see {tmp_path / 'x'}\n"
    left.mkdir()  # another one, which is not finished
    assert main(["sweep", "--resume", str(left)]) == 2
    assert "is no unfinished sweep: it has no plan.json" in capsys.readouterr().err


def test_what_is_kept_and_what_failed_is_said(engine, capsys):
    failed = {
        "world": 3,
        "controller": "robust_kinematic",
        "varied": {},
        "seed": 0,
        "failure": "ValueError: no",
    }
    entry = run_entry("robust_kinematic", rms=None, status="failed")
    engine.answer = FakeResult(
        payload([RUNS[0], entry]),
        Path("runs/x"),
        signals_note="signals: at most 51 rows of each run",
        failures=(failed,) * 6,
        varied=("ground.friction",),
    )
    assert main(["sweep", "friction-sweep"]) == 0
    out, err = capsys.readouterr()
    assert "2 recordings: one per world · signals: at most 51 rows of each run · runs/x" in out
    assert err.splitlines()[:3] == [
        "1 of 2 runs ended early: 1 failed",
        "world 3 (robust_kinematic) failed: ValueError: no",
        "  run it alone: slipctl run runs/x --world 3",
    ]
    assert err.count("run it alone") == 1  # once for a world
    assert err.splitlines()[-1] == "and 1 more, listed under failures in runs/x/manifest.json"


def test_an_interruption_before_the_first_run_leaves_nothing(engine, capsys):
    engine.answer = KeyboardInterrupt()
    assert main(["run", "friction-sweep", "--json"]) == 130
    assert capsys.readouterr() == ("", "interrupted before any run was finished; nothing was written\n")


def test_an_early_interruption_of_going_on_says_that_what_was_there_is_kept(tmp_path, monkeypatch, capsys):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.experiment.resume", stop)
    left = tmp_path / "x.unfinished"
    assert main(["sweep", "--resume", str(left)]) == 130
    assert capsys.readouterr().err == (
        f"interrupted; what is finished is kept; go on: slipctl sweep --resume {left}\n"
    )


def test_ctrl_c_while_the_commands_are_read_shows_no_traceback(monkeypatch, capsys):
    import importlib.machinery

    class Interrupting(importlib.machinery.PathFinder):
        @classmethod
        def find_spec(cls, fullname, path=None, target=None):
            if fullname == "slipctl.cli.app":
                raise KeyboardInterrupt

    monkeypatch.delitem(sys.modules, "slipctl.cli.app", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupting, *sys.meta_path])
    assert main(["run", "friction-sweep"]) == 130
    assert capsys.readouterr() == ("", "interrupted; nothing was begun\n")


def test_a_defect_shows_its_traceback_and_is_no_failed_gate(engine, capsys):
    engine.answer = ZeroDivisionError("oops")
    assert main(["run", "friction-sweep", "--json"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" in err
    assert "oops" in err


@pytest.mark.parametrize("part", ["slipctl.cli.app", "slipctl.scenario"])
def test_a_slipctl_that_cannot_be_imported_is_no_failed_gate(monkeypatch, tmp_path, capsys, part):
    (tmp_path / "short.toml").write_text(SHORT_SCENARIO)
    monkeypatch.setitem(sys.modules, part, None)
    assert main(["run", str(tmp_path / "short.toml"), "--out", str(tmp_path)]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "ModuleNotFoundError" in err


def test_a_full_disk_is_a_message_and_exit_3(engine, capsys):
    engine.answer = OSError(28, "No space left on device")
    assert main(["run", "friction-sweep"]) == 3
    assert capsys.readouterr().err == "could not go on: [Errno 28] No space left on device\n"


@pytest.mark.parametrize(
    ("error", "status"), [(OSError("the network is down"), 3), (ClusterError("no answer"), 2)]
)
def test_what_stops_a_sweep_says_how_to_go_on_where_something_is_kept(engine, capsys, error, status):
    error.add_note("what is finished is kept; go on: slipctl sweep --resume x.unfinished")
    engine.answer = error
    assert main(["run", "friction-sweep"]) == status
    first, second = capsys.readouterr().err.splitlines()
    assert first.endswith(str(error))
    assert second == "what is finished is kept; go on: slipctl sweep --resume x.unfinished"


def test_a_real_run_writes_what_it_prints(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.toml").write_text(SHORT_SCENARIO)
    assert main(["run", "short.toml", "--record", "none", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    (run,) = printed["runs"]
    assert run["status"] == "completed"
    assert 0 <= run["metrics"]["max_position_error"] < 1e-6
    folder = tmp_path / "runs" / "short"
    assert {path.name for path in folder.iterdir()} == {"metrics.parquet", "signals.parquet", "manifest.json"}
    assert json.loads((folder / "manifest.json").read_text())["scenario_id"] == printed["scenario_id"]
    assert main(["run", "short.toml", "--quiet"]) == 0
    assert sorted(path.name for path in folder.parent.iterdir()) == ["short", "short-2"]
    assert len(list((folder.parent / "short-2").glob("*.rrd"))) == 1
