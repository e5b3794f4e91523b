"""Run a scenario: worlds in batches, results streamed to disk, recordings from them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slipctl import scenario as files
from slipctl.experiment import assemble, certified, folder
from slipctl.experiment.batch import batches, run_batch
from slipctl.experiment.collect import Collector
from slipctl.experiment.machine import machine, versions
from slipctl.experiment.own import OwnLaws, check_labels, described
from slipctl.experiment.record import record_worlds, worlds_to_record
from slipctl.experiment.result import Result, metrics_table, varied_keys, write_json

Progress = Callable[[int, int, str], None]

LARGEST_BATCH = 64
ROWS_IN_MEMORY = 500_000
"""Rows times worlds that one batch may hold: about 0.2 GB of signals."""


def run(
    scenario: files.Scenario | str | Path,
    *,
    out: Path | str | None = None,
    record: str = "auto",
    threads: int | None = None,
    progress: Progress | None = None,
    laws: OwnLaws | None = None,
) -> Result:
    """Run every world of a scenario under every listed controller.

    Parameters
    ----------
    scenario : Scenario, path, or name of a shipped scenario
    out : path, optional
        Folder in which a new run folder is made; nothing is written where it is None.
    record : str
        Which worlds get a Rerun recording: ``auto``, ``all``, ``none`` or ``worst:N``. Without `out`, none.
    threads : int, optional
        Threads for MuJoCo; by default chosen from the size of a batch. Results do not depend on it.
    progress : callable, optional
        Called with steps done, steps in all and a text.
    laws : mapping, optional
        Laws of one's own by label: they run beside the listed controllers, in the same worlds. Each is a
        `slipctl.simulate.Controller`, or what makes one from a `slipctl.experiment.own.KnownRobot`.

    Returns
    -------
    Result

    Raises
    ------
    slipctl.scenario.ScenarioError
        Where the scenario is wrong.
    slipctl.experiment.folder.OutputError
        Where `out` cannot be written.
    slipctl.experiment.checked.OwnLawError
        Where an own law has a label that cannot be, raises, or gives what does not fit or is not finite.
    """
    if not isinstance(scenario, files.Scenario):
        scenario = files.load(scenario)
    laws = dict(laws or {})
    check_labels(laws, [controller.label for controller in scenario.controller])
    worlds = files.worlds(scenario)
    began = time.monotonic()
    tell = progress or (lambda done, total, text: None)
    with ExitStack() as stack:
        part = None
        if out is not None:
            out = Path(out)
            part = stack.enter_context(folder.unfinished(out, scenario.name))
        # the model is read before the first tick, so that a wrong one is refused before any work
        robot = assemble.read_robot(scenario)
        collector = Collector(part)
        try:
            _simulate(worlds, robot, threads, collector, tell, laws)
        except KeyboardInterrupt:
            collector.interrupted = True
            collector.flush()
            if not collector.runs:
                raise
        signals = collector.close()
        manifest = _manifest(scenario, worlds, robot.model_id)
        if laws:
            manifest["own_laws"] = described(laws)
        if robot.notes:
            manifest["robot_notes"] = list(robot.notes)
        recordings: dict[int, str] = {}
        note = "no recordings: nothing was written to disk"
        if part is not None:
            chosen, note = worlds_to_record(record, collector.runs, len(worlds))
            recordings = record_worlds(part, chosen, collector.runs, worlds, manifest, robot.shapes)
        metrics = metrics_table(collector.runs, worlds, recordings)
        target = None
        if part is not None and isinstance(out, Path):
            import pyarrow.parquet as pq

            pq.write_table(metrics, part / "metrics.parquet")
            manifest |= {
                "runs": metrics.num_rows,
                "interrupted": collector.interrupted,
                "recordings": note,
                "finished": datetime.now(UTC).isoformat(timespec="seconds"),
                "wall_time": round(time.monotonic() - began, 3),
            }
            write_json(part / "manifest.json", manifest)
            target = folder.publish(part, out, scenario.name)
            signals = pq.read_table(target / "signals.parquet", memory_map=True)
    return Result(target, metrics, signals, manifest, varied_keys(worlds), note, collector.interrupted)


def _simulate(
    worlds: Sequence[files.World],
    robot: assemble.RobotModel,
    threads: int | None,
    collector: Collector,
    tell: Progress,
    laws: OwnLaws,
) -> None:
    runs = len(worlds[0].scenario.controller) + len(laws)
    steps = [assemble.tick_count(world.scenario) * runs for world in worlds]
    total, done = sum(steps), 0
    longest = max(assemble.tick_count(world.scenario) for world in worlds) + 1
    largest = max(1, min(LARGEST_BATCH, ROWS_IN_MEMORY // longest))
    for indices in batches(worlds, largest):
        text = f"world {indices[0] + 1} to {indices[-1] + 1} of {len(worlds)}"

        def report(within: int, before: int = done, text: str = text) -> None:
            tell(before + within, total, text)

        workers = threads or _threads(len(indices))
        for finished in run_batch(worlds, indices, robot, workers, report, laws):
            collector.add(finished)
        collector.flush()
        done += sum(steps[index] for index in indices)


def _threads(worlds: int) -> int:
    """Return how many threads pay: handing a tick over costs as much as a few worlds' physics."""
    return max(1, min(os.cpu_count() or 1, worlds // 4))


def _manifest(scenario: files.Scenario, worlds: Sequence[files.World], model_id: str) -> dict[str, Any]:
    return {
        "format": 1,
        "scenario": scenario.name,
        "scenario_id": files.scenario_id(scenario),
        "model_id": model_id,
        "certified": certified.standing(worlds[0].scenario),
        "versions": versions(),
        "machine": machine(),
        "worlds": len(worlds),
        "controllers": [controller.label for controller in scenario.controller],
        "scenario_file": files.dump(scenario),
    }
