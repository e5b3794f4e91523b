"""Section VI many times: what the paper does not say about its experiment, chosen, varied and counted.

The paper gives the path, the start at rest, the speed floor, α, ε and "about 3 Hz". It gives neither the
command rate nor how a camera fix corrects the odometry. Both are varied here, over seeds of the camera's
phase and noise; every law meets the same seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipctl import scenario as files
from slipctl.experiment import Result, assemble, run
from slipctl.sensing.odometry import OdometryPose, advance
from slipctl.study.runs import edited
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array

if TYPE_CHECKING:
    import pyarrow as pa

Progress = Callable[[int, int, str], None]
Row = dict[str, Any]

SCENARIO = "paper-experiment"
SEEDS = tuple(range(20))
TICKS = (0.2, 0.1, 0.05)
"""Command rates of 5, 10 and 20 Hz [s]."""

GAINS = (1.0, 0.5)
"""Shares of the difference that a camera fix corrects: all of it, or half."""

COUNTER_EXAMPLE = (15.0, 20.0)
"""When the paper saw the robust law do worse in y [s]."""

MOVING_AFTER = 5.0
"""From then on what the start at rest left behind no longer rules the error [s] (assumed)."""

RESAMPLES = 2000
COVERAGE = 0.95


def experiment_runs(
    seeds: Sequence[int] = SEEDS,
    ticks: Sequence[float] = TICKS,
    gains: Sequence[float] = GAINS,
    scenario: files.Scenario | None = None,
    progress: Progress | None = None,
) -> pa.Table:
    """Run the experiment for every seed, command period and share corrected at a fix.

    Parameters
    ----------
    seeds : sequence of int
    ticks : sequence of float
        Command periods, multiples of the physics step [s].
    gains : sequence of float
        `sensing.camera_gain`.
    scenario : Scenario, optional
        With a camera; the shipped one by default.
    progress : callable, optional
        As of `slipctl.run`; counts the ticks of one command period after the other.

    Returns
    -------
    pyarrow.Table
        One row per run: `tick` [s], `camera_gain`, `seed`, `controller`; RMS, maximum and final position
        error, RMS after 5 s (`moving_position_error`) and RMS of y between 15 and 20 s (`late_y_error`, and
        `late_y_seen` of the pose that the robot believed, which is what an experimenter can plot) [m];
        `odometry_error`, how far off the wheels alone are at the end [m]; RMS over the fixes of what
        `fix_errors` tells; `fix_helped`, the share of fixes that made the position better; and
        `command_variation` [rad/s]. Null where a run is too short for a number.

    Raises
    ------
    slipctl.scenario.ScenarioError
        Where the scenario has no camera, or a tick does not fit.
    """
    import pyarrow as pa

    scenario = scenario or files.load(SCENARIO)
    geometry = assemble.read_robot(scenario).geometry
    rows: list[Row] = []
    for tick in ticks:
        varied = files.override(
            edited(scenario, {"tick": tick}), {"sensing.camera_gain": list(gains), "seed": list(seeds)}
        )
        result = run(varied, progress=progress)
        rows += [{"tick": tick, **row} for row in _measured(result, geometry)]
    return pa.Table.from_pylist(rows)


def fix_errors(signals: pa.Table, geometry: WheelGeometry) -> dict[str, Array]:
    """Return what every camera fix of a run did, arrays (number of fixes,).

    Parameters
    ----------
    signals : pyarrow.Table
        Of one run with a camera.
    geometry : WheelGeometry
        What the odometry reckons with.

    Returns
    -------
    dict
        `time` of the row at which the fix arrived [s]; distance of the believed from the true position in
        the row before and in this row, `position_before` and `position_after` [m]; the same of the heading
        [rad]; and `drift`, how far the wheels alone went astray since the fix before [m].
    """
    time, fix = _of(signals, "time"), _of(signals, "sensed.fix").astype(bool)
    off = np.abs(_place(signals, "sensed") - _place(signals, "motion"))
    turned = np.abs(_wrapped(_of(signals, "sensed.heading") - _of(signals, "motion.heading")))
    rows = np.flatnonzero(fix)
    anchors = np.concatenate([[0], rows])
    wheels, wheels_heading = _reckoned(signals, geometry)
    reckoned = np.diff(wheels[anchors]) * np.exp(-1j * wheels_heading[anchors[:-1]])
    true = np.diff(_place(signals, "motion")[anchors])
    true = true * np.exp(-1j * _of(signals, "motion.heading")[anchors[:-1]])
    return {
        "time": time[rows],
        "position_before": off[rows - 1],
        "position_after": off[rows],
        "heading_before": turned[rows - 1],
        "heading_after": turned[rows],
        "drift": np.abs(reckoned - true),
    }


def _measured(result: Result, geometry: WheelGeometry) -> Iterator[Row]:
    for row in result.metrics.to_pylist():
        signals = result.run_signals(row["run"])
        time = _of(signals, "time")
        late = (time >= COUNTER_EXAMPLE[0]) & (time <= COUNTER_EXAMPLE[1])
        true, seen, planned = (_place(signals, name) for name in ("motion", "sensed", "reference"))
        fixes = fix_errors(signals, geometry)
        helped = fixes["position_after"] < fixes["position_before"]
        yield {
            "camera_gain": row["sensing.camera_gain"],
            "seed": row["seed"],
            "controller": row["controller"],
            "rms_position_error": row["rms_position_error"],
            "max_position_error": row["max_position_error"],
            "final_position_error": row["final_position_error"],
            "moving_position_error": _rms(np.abs(true - planned)[time >= MOVING_AFTER]),
            "late_y_error": _rms((true - planned).imag[late]),
            "late_y_seen": _rms((seen - planned).imag[late]),
            "odometry_error": float(np.abs(_reckoned(signals, geometry)[0] - true)[-1]),
            **{name: _rms(values) for name, values in fixes.items() if name != "time"},
            "fix_helped": float(np.mean(helped)) if len(helped) else None,
            "command_variation": row["command_variation"],
        }


def _reckoned(signals: pa.Table, geometry: WheelGeometry) -> tuple[NDArray[np.complex128], Array]:
    """Return where the wheels alone put the robot from its true start on: x + iy [m] and heading [rad]."""
    angles = np.stack([_of(signals, f"wheel.angle.{side}") for side in ("left", "right")], axis=-1)
    start = _place(signals, "motion")[0]
    pose = OdometryPose(np.array([[start.real, start.imag]]), _of(signals, "motion.heading")[:1], angles[:1])
    poses = [pose]
    for angle in angles[1:]:
        pose = advance(pose, angle[None], geometry)
        poses.append(pose)
    place = np.array([pose.position[0, 0] + 1j * pose.position[0, 1] for pose in poses])
    return place, np.array([pose.heading[0] for pose in poses])


def _of(signals: pa.Table, name: str) -> Array:
    return signals[name].to_numpy(zero_copy_only=False)


def _place(signals: pa.Table, name: str) -> NDArray[np.complex128]:
    """Return a position as x + iy, (T + 1,) [m]."""
    return _of(signals, f"{name}.position.x") + 1j * _of(signals, f"{name}.position.y")


def summary(runs: pa.Table) -> list[Row]:
    """Return the medians over seeds, one row per command period, share corrected, and law.

    Parameters
    ----------
    runs : pyarrow.Table
        Of `experiment_runs`.

    Returns
    -------
    list of dict
        `tick`, `camera_gain`, `controller`, `runs`; the median of every number of `experiment_runs`, and of
        the RMS position error `lower` and `upper`, a bootstrap interval of the median.
    """
    rows = []
    for key, group in _groups(runs, ("tick", "camera_gain", "controller")):
        numbers = {name: _column(group, name) for name in group[0] if name not in (*key, "seed")}
        lower, upper = bootstrap(numbers["rms_position_error"])
        medians = {name: _median(values) for name, values in numbers.items()}
        rows.append({**key, "runs": len(group), **medians, "lower": lower, "upper": upper})
    return rows


def comparison(runs: pa.Table) -> list[Row]:
    """Return the laws against the first one seed by seed, and how often the paper's counter-example shows.

    Parameters
    ----------
    runs : pyarrow.Table
        Of `experiment_runs`.

    Returns
    -------
    list of dict
        `tick`, `camera_gain`, `controller`, `runs`, `against`; the median of the difference in RMS position
        error (negative: better than `against`) with its bootstrap interval, `rms_difference`, `lower`,
        `upper` [m]; `better`, the share of seeds with a smaller RMS; the same after 5 s, `moving_difference`
        [m] and `moving_better`; and the share of pairs of runs in which the RMS of y between 15 and 20 s is
        larger: `counter_example` at the same seed, `counter_example_apart` at any two different seeds, as
        two runs in a laboratory are, and `counter_example_seen`, the latter by the position that the robot
        believed. None where runs are too short.
    """
    rows = []
    for key, group in _groups(runs, ("tick", "camera_gain")):
        laws = [list(of_law) for _, of_law in _groups(group, ("controller",))]
        base = sorted(laws[0], key=lambda row: row["seed"])
        for law in laws[1:]:
            compared = sorted(law, key=lambda row: row["seed"])
            rows.append({**key, **_against(base, compared)})
    return rows


def _against(base: Sequence[Row], law: Sequence[Row]) -> Row:
    """Compare two laws over the same seeds in the same order."""

    def more(name: str) -> Array:
        """Return law less base: row by seed of the law, column by seed of the base."""
        return _column(law, name)[:, None] - _column(base, name)[None, :]

    same = np.eye(len(base), dtype=bool)
    difference, moving = more("rms_position_error")[same], more("moving_position_error")[same]
    lower, upper = bootstrap(difference)
    return {
        "controller": law[0]["controller"],
        "against": base[0]["controller"],
        "runs": len(base),
        "rms_difference": _median(difference),
        "lower": lower,
        "upper": upper,
        "better": _share(difference < 0.0, difference),
        "moving_difference": _median(moving),
        "moving_better": _share(moving < 0.0, moving),
        "counter_example": _share(more("late_y_error")[same] > 0.0, more("late_y_error")[same]),
        "counter_example_apart": _share(more("late_y_error")[~same] > 0.0, more("late_y_error")[~same]),
        "counter_example_seen": _share(more("late_y_seen")[~same] > 0.0, more("late_y_seen")[~same]),
    }


def bootstrap(values: Array) -> tuple[float, float]:
    """Return the 95 % percentile bootstrap interval of the median of some values (K,).

    The resamples are drawn from a fixed seed: the same values give the same interval.
    """
    chosen = np.random.default_rng(0).integers(len(values), size=(RESAMPLES, len(values)))
    lower, upper = np.quantile(np.median(values[chosen], axis=1), [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2])
    return float(lower), float(upper)


def _groups(runs: pa.Table | Sequence[Row], keys: tuple[str, ...]) -> Iterator[tuple[Row, list[Row]]]:
    groups: dict[tuple, list[Row]] = {}
    for row in runs if isinstance(runs, Sequence) else runs.to_pylist():
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    for values, group in groups.items():
        yield dict(zip(keys, values, strict=True)), group


def _column(rows: Sequence[Row], name: str) -> Array:
    return np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=float)


def _median(values: Array) -> float | None:
    median = float(np.median(values))
    return median if np.isfinite(median) else None


def _share(flags: NDArray[np.bool_], of: Array) -> float | None:
    return float(np.mean(flags)) if len(of) and np.isfinite(of).all() else None


def _rms(values: Array) -> float | None:
    return float(np.sqrt(np.mean(values * values))) if len(values) else None


def _wrapped(angle: Array) -> Array:
    return np.arctan2(np.sin(angle), np.cos(angle))
