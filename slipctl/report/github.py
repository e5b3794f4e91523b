"""What a pull request shows where ``slipctl check`` runs in GitHub Actions: annotations and a summary.

The form of an annotation is a workflow command: ``::error file=…,title=…::message`` on a line of its own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from slipctl.report.findings import sentence, values_text
from slipctl.report.judged import Finding, Judged, claim_text, metric_text, run_text

NAMED = 10
"""Findings that one annotation names: it is a hint beside a file, the summary holds the table."""

ROWS = 100
"""Rows of one table of the summary. GitHub drops a summary that is longer than a megabyte."""


def active(environment: Mapping[str, str]) -> bool:
    """Whether this runs in GitHub Actions."""
    return environment.get("GITHUB_ACTIONS") == "true"


def workflow_commands(scenarios: Sequence[Judged], workspace: Path | None = None) -> Iterator[str]:
    """Yield the lines that GitHub turns into annotations: one per scenario and kind, for it shows only ten.

    Parameters
    ----------
    scenarios
        What was judged. An error names what fails, a warning what could not be judged, a notice what is
        better than recorded.
    workspace
        Folder of the checkout; scenario files within it are named relative to it, others are not named.
    """
    for judged in scenarios:
        file = within(judged.file, workspace)
        for command, title, findings in (
            ("error", _how_failed(judged), judged.failed),
            ("warning", "could not be judged", judged.not_judged),
            ("notice", "is better than recorded", judged.better),
        ):
            if not findings:
                continue
            said = [sentence(finding) for finding in findings[:NAMED]]
            if len(findings) > NAMED:
                said.append(f"and {len(findings) - NAMED} more")
            # claims are held against what the scenario file says
            if command == "error" and judged.since is not None and _is_worse(judged):
                said.append(f"compared with {judged.since}")
            if command == "notice" and judged.update is not None:
                said.append(f"record it with {judged.update}")
            yield workflow_command(command, f"{judged.scenario} {title}", "\n".join(said), file)


def workflow_command(command: str, title: str, message: str, file: str | None) -> str:
    """Return one workflow command, escaped by GitHub's rules: properties and message differ."""
    properties = [f"file={_property(file)}"] if file else []
    properties.append(f"title={_property(title)}")
    return f"::{command} {','.join(properties)}::{_data(message)}"


def within(file: Path | None, workspace: Path | None) -> str | None:
    """Return a file's path as GitHub knows it: relative to the checkout, with slashes; None outside it."""
    if file is None or workspace is None:
        return None
    try:
        return file.resolve().relative_to(workspace.resolve()).as_posix()
    except ValueError:
        return None


def summary(scenarios: Sequence[Judged]) -> str:
    """Return the Markdown that the page of the workflow's run shows.

    First what failed, by how much and since when; then what could not be judged, what is better, and how
    to look at the recordings of the runs that failed.
    """
    failed = [judged for judged in scenarios if judged.failed]
    unknown = [judged for judged in scenarios if judged.not_judged]
    parts = [f"## slipctl check: {_headline(scenarios, failed, unknown)}", ""]
    parts += _section("What failed", failed, lambda judged: judged.failed)
    parts += _section("What could not be judged", unknown, lambda judged: judged.not_judged)
    parts += _section("What is better than recorded", scenarios, lambda judged: judged.better)
    commands = [judged.command for judged in scenarios if judged.command is not None]
    if commands:
        parts += ["### Look at it", "", "With the uploaded recordings unpacked into the working folder:", ""]
        parts += ["```console", *commands, "```", ""]
    notes = [(judged.scenario, note) for judged in scenarios for note in judged.notes]
    if notes:
        parts += ["### Notes", "", *(f"* {_cell(name)}: {_cell(note)}" for name, note in notes), ""]
    return "\n".join(parts)


def append_summary(path: Path, scenarios: Sequence[Judged]) -> None:
    """Append the summary to the file that GitHub names in ``GITHUB_STEP_SUMMARY``.

    Raises
    ------
    OSError
        It cannot be written.
    """
    with path.open("a", encoding="utf-8", newline="\n") as file:
        file.write(summary(scenarios) + "\n")


def _headline(scenarios: Sequence[Judged], failed: Sequence[Judged], unknown: Sequence[Judged]) -> str:
    count = len(scenarios)
    of = f"of {count} scenario{'s' if count != 1 else ''}"
    worse = sum(_is_worse(judged) for judged in failed)
    parts = [
        f"{number} {of} {what}"
        for number, what in (
            (worse, "got worse"),
            (len(failed) - worse, "failed a claim"),
            (len(unknown), "could not be judged"),
        )
        if number
    ]
    return ", ".join(parts) or f"{count} {of} good"


def _is_worse(judged: Judged) -> bool:
    """Whether a number or a status is not as recorded; otherwise it is only claims that fail."""
    return any(finding["claim"] is None for finding in judged.failed)


def _how_failed(judged: Judged) -> str:
    return "got worse" if _is_worse(judged) else "failed a claim"


def _section(
    title: str, scenarios: Sequence[Judged], choose: Callable[[Judged], list[Finding]]
) -> Iterator[str]:
    rows = [row for judged in scenarios for row in _rows(judged, choose(judged))]
    if not rows:
        return
    yield from (f"### {title}", "", "| scenario | run | what | by how much | compared with |")
    yield "|---|---|---|---|---|"
    yield from rows
    yield ""


def _rows(judged: Judged, findings: Sequence[Finding]) -> Iterator[str]:
    for finding in findings[:ROWS]:
        claim = finding["claim"]
        what = claim_text(finding) if claim is not None else metric_text(finding["metric"] or "")
        valued = finding["baseline"] is not None or finding["current"] is not None
        values = values_text(finding) if valued else ""
        said = ": ".join(part for part in (values, finding["note"]) if part)
        # a claim is held against what the scenario file says, not against a baseline
        since = "the scenario's claim" if claim is not None else judged.since or "–"
        yield _row(judged.scenario, run_text(finding) or "all", what or "–", said or "–", since)
    if len(findings) > ROWS:
        yield _row(judged.scenario, f"and {len(findings) - ROWS} more", "", "", "")


def _row(*cells: str) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _cell(text: str) -> str:
    """Keep text from being read as Markdown or as HTML."""
    flat = " ".join(text.split()).replace("&", "&amp;")
    return re.sub(r"([\\`*_\[\]|~#])", r"\\\1", flat).replace("<", "&lt;").replace("@", "&#64;")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
