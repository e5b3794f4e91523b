"""The fixture that gates a law of one's own, in test suites of its own."""

from __future__ import annotations

import importlib.metadata
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from textwrap import dedent

import pytest

# Suites run in this process; what they import must stay, as extension modules load only once.
import slipctl.regression.own_law.check
import slipctl.view  # noqa: F401
from slipctl.regression import read
from tests.repository import Repository, needs_git

pytest_plugins = "pytester"

ROOT = Path(__file__).resolve().parents[1]

SCENARIO = """
tick = 0.02
robot = { model = "magellan_pro", drive = "wheel_speed" }
plant = { kind = "kinematic_ode" }
slip = { kind = "proportional", longitudinal = 0.2, lateral = 0.1 }
reference = { kind = "line", speed = 0.3, distance = 0.6 }
start = { y_offset = 0.02 }

[[controller]]
kind = "nominal_kinematic"
pole = -1.0
"""

LAW = """
import numpy as np
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.theory.robust import chain_gains

POLE = -2.0

def my_law(robot):
    return NominalKinematic(robot.speed_drive(), chain_gains(np.full(robot.worlds, POLE), 2))
"""

TEST = """
import law

def test_my_law(slipctl_check):
    slipctl_check("line.toml", controller=law.my_law)
"""


@pytest.fixture
def suite(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A folder of tests: a scenario, a law and a test of it."""
    # the law's file is changed within a second, which compiled files do not notice
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    pytester.path.joinpath("line.toml").write_text(SCENARIO, encoding="utf-8")
    pytester.makepyfile(law=LAW, test_law=TEST)
    pytester.syspathinsert()
    return pytester


def run(suite: pytest.Pytester, *arguments: str, in_process: bool = True) -> pytest.RunResult:
    plugin = () if _is_installed() else ("-p", "slipctl.pytest_plugin")
    call = suite.runpytest_inprocess if in_process else suite.runpytest_subprocess
    without = ("-p", "no:cacheprovider", "-p", "no:randomly", "--slipctl-artefacts", "none")
    return call(*without, *plugin, *arguments)


def _is_installed() -> bool:
    return any(point.name == "slipctl" for point in importlib.metadata.entry_points(group="pytest11"))


def weaken(suite: pytest.Pytester, pole: float) -> None:
    text = LAW.replace("POLE = -2.0", f"POLE = {pole}")
    suite.path.joinpath("law.py").write_text(text, encoding="utf-8")


@pytest.fixture
def recorded(suite: pytest.Pytester) -> pytest.Pytester:
    run(suite, "--slipctl-record", "the first").assert_outcomes(passed=1)
    return suite


def baseline(suite: pytest.Pytester, label: str = "my_law") -> Path:
    return suite.path / "baselines" / f"line.{label}.json"


def test_a_missing_baseline_fails_with_the_command_that_records_it(suite) -> None:
    result = run(suite)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ['no baseline *line.my_law.json; record one: pytest "test_law.py::test_my_law" --slipctl-record "*"']
    )
    assert not baseline(suite).exists()
    # nothing but the message: no traceback of slipctl's own
    assert "check.py" not in result.stdout.str()
    assert "During handling" not in result.stdout.str()


def test_recording_writes_the_law_s_runs_only_and_says_so(recorded) -> None:
    found = read(baseline(recorded))
    assert [run.controller for run in found.runs] == ["my_law"]
    assert found.reason == "the first"
    assert baseline(recorded).with_name("line.my_law.tracks.parquet").exists()
    again = run(recorded, "--slipctl-record", "the second")
    again.assert_outcomes(passed=1)
    again.stdout.fnmatch_lines(
        [
            "*= slipctl =*",
            "line, my_law: recorded in *line.my_law.json: the second",
            "  7 numbers of 1 run recorded",
        ]
    )
    assert read(baseline(recorded)).runs == found.runs


def test_the_same_law_passes(recorded) -> None:
    result = run(recorded)
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["*= slipctl =*", "line, my_law: * same"])


def test_a_worse_law_fails_and_the_metric_is_named(recorded) -> None:
    weaken(recorded, -1.5)
    result = run(recorded)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "line, my_law: * worse*",
            "*compared with the record of ????-??-??: the first*",
            "*rms position error* mm *worse",
            'if this is meant: pytest "test_law.py::test_my_law" --slipctl-record "reason"',
        ]
    )
    weaken(recorded, -2.0)
    run(recorded).assert_outcomes(passed=1)


def test_what_failed_is_recorded_beside_the_baseline(recorded) -> None:
    weaken(recorded, -1.5)
    result = run(recorded, "--slipctl-artefacts", "seen")
    result.assert_outcomes(failed=1)
    folder = recorded.path / "seen" / "line"
    result.stdout.fnmatch_lines([f"look at what failed: slipctl view {folder.as_posix()}"])
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["line-against-baseline.rrd", "line.rrd"]
    assert all(b"my_law" in path.read_bytes() for path in folder.iterdir())
    # a place that cannot be written does not hide the verdict
    recorded.path.joinpath("taken").write_text("", encoding="utf-8")
    result = run(recorded, "--slipctl-artefacts", "taken")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ["line, my_law: * worse*", "no recordings: cannot write*taken*name another with --slipctl-artefacts"]
    )
    # without the tracks there is one recording, and it is said what makes them
    baseline(recorded).with_name("line.my_law.tracks.parquet").unlink()
    result = run(recorded, "--slipctl-artefacts", "alone")
    result.stdout.fnmatch_lines(
        [
            '*tracks.parquet is not there: *made by pytest "test_law.py::test_my_law" --slipctl-record "*"',
            "look at what failed: slipctl view *alone/line",
        ]
    )


def test_a_better_law_passes_and_is_reported(recorded) -> None:
    weaken(recorded, -2.5)
    result = run(recorded)
    # it also drives otherwise: what it takes more of is worse
    numbers = json.loads(baseline(recorded).read_text(encoding="utf-8"))["runs"][0]["metrics"]
    assert numbers["rms_position_error"]["value"] > 0
    result.stdout.fnmatch_lines(["*better: rms_position_error*"])


def test_better_alone_passes_and_asks_to_be_recorded(recorded) -> None:
    text = baseline(recorded).read_text(encoding="utf-8")
    content = json.loads(text)
    number = content["runs"][0]["metrics"]["rms_position_error"]
    number["value"] *= 2.0
    baseline(recorded).write_text(json.dumps(content), encoding="utf-8")
    result = run(recorded)
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(
        [
            "line, my_law: 1 better, * same",
            "*better: rms_position_error*(-50 %)*",
            '*record it: pytest "test_law.py::test_my_law" --slipctl-record "reason"',
        ]
    )
    after = run(recorded, "--slipctl-record", "an integral was added")
    after.stdout.fnmatch_lines(["*: an integral was added", "  rms_position_error * → * mm"])


def test_a_law_that_raises_is_named_with_its_tick(recorded) -> None:
    spoiled = LAW + dedent(
        """
        class Raises:
            def __init__(self, robot):
                self.law = my_law(robot)
            def start(self, start):
                return self.law.start(start), 0
            def update(self, memory, reference, motion, tick):
                decision = self.law.update(memory[0], reference, motion, tick)
                if memory[1] == 4:
                    raise ValueError("the gain is lost")
                return type(decision)(decision.command, (decision.memory, memory[1] + 1), decision.trace)
        """
    )
    recorded.path.joinpath("law.py").write_text(spoiled, encoding="utf-8")
    recorded.makepyfile(test_law=TEST.replace("law.my_law", 'law.Raises, label="my_law"'))
    result = run(recorded)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            '*raise ValueError("the gain is lost")',
            "*OwnLawError: law 'my_law' at tick 4 (0.08 s) failed: ValueError: the gain is lost",
            "line.toml, my_law: not judged: law 'my_law' at tick 4 *",
        ]
    )


@pytest.mark.parametrize(
    ("arguments", "outcome", "said"),
    [
        ('better_than="nominal_kinematic", factor=1.5', "passed", "line, my_law: * same, 1 claim held"),
        ('better_than="nominal_kinematic", factor=50', "failed", "*claim failed: my_law beats nominal*"),
        ('better_than="nominal"', "failed", '*no controller labelled "nominal"*'),
        ("factor=2", "failed", "factor goes with better_than*"),
        ('expect=[{"kind": "below", "limit": 0.1}]', "passed", "line, my_law: * same, 1 claim held"),
        (
            'expect=[{"kind": "below", "limit": 1e-6}]',
            "failed",
            "*claim failed: rms_position_error of my_law*",
        ),
        ('expect=[{"kind": "belo", "limit": 0.1}]', "failed", '*"below"*'),
        ('overrides={"slip.lateral": 0.15}', "failed", "*another scenario than the one*"),
        ('overrides={"slip.lateral": "a"}', "failed", "*slip.lateral*"),
        ('label="nominal_kinematic"', "failed", "*lists a controller 'nominal_kinematic' itself*"),
        ('label="My Law"', "failed", "*the label 'My Law', allowed are lower-case*"),
    ],
)
def test_claims_labels_and_overrides(recorded, arguments, outcome, said) -> None:
    recorded.makepyfile(test_law=TEST.replace("law.my_law", f"law.my_law, {arguments}"))
    result = run(recorded)
    result.assert_outcomes(**{outcome: 1})
    result.stdout.fnmatch_lines([said])


def test_a_failed_claim_fails_while_recording_too(suite) -> None:
    suite.makepyfile(
        test_law=TEST.replace("law.my_law", 'law.my_law, better_than="nominal_kinematic", factor=50')
    )
    result = run(suite, "--slipctl-record", "the first")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*claim failed*"])
    # no recording would help
    assert "if this is meant" not in result.stdout.str()


def test_overrides_sweep_and_a_label_of_its_own_keeps_them_apart(suite) -> None:
    suite.makepyfile(
        test_law="""
        import law

        def test_both(slipctl_check):
            slipctl_check("line.toml", controller=law.my_law)
            over = {"slip.lateral": [0.0, 0.1], "tick": 0.02}
            report = slipctl_check("line.toml", controller=law.my_law, label="swept", overrides=over)
            lateral = {finding.varied["slip.lateral"] for finding in report.findings}
            assert report.recorded or lateral == {0.0, 0.1}

        def test_shared(slipctl_check):
            slipctl_check("line.toml", controller=law.my_law, overrides={"slip.lateral": 0.0})
        """
    )
    first = run(suite, "--slipctl-record", "the first")
    first.assert_outcomes(passed=1, failed=1)
    first.stdout.fnmatch_lines(["two checks share line.my_law.json but not the scenario: give one of them*"])
    assert len(read(baseline(suite, "swept")).runs) == 2
    run(suite, "-k", "both").assert_outcomes(passed=1)


def test_a_lambda_needs_a_label(suite) -> None:
    suite.makepyfile(test_law=TEST.replace("law.my_law", "lambda robot: law.my_law(robot)"))
    result = run(suite)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["'<lambda>' is no label: say label=*"])


@pytest.mark.parametrize("text", ["", "{", '{"format": 3}'])
def test_a_damaged_baseline_is_no_pass(recorded, text) -> None:
    baseline(recorded).write_text(text, encoding="utf-8")
    result = run(recorded)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["baseline *line.my_law.json is *"])


def test_a_test_that_asks_for_a_check_and_calls_none_fails(suite) -> None:
    suite.makepyfile(
        test_law="""
        import pytest

        def test_forgotten(slipctl_check):
            pass

        def test_skipped(slipctl_check):
            pytest.skip("not here")

        @pytest.mark.xfail
        def test_failing(slipctl_check):
            raise ValueError("no check before this")

        def test_failed(slipctl_check):
            raise ValueError("no check before this")
        """
    )
    result = run(suite)
    # it is the first that has an error, of its own; the others have said what they have to say
    result.assert_outcomes(passed=1, errors=1, skipped=1, xfailed=1, failed=1)
    said = [line for line in result.outlines if "asked for slipctl_check and never called it" in line]
    assert "asked for slipctl_check and never called it: nothing was checked" in said
    result.stdout.fnmatch_lines(["*ERROR at teardown of test_forgotten*"])
    result.stdout.no_fnmatch_line("*ERROR at teardown of test_[!f]*")


def test_a_check_that_fails_has_been_called(recorded) -> None:
    weaken(recorded, -1.5)
    run(recorded).assert_outcomes(failed=1)


def test_a_baseline_that_cannot_be_written_is_one_line_before_anything_is_run(suite, monkeypatch) -> None:
    monkeypatch.setattr("slipctl.experiment.run", lambda *_, **__: pytest.fail("ran"))
    suite.path.joinpath("baselines").write_text("a file", encoding="utf-8")
    result = run(suite, "--slipctl-record", "in vain")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ["cannot write the baseline *line.my_law.json: *", "line.toml, my_law: not judged"]
    )
    assert "check.py" not in result.stdout.str()


def test_a_disk_that_is_full_at_the_end_is_one_line_too(suite, monkeypatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("slipctl.regression.own_law.check.write_with_tracks", full)
    result = run(suite, "--slipctl-record", "in vain")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*No space left on device", "line.toml, my_law: not judged"])
    assert "check.py" not in result.stdout.str()


NOISY = """
class Noisy:
    def __init__(self, robot):
        self.law = my_law(robot)
        self.noise = np.random.default_rng()

    def start(self, start):
        return self.law.start(start)

    def update(self, memory, reference, motion, tick):
        wrong = 0.001 * self.noise.standard_normal(motion.position.shape)
        return self.law.update(memory, reference, replace(motion, position=motion.position + wrong), tick)
"""


def test_a_law_that_does_not_repeat_is_not_recorded(suite) -> None:
    suite.path.joinpath("law.py").write_text("from dataclasses import replace\n" + LAW + NOISY, "utf-8")
    suite.makepyfile(test_law=TEST.replace("law.my_law", "law.Noisy"))
    result = run(suite, "--slipctl-record", "in vain")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["line: noisy is not repeatable, so that nothing can be recorded: *"])
    assert not baseline(suite, "noisy").exists()


CHAOTIC = """
from dataclasses import replace

class Chaotic:
    def __init__(self, robot):
        self.law = my_law(robot)

    def start(self, start):
        return self.law.start(start), 0.02 * np.sin(1e11 * start.position)

    def update(self, memory, reference, motion, tick):
        inner, wrong = memory
        motion = replace(motion, position=motion.position + wrong)
        decision = self.law.update(inner, reference, motion, tick)
        return replace(decision, memory=(decision.memory, wrong))
"""
"""A law that a nanometre at the start leads astray by centimetres."""


def test_recording_says_how_many_numbers_are_chaotic(suite) -> None:
    suite.path.joinpath("law.py").write_text(LAW + CHAOTIC, encoding="utf-8")
    suite.makepyfile(test_law=TEST.replace("law.my_law", "law.Chaotic"))
    result = run(suite, "--slipctl-record", "the first")
    result.assert_outcomes(passed=1)
    numbers = read(baseline(suite, "chaotic")).runs[0].metrics.values()
    chaotic = sum(number.gate == "verdict" for number in numbers)
    assert chaotic >= 3
    result.stdout.fnmatch_lines(
        [
            "line, chaotic: recorded in *: the first",
            f"  7 numbers of 1 run recorded, {chaotic} of them chaotic and not gated as numbers",
        ]
    )


@needs_git
def test_what_failed_names_the_commit_of_the_tests_repository(suite) -> None:
    commit = Repository(suite.path).commit("a law")
    run(suite, "--slipctl-record", "the first").assert_outcomes(passed=1)
    assert read(baseline(suite)).commit == commit[:12]
    weaken(suite, -1.5)
    result = run(suite)
    result.stdout.fnmatch_lines([f"*compared with commit {commit[:12]} of ????-??-??: the first"])


def test_recording_needs_a_reason(suite) -> None:
    result = run(suite, "--slipctl-record", " ")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*--slipctl-record needs a reason*"])


def test_the_lines_come_back_from_other_processes(recorded) -> None:
    pytest.importorskip("xdist")
    result = run(recorded, "-n", "1", in_process=False)
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["*= slipctl =*", "line, my_law: * same"])


def test_the_plugin_costs_pytest_s_start_nothing_heavy(suite) -> None:
    suite.makepyfile(
        test_law="""
        import sys

        def test_light(request):
            assert request.config.getoption("--slipctl-record") is None
            heavy = {"mujoco", "rerun", "pyarrow", "numpy", "scipy", "pydantic", "rich", "typer"}
            assert "slipctl.pytest_plugin" in sys.modules
            assert not heavy & set(sys.modules)
        """
    )
    # other plugins of this environment may be heavy themselves
    command = [sys.executable, "-m", "pytest", "-q", "-p", "slipctl.pytest_plugin", "-p", "no:cacheprovider"]
    environment = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONPATH": str(ROOT)}
    ended = subprocess.run(
        command, cwd=suite.path, env={**os.environ, **environment}, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stdout


def test_pytest_is_told_where_the_plugin_is() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"]["pytest11"] == {"slipctl": "slipctl.pytest_plugin"}
    # users of the commands need no pytest
    assert not any(requirement.startswith("pytest") for requirement in project["dependencies"])
