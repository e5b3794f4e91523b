"""What differs between two baselines, and that recording leaves the old one where it cannot finish."""

import pytest

from slipctl import experiment
from slipctl.cli import main
from slipctl.experiment.folder import OutputError
from slipctl.regression import check, read, record, write
from slipctl.regression.baseline.gated import GATED
from slipctl.regression.record import changes, try_to_write
from slipctl.scenario import load, scenario_id
from tests.fakes import SHORT_SCENARIO, baseline_of, payload, run_entry
from tests.repository import Repository, needs_git


def baseline(*runs):
    return baseline_of(payload(runs))


def said(rows):
    return [(row["controller"], row["metric"]) for row in rows]


def test_nothing_changed_is_an_empty_list():
    assert changes(baseline(run_entry("a")), baseline(run_entry("a"))) == []
    assert changes(None, baseline(run_entry("a"))) == []


def test_every_number_that_changed_is_listed_with_old_and_new():
    rows = changes(
        baseline(run_entry("a"), run_entry("b")), baseline(run_entry("a"), run_entry("b", rms=0.002))
    )
    assert said(rows) == [
        ("b", name)
        for name in (
            "rms_position_error",
            "max_position_error",
            "final_position_error",
            "rms_cross_track_error",
        )
    ]
    assert (rows[0]["before"]["value"], rows[0]["after"]["value"]) == (0.001, 0.002)
    assert rows[0]["varied"] == {"ground.friction": 0.8}


def test_a_tolerance_that_changed_alone_is_listed():
    before, after = (baseline_of(payload([run_entry("a")]), tolerance) for tolerance in (1e-5, 2e-5))
    rows = changes(before, after)
    assert [row["metric"] for row in rows] == list(GATED)
    assert {(row["before"]["tolerance"], row["after"]["tolerance"]) for row in rows} == {(1e-5, 2e-5)}


def test_statuses_and_runs_that_came_or_went_are_listed():
    before = baseline(run_entry("a"), run_entry("b"))
    after = baseline(run_entry("a", status="tipped"), run_entry("c"))
    rows = {row["controller"]: (row["before"], row["after"]) for row in changes(before, after)}
    assert rows == {"a": ("completed", "tipped"), "b": ("completed", None), "c": (None, "completed")}


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(SHORT_SCENARIO, encoding="utf-8")
    return str(path)


def test_what_was_recorded_is_judged_the_same(scenario):
    recording = record(scenario, "a test")
    assert recording.baseline == read(recording.path)
    assert recording.changes == []
    assert recording.report.findings == ()
    report = check(scenario)
    assert report.judged
    assert not report.failed
    assert {str(finding.verdict) for finding in report.findings} == {"same"}
    assert report.recorded is not None
    assert report.recorded["reason"] == "a test"


def test_recording_again_gives_the_same_numbers(scenario):
    first, again = record(scenario, "one"), record(scenario, "two")
    assert again.changes == []
    assert again.baseline.runs == first.baseline.runs
    assert again.baseline.reason == "two"


@pytest.mark.parametrize("stopped_at", [0, 1, 3])
def test_an_interruption_anywhere_leaves_the_old_baseline(scenario, monkeypatch, stopped_at):
    path = record(scenario, "one").path
    before = {entry.name: entry.read_bytes() for entry in path.parent.iterdir()}
    run, calls = experiment.run, []

    def interrupted(*arguments, **options):
        calls.append(None)
        if len(calls) > stopped_at:
            raise KeyboardInterrupt
        return run(*arguments, **options)

    monkeypatch.setattr(experiment, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        record(scenario, "two")
    assert {entry.name: entry.read_bytes() for entry in path.parent.iterdir()} == before


def test_a_baseline_of_another_scenario_is_not_compared_with(scenario, tmp_path):
    path = record(scenario, "one").path
    other = read(path).model_copy(update={"scenario_id": "sha256:other"})
    write(other, path)
    report = check(scenario)
    assert [str(finding.verdict) for finding in report.findings] == ["unjudged"]
    assert "another scenario" in report.findings[0].note
    assert record(scenario, "two").baseline.scenario_id == scenario_id(load(scenario))


@pytest.mark.parametrize("place", ["baselines", "baselines/short.json"])
def test_where_no_baseline_can_be_written_nothing_is_run(scenario, tmp_path, monkeypatch, capsys, place):
    monkeypatch.setattr(experiment, "run", lambda *_, **__: pytest.fail("ran"))
    if place == "baselines":
        (tmp_path / place).write_text("a file", encoding="utf-8")
    else:
        (tmp_path / place).mkdir(parents=True)
    with pytest.raises(OutputError):
        record(scenario, "in vain")
    assert main(["check", scenario, "--update", "--reason", "in vain"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"cannot write the baseline {tmp_path / 'baselines' / 'short.json'}: ")


def test_seeing_that_a_baseline_can_be_written_leaves_nothing(tmp_path):
    try_to_write(tmp_path / "baselines" / "short.json")
    assert list(tmp_path.iterdir()) == []


@needs_git
def test_a_baseline_names_the_commit_of_the_repository_that_holds_it(tmp_path):
    repository = Repository(tmp_path / "team")
    path = repository.folder / "scenarios" / "short.toml"
    path.parent.mkdir()
    path.write_text(SHORT_SCENARIO, encoding="utf-8")
    commit = repository.commit("a scenario", {"law.py": "one"})
    assert record(str(path), "first").baseline.commit == commit[:12]
    # a second baseline is of the same code, whether the first is committed or not
    commit = repository.commit("its baseline")
    (repository.folder / "notes.txt").write_text("not tracked", encoding="utf-8")
    assert record(str(path), "again").baseline.commit == commit[:12]
    assert record(str(path), "once more").baseline.commit == commit[:12]
    (repository.folder / "law.py").write_text("two", encoding="utf-8")
    assert record(str(path), "changed").baseline.commit == f"{commit[:12]}-dirty"


@needs_git
def test_where_there_is_no_commit_none_is_named(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(SHORT_SCENARIO, encoding="utf-8")
    assert record(str(path), "first").baseline.commit is None
    Repository(tmp_path)
    assert record(str(path), "in a repository without a commit").baseline.commit is None
