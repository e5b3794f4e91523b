"""What CI runs is what the README tells a newcomer to run."""

import math
import os
import re
import shlex
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement

from slipctl import shipped
from slipctl.metrics import UNITS
from slipctl.regression import read

ROOT = Path(__file__).resolve().parent.parent


WORKFLOW = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))
PAGE = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
SYSTEMS = ["ubuntu-latest", "macos-latest", "windows-latest"]


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
    job = WORKFLOW["jobs"]["tests"]
    assert ".ci/run" in [step.get("run") for step in job["steps"]]
    assert job["strategy"]["matrix"]["python"] == ["3.11", "3.13"]


def test_on_windows_the_same_is_run_without_a_shell_script():
    steps = WORKFLOW["jobs"]["tests"]["steps"]
    own = [step["run"] for step in steps if step.get("if") == "runner.os == 'Windows'"]
    (line,) = commands(ROOT / ".ci" / "run")
    install, tests = (part.partition(" && ")[0] for part in line.split(".venv/bin/")[1:])
    assert own == [f"python -m {install}".replace("'", '"'), tests]


@pytest.mark.parametrize("job", ["tests", "gate", "nightly"])
def test_every_job_runs_on_every_system_and_ends(job):
    entry = WORKFLOW["jobs"][job]
    assert entry["strategy"]["matrix"]["system"] == SYSTEMS
    assert entry["runs-on"] == "${{ matrix.system }}"
    assert entry["strategy"]["fail-fast"] is False
    assert entry["timeout-minutes"] <= 60


def test_the_gate_runs_on_the_oldest_engine_that_is_supported_and_on_the_newest():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (mujoco,) = [r for r in map(Requirement, project["dependencies"]) if r.name == "mujoco"]
    oldest, newest = WORKFLOW["jobs"]["gate"]["strategy"]["matrix"]["mujoco"]
    (lowest,) = [part.version for part in mujoco.specifier if part.operator == ">="]
    assert oldest.removesuffix(".0") == lowest
    assert newest == "newest"


@pytest.mark.parametrize("job", ["gate", "nightly"])
def test_what_the_gate_leaves_is_uploaded_when_it_fails(job):
    steps = WORKFLOW["jobs"][job]["steps"]
    (check,) = [step["run"] for step in steps if "slipctl check" in step.get("run", "")]
    upload = next(step for step in steps if "upload-artifact" in step.get("uses", ""))
    words = shlex.split(check)
    left = [words[words.index(option) + 1] for option in ("--junit", "--artefacts")]
    assert upload["with"]["path"].split() == left
    assert upload["if"] == "${{ !cancelled() }}"


def test_the_nightly_job_tries_what_is_not_released():
    triggers = WORKFLOW[True]  # YAML takes the word `on` for a truth value
    assert set(triggers) == {"push", "pull_request", "schedule", "workflow_dispatch"}
    job = WORKFLOW["jobs"]["nightly"]
    assert "schedule" in job["if"]
    (install,) = [step["run"] for step in job["steps"] if "--pre" in step.get("run", "")]
    assert {"mujoco", "numpy", "scipy", "rerun-sdk", "-U"} <= set(shlex.split(install))


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def test_the_page_says_how_wide_the_tolerances_of_the_committed_baselines_are():
    numbers = [
        (metric, number.value, number)
        for path in shipped.baseline_folder().glob("*.json")
        for run in read(path).runs
        for metric, number in run.metrics.items()
        if number.gate == "number" and number.value and metric != "guarantee_fraction"
    ]
    here = sorted(number.tolerance / value for _, value, number in numbers)
    elsewhere = sorted(number.tolerance_elsewhere / value for _, value, number in numbers)
    count = len(numbers)
    wide = [(metric, value) for metric, value, number in numbers if number.tolerance_elsewhere > 0.2 * value]
    said = re.search(
        r"Of the some (\d+) gated numbers .*? by ([\d.]+) % of themselves at most on the same engine .*?"
        r"half of them may be worse by ([\d.]+) %, nine in ten by ([\d.]+) % at most, and ([\d.]+) % of them"
        r" by more than a fifth: errors of ([\d.]+) mm or ([\d.]+)° at most and smooth torques",
        " ".join(PAGE.split()),
    )
    assert said is not None
    measured = [
        count,
        100.0 * here[int(0.9 * count)],
        100.0 * elsewhere[int(0.5 * count)],
        100.0 * elsewhere[int(0.9 * count)],
        100.0 * len(wide) / count,
    ]
    assert [float(text) for text in said.groups()[:5]] == pytest.approx(measured, rel=0.2)
    limits = {"m": 1e-3 * float(said[6]), "rad": math.radians(float(said[7]))}
    for metric, value in wide:
        assert metric == "command_variation" or value <= limits[UNITS[metric]], metric


def test_the_ten_lines_of_the_page_are_a_workflow():
    text, _ = blocks("yaml")
    assert len(text.splitlines()) == 10
    steps = yaml.safe_load(text)["jobs"]["gate"]["steps"]
    (check,) = [step["run"] for step in steps if "slipctl check" in step.get("run", "")]
    (upload,) = [step for step in steps if "upload-artifact" in step.get("uses", "")]
    # what is written by default lies in the folder that is uploaded
    assert upload["with"]["path"] == "runs"
    assert "--junit runs/check.xml" in check


def test_the_page_s_workflow_that_records_asks_for_what_it_needs_and_uploads_it():
    workflow = yaml.safe_load(blocks("yaml")[1])
    asked = workflow[True]["workflow_dispatch"]["inputs"]  # YAML takes the word `on` for a truth value
    steps = workflow["jobs"]["record"]["steps"]
    (check,) = [step for step in steps if "slipctl check" in step.get("run", "")]
    # what a person types is no part of the script: it could be anything
    assert "${{" not in check["run"]
    given = {name: re.findall(r"inputs\.(\w+)", value) for name, value in check["env"].items()}
    assert sorted(name for names in given.values() for name in names) == sorted(asked)
    assert set(re.findall(r"\$(\w+)", check["run"])) == set(given)
    (upload,) = [step for step in steps if "upload-artifact" in step.get("uses", "")]
    assert f"into `{upload['with']['path']}`" in PAGE
    # the baseline is written though a claim fails
    assert upload["if"] == "!cancelled()"


def commands_of_the_page():
    lines = [line for text in blocks("sh") for line in text.splitlines()]
    jobs = [job for text in blocks("yaml") for job in yaml.safe_load(text)["jobs"].values()]
    lines += [step["run"] for job in jobs for step in job["steps"] if "run" in step]
    return sorted({line for line in lines if line.startswith("slipctl ")})


@pytest.mark.parametrize("line", [*commands_of_the_page(), "slipctl check --junit a --artefacts b"])
def test_every_command_of_the_page_has_only_options_that_exist(line):
    name, *words = shlex.split(line, comments=True)[1:]
    assert {word for word in words if word.startswith("--")} <= options(name)


def test_every_option_that_the_page_names_exists():
    named = set(re.findall(r"(?<![\w-])--[a-z]+(?:-[a-z]+)*", PAGE))
    assert {"--junit", "--artefacts", "--record", "--update", "--reason", "--json", "--against"} <= named
    assert named - {"--format"} <= options("check") | options("run")  # git has one of its own


def options(name):
    import typer

    from slipctl.cli.app import app

    group: Any = typer.main.get_command(app)
    return {option for parameter in group.commands[name].params for option in parameter.opts}


def test_every_direct_dependency_is_pinned_within_its_range():
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
