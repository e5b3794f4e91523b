"""Which worlds get a Rerun recording, and writing them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipctl.experiment import assemble
from slipctl.experiment.batch import Run
from slipctl.experiment.collect import SIGNALS
from slipctl.guarantee import METRIC_UNITS
from slipctl.metrics import UNITS

if TYPE_CHECKING:
    from slipctl.scenario import World
    from slipctl.shape import Shape
    from slipctl.view import RunInfo, Theorem

MANY = 24
"""Up to so many worlds, all are recorded unless told otherwise; above, those with the largest errors."""


class RecordChoiceError(Exception):
    """The choice of recordings cannot be understood."""


def check_choice(record: str) -> int | None:
    """Return N of ``worst:N``, or None for ``auto``, ``all`` and ``none``.

    Raises
    ------
    RecordChoiceError
        For anything else.
    """
    if record in ("auto", "all", "none"):
        return None
    match = re.fullmatch(r"worst:([1-9][0-9]*)", record)
    if match is None:
        raise RecordChoiceError(f"record: found {record!r}, allowed are auto, all, none, worst:N with N ≥ 1")
    return int(match[1])


def worlds_to_record(record: str, runs: Sequence[Run], total: int) -> tuple[list[int], str]:
    """Return the indices of the worlds to record, in order, and a sentence that says how many and why.

    Parameters
    ----------
    record : str
        ``auto``, ``all``, ``none`` or ``worst:N``.
    runs : sequence of Run
        What finished; only worlds with every controller finished are recorded.
    total : int
        Number of worlds in the scenario.

    Raises
    ------
    RecordChoiceError
        Where `record` is none of these.
    """
    count = check_choice(record)
    finished = sorted({run.world for run in runs})
    if record == "none":
        return [], "no recordings: told so by record none"
    if record == "auto" and total > MANY:
        count = MANY
    if count is None or count >= len(finished):
        reason = "one per world" if len(finished) == total else "one per world that finished"
        return finished, f"{len(finished)} recording{'s' if len(finished) != 1 else ''}: {reason}"

    def badness(world: int) -> tuple[bool, float]:
        own = [run for run in runs if run.world == world]
        errors = [run.metrics["max_position_error"] for run in own]
        return (
            any(run.status != "completed" for run in own),
            max((error for error in errors if error is not None), default=0.0),
        )

    worst = sorted(finished, key=badness, reverse=True)[:count]
    note = f"{count} recordings of {len(finished)} worlds: those that ended early, then the largest errors"
    return sorted(worst), note + (" (more with record all)" if record == "auto" else "")


def record_worlds(
    folder: Path,
    chosen: Sequence[int],
    runs: Sequence[Run],
    worlds: Sequence[World],
    manifest: dict[str, Any],
    shapes: Sequence[Shape],
) -> dict[int, str]:
    """Write one recording per chosen world into `folder`; return the file names by world.

    The recordings are made from `signals.parquet`: the archive is Parquet, a recording is a view of it.
    """
    if not chosen:
        return {}
    from slipctl.view import WorldRecording, world_slug, write_recordings

    names = {world: world_slug(worlds[world].varied, manifest["scenario"]) + ".rrd" for world in chosen}
    recordings = [
        WorldRecording(
            file=names[world],
            runs=tuple(run_info(worlds[world], run) for run in runs if run.world == world),
            info=world_info(worlds[world], manifest),
        )
        for world in chosen
    ]
    bodies = shapes if worlds[0].scenario.plant.kind == "mujoco" else None
    write_recordings(folder, folder / SIGNALS, recordings, bodies)
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


def run_info(world: World, run: Run | Mapping[str, Any]) -> RunInfo:
    """Return what a recording says of a run of a world: one that has just finished, or its row of metrics."""
    from slipctl.view import RunInfo

    if not isinstance(run, Mapping):
        row = {"run": run.index, "controller": run.label, **vars(run), **run.metrics, **run.guarantee}
        return run_info(world, row)
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
