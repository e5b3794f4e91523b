"""The world that the recording tests write: a nominal and a robust law on the same figure-eight."""

from __future__ import annotations

from slipctl.view import RunInfo, Theorem

NOMINAL = RunInfo(
    0, "nominal_kinematic", "nominal_kinematic", metrics={"rms_position_error": 0.002, "x": None}
)
ROBUST = RunInfo(
    1,
    "robust_kinematic",
    "robust_kinematic",
    metrics={"rms_position_error": 0.001, "guarantee_fraction": 0.9},
    slip_bound=0.4,
    theorem=Theorem("independent", 0.4, 0.05),
    guarantee={
        "first_violation": "uncertainty_covered",
        "first_violation_time": 3.6,
        "first_violation_excess": 0.275,
        "settling_time": 2.0,
        "settled_error": 0.004,
        "lyapunov_level": 0.02,
        "error_bound": 0.05,
        "error_bound_small_gain": 0.05,
        "calm_tick": 0.03,
        "calm_fraction": 1.0,
        "alarm_time": None,
    },
)
INFO = {
    "scenario": "friction-sweep",
    "scenario_id": "sha256:0123456789abcdef",
    "description": "a figure-eight",
    "varied": {"ground.friction": 0.1},
    "versions": {"slipctl": "0.1.0"},
    "units": {"rms_position_error": "m"},
    "seed": 1,
}
ROOT = "/runs/robust_kinematic"
# all that was seen drawn: the viewer ends where its font lacks a glyph, ᵀ for one
GLYPHS = {chr(code) for code in range(0x20, 0x7F)} | set("·–−±≤≥ηρεαΔθμ²³√°…σ|\u0302")
