"""The theorem behind a robust law, checked on every tick of a recording.

The theorem says: as long as its hypotheses hold, V = eᵀPe falls outside a set that bounds the position error.
`with_guarantee` evaluates hypotheses, consequence and monitor tick by tick; `verdicts` sums runs up.
"""

from __future__ import annotations

from slipctl.guarantee.columns import HYPOTHESES, METRIC_UNITS, UNITS
from slipctl.guarantee.evaluate import with_guarantee
from slipctl.guarantee.hypotheses import Hypotheses
from slipctl.guarantee.verdict import verdict, verdicts

__all__ = ["HYPOTHESES", "METRIC_UNITS", "UNITS", "Hypotheses", "verdict", "verdicts", "with_guarantee"]
