"""The part of the page about the experiment of Section VI."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from slipctl.study.markdown import mm, prose, table

Numbers = dict[str, Any]
Row = dict[str, Any]

SHARES = ("better", "counter_example")


def experiment_part(numbers: Numbers) -> list[str]:
    """Return the experiment: medians over seeds, and the paper's counter-example."""
    rows, compared = (numbers["experiment"][name] for name in ("summary", "comparison"))
    late = numbers["facts"]["late_y_mm"]
    laws = (
        "rate",
        "share corrected",
        "law",
        "RMS, median",
        "95 % interval",
        "odometry before a fix",
        "after",
    )
    against = (
        "rate",
        "share corrected",
        "robust less nominal, RMS",
        "95 % interval",
        "smaller in",
        "larger in y",
    )
    return [
        "## The experiment of Section VI",
        "",
        *prose("""Simulated on MuJoCo: the robot starts at rest on a slippery film, the law's speed floor is
        0.05 m/s, and it sees odometry that an overhead camera corrects three times a second. The paper
        gives neither the command rate nor how a fix is used, so both are varied, over the same seeds for
        both laws. Errors in mm."""),
        *table(laws, [_law_cells(row) for row in rows], right=(3, 4, 5, 6)),
        "",
        *prose(f"""The robust law has the smaller RMS error in {_span(compared, "better")} of the seeds,
        depending on the command rate and the share. The paper's own counter-example, larger errors in y
        than the nonrobust law between 15 and 20 s, appears in {_span(compared, "counter_example")} of the
        seeds. In the run of the figures the RMS of y over that time is {mm(late["nominal"])} mm nominal and
        {mm(late["robust"])} mm robust."""),
        *table(against, [_comparison_cells(row) for row in compared], right=(2, 3, 4, 5)),
        "",
    ]


def _law_cells(row: Row) -> list[str]:
    interval = f"{mm(1e3 * row['lower'])} to {mm(1e3 * row['upper'])}"
    fixes = [
        _or_dash(row[name], lambda value: mm(1e3 * value)) for name in ("position_before", "position_after")
    ]
    return [*_case(row), row["controller"], mm(1e3 * row["rms_position_error"]), interval, *fixes]


def _comparison_cells(row: Row) -> list[str]:
    difference = f"{1e3 * row['rms_difference']:+.2f}"
    interval = f"{1e3 * row['lower']:+.2f} to {1e3 * row['upper']:+.2f}"
    return [*_case(row), difference, interval, *(_or_dash(row[name], _percent) for name in SHARES)]


def _case(row: Row) -> tuple[str, str]:
    return f"{1 / row['tick']:.0f} Hz", f"{row['camera_gain']:g}"


def _or_dash(value: float | None, write: Callable[[float], str]) -> str:
    return "–" if value is None else write(value)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _span(rows: list[Row], name: str) -> str:
    """Write from which to which share some rows go."""
    shares = [row[name] for row in rows if row[name] is not None]
    if not shares:
        return "–"
    low, high = _percent(min(shares)), _percent(max(shares))
    return low if low == high else f"{low} to {high}"
