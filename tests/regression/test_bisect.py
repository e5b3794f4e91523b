"""The bisection of docs/ci.md, as printed there, finds a planted commit."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from slipctl.cli import main
from tests.fakes import SHORT_SCENARIO
from tests.repository import ROOT, copy_of_slipctl, needs_git

pytestmark = [needs_git, pytest.mark.skipif(shutil.which("sh") is None, reason="there is no sh")]

SCENARIO = SHORT_SCENARIO + "[start]\nx_offset = 0.01\n"
"""Starts beside its path, so that the gain plays a part; called paper-kinematic, as in the recipe."""

LAW = "slipctl/control/flat.py"
GAIN = "- first_gain * position_error"
WHOLE = "reference.acceleration - first_gain * position_error - second_gain * velocity_error"
OTHERWISE = "-(second_gain * velocity_error + first_gain * position_error - reference.acceleration)"
IMPORT = "import math\n"
MISSING = IMPORT + "import missing_module\n"


def recipe():
    """The shell commands below the heading, and nothing else."""
    text = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
    _, section = text.split("## Which commit did it: git bisect\n")
    return re.findall(r"```sh\n(.*?)```", section, re.DOTALL)[0]


TRUTH = [
    ("good", "green"),
    ("good", "a page"),
    ("good", "another order of the sum"),
    ("skip", "cannot be imported: slipctl says so, with 3"),
    ("skip", "cannot be imported: Python says so, with 1"),
    ("good", "can be imported again"),
    ("bad", "a gain lost 5 %"),
    ("bad", "more of the page"),
    ("bad", "a comment"),
]
"""What each commit is, in their order."""


@pytest.fixture
def repository(tmp_path):
    """slipctl's source, green at the tag v0.1.0; eight commits later it is red."""
    repository = copy_of_slipctl(tmp_path / "source")
    file = repository.folder / "scenarios" / "paper-kinematic.toml"
    file.write_text(SCENARIO, encoding="utf-8")
    assert main(["check", str(file), "--record", "--quiet"]) == 0
    assert main(["run", str(file), "--record", "none", "--out", str(tmp_path / "runs"), "--quiet"]) == 0
    repository.commit("green")
    repository.git("tag", "v0.1.0")
    repository.commit("a page", {"page.md": "Words."})
    repository.replace(LAW, WHOLE, OTHERWISE)
    repository.commit("another order of the sum")
    repository.replace("slipctl/theory/robust.py", IMPORT, MISSING)
    repository.commit("cannot be imported: slipctl says so, with 3")
    repository.replace("slipctl/cli/exits.py", "import sys\n", "import sys\nimport missing_module\n")
    repository.commit("cannot be imported: Python says so, with 1")
    repository.replace("slipctl/theory/robust.py", MISSING, IMPORT)
    repository.replace("slipctl/cli/exits.py", "import sys\nimport missing_module\n", "import sys\n")
    repository.commit("can be imported again")
    repository.replace(LAW, GAIN.removeprefix("- "), "0.95 * " + GAIN.removeprefix("- "))
    repository.commit("a gain lost 5 %")
    repository.commit("more of the page", {"page.md": "More words."})
    file.write_text(SCENARIO + "# a comment\n", encoding="utf-8")
    repository.commit("a comment")
    return repository


@pytest.fixture
def on_the_path(tmp_path, repository):
    """An environment whose slipctl is that of the checkout, as after an editable install."""
    programs = tmp_path / "programs"
    programs.mkdir()
    shim = programs / "slipctl"
    python, source = Path(sys.executable).as_posix(), repository.folder.as_posix()
    shim.write_text(f'#!/bin/sh\nPYTHONPATH="{source}" exec "{python}" -m slipctl.cli "$@"\n', newline="\n")
    shim.chmod(0o755)
    return os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}


@pytest.mark.parametrize("how", ["as printed", "against a run"])
def test_the_recipe_names_the_planted_commit(repository, on_the_path, how):
    text = recipe()
    if how == "against a run":
        shutil.rmtree(repository.folder / "scenarios" / "baselines")
        text = text.replace('sh "$scenario"\n', 'sh "$scenario" --against ../runs/paper-kinematic\n')
        assert text.count("--against") == 1
    keep_the_log = text.replace("git bisect reset", "git bisect log\ngit bisect reset")
    done = subprocess.run(
        ["sh", "-c", keep_the_log], cwd=repository.folder, env=on_the_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (found,) = re.findall(r"^(\w+) is the first bad commit$", done.stdout, re.MULTILINE)
    assert repository.git("log", "-1", "--format=%s", found) == "a gain lost 5 %"
    judged = re.findall(r"^# (good|bad|skip): \[\w+\] (.*)$", done.stdout, re.MULTILINE)
    assert {(verdict, subject) for verdict, subject in judged} <= set(TRUTH)
    assert "skip" in {verdict for verdict, _ in judged}
    assert repository.git("symbolic-ref", "--short", "HEAD") == "main"
    assert len(repository.worktrees()) == 1


@pytest.mark.parametrize(
    ("slipctl", "status"),
    [
        ("echo '{}'", 0),
        ("echo '{}'; exit 1", 1),
        ("echo 'ImportError' >&2; exit 1", 125),
        ("echo 'what is that?' >&2; exit 2", 125),
        ("echo 'no baseline' >&2; exit 3", 125),
        ("exit 130", 255),
        (None, 255),
    ],
)
def test_git_is_told_what_each_exit_status_means(tmp_path, slipctl, status):
    (script,) = re.findall(r"sh -c '(.*?)' sh", recipe(), re.DOTALL)
    program = tmp_path / "slipctl"
    if slipctl is not None:
        program.write_text(f'#!/bin/sh\necho "$@" > "{tmp_path.as_posix()}/asked"\n{slipctl}\n', newline="\n")
        program.chmod(0o755)
    command = [str(shutil.which("sh")), "-c", script, "sh", "wet-slope", "--against", "main"]
    done = subprocess.run(command, env=os.environ | {"PATH": str(tmp_path)}, capture_output=True)
    assert done.returncode == status
    if slipctl is not None:
        assert (tmp_path / "asked").read_text() == "check wet-slope --against main --json --artefacts none\n"
