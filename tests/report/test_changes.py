"""The tables of a recorded baseline: old beside new, in units for people, within 80 columns."""

import io

from rich.console import Console

from slipctl.regression.baseline.gated import GATED
from slipctl.report.changes import summary, tables


def number(value, tolerance=1e-6, gate="number"):
    return {"value": value, "tolerance": tolerance, "tolerance_elsewhere": tolerance, "gate": gate}


def change(metric, before, after, controller="robust_kinematic", friction=0.16):
    varied = {"ground.friction": friction}
    return {
        "controller": controller, "varied": varied, "seed": 1, "metric": metric,
        "before": before, "after": after,
    }  # fmt: skip


def shown(changes):
    page = io.StringIO()
    console = Console(file=page, width=80, highlight=False)
    for laid in tables(changes):
        console.print(laid)
    return page.getvalue().splitlines()


def words(changes):
    return [" ".join(line.split()) for line in shown(changes)]


def test_old_and_new_the_change_and_the_tolerance():
    heading, titles, row = words([change("rms_position_error", number(0.001), number(0.0011))])
    assert heading == "robust_kinematic, ground.friction 0.16, seed 1"
    assert titles == "metric old → new change tolerance"
    assert row == "rms position error 1.00 → 1.10 mm +10 % 0.0010 mm"


def test_a_tolerance_that_changed_alone_is_said_with_the_old_one():
    *_, row = words([change("command_variation", number(2.0, 0.1), number(2.0, 0.2))])
    assert row == "command variation 2.00 same 0.10 → 0.20"


def test_a_number_that_became_chaotic_says_so():
    after = number(0.5, 0.1, "verdict")
    *_, row = words([change("rms_heading_error", number(0.5, 0.1), after)])
    assert row.endswith("5.7° → chaotic")


def test_statuses_and_runs_that_came_or_went():
    rows = words([change("status", "completed", "tipped"), change("status", None, "completed", "new")])
    assert "status completed → tipped" in rows
    assert "status no such run → completed" in rows


def test_a_number_that_was_none():
    *_, row = words([change("guarantee_fraction", number(None, 0.0), number(1.0, 1e-3))])
    assert row.startswith("guarantee fraction not finite → 1.00")


def test_each_run_is_named_once_and_everything_fits():
    changes = [
        change(metric, number(0.123456789), number(0.1234569), controller)
        for controller in ("nominal_kinematic", "robust_kinematic")
        for metric in GATED
    ]
    lines = shown(changes)
    assert len(lines) == 2 * (1 + len(GATED)) + 1
    assert max(map(len, lines)) <= 80
    column = lines[1].index("old")
    rows = [line for line in lines if line.startswith("    ") and "old" not in line]
    assert {(line[column - 1], line[column].isdigit()) for line in rows} == {(" ", True)}


def test_the_summary_counts_numbers_runs_and_chaos():
    runs = [{"metrics": {name: number(1.0) for name in GATED}}] * 2
    assert summary("ice", runs, []) == "ice: 14 numbers of 2 runs recorded"
    runs = [*runs, {"metrics": {"rms_position_error": number(1.0, gate="verdict")}}]
    assert summary("ice", runs, [{}, {}]) == (
        "ice: 15 numbers of 3 runs recorded, 1 of them chaotic and not gated as numbers, 2 changed"
    )
