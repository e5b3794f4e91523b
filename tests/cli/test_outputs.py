"""``slipctl check``: JUnit files, GitHub's annotations and summary, and recordings that cannot be written."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import pytest

from slipctl import regression
from slipctl.cli import main
from slipctl.experiment.folder import OutputError
from slipctl.regression import Finding, Report, Verdict
from slipctl.regression.artefacts import Artefacts
from tests.fakes import SHORT_SCENARIO

WORSE = Finding(
    "ice", "nominal_kinematic", {}, 0, "rms_position_error", 0.001, 0.002, 1e-4, Verdict.WORSE, unit="m"
)
BETTER = Finding(
    "ice", "nominal_kinematic", {}, 0, "rms_position_error", 0.002, 0.001, 1e-4, Verdict.BETTER, unit="m"
)
SAME = Finding(
    "ice", "nominal_kinematic", {}, 0, "rms_position_error", 1.0, 1.0, 1e-4, Verdict.SAME, unit="m"
)
UNJUDGED = Finding("ice", None, {}, None, None, None, None, None, Verdict.UNJUDGED, "no baseline")
RECORDED = {"commit": "abc", "date": "2026-11-20", "reason": "first record"}


@pytest.fixture
def ice(tmp_path, monkeypatch):
    """A scenario file in the working folder."""
    monkeypatch.chdir(tmp_path)
    for name in ("GITHUB_ACTIONS", "GITHUB_WORKSPACE", "GITHUB_STEP_SUMMARY"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "ice.toml").write_text(SHORT_SCENARIO, encoding="utf-8")
    return "own/ice.toml"


@pytest.fixture
def found(monkeypatch):
    """What the next check finds."""
    findings: list[Finding] = []
    monkeypatch.setattr(
        regression,
        "check",
        lambda *_: Report("ice", tuple(findings), ("another engine",), None, "", RECORDED),
    )
    return findings


@pytest.fixture
def on_github(tmp_path, monkeypatch):
    """The environment of a step, and the file of its summary."""
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    return tmp_path / "summary.md"


@pytest.mark.parametrize(
    ("finding", "status", "tags"),
    [(SAME, 0, []), (WORSE, 1, ["failure"]), (UNJUDGED, 3, ["error"])],
)
def test_a_junit_file_is_written_whatever_the_verdict(ice, found, finding, status, tags):
    found.append(finding)
    assert main(["check", ice, "--artefacts", "none", "--junit", "made/check.xml"]) == status
    root = ElementTree.parse("made/check.xml").getroot()
    assert [child.tag for case in root.iter("testcase") for child in case] == tags
    (suite,) = root.findall("testsuite")
    told = {entry.attrib["name"]: entry.attrib["value"] for entry in suite.iter("property")}
    assert told == {"file": "own/ice.toml", "compared_with": "commit abc of 2026-11-20"}


def test_a_junit_file_goes_with_a_comparison_only(ice, capsys):
    assert main(["check", ice, "--record", "--junit", "check.xml"]) == 2
    assert "--junit is of a comparison" in capsys.readouterr().err


def test_a_junit_file_that_cannot_be_is_refused_before_anything_is_run(ice, found, tmp_path, capsys):
    assert main(["check", ice, "--junit", str(tmp_path)]) == 2
    assert "is a folder; name a file in it" in capsys.readouterr().err


def test_a_junit_file_that_cannot_be_written_is_refused_before_anything_is_run(
    ice, monkeypatch, tmp_path, capsys
):
    monkeypatch.setattr(regression, "check", lambda *_: pytest.fail("ran"))
    (tmp_path / "file").write_bytes(b"")
    assert main(["check", ice, "--quiet", "--junit", "file/check.xml"]) == 2
    err = capsys.readouterr().err
    assert "--junit: cannot write file" in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(("finding", "status"), [(SAME, 3), (WORSE, 1), (UNJUDGED, 3)])
def test_a_junit_file_that_cannot_be_written_afterwards_hides_no_verdict(
    ice, found, monkeypatch, capsys, finding, status
):
    def full(*_: object) -> None:
        raise OSError(28, "no space left")

    monkeypatch.setattr("slipctl.report.junit.write", full)
    found.append(finding)
    assert main(["check", ice, "--json", "--artefacts", "none", "--junit", "check.xml"]) == status
    out, err = capsys.readouterr()
    assert "--junit: cannot write check.xml: no space left" in err
    assert "Traceback" not in err
    # what cannot be judged has no JSON; what failed has it
    assert (json.loads(out)["passed"] is False) if status == 1 else (out == "")


def test_trying_out_where_a_junit_file_goes_leaves_what_is_there(ice, found, tmp_path):
    (tmp_path / "check.xml").write_text("older", encoding="utf-8")
    assert main(["check", "no-such-scenario", "--junit", "check.xml"]) == 2
    assert (tmp_path / "check.xml").read_text(encoding="utf-8") == "older"
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["check.xml", "own"]


def test_github_is_told_beside_the_table(ice, found, on_github, capsys):
    found += [WORSE, UNJUDGED]
    assert main(["check", ice, "--artefacts", "none"]) == 1
    out = capsys.readouterr().out.splitlines()
    (error,) = [line for line in out if line.startswith("::error ")]
    assert error.startswith(
        "::error file=own/ice.toml,title=ice got worse::ice: nominal_kinematic, seed 0: worse"
    )
    assert len([line for line in out if line.startswith("::warning ")]) == 1
    summary = on_github.read_text(encoding="utf-8")
    assert "1.00 → 2.00 mm (+100 %) | commit abc of 2026-11-20 |" in summary
    assert "* ice: another engine" in summary


def test_what_is_better_is_recorded_by_a_command_that_names_this_scenario(ice, found, on_github, capsys):
    found.append(BETTER)
    assert main(["check", ice]) == 0
    out = capsys.readouterr().out
    table, annotation = out.split("::notice ")
    command = "slipctl check own/ice.toml --update --reason '…'"
    assert f"record it with {command}\n" in table
    assert annotation.endswith(f"record it with {command}\n")


def test_with_json_standard_output_holds_json_only(ice, found, on_github, capsys):
    found.append(WORSE)
    assert main(["check", ice, "--json", "--artefacts", "none"]) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["passed"] is False
    assert "::error file=own/ice.toml" in err


def test_elsewhere_nobody_is_told(ice, found, tmp_path, capsys):
    found.append(WORSE)
    assert main(["check", ice, "--artefacts", "none"]) == 1
    assert "::error" not in "".join(capsys.readouterr())
    assert not (tmp_path / "summary.md").exists()


def test_a_summary_that_cannot_be_written_does_not_change_the_verdict(ice, found, on_github, capsys):
    on_github.mkdir()
    assert main(["check", ice]) == 0
    assert "no step summary" in capsys.readouterr().err


def test_the_command_that_opens_the_recordings_is_said_everywhere(
    ice, found, on_github, monkeypatch, tmp_path, capsys
):
    found.append(WORSE)
    made = Artefacts(tmp_path / "runs" / "check" / "ice", ("only the recordings of now",))
    asked = []
    monkeypatch.setattr(regression, "record_failing", lambda *given, **_: asked.append(given) or made)
    assert main(["check", ice, "--junit", "check.xml"]) == 1
    (_, _, out, baseline) = asked[0]
    assert (out.as_posix(), baseline.name) == ("runs/check", "ice.json")
    err = capsys.readouterr().err
    assert f"ice: look at what failed: {made.command}\n" in err
    assert "ice: only the recordings of now\n" in err
    assert made.command in on_github.read_text(encoding="utf-8")
    assert made.command in (tmp_path / "check.xml").read_text(encoding="utf-8")


@pytest.mark.parametrize(("finding", "status"), [(SAME, 0), (UNJUDGED, 3)])
def test_what_did_not_fail_is_not_recorded(ice, found, monkeypatch, finding, status):
    found.append(finding)
    monkeypatch.setattr(regression, "record_failing", lambda *_, **__: pytest.fail("recorded"))
    assert main(["check", ice]) == status


def test_nobody_who_wants_no_recordings_gets_any(ice, found, monkeypatch):
    found.append(WORSE)
    monkeypatch.setattr(regression, "record_failing", lambda *_, **__: pytest.fail("recorded"))
    assert main(["check", ice, "--artefacts", "none"]) == 1


def test_a_recording_that_cannot_be_written_does_not_change_the_verdict(ice, found, monkeypatch, capsys):
    def full(*_: object, **__: object) -> None:
        raise OutputError("cannot write to the output folder runs/check: no space left")

    found.append(WORSE)
    monkeypatch.setattr(regression, "record_failing", full)
    assert main(["check", ice]) == 1
    assert "ice: no recordings: cannot write to the output folder" in capsys.readouterr().err


def test_a_folder_that_cannot_be_is_said_with_the_option_that_names_another(ice, found, tmp_path, capsys):
    (tmp_path / "taken").write_text("", encoding="utf-8")
    found.append(WORSE)
    assert main(["check", ice, "--quiet", "--artefacts", "taken"]) == 1
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "no recordings" in line]
    assert line.startswith("ice: no recordings: cannot write to the output folder taken: ")
    assert line.endswith("; name another with --artefacts")


def test_an_interrupted_recording_is_an_interruption(ice, found, monkeypatch, capsys):
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    found.append(WORSE)
    monkeypatch.setattr(regression, "record_failing", stop)
    assert main(["check", ice]) == 130
    assert "failed and was not recorded" in capsys.readouterr().err
