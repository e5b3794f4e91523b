"""Runs of a baseline of which no number is judged and that no claim names: not to pass in silence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from slipctl.regression.baseline.file import RunBaseline
from slipctl.scenario import Better, Claim, StatusIs


def only_status_judged(runs: Sequence[RunBaseline], claims: Iterable[Claim] = ()) -> list[str]:
    """Say of which controllers a check judges only how their runs end.

    Parameters
    ----------
    runs
        Of a baseline.
    claims
        What is judged besides. A claim about a status says nothing of a number.

    Returns
    -------
    list of str
        One sentence per controller that has such runs.
    """
    stated = [claim for claim in claims if not isinstance(claim, StatusIs)]
    silent = Counter(
        run.controller
        for run in runs
        if _has_no_gated_number(run) and not any(_names(claim, run) for claim in stated)
    )
    return [
        f"only the status of {controller} is judged"
        f" in {count} {'run' if count == 1 else 'runs'}: all numbers are chaotic and no claim names it"
        for controller, count in silent.items()
    ]


def _has_no_gated_number(run: RunBaseline) -> bool:
    return all(number.gate == "verdict" or number.value is None for number in run.metrics.values())


def _names(claim: Claim, run: RunBaseline) -> bool:
    """Whether a claim is about a run: by its labels, and by its `where`."""
    labels = {claim.controller, claim.than} if isinstance(claim, Better) else {claim.controller}
    return run.controller in labels and all(
        condition.key in run.varied and condition.holds(run.varied[condition.key])
        for condition in claim.where
    )
