"""Which worlds get a Rerun recording, and writing them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl.experiment import assemble
from slipctl.guarantee import METRIC_UNITS
from slipctl.metrics import UNITS

if TYPE_CHECKING:
    import pyarrow as pa

    from slipctl.experiment.chunk import Setup
    from slipctl.scenario import World
    from slipctl.view import RunInfo, Theorem

MANY = 24
"""Up to so many worlds, all are recorded unless told otherwise."""

WORST = 8
"""Of more worlds, so many are: those with the largest errors; more cost more than a tenth of a sweep."""


class RecordChoiceError(Exception):
    """The choice of recordings cannot be understood."""


def check_choice(record: str) -> int | None:
    """Return N of ``worst:N``, or None for ``auto``, ``all``, ``failed`` and ``none``.

    Raises
    ------
    RecordChoiceError
        For anything else.
    """
    if record in ("auto", "all", "failed", "none"):
        return None
    match = re.fullmatch(r"worst:([1-9][0-9]*)", record)
    if match is None:
        raise RecordChoiceError(
            f"record: found {record!r}, allowed are auto, all, failed, none, worst:N with N ≥ 1"
        )
    return int(match[1])


def worlds_to_record(record: str, metrics: pa.Table) -> tuple[list[int], str]:
    """Return the indices of the worlds to record, in order, and a sentence that says how many and why.

    A world of which every run failed before its first row, or kept none, has nothing to show: it is never
    among them, and the sentence says so.

    Parameters
    ----------
    record : str
        ``auto``, ``all``, ``failed``, ``none`` or ``worst:N``.
    metrics : pyarrow.Table
        One row per run, ordered by world.

    Raises
    ------
    RecordChoiceError
        Where `record` is none of these.
    """
    count = check_choice(record)
    if record == "none":
        return [], "no recordings: told so by record none"
    worlds, first = np.unique(metrics["world"].to_numpy(), return_index=True)
    statuses = metrics["status"].to_pylist()
    early = np.logical_or.reduceat([status != "completed" for status in statuses], first)
    shown = np.logical_or.reduceat(~np.isnan(metrics["end_time"].to_numpy()), first)
    hidden, total = int((~shown).sum()), len(worlds)
    left_out = f"; nothing to show of {hidden} whose every run failed" if hidden else ""
    of_all = f"of {total} world{'s' if total != 1 else ''}"
    if record == "failed":
        chosen = worlds[early & shown].tolist()
        what = "those that did not complete" if early.any() else "every run completed"
        return chosen, f"{_recordings(len(chosen))} {of_all}: {what}{left_out}"
    if record == "auto" and total > MANY:
        count = WORST
    if count is None or count >= shown.sum():
        of = f" {of_all}" if hidden else ""
        return worlds[shown].tolist(), f"{_recordings(int(shown.sum()))}{of}: one per world{left_out}"
    errors = metrics["max_position_error"].fill_null(0.0).to_numpy()
    largest = np.maximum.reduceat(errors, first)
    order = np.lexsort((worlds, -largest, ~early))
    worst = worlds[order][shown[order]][:count]
    note = f"{_recordings(count)} {of_all}: those that ended early, then the largest errors"
    note += " (more with record all)" if record == "auto" else ""
    return sorted(worst.tolist()), note + left_out


def _recordings(count: int) -> str:
    return f"{count} recording{'s' if count != 1 else ''}"


def record_worlds(
    folder: Path,
    signals: Path,
    chosen: Sequence[int],
    metrics: pa.Table,
    setup: Setup,
    manifest: dict[str, Any],
) -> dict[int, str]:
    """Write one recording per chosen world into `folder`; return the file names by world.

    The recordings are made from a Parquet file: the archive is Parquet, a recording is a view of it.

    Parameters
    ----------
    folder : pathlib.Path
    signals : pathlib.Path
        Holds every row of the chosen worlds' runs.
    chosen : sequence of int
        Indices of worlds.
    metrics : pyarrow.Table
        One row per run.
    setup : Setup
    manifest : dict
    """
    if not chosen:
        return {}
    from slipctl.view import WorldRecording, world_slug, write_recordings

    runs: dict[int, list[dict[str, Any]]] = {}
    count = len(setup.plan.entrants)
    for world, first in zip(chosen, np.searchsorted(metrics["world"].to_numpy(), chosen), strict=True):
        rows = metrics.slice(int(first), count).to_pylist()
        runs[world] = [row for row in rows if row["end_time"] is not None]  # others have nothing to show
    grid = setup.plan.grid
    names = {world: world_slug(grid.varied(world), manifest["scenario"]) + ".rrd" for world in runs}
    recordings = [
        WorldRecording(
            file=names[index],
            runs=tuple(run_info(grid[index], row) for row in own),
            info=world_info(grid[index], manifest),
        )
        for index, own in runs.items()
    ]
    shapes = setup.robot.shapes if grid[0].scenario.plant.kind == "mujoco" else None
    write_recordings(folder, signals, recordings, shapes)
    return names


def world_info(world: World, manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a recording says of its world, see `slipctl.view.recording.write`."""
    return {
        "scenario": manifest["scenario"],
        "scenario_id": manifest["scenario_id"],
        "model_id": manifest["model_id"],
        "versions": manifest["versions"],
        "description": world.scenario.description,
        "varied": world.varied,
        "seed": world.seed,
        "tick": world.scenario.tick,
        "units": UNITS,
        **_floor(world),
    }


def run_info(world: World, run: Mapping[str, Any]) -> RunInfo:
    """Return what a recording says of a run of a world, from its row of metrics."""
    from slipctl.view import RunInfo

    config = _config(world, run["controller"])
    return RunInfo(
        run=run["run"],
        label=run["controller"],
        kind=run["kind"],
        status=run["status"],
        end_time=run["end_time"],
        metrics={name: run[name] for name in UNITS},
        slip_bound=getattr(config, "slip_bound", None),
        theorem=_theorem(config),
        guarantee={name: run[name] for name in ("first_violation", *METRIC_UNITS)},
    )


def _floor(world: World) -> dict[str, Any]:
    """Return what pictures need of the floor and of pushes, where there is more than one even floor."""
    scenario, ground = world.scenario, world.scenario.ground
    told: dict[str, Any] = {
        "patches": [patch.model_dump() for patch in ground.patch],
        "changes": [change.model_dump() for change in ground.change],
        "pushes": [push.model_dump() for push in scenario.disturbance],
    }
    uneven = assemble.terrain([world]) if ground.terrain is not None else None
    if uneven is not None:
        told["terrain"] = {name: values[0].tolist() for name, values in vars(uneven).items()}
    told = {name: entries for name, entries in told.items() if entries}
    if "changes" in told:
        told |= {"friction": min(ground.wheel_friction), "film": ground.film}
    return told


def _theorem(config: Any) -> Theorem | None:
    """Return what pictures need of the theorem behind a controller, None for a law without one."""
    from slipctl.view import Theorem

    if not hasattr(config, "boundary_layer"):
        return None
    general = config.uncertainty == "general"
    return Theorem(
        uncertainty=config.uncertainty,
        slip_bound=config.slip_bound,
        boundary_layer=config.boundary_layer,
        yaw_slip_bound=config.yaw_slip_bound if general else None,
        lateral_slip_bound=config.lateral_slip_bound if general else None,
        order=3 if config.kind == "robust_dynamic" else 2,
    )


def _config(world: World, label: str) -> Any:
    # None for a law of one's own, of which the scenario says nothing
    return next((listed for listed in world.scenario.controller if listed.label == label), None)
