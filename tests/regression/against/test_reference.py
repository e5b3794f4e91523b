"""What a scenario gave elsewhere: found by name, run as it stood, read back from a run folder."""

import json
import math
import shutil
import tempfile
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from slipctl import experiment, shipped
from slipctl.regression import git
from slipctl.regression.against import reference
from slipctl.regression.against.reference import Revision, RunFolder, find
from slipctl.regression.baseline.file import CannotJudge
from slipctl.scenario import load
from tests.fakes import SHORT_SCENARIO
from tests.repository import Repository, copy_of_slipctl, needs_git

OFFSET = SHORT_SCENARIO + "[start]\nx_offset = 0.01\n"
"""Starts beside its path, so that the gain plays a part."""

GIVES_NAN = """
import json

run = {"controller": "a", "varied": {}, "seed": 0, "status": "completed"}
run["metrics"] = {"rms_position_error": float("nan")}
head = {"scenario": "ice", "scenario_id": "s", "model_id": None, "versions": {}}
print(json.dumps(head | {"runs": [run]}))
"""
"""A slipctl whose answer is a run with a number that is none."""

SWEPT = OFFSET + '[sweep]\nseed = [1, 2]\n"start.y_offset" = [0.0, 0.01]\n'


def numbers(payload):
    return {
        (run["controller"], tuple(run["varied"].items()), run["seed"]): run["metrics"]
        for run in payload["runs"]
    }


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The folder for temporary files, where the test can see what is left."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def repository(tmp_path, temporary):
    """A user's repository: a scenario whose gain changed after the tag `then`."""
    repository = Repository(tmp_path / "mine")
    repository.commit("first", {"ice.toml": OFFSET})
    repository.git("tag", "then")
    repository.commit("slower", {"ice.toml": OFFSET.replace("pole = -1.0", "pole = -0.9")})
    return repository


@pytest.fixture
def run_folder(tmp_path):
    (tmp_path / "ice.toml").write_text(SWEPT)
    return experiment.run(tmp_path / "ice.toml", out=tmp_path / "runs", record="none").folder


def test_a_run_folder_gives_back_what_the_run_gave(run_folder, tmp_path):
    found = find(str(tmp_path / "ice.toml"), str(run_folder))
    assert isinstance(found, RunFolder)
    read = found.reference()
    direct = experiment.run(tmp_path / "ice.toml").json()
    assert numbers(read.payload) == numbers(direct)
    assert len(numbers(direct)) == 4
    for key in ("scenario", "scenario_id", "model_id", "versions"):
        assert read.payload[key] == direct[key]
    assert read.machine == json.loads((run_folder / "manifest.json").read_text())["machine"]
    assert read.notes == ()


def test_a_run_that_was_interrupted_says_so(run_folder):
    path = run_folder / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"interrupted": True}))
    (note,) = RunFolder(run_folder).reference().notes
    assert "was interrupted" in note


def rewrite(folder, change):
    """Change the manifest of a run folder."""
    content = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps(change(content)))


def replace(folder, column, values):
    """Put other values into a column of the metrics."""
    table = pq.read_table(folder / "metrics.parquet")
    place = table.schema.get_field_index(column)
    changed = table.set_column(place, column, pa.array([values] * table.num_rows))
    pq.write_table(changed, folder / "metrics.parquet")


def without(folder, column):
    pq.write_table(
        pq.read_table(folder / "metrics.parquet").drop_columns([column]), folder / "metrics.parquet"
    )


def cut(folder, name, size):
    (folder / name).write_bytes((folder / name).read_bytes()[:size])


DAMAGE = {
    "cut manifest": (lambda folder: cut(folder, "manifest.json", 100), "cannot be read"),
    "cut metrics": (lambda folder: cut(folder, "metrics.parquet", 50), "cannot be read"),
    "a list": (lambda folder: rewrite(folder, lambda _: []), "cannot be read"),
    "newer": (
        lambda folder: rewrite(folder, lambda content: content | {"format": 9}),
        "format 9; this slipctl reads format 1",
    ),
    "no model": (
        lambda folder: rewrite(folder, lambda c: {key: c[key] for key in c if key != "model_id"}),
        "'model_id' is missing",
    ),
    "no status": (lambda folder: without(folder, "status"), "'status' is missing"),
    "no swept key": (lambda folder: without(folder, "start.y_offset"), "'start.y_offset' is missing"),
    "machine a list": (lambda folder: rewrite(folder, lambda c: c | {"machine": []}), "at machine"),
    "no versions": (lambda folder: rewrite(folder, lambda c: c | {"versions": None}), "at versions"),
    "scenario a list": (
        lambda folder: rewrite(folder, lambda c: c | {"scenario_file": []}),
        "at scenario_file",
    ),
    "sweep a list": (
        lambda folder: rewrite(folder, lambda c: c | {"scenario_file": {"sweep": ["seed"]}}),
        "at scenario_file.sweep",
    ),
    "finished a list": (lambda folder: rewrite(folder, lambda c: c | {"finished": []}), "at finished"),
    "not a number": (
        lambda folder: replace(folder, "rms_position_error", math.nan),
        "runs.0.metrics.rms_position_error: Input should be a finite number",
    ),
    "infinity": (
        lambda folder: replace(folder, "max_position_error", math.inf),
        "runs.0.metrics.max_position_error: Input should be a finite number",
    ),
    "text": (
        lambda folder: replace(folder, "rms_position_error", "0.01"),
        "runs.0.metrics.rms_position_error: Input should be a valid number",
    ),
    "null": (
        lambda folder: replace(folder, "rms_position_error", None),
        "rms_position_error has no value though the run completed",
    ),
    "one seed": (lambda folder: replace(folder, "seed", 1), "the same run twice"),
    "seeds in words": (lambda folder: replace(folder, "seed", "one"), "runs.0.seed"),
}


@pytest.mark.parametrize("how", DAMAGE)
def test_a_damaged_run_folder_cannot_be_compared_with(run_folder, how):
    damage, said = DAMAGE[how]
    damage(run_folder)
    with pytest.raises(CannotJudge, match=said) as error:
        RunFolder(run_folder).reference()
    assert "\n" not in str(error.value)


def test_a_metric_that_an_older_slipctl_did_not_have_is_left_out(run_folder):
    metrics = run_folder / "metrics.parquet"
    pq.write_table(pq.read_table(metrics).drop_columns(["rms_heading_error"]), metrics)
    for run in RunFolder(run_folder).reference().payload["runs"]:
        assert "rms_heading_error" not in run["metrics"]
        assert "rms_position_error" in run["metrics"]


@needs_git
def test_a_revision_is_run_as_it_stood_by_this_slipctl(repository, temporary):
    file = repository.folder / "ice.toml"
    file.write_text("not a scenario any more")
    found = find(str(file), "then")
    assert isinstance(found, Revision)
    gave = found.reference()
    then = load_text(repository, OFFSET)
    assert numbers(gave.payload) == numbers(then)
    assert gave.payload["scenario_id"] == then["scenario_id"]
    assert gave.label.startswith("then (")
    assert gave.notes == ("run by this slipctl",)
    assert gave.machine is None
    assert file.read_text() == "not a scenario any more"
    assert len(repository.worktrees()) == 1
    assert list(temporary.iterdir()) == []


def load_text(repository, text):
    (repository.folder.parent / "ice.toml").write_text(text)
    return experiment.run(repository.folder.parent / "ice.toml").json()


@needs_git
def test_the_revision_before_and_after_differ_by_the_gain(repository):
    file = str(repository.folder / "ice.toml")
    then, now = (find(file, name).reference().payload for name in ("HEAD~1", "main"))
    assert then["scenario_id"] != now["scenario_id"]
    (first,), (second,) = numbers(then).values(), numbers(now).values()
    assert second["rms_position_error"] > 1.01 * first["rms_position_error"]


@needs_git
def test_files_that_a_scenario_names_are_those_of_then(repository):
    robot = shipped.model_path("magellan_pro").read_text(encoding="utf-8")
    text = OFFSET.replace('"magellan_pro"', '"robot.xml"')
    repository.commit("own robot", {"ice.toml": text, "robot.xml": robot})
    assert 'name="magellan_pro"' in robot or "<mujoco" in robot
    repository.commit("renamed", {"ice.toml": text, "robot.xml": robot.replace("<mujoco", "<mujoco ", 1)})
    before, after = (
        find(str(repository.folder / "ice.toml"), name).reference().payload for name in ("HEAD~1", "HEAD")
    )
    assert before["scenario_id"] != after["scenario_id"]  # a robot's file counts by its content
    assert numbers(before) == numbers(after)


@needs_git
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "then .* has no ice.toml"),
        ("tick = ", "then .* cannot run ice.toml: .*not a TOML file"),
        (OFFSET.replace("pole = -1.0", "pole = 1.0"), "then .* cannot run ice.toml: .*pole"),
    ],
)
def test_a_revision_that_cannot_run_the_scenario_cannot_be_judged(tmp_path, temporary, text, said):
    repository = Repository(tmp_path / "mine")
    repository.commit("first", {"other.txt": ""} if text is None else {"ice.toml": text})
    repository.git("tag", "then")
    repository.commit("second", {"ice.toml": OFFSET})
    with pytest.raises(CannotJudge, match=said) as error:
        find(str(repository.folder / "ice.toml"), "then").reference()
    assert "\n" not in str(error.value)
    assert str(temporary) not in str(error.value)
    assert len(repository.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_an_interruption_leaves_no_worktree(repository, temporary, monkeypatch):
    def interrupted(*_, **__):
        assert len(repository.worktrees()) == 2
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.experiment.run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        find(str(repository.folder / "ice.toml"), "then").reference()
    assert len(repository.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_a_name_that_is_neither_says_what_is_near(repository, tmp_path):
    file = str(repository.folder / "ice.toml")
    with pytest.raises(git.UnknownRevision, match=r"--against thn: there is no such folder, and .* then\?"):
        find(file, "thn")
    with pytest.raises(git.UnknownRevision, match="the folder holds no run, and git knows no revision"):
        find(file, str(tmp_path))


@needs_git
def test_a_name_that_is_both_is_the_folder_and_says_so(repository, run_folder, monkeypatch):
    monkeypatch.chdir(run_folder.parent)
    run_folder.rename("then")
    found = find(str(repository.folder / "ice.toml"), "then")
    assert isinstance(found, RunFolder)
    assert found.notes == ("then is a run folder and a git revision: the folder is taken",)
    (run_folder.parent / "main").mkdir()  # no run in it
    assert isinstance(find(str(repository.folder / "ice.toml"), "main"), Revision)


@needs_git
def test_a_scenario_outside_git_has_no_revision(tmp_path):
    (tmp_path / "ice.toml").write_text(OFFSET)
    with pytest.raises(CannotJudge, match="in no git checkout"):
        find(str(tmp_path / "ice.toml"), "HEAD")


@needs_git
def test_a_shipped_scenario_of_an_installed_slipctl_has_no_revision(tmp_path, monkeypatch):
    # as in a virtual environment within a user's own checkout: git is around, but does not hold the package
    repository = Repository(tmp_path / "mine")
    repository.commit("first", {".gitignore": "venv"})
    package = repository.folder / "venv" / "slipctl"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    monkeypatch.setattr(reference, "PACKAGE", package)
    with pytest.raises(CannotJudge, match="comes with the installed slipctl, which is no git checkout"):
        find("paper-kinematic", "HEAD")


@pytest.fixture(scope="module")
def slipctl_source(tmp_path_factory):
    """slipctl's own source with a scenario; the commit after the tag `then` halves a gain in the code."""
    repository = copy_of_slipctl(tmp_path_factory.mktemp("source") / "slipctl")
    (repository.folder / "scenarios" / "ice.toml").write_text(OFFSET)
    repository.commit("first")
    repository.git("tag", "then")
    gain = "- first_gain * position_error"
    repository.replace("slipctl/control/flat.py", gain, gain.replace("- ", "- 0.5 * "))
    repository.commit("half a gain")
    repository.git("tag", "halved")
    repository.replace(
        "slipctl/theory/robust.py", "def chain_gains", "import missing_module\n\n\ndef chain_gains"
    )
    repository.commit("cannot be imported")
    repository.git("tag", "broken")
    repository.commit("ends as after Ctrl-C", {"slipctl/cli/__main__.py": "raise SystemExit(130)\n"})
    repository.git("tag", "interrupted")
    repository.commit("gives no numbers", {"slipctl/cli/__main__.py": GIVES_NAN})
    repository.git("tag", "nan")
    return repository


@needs_git
def test_slipctl_itself_is_run_as_it_stood(slipctl_source, temporary):
    file = slipctl_source.folder / "scenarios" / "ice.toml"
    then, halved = (find(str(file), name).reference() for name in ("then", "halved"))
    assert then.notes == halved.notes == ("run by the slipctl of then",)
    direct = experiment.run(load(file)).json()
    assert numbers(then.payload) == numbers(direct)
    (whole,), (half,) = numbers(then.payload).values(), numbers(halved.payload).values()
    assert half["rms_position_error"] > 1.01 * whole["rms_position_error"]
    assert list(temporary.iterdir()) == []


@needs_git
def test_the_working_folder_and_the_path_do_not_decide_which_slipctl_runs(slipctl_source, monkeypatch):
    decoy = slipctl_source.folder.parent / "decoy"
    shutil.copytree(slipctl_source.folder / "slipctl", decoy / "slipctl", dirs_exist_ok=True)
    (decoy / "slipctl" / "cli" / "__main__.py").write_text("raise SystemExit('the decoy')")
    monkeypatch.chdir(decoy)
    monkeypatch.setenv("PYTHONPATH", str(decoy))
    gave = find(str(slipctl_source.folder / "scenarios" / "ice.toml"), "then").reference()
    assert len(gave.payload["runs"]) == 1


@needs_git
def test_a_slipctl_that_cannot_be_imported_cannot_be_compared_with(slipctl_source, temporary):
    found = find(str(slipctl_source.folder / "scenarios" / "ice.toml"), "broken")
    with pytest.raises(CannotJudge, match=r"broken .* cannot run scenarios/ice.toml: .*missing_module"):
        found.reference()
    assert len(slipctl_source.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_a_revision_that_gives_no_numbers_cannot_be_compared_with(slipctl_source, temporary):
    found = find(str(slipctl_source.folder / "scenarios" / "ice.toml"), "nan")
    with pytest.raises(CannotJudge, match=r"what nan .* is damaged at runs.0.metrics.rms_position_error"):
        found.reference()
    assert len(slipctl_source.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_an_interruption_of_the_slipctl_of_then_leaves_nothing(slipctl_source, temporary):
    found = find(str(slipctl_source.folder / "scenarios" / "ice.toml"), "interrupted")
    with pytest.raises(KeyboardInterrupt):
        found.reference()
    assert len(slipctl_source.worktrees()) == 1
    assert list(temporary.iterdir()) == []


@needs_git
def test_a_shipped_scenario_is_that_of_its_checkout(slipctl_source, monkeypatch):
    monkeypatch.setattr(reference, "PACKAGE", slipctl_source.folder / "slipctl")
    monkeypatch.setattr(shipped, "_PACKAGE", slipctl_source.folder / "slipctl")
    found = find("ice", "then")
    assert isinstance(found, Revision)
    assert (found.root, found.file, found.source) == (
        slipctl_source.folder,
        Path("scenarios/ice.toml"),
        Path(),
    )
