"""The gate: metrics of a scenario against committed baselines, per controller, world and seed.

`check` runs a scenario and holds it against its baseline; `record` writes a new one. Each folder answers one
question. `baseline`: what was stored, and how far may it move? `judging`: is a number worse? `claims`: does
what a scenario claims hold? `against`: what of another revision or run? `own_law`: what of one's own law?
"""

from slipctl.regression.against.compare import against, look_up
from slipctl.regression.artefacts import record_failing
from slipctl.regression.baseline.file import Baseline, CannotJudge, Number, RunBaseline, read, write
from slipctl.regression.baseline.spread import measure
from slipctl.regression.check import Report, baseline_file, check, recorded_scenarios
from slipctl.regression.git import UnknownRevision
from slipctl.regression.judging.findings import Finding, Verdict, judge, unjudged
from slipctl.regression.record import Recording, record, try_to_write

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
