"""What a simulation leaves behind: columns (worlds, rows), then Arrow tables.

A column's name is its only name: in `signals.parquet`, in Python and as a Rerun entity path.
"""

from __future__ import annotations

from slipctl.recording.errors import with_errors, with_plan
from slipctl.recording.recorder import Recorder
from slipctl.recording.signals import LAW_COLUMNS, SIGNALS, UNITS, Columns
from slipctl.recording.tables import signal_tables

__all__ = [
    "LAW_COLUMNS",
    "SIGNALS",
    "UNITS",
    "Columns",
    "Recorder",
    "signal_tables",
    "with_errors",
    "with_plan",
]
