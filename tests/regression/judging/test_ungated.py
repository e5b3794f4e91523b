"""A run of which only the status is judged is said at every check."""

import pytest

from slipctl.regression.judging.ungated import only_status_judged
from slipctl.scenario import Below, Better, StatusIs
from slipctl.scenario.where import Condition
from tests.fakes import baseline_of, payload, run_entry

SAID = "only the status of a is judged in {}: all numbers are chaotic and no claim names it"


def runs(*gates, metrics=None):
    """One run of `a` per gate, on ever higher friction, and one of `b` whose numbers are gated."""
    entries = [run_entry("a", friction=place / 10) for place in range(len(gates))]
    recorded = baseline_of(payload([*entries, run_entry("b")])).runs
    changed = []
    for run, gate in zip(recorded, [*gates, "number"], strict=True):
        numbers = {
            name: number.model_copy(update={"gate": gate if metrics is None or name in metrics else "number"})
            for name, number in run.metrics.items()
        }
        changed.append(run.model_copy(update={"metrics": numbers}))
    return changed


def test_runs_with_gated_numbers_are_not_mentioned():
    assert only_status_judged(runs("number", "number")) == []
    assert only_status_judged(runs("verdict", metrics=["rms_position_error"])) == []


@pytest.mark.parametrize(("gates", "said"), [(["verdict"], "1 run"), (["verdict", "verdict"], "2 runs")])
def test_runs_with_chaotic_numbers_only_are_said(gates, said):
    assert only_status_judged(runs(*gates)) == [SAID.format(said)]


def test_a_guarantee_that_is_not_there_is_no_gated_number():
    (run, other) = runs("verdict")
    share = run.metrics["guarantee_fraction"].model_copy(update={"value": None, "gate": "number"})
    run = run.model_copy(update={"metrics": run.metrics | {"guarantee_fraction": share}})
    assert only_status_judged([run, other]) == [SAID.format("1 run")]


def below(controller="a", **more):
    return Below(kind="below", controller=controller, metric="rms_position_error", limit=1.0, **more)


@pytest.mark.parametrize(
    "claim",
    [
        below(),
        Better(kind="better", controller="a", than="b"),
        Better(kind="better", controller="b", than="a"),
    ],
)
def test_a_claim_that_names_it_judges_it(claim):
    assert only_status_judged(runs("verdict"), [claim]) == []


@pytest.mark.parametrize(
    "claim", [below("b"), StatusIs(kind="status"), StatusIs(kind="status", controller="a")]
)
def test_a_claim_about_another_or_about_a_status_does_not(claim):
    assert only_status_judged(runs("verdict"), [claim]) == [SAID.format("1 run")]


def test_a_claim_about_some_worlds_judges_those():
    claim = below(where=(Condition(key="ground.friction", values=(0.1,)),))
    assert only_status_judged(runs("verdict", "verdict"), [claim]) == [SAID.format("1 run")]
