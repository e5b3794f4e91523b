"""What slipctl costs on this machine: a sweep against the engine alone, and laws by themselves."""

from __future__ import annotations

from slipctl.bench.decisions import decision_times
from slipctl.bench.history import append
from slipctl.bench.replay import Replay, ReplayError
from slipctl.bench.sweep import Measurement, bench_scenario, measure_sweep

__all__ = [
    "Measurement",
    "Replay",
    "ReplayError",
    "append",
    "bench_scenario",
    "decision_times",
    "measure_sweep",
]
