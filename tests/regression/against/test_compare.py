"""``slipctl check --against``: another revision, a run folder, and everything that can be wrong with them."""

import json
import math
import tempfile

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from slipctl import experiment
from slipctl.cli import main
from slipctl.regression import CannotJudge, Verdict, against, judge, write
from slipctl.regression.against.compare import as_baseline
from slipctl.regression.baseline.gated import GATED
from tests.fakes import SHORT_SCENARIO, baseline_of, payload, run_entry
from tests.repository import Repository, needs_git

OFFSET = SHORT_SCENARIO + "[start]\nx_offset = 0.01\n"
"""Starts beside its path, so that the gain plays a part."""

SLOWER = OFFSET.replace("pole = -1.0", "pole = -0.9")

CLOSER = OFFSET.replace("0.01", "0.009")
"""Better in every way."""

WORLDS = '[sweep]\n"start.y_offset" = [0.0, 0.01, 0.02]\n'


IMPOSSIBLE = """
[[expect]]
kind = "below"
controller = "nominal_kinematic"
metric = "rms_position_error"
limit = 1e-9
"""


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The folder for temporary files, where the test can see what is left."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def repository(tmp_path, temporary):
    """A user's repository: a scenario whose gain was lowered after the tag `then`."""
    repository = Repository(tmp_path / "mine")
    repository.commit("first", {"ice.toml": OFFSET + WORLDS})
    repository.git("tag", "then")
    repository.commit("slower", {"ice.toml": SLOWER + WORLDS})
    return repository


def answer(capsys, *arguments):
    """Exit status, findings and what was said, of ``check --json``."""
    status = main(["check", *map(str, arguments), "--json", "--artefacts", "none"])
    out, err = capsys.readouterr()
    results = json.loads(out)["results"] if out else []
    return status, results, err


@needs_git
def test_a_lower_gain_is_worse_than_the_revision_before(repository, temporary, capsys):
    status, results, err = answer(capsys, repository.folder / "ice.toml", "--against", "then")
    assert status == 1
    worse = [entry for entry in results if entry["verdict"] == "worse"]
    runs = {
        entry["varied"].get("start.y_offset") for entry in worse if entry["metric"] == "rms_position_error"
    }
    assert runs == {0.0, 0.01, 0.02, None}  # every world, and their mean
    assert "ice: against then (" in err
    assert "another scenario than then, judged all the same" in err
    assert "tolerances measured here, from moved starts" in err
    assert len(repository.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_the_mean_difference_is_that_of_the_runs_and_lies_in_its_interval(repository):
    report = against(str(repository.folder / "ice.toml"), "then")
    entries = [finding.json() for finding in report.findings if finding.metric == "rms_position_error"]
    *runs, mean = [(entry["current"] - entry["baseline"], entry) for entry in entries]
    differences = [difference for difference, _ in runs]
    assert len(runs) == 3
    difference, entry = mean
    assert difference == pytest.approx(sum(differences) / 3, rel=1e-9)
    assert entry["interval"] == pytest.approx([min(differences), max(differences)], rel=1e-9)
    assert (entry["varied"], entry["seed"], entry["verdict"]) == ({}, None, "worse")


@needs_git
def test_the_other_way_round_the_error_is_better_and_its_price_is_worse(repository, capsys):
    (repository.folder / "ice.toml").write_text(OFFSET + WORLDS)  # not committed: what lies there is judged
    status, results, _ = answer(capsys, repository.folder / "ice.toml", "--against", "main")
    assert status == 1
    assert {entry["verdict"] for entry in results if entry["metric"] == "rms_position_error"} == {"better"}
    assert "command_variation" in {entry["metric"] for entry in results if entry["verdict"] == "worse"}


@needs_git
def test_what_failed_is_recorded_as_it_is_now(repository, tmp_path, capsys):
    out = tmp_path / "out"
    file = repository.folder / "ice.toml"
    assert main(["check", str(file), "--against", "then", "--quiet", "--artefacts", str(out)]) == 1
    names = sorted(path.name for path in (out / "ice").iterdir())
    assert names == ["y_offset-0_0.rrd", "y_offset-0_01.rrd", "y_offset-0_02.rrd"]
    err = capsys.readouterr().err
    assert "there are no tracks of what it was compared with" in err
    assert "then (" in err


@needs_git
def test_better_is_good_and_not_asked_to_be_recorded(repository, capsys):
    repository.commit("first again", {"ice.toml": OFFSET})
    (repository.folder / "ice.toml").write_text(CLOSER)
    assert main(["check", str(repository.folder / "ice.toml"), "--against", "main"]) == 0
    out = capsys.readouterr().out
    assert "better" in out
    assert "--update" not in out


@needs_git
def test_a_revision_is_the_same_as_itself_to_the_last_bit(repository, capsys):
    status, results, err = answer(capsys, repository.folder / "ice.toml", "--against", "HEAD")
    assert status == 0
    for entry in results:
        assert entry["verdict"] == "same"
        assert entry["baseline"] == entry["current"]
        assert entry["interval"] in (None, [0.0, 0.0])
    assert "another scenario" not in err


@needs_git
def test_a_change_smaller_than_a_moved_start_is_the_same(repository, capsys):
    (repository.folder / "ice.toml").write_text(SLOWER.replace("-0.9", "-0.90000000001") + WORLDS)
    status, results, err = answer(capsys, repository.folder / "ice.toml", "--against", "HEAD")
    assert status == 0
    assert "another scenario than then" in err
    assert any(entry["baseline"] != entry["current"] for entry in results)


def tolerances(results):
    """Of what has a number: these laws have no theorem."""
    numbers = [entry for entry in results if entry["metric"] != "guarantee_fraction"]
    return [entry["tolerance"] for entry in numbers if entry["tolerance"] is not None]


@needs_git
@pytest.mark.parametrize(("tolerance", "status"), [(9e-5, 0), (1e-5, 1)])
def test_tolerances_are_those_of_the_baseline_of_this_very_scenario(repository, capsys, tolerance, status):
    file = repository.folder / "ice.toml"
    file.write_text(OFFSET.replace("-1.0", "-0.99") + WORLDS)
    result = experiment.run(file).json()
    write(baseline_of(result, tolerance), repository.folder / "baselines" / "ice.json")
    found, results, err = answer(capsys, file, "--against", "then")
    assert found == status
    assert tolerances(results) == pytest.approx([tolerance] * len(tolerances(results)))
    assert "measured here" not in err
    other = baseline_of({**result, "scenario_id": "sha256:other"}, tolerance)
    write(other, repository.folder / "baselines" / "ice.json")
    found, results, err = answer(capsys, file, "--against", "then")
    assert found == 1
    assert "tolerances measured here" in err
    assert max(tolerances(results)) < 1e-6


@needs_git
def test_claims_are_not_judged_and_do_not_make_another_scenario(repository, capsys):
    file = repository.folder / "ice.toml"
    file.write_text(file.read_text() + IMPOSSIBLE)
    status, results, err = answer(capsys, file, "--against", "main")
    assert status == 0
    assert {entry["claim"] for entry in results} == {None}
    assert "another scenario" not in err
    assert main(["check", str(file), "--quiet", "--artefacts", "none"]) == 1  # where it is judged, it fails


@needs_git
def test_worlds_on_one_side_only_cannot_be_judged(repository, capsys):
    (repository.folder / "ice.toml").write_text(SLOWER + WORLDS.replace("0.02", "0.03"))
    report = against(str(repository.folder / "ice.toml"), "main")
    odd = {f.varied["start.y_offset"]: f.verdict for f in report.findings if not f.verdict.judged}
    assert odd == {0.02: Verdict.MISSING, 0.03: Verdict.EXTRA}
    assert main(["check", str(repository.folder / "ice.toml"), "--against", "main"]) == 3


@needs_git
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "has no ice.toml"),
        ("tick = ", "cannot run ice.toml: this is not a TOML file"),
        (OFFSET + '[sweep]\n"start.y_offset" = [0.5]\n', "has no run with the controllers, worlds and seeds"),
    ],
)
def test_a_revision_that_cannot_be_judged_is_exit_3_with_one_line(tmp_path, temporary, capsys, text, said):
    repository = Repository(tmp_path / "mine")
    repository.commit("first", {} if text is None else {"ice.toml": text})
    repository.commit("second", {"ice.toml": OFFSET + WORLDS})
    status, results, err = answer(capsys, repository.folder / "ice.toml", "--against", "HEAD~1")
    assert (status, results) == (3, [])
    assert said in err
    assert len(err.splitlines()) == 1
    assert len(repository.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_a_scenario_outside_git_is_exit_3(tmp_path, capsys):
    (tmp_path / "ice.toml").write_text(OFFSET)
    status, results, err = answer(capsys, tmp_path / "ice.toml", "--against", "HEAD")
    assert (status, results) == (3, [])
    assert "is in no git checkout" in err
    assert len(err.splitlines()) == 1


@needs_git
def test_an_unknown_revision_is_exit_2_and_costs_no_run(repository, capsys, monkeypatch):
    monkeypatch.setattr("slipctl.experiment.run", lambda *_, **__: pytest.fail("nothing may be run"))
    status, results, err = answer(capsys, repository.folder / "ice.toml", "--against", "thne")
    assert (status, results) == (2, [])
    assert "did you mean then?" in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("other", [["--record"], ["--update", "--reason", "why"]])
def test_against_records_nothing(tmp_path, capsys, other):
    (tmp_path / "ice.toml").write_text(OFFSET)
    assert main(["check", str(tmp_path / "ice.toml"), "--against", "HEAD", *other]) == 2
    assert "does not go with --record or --update" in capsys.readouterr().err
    assert not (tmp_path / "baselines").exists()


@needs_git
def test_an_interruption_is_exit_130_and_leaves_no_worktree(repository, temporary, capsys, monkeypatch):
    def interrupted(*_, **__):
        assert len(repository.worktrees()) == 2
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.experiment.run", interrupted)
    status, results, err = answer(capsys, repository.folder / "ice.toml", "--against", "then")
    assert (status, results) == (130, [])
    assert err == f"interrupted; {repository.folder / 'ice.toml'} was not judged\n"
    assert len(repository.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@pytest.fixture
def run_folder(tmp_path):
    """A run of a scenario whose gain has been lowered since."""
    (tmp_path / "ice.toml").write_text(OFFSET + WORLDS)
    folder = experiment.run(tmp_path / "ice.toml", out=tmp_path / "runs", record="none").folder
    (tmp_path / "ice.toml").write_text(SLOWER + WORLDS)
    return folder


def test_a_run_folder_is_compared_with_without_git(run_folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    status, results, err = answer(capsys, tmp_path / "ice.toml", "--against", run_folder)
    assert status == 1
    assert f"against run {run_folder}" in err
    assert "elsewhere" not in err
    (tmp_path / "ice.toml").write_text(OFFSET + WORLDS)
    status, results, _ = answer(capsys, tmp_path / "ice.toml", "--against", run_folder)
    assert status == 0
    assert {entry["verdict"] for entry in results} == {"same"}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"versions": {"mujoco": "4.9.9"}}, "mujoco 4.9.9 then"),
        ({"machine": {"family": "x86_64 Other 1"}}, "processor family x86_64 Other 1 then"),
    ],
)
def test_a_run_from_elsewhere_has_the_wider_tolerances(run_folder, tmp_path, capsys, change, said):
    path = run_folder / "manifest.json"
    manifest = json.loads(path.read_text())
    for table, values in change.items():
        manifest[table] |= values
    path.write_text(json.dumps(manifest))
    file = tmp_path / "ice.toml"
    write(baseline_of(experiment.run(file).json(), 1e-5), tmp_path / "baselines" / "ice.json")
    status, results, err = answer(capsys, file, "--against", run_folder)
    assert status == 1
    assert tolerances(results) == pytest.approx([2e-5] * len(tolerances(results)))
    assert said in err
    assert "with the tolerances for elsewhere" in err


def test_a_damaged_run_folder_is_exit_3(run_folder, tmp_path, capsys):
    (run_folder / "metrics.parquet").write_bytes(b"PAR1")
    status, results, err = answer(capsys, tmp_path / "ice.toml", "--against", run_folder)
    assert (status, results) == (3, [])
    assert "cannot be read" in err
    assert len(err.splitlines()) == 1


def set_column(folder, name, value):
    """Give every run of a folder the same value of a metric; None takes the metric out."""
    path = folder / "metrics.parquet"
    table = pq.read_table(path)
    values = pa.array([value] * table.num_rows, pa.float64())
    place = table.schema.get_field_index(name)
    changed = table.drop_columns([name]) if value is None else table.set_column(place, name, values)
    pq.write_table(changed, path)


def test_a_run_folder_whose_numbers_are_none_cannot_be_judged(run_folder, tmp_path, capsys):
    set_column(run_folder, "rms_position_error", math.nan)
    status, results, err = answer(capsys, tmp_path / "ice.toml", "--against", run_folder)
    assert (status, results) == (3, [])
    assert "rms_position_error: Input should be a finite number" in err
    assert len(err.splitlines()) == 1


def test_a_run_folder_without_a_gated_metric_cannot_be_judged(run_folder, tmp_path, capsys):
    (tmp_path / "ice.toml").write_text(OFFSET + WORLDS)  # as it was: the rest is the same
    for metric in GATED:
        set_column(run_folder, metric, None)
    status, results, err = answer(capsys, tmp_path / "ice.toml", "--against", run_folder)
    assert (status, results) == (3, [])
    assert f"does not hold {', '.join(GATED)}" in err


def verdicts(before, after, **status):
    recorded = baseline_of(payload(after)).runs
    recorded = [run.model_copy(update=status) for run in recorded]
    return [finding.verdict for finding in judge(as_baseline(payload(before), recorded, "x"), payload(after))]


def test_values_are_of_then_and_tolerances_of_now():
    before, after = [run_entry("a", rms=0.5)], [run_entry("a", rms=0.1)]
    (run,) = as_baseline(payload(before), baseline_of(payload(after), 1e-3).runs, "x").runs
    number = run.metrics["rms_position_error"]
    assert (number.value, number.tolerance) == (0.5, 1e-3)


def test_another_end_fails_also_where_runs_now_end_so_and_so():
    tipped, completed = [run_entry("a", status="tipped")], [run_entry("a")]
    assert verdicts(tipped, completed) == [Verdict.STATUS_CHANGED]
    assert verdicts(completed, tipped) == [Verdict.STATUS_CHANGED]
    seen = {"statuses_seen": ["tipped"]}
    assert verdicts(tipped, completed, **seen) == [Verdict.STATUS_CHANGED]
    assert verdicts(completed, tipped, **seen) == [Verdict.STATUS_CHANGED]
    assert verdicts([run_entry("a", status="diverged")], completed, **seen) == [Verdict.STATUS_CHANGED]


def test_a_metric_that_is_not_known_of_then_is_left_out():
    before, after = payload([run_entry("a")]), payload([run_entry("a")])
    del before["runs"][0]["metrics"]["rms_heading_error"]
    findings = judge(as_baseline(before, baseline_of(after).runs, "x"), after)
    assert "rms_heading_error" not in {finding.metric for finding in findings}
    assert all(finding.verdict is Verdict.SAME for finding in findings)


def test_nothing_in_common_cannot_be_judged():
    before, after = payload([run_entry("a")]), payload([run_entry("b")])
    with pytest.raises(CannotJudge, match="x has no run with the controllers"):
        as_baseline(before, baseline_of(after).runs, "x")
