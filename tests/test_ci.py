"""What CI runs is what the README tells a newcomer to run."""

import os
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def commands(path):
    return [
        line
        for line in path.read_text(encoding="utf-8").splitlines()
        if "venv" in line and "pip install" in line
    ]


def test_the_line_in_ci_run_stands_in_the_readme():
    (line,) = commands(ROOT / ".ci" / "run")
    assert line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert line.endswith("-m tests")


def test_ci_run_can_be_executed_and_passes_the_exit_status_on():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    lines = script.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "#!/usr/bin/env bash"
    assert "set -euo pipefail" in lines
    assert [line for line in lines if line][-1] == commands(script)[0]  # nothing after it hides its status


def test_the_workflow_runs_the_same_script():
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert "run: .ci/run" in text
    assert re.findall(r'"3\.\d+"', text) == ['"3.11"', '"3.13"']


def test_every_direct_dependency_is_pinned_within_its_range():
    from packaging.requirements import Requirement

    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = dict(line.lower().split("==") for line in lines if line and not line.startswith("#"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = project["dependencies"] + project["optional-dependencies"]["dev"]
    for requirement in map(Requirement, wanted):
        assert requirement.specifier.contains(pins[requirement.name.lower()]), requirement


def test_pins_name_no_place_to_download_from():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    assert all(
        re.fullmatch(r"[A-Za-z0-9_.-]+==[0-9a-z.]+", line) for line in lines if not line.startswith("#")
    )


def test_every_step_runs_and_the_first_failure_gives_the_exit_status(monkeypatch, capfd):
    from tests import __main__ as steps

    def python(code):
        return [sys.executable, "-c", code]

    monkeypatch.setattr(
        steps,
        "STEPS",
        {
            "good": python("print('one')"),
            "bad": python("raise SystemExit(5)"),
            "worse": python("raise SystemExit(7)"),
            "last": python("print('four')"),
        },
    )
    assert steps.main() == 5
    out = capfd.readouterr().out
    assert "one" in out
    assert "four" in out
    assert out.endswith("2 of 4 steps good; FAILED: bad, worse\n")


def test_the_steps_are_those_that_a_change_must_pass():
    from tests import __main__ as steps

    names = [Path(command[0]).name for command in steps.STEPS.values()]
    assert names == ["ruff", "ruff", "pyright", "lint-imports", "slipctl", "slipctl", "pytest"]
