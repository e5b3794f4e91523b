"""Annotations by the rules of workflow commands, and a summary that is a table whatever the names are."""

import re
import shlex
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from slipctl.report.github import (
    NAMED,
    ROWS,
    active,
    append_summary,
    summary,
    within,
    workflow_command,
    workflow_commands,
)
from slipctl.report.judged import Judged
from tests.report.findings import EVERY_VERDICT, NO_BASELINE, claim, finding

COMMAND = re.compile(r"::(error|warning|notice) ([^:]*)::(.*)")


def parsed(line):
    """Read a workflow command as GitHub's runner does."""
    match = COMMAND.fullmatch(line)
    assert match, line
    properties = dict(part.split("=", 1) for part in match[2].split(","))
    undone = {name: undo(value) for name, value in properties.items()}
    return match[1], undone, undo(match[3])


def undo(text):
    for code, sign in (("%0D", "\r"), ("%0A", "\n"), ("%3A", ":"), ("%2C", ","), ("%25", "%")):
        text = text.replace(code, sign)
    return text


def test_only_where_github_says_so():
    assert active({"GITHUB_ACTIONS": "true"})
    assert not active({"GITHUB_ACTIONS": "false"})
    assert not active({})


@given(st.text(), st.text(), st.text())
def test_any_text_comes_back_from_a_command_of_one_line(title, message, file):
    line = workflow_command("error", title, message, file)
    assert "\n" not in line
    assert "\r" not in line
    kind, properties, said = parsed(line)
    assert (kind, properties["title"], said) == ("error", title, message)
    assert properties.get("file", "") == file


def test_each_kind_of_finding_has_its_command():
    judged = Judged("ice", EVERY_VERDICT, commit="abc", date="2026-11-20")
    commands = [parsed(line) for line in workflow_commands([judged])]
    assert [kind for kind, _, _ in commands] == ["error", "warning", "notice"]
    _, properties, said = commands[0]
    assert properties == {"title": "ice got worse"}
    assert "rms_position_error 12.3 → 14.5 mm (+18 %)" in said
    assert said.endswith("compared with commit abc of 2026-11-20")


def test_what_is_better_is_asked_to_be_recorded_by_name_and_for_this_scenario_only():
    """Without a name the command would record every scenario again."""
    better = finding(verdict="better")
    for source, named in (("ice", "ice"), ("my floors/ice.toml", "'my floors/ice.toml'")):
        ((_, _, said),) = [parsed(line) for line in workflow_commands([Judged("ice", [better], source)])]
        assert said.endswith(f"\nrecord it with slipctl check {named} --update --reason '…'")
        words = shlex.split(said.rpartition("record it with ")[2])
        assert words == ["slipctl", "check", source, "--update", "--reason", "…"]
    # what is better than another revision need not be recorded
    ((_, _, said),) = [parsed(line) for line in workflow_commands([Judged("ice", [better])])]
    assert "record it" not in said


def test_a_claim_that_fails_is_not_called_a_number_that_got_worse():
    claimed, worse = (
        Judged("ice", [claim("claim_failed")]),
        Judged("rain", [finding(), claim("claim_failed")]),
    )
    titles = [parsed(line)[1]["title"] for line in workflow_commands([claimed, worse])]
    assert titles == ["ice failed a claim", "rain got worse"]

    def headline(*judged):
        return summary(judged).splitlines()[0].removeprefix("## slipctl check: ")

    assert headline(claimed) == "1 of 1 scenario failed a claim"
    assert headline(worse) == "1 of 1 scenario got worse"
    assert headline(claimed, worse, Judged("fog", [NO_BASELINE])) == (
        "1 of 3 scenarios got worse, 1 of 3 scenarios failed a claim, 1 of 3 scenarios could not be judged"
    )


def test_only_numbers_are_said_to_be_compared_with_a_record():
    for findings, said_since in (([claim("claim_failed")], False), ([finding()], True)):
        judged = Judged("ice", findings, commit="abc", date="2026-11-20")
        ((_, _, said),) = [parsed(line) for line in workflow_commands([judged])]
        assert said.endswith("compared with commit abc of 2026-11-20") == said_since


def test_two_metrics_of_one_claim_are_told_apart():
    judged = Judged("ice", [claim("claim_failed"), claim("claim_failed", metric="command_variation")])
    rows = [cells(row) for row in summary([judged]).splitlines() if row.startswith("| ice")]
    assert [row[2] for row in rows] == [
        "robust better than nominal by a factor 3: rms position error",
        "robust better than nominal by a factor 3: command variation",
    ]


def test_what_is_good_is_not_annotated():
    assert list(workflow_commands([Judged("ice", [finding(verdict="same"), claim("claim_held")])])) == []


def test_the_worst_findings_are_named_first_and_the_rest_is_counted():
    findings = [finding(current=0.0123 * (1 + 0.01 * k), seed=k) for k in range(1, NAMED + 6)]
    ((_, _, said),) = [parsed(line) for line in workflow_commands([Judged("ice", findings)])]
    named = said.splitlines()
    assert f"seed {NAMED + 5}:" in named[0]
    assert named[-1] == "and 5 more"
    assert len(named) == NAMED + 1


def test_a_file_is_named_relative_to_the_checkout(tmp_path):
    file = tmp_path / "scenarios" / "ice.toml"
    assert within(file, tmp_path) == "scenarios/ice.toml"
    assert within(tmp_path / "scenarios" / ".." / "ice.toml", tmp_path) == "ice.toml"
    assert within(file, tmp_path / "elsewhere") is None
    assert within(None, tmp_path) is None
    assert within(file, None) is None
    (line,) = workflow_commands([Judged("ice", [finding()], file=file)], tmp_path)
    assert parsed(line)[1]["file"] == "scenarios/ice.toml"


def cells(row):
    """Split a row of a Markdown table where a renderer would."""
    assert row.startswith("| ")
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]]


def test_the_summary_says_what_got_worse_by_how_much_and_since_when():
    text = summary([Judged("ice", [finding()], commit="abc", date="2026-11-20"), Judged("rain", [])])
    assert text.startswith("## slipctl check: 1 of 2 scenarios got worse\n")
    (row,) = [line for line in text.splitlines() if line.startswith("| ice")]
    assert cells(row) == [
        "ice",
        "robust, ground.friction 0.16, seed 1",
        "rms position error",
        "12.3 → 14.5 mm (+18 %)",
        "commit abc of 2026-11-20",
    ]


def test_a_record_that_names_no_commit_is_named_by_its_day():
    assert Judged("ice", [], date="2026-11-20").since == "the record of 2026-11-20"
    assert Judged("ice", [], commit="abc").since == "commit abc"
    assert Judged("ice", []).since is None
    row = summary([Judged("ice", [finding()], date="2026-11-20")]).splitlines()[6]
    assert cells(row)[-1] == "the record of 2026-11-20"


def test_the_summary_of_what_is_good_is_a_headline():
    same = finding(verdict="same")
    assert summary([Judged("ice", [same])]).strip() == "## slipctl check: 1 of 1 scenario good"
    text = summary([Judged("ice", [NO_BASELINE])])
    assert "1 of 1 scenario could not be judged" in text
    assert "| ice | all | – | no baseline | – |" in text


def test_the_summary_holds_the_command_that_opens_the_recordings():
    text = summary(
        [Judged("ice", [finding()], command="slipctl view runs/check/ice", notes=["another *engine*"])]
    )
    assert "```console\nslipctl view runs/check/ice\n```" in text
    assert r"* ice: another \*engine\*" in text


def test_a_claim_is_not_said_to_be_compared_with_a_baseline():
    text = summary([Judged("ice", [claim("claim_failed")], commit="abc")])
    assert "required 3.00 | the scenario's claim |" in text


@given(st.text(min_size=1), st.text())
def test_no_name_breaks_the_table(name, note):
    text = summary([Judged(name, [finding(scenario=name, controller=name, note=note)], commit="abc")])
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert [len(cells(row)) for row in rows] == [5, 5]
    assert "<" not in rows[1]
    assert "@" not in rows[1].replace("&#64;", "")


def test_a_long_table_is_cut_and_says_so():
    text = summary([Judged("ice", [finding(seed=seed) for seed in range(ROWS + 3)])])
    assert len([line for line in text.splitlines() if line.startswith("| ice")]) == ROWS + 1
    assert "and 3 more" in text


def test_the_summary_is_appended(tmp_path: Path):
    path = tmp_path / "summary.md"
    path.write_bytes("before µ\n".encode())
    append_summary(path, [Judged("ice", [finding()])])
    content = path.read_bytes().decode()
    assert content.startswith("before µ\n## slipctl check: ")
    assert "\r" not in content
