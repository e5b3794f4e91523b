"""What ``slipctl check`` says of a scenario: a count, and a sentence for everything that is not the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from slipctl.report.table import number_text, value_text

if TYPE_CHECKING:
    from rich.text import Text

Finding = Mapping[str, Any]
"""One entry of ``results`` in the JSON output of ``slipctl check``."""

STYLES = {"worse": "bold red", "status_changed": "bold red", "better": "green"}
WORDS = {"status_changed": "status changed", "unjudged": "not judged"}


def lines(scenario: str, findings: Sequence[Finding], updated: bool = False) -> list[Text]:
    """Lay out the findings of one scenario.

    Parameters
    ----------
    scenario
        Its name.
    findings
        All of them.
    updated
        Whether the present numbers have just been recorded, so that nothing is asked of the reader.
    """
    from rich.text import Text

    counts = Counter(finding["verdict"] for finding in findings)
    said = ", ".join(f"{count} {WORDS.get(verdict, verdict)}" for verdict, count in counts.items())
    laid = [Text.assemble((scenario, "bold"), f": {said or 'recorded for the first time'}")]
    for finding in findings:
        verdict = finding["verdict"]
        if verdict != "same":
            laid.append(Text("  " + sentence(finding), style=STYLES.get(verdict, "yellow")))
    if counts["better"] and not updated:
        laid.append(Text("  better than the baseline: record it with --update --reason '…'", style="green"))
    return laid


def sentence(finding: Finding) -> str:
    """Say one finding in one line: which run, which number, both values and the tolerance."""
    if finding["controller"] is None:
        return f"{finding['scenario']}: {WORDS['unjudged']}: {finding['note']}"
    which = ", ".join(
        [finding["controller"], *(f"{key} {value_text(value)}" for key, value in finding["varied"].items())]
        + (
            [f"seed {finding['seed']}"]
            if finding["seed"] is not None and "seed" not in finding["varied"]
            else []
        )
    )
    verdict = finding["verdict"]
    text = f"{finding['scenario']}: {which}: {WORDS.get(verdict, verdict)}"
    if finding["metric"] is not None:
        text += f": {finding['metric']} {_amount(finding['baseline'])} → {_amount(finding['current'])}"
    if finding["tolerance"] is not None:
        text += f", tolerance {_amount(finding['tolerance'])}"
    return text + (f" ({finding['note']})" if finding["note"] else "")


def _amount(value: float | str | None) -> str:
    if value is None:
        return "not finite"
    return value if isinstance(value, str) else f"{number_text(1e3 * value)} mm"
