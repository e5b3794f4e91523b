"""Results without an engine, for the tests of what is done with results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa

from slipctl.regression import Baseline, Number, RunBaseline
from slipctl.regression.baseline.gated import GATED

SHORT_SCENARIO = """
tick = 0.01
[robot]
model = "magellan_pro"
drive = "wheel_speed"
[plant]
kind = "kinematic_ode"
[reference]
kind = "line"
speed = 0.2
distance = 0.2
[[controller]]
kind = "nominal_kinematic"
pole = -1.0
"""
"""A hundred ticks of the paper's model: milliseconds to run."""

MACHINE = {
    "system": "Linux",
    "architecture": "x86_64",
    "processor": "a processor",
    "family": "x86_64 AVendor 1",
}
"""What fake results and baselines were made on."""

NAMES = (
    "rms_position_error",
    "max_position_error",
    "final_position_error",
    "rms_cross_track_error",
    "rms_heading_error",
    "rms_robust_input",
    "command_variation",
    "max_slip_ratio",
    "median_slip_ratio",
    "saturation_fraction",
    "guarantee_fraction",
    "min_forward_speed",
)


def run_entry(
    controller: str,
    friction: float = 0.8,
    rms: float | None = 0.001,
    status: str = "completed",
    seed: int = 1,
    varied: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """One entry of ``runs``: the maximum is three times the RMS, the final and the cross-track error half."""
    metrics: dict[str, float | None] = dict.fromkeys(NAMES, 0.25)
    metrics |= {
        "rms_position_error": rms,
        "max_position_error": None if rms is None else 3 * rms,
        "final_position_error": None if rms is None else rms / 2,
        "rms_cross_track_error": None if rms is None else rms / 2,
        "median_slip_ratio": 0.0123,
    }
    return {
        "controller": controller,
        "varied": {"ground.friction": friction} if varied is None else varied,
        "seed": seed,
        "status": status,
        "metrics": metrics,
        "recording": None,
    }


def baseline_of(content: dict[str, Any], tolerance: float = 1e-4) -> Baseline:
    """A baseline that holds exactly this content."""
    runs = [
        RunBaseline(
            controller=run["controller"],
            varied=run["varied"],
            seed=run["seed"],
            status=run["status"],
            ticks=100,
            metrics={name: _number(run["metrics"][name], tolerance) for name in GATED},
        )
        for run in content["runs"]
    ]
    return Baseline(
        scenario=content["scenario"],
        scenario_id=content["scenario_id"],
        model_id=content["model_id"],
        versions=content["versions"],
        machine=MACHINE,
        commit=None,
        date="2000-01-01",
        reason="for a test",
        runs=runs,
    )


def _number(value: float | None, tolerance: float) -> Number:
    """The tolerances that follow from a tenth of the tolerance as spread, and twice of it at half a step."""
    if value is None:
        return Number(value=None, tolerance=0.0, tolerance_elsewhere=0.0, why="for a test")
    return Number(
        value=value,
        tolerance=tolerance,
        tolerance_elsewhere=2 * tolerance,
        spread=tolerance / 10,
        halving=2 * tolerance,
        why="for a test",
    )


def payload(
    runs: Sequence[dict[str, Any]], scenario: str = "friction-sweep", scenario_id: str = "sha256:s"
) -> dict:
    return {
        "scenario": scenario,
        "scenario_id": scenario_id,
        "model_id": "sha256:m",
        "versions": {"slipctl": "0.1.0", "mujoco": "4.0.0"},
        "runs": list(runs),
    }


@dataclass(frozen=True)
class FakeResult:
    """What the commands need of a `slipctl.experiment.Result`."""

    content: dict[str, Any]
    folder: Path | None = None
    interrupted: bool = False
    recording_note: str = "2 recordings: one per world"
    end_time: float = 3.21

    signals_note: str = "signals: every row of every run"
    failures: tuple[dict[str, Any], ...] = ()
    varied: tuple[str, ...] = ()

    @property
    def metrics(self) -> pa.Table:
        runs = self.content["runs"]
        return pa.table(
            {
                "run": pa.array(range(len(runs)), pa.int32()),
                "world": pa.array([0] * len(runs), pa.int32()),
                "controller": pa.array([run["controller"] for run in runs], pa.string()),
                "end_time": pa.array([self.end_time] * len(runs), pa.float64()),
                "status": pa.array([run["status"] for run in runs], pa.string()),
            }
        )

    @property
    def signals(self) -> pa.Table:
        return pa.concat_tables([self.run_signals(run) for run in range(len(self.content["runs"]))])

    def run_signals(self, run: int) -> pa.Table:
        """A hundred ticks of 0.01 s in which the robot stands still."""
        names = ("motion.position.x", "motion.position.y", "motion.heading", "error.position")
        columns: dict[str, Any] = {
            "run": pa.array([run] * 101, pa.int32()),
            "time": [k / 100 for k in range(101)],
        }
        return pa.table(columns | {name: [0.0] * 101 for name in (*names, "error.cross_track")})

    @property
    def manifest(self) -> dict[str, Any]:
        return {**self.content, "machine": MACHINE | {"cores": 2}}

    def json(self) -> dict[str, Any]:
        return self.content

    def json_head(self) -> dict[str, Any]:
        return {key: value for key, value in self.content.items() if key != "runs"}

    def json_runs(self) -> list[dict[str, Any]]:
        return self.content["runs"]
