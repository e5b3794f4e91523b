"""The table of ``slipctl certify``, and in what words a model's certificate is spoken of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text


def table(content: Mapping[str, Any], laws: bool) -> Table:
    """Lay out the checks of a certificate, one a row, with the closed forms in symbols where `laws`."""
    from rich import box
    from rich.table import Table

    laid = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    laid.add_column("", no_wrap=True, min_width=4)
    laid.add_column("fixture", overflow="fold")
    for heading, width in (("measured", 8), ("closed form", 11), ("error", 9), ("allowed", 7)):
        laid.add_column(heading, justify="right", no_wrap=True, min_width=width)
    laid.add_column("unit", no_wrap=True, min_width=5)
    if laws:
        laid.add_column("law", overflow="fold")
    for check in content["checks"]:
        laid.add_row(
            "ok" if check["passed"] else "FAIL",
            check["name"].replace("_", " "),
            number(check, check["measured"]),
            number(check, check["expected"]),
            amount(check, check["error"], "+"),
            amount(check, check["tolerance"]),
            check["unit"],
            *([check["law"]] if laws else []),
            style=None if check["passed"] else "red",
        )
    return laid


def verdict(content: Mapping[str, Any]) -> list[Text]:
    """Say whether the model is certified against closed forms, and each reason why not."""
    from rich.text import Text

    failed = [check for check in content["checks"] if not check["passed"]]
    count = len(content["checks"])
    name = f"{content['model']} at {content['timestep']:g} s"
    if not failed:
        return [
            Text(f"{name} is certified against closed forms: {count} of {count} fixtures", style="bold green")
        ]
    lines = [
        Text(
            f"{name} is not certified against closed forms: {len(failed)} of {count} fixtures failed",
            style="bold red",
        )
    ]
    reasons: dict[str, list[str]] = {}
    for check in failed:
        reasons.setdefault(check["reason"], []).append(check["name"].replace("_", " "))
    lines += [Text(f"  {', '.join(names)}: {reason}", style="red") for reason, names in reasons.items()]
    return lines


def standing_line(standing: Mapping[str, Any] | None, model: str) -> str | None:
    """Say in a summary whether the model of a run is certified; None where there is no engine to certify."""
    if standing is None:
        return None
    state, failed = standing["state"], standing["failed"]
    command = standing.get("command", f"slipctl certify {model}")
    if state == "passed":
        return f"{model}: certified against closed forms"
    if state == "failed":
        missed = ", ".join(name.replace("_", " ") for name in failed)
        return f"{model}: NOT certified against closed forms: {missed} failed; see {command}"
    return f"{model}: not yet certified against closed forms; {command} does it"


def number(check: Mapping[str, Any], value: float | None) -> str:
    """Write a measurement with the digits that matter; what is far below its tolerance is nought."""
    if value is None:
        return "–"
    least = 0.0 if check["relative"] else 1e-3 * check["tolerance"]
    return "0" if abs(value) <= least else f"{value:.5g}"


def amount(check: Mapping[str, Any], value: float | None, sign: str = "") -> str:
    """Write an error or a tolerance: in percent where it is relative."""
    if value is None:
        return "–"
    if not check["relative"]:
        least = 1e-3 * check["tolerance"]
        return "0" if abs(value) <= least else f"{value:{sign}.2g}"
    percent = 100.0 * value
    if not sign:
        return f"{percent:.2g} %"
    if abs(percent) < 5e-4:
        return "0 %"
    return f"{percent:+.0f} %" if abs(percent) >= 10.0 else f"{percent:+.3f} %"
