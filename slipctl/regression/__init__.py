"""The gate: metrics of a scenario against committed baselines, per controller, world and seed."""

from slipctl.regression.baseline import Baseline, CannotJudge, Number, RunBaseline, read, write
from slipctl.regression.check import Report, baseline_file, check, recorded_scenarios, update
from slipctl.regression.judge import Finding, Verdict, judge
from slipctl.regression.tolerance import measure

__all__ = [
    "Baseline",
    "CannotJudge",
    "Finding",
    "Number",
    "Report",
    "RunBaseline",
    "Verdict",
    "baseline_file",
    "check",
    "judge",
    "measure",
    "read",
    "recorded_scenarios",
    "update",
    "write",
]
