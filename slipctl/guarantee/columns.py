"""Names and units of what the guarantee adds to signals and to the metrics."""

from __future__ import annotations

HYPOTHESES = {
    "speed_above_floor": "speed above its floor",
    "slip_bounded": "slip within its bound",
    "yaw_slip_bounded": "yaw slip within its bound",
    "feedback_exact": "feedback exact",
    "uncertainty_covered": "uncertainty covered by ρ",
}
"""Every hypothesis of the theorems and how people read it. Causes come before what they cause: where several
fail at once, the first one is named."""

UNITS = {
    "guarantee.uncertainty": "m/s²",
    "guarantee.held": "bool",
    **{f"guarantee.{name}": "bool" for name in HYPOTHESES},
    "guarantee.slip_rates_bounded": "bool",
    "guarantee.weighted_error": "1",
    "guarantee.lyapunov": "1",
    "guarantee.lyapunov_falls": "bool",
    "guarantee.calm_tick": "s",
    "guarantee.calm": "bool",
    "guarantee.monitored_slip": "1",
    "guarantee.monitor_limit": "1",
    "guarantee.alarm": "bool",
}
"""Columns of `signals.parquet`; all but the first need a law with a theorem."""

METRIC_UNITS = {
    "first_violation_time": "s",
    "first_violation_excess": "1",
    "settling_time": "s",
    "settled_guarantee_fraction": "1",
    "settled_error": "m",
    "error_bound": "m",
    "error_bound_share": "1",
    "lyapunov_level": "1",
    "error_bound_level_set": "m",
    "error_bound_tight_level_set": "m",
    "error_bound_small_gain": "m",
    "slip_rate_fraction": "1",
    "lyapunov_fraction": "1",
    "calm_fraction": "1",
    "calm_tick": "s",
    "alarm_time": "s",
}
"""Numbers of a run beside its metrics; the column `first_violation` holds a word and goes before them."""
