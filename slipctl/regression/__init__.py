"""The gate: metrics of a scenario against committed baselines, per controller, world and seed."""

from slipctl.regression.against import against, look_up
from slipctl.regression.artefacts import record_failing
from slipctl.regression.baseline import Baseline, CannotJudge, Number, RunBaseline, read, write
from slipctl.regression.check import Report, baseline_file, check, recorded_scenarios
from slipctl.regression.git import UnknownRevision
from slipctl.regression.judge import Finding, Verdict, judge, unjudged
from slipctl.regression.record import Recording, record, try_to_write
from slipctl.regression.spread import measure

__all__ = [
    "Baseline",
    "CannotJudge",
    "Finding",
    "Number",
    "Recording",
    "Report",
    "RunBaseline",
    "UnknownRevision",
    "Verdict",
    "against",
    "baseline_file",
    "check",
    "judge",
    "look_up",
    "measure",
    "read",
    "record",
    "record_failing",
    "recorded_scenarios",
    "try_to_write",
    "unjudged",
    "write",
]
