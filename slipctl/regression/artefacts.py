"""Recordings of the runs that failed: as they are now, and beside what the baseline holds of them."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from slipctl import experiment
from slipctl.experiment import assemble, folder
from slipctl.experiment.own import OwnLaws
from slipctl.experiment.record import run_info, world_info
from slipctl.regression.baseline.tracks import tracks_file
from slipctl.regression.judging.findings import Finding
from slipctl.report.amounts import amount
from slipctl.report.findings import values_text
from slipctl.report.judged import metric_text, worst_first
from slipctl.scenario import Axis, Scenario, World, scenario_id, worlds

if TYPE_CHECKING:
    import pyarrow as pa


WORLDS = 4
"""Worlds of one scenario that are recorded: what fails in many fails in these worst of all."""


@dataclass(frozen=True)
class Artefacts:
    """What was recorded of a scenario.

    Attributes
    ----------
    folder : pathlib.Path
        Where the recordings lie.
    notes : tuple of str
        What is not there, and why.
    """

    folder: Path
    notes: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        """The one command that opens them."""
        return f"slipctl view {shlex.quote(self.folder.as_posix())}"


def failing_worlds(grid: Sequence[World], findings: Iterable[Finding]) -> list[int]:
    """Return the indices of the worlds to record, worst first, at most `WORLDS`.

    Parameters
    ----------
    grid : sequence of World
        All worlds of the scenario.
    findings : iterable of Finding
        A finding that fails calls for the first world that it is about.
    """
    failed = [finding for finding in findings if finding.verdict.failed and not _is_mean(finding)]
    order = worst_first([finding.json() | {"place": place} for place, finding in enumerate(failed)])
    chosen: dict[int, None] = {}
    for entry in order:
        about = [index for index, world in enumerate(grid) if _is_about(failed[entry["place"]], world)]
        chosen |= dict.fromkeys(about[:1])
    return list(chosen)[:WORLDS]


def record_failing(
    scenario: Scenario,
    findings: Sequence[Finding],
    out: Path,
    baseline: Path | None = None,
    laws: OwnLaws | None = None,
    threads: int | None = None,
    *,
    option: str = "--artefacts",
    update: str | None = None,
) -> Artefacts | None:
    """Run the worlds that failed again and record them.

    Parameters
    ----------
    scenario : Scenario
    findings : sequence of Finding
        All of the scenario.
    out : pathlib.Path
        Folder in which a new folder is made, named after the scenario: what exists is never overwritten.
    baseline : pathlib.Path, optional
        The baseline file, beside which its tracks lie; without them there is nothing to record beside.
    laws : mapping, optional
        Laws of one's own, as for `slipctl.experiment.run`.
    threads : int, optional
    option : str
        With which the user chose `out`, for messages.
    update : str, optional
        The command that records the baseline again, and with it the tracks.

    Returns
    -------
    Artefacts or None
        None where nothing failed that a run could show.

    Raises
    ------
    OutputError
        `out` cannot be written.
    RecordingError
        A recording cannot be written.
    KeyboardInterrupt
        It was interrupted; nothing is left behind.
    """
    from slipctl.view import world_slug, write_against_baseline, write_recording

    grid = worlds(scenario)
    chosen = failing_worlds(grid, findings)
    if not chosen:
        return None
    robot = assemble.read_robot(scenario)
    shapes = robot.shapes if scenario.plant.kind == "mujoco" else None
    notes: dict[str, None] = {}
    with folder.unfinished(out, scenario.name, option) as part:
        for index in chosen:
            world = grid[index]
            result = experiment.run(_only(scenario, world), record="none", threads=threads, laws=laws)
            if result.interrupted:
                raise KeyboardInterrupt
            runs = [run_info(world, row) for row in result.metrics.to_pylist()]
            info = world_info(world, {**result.manifest, "scenario_id": scenario_id(scenario)})
            name = world_slug(world.varied, scenario.name)
            write_recording(part / f"{name}.rrd", result.signals, runs, info, shapes)
            about = [finding for finding in findings if finding.verdict.failed and _is_about(finding, world)]
            shown = _labels(about)
            tracks, note = _tracks(baseline, index, scenario, update)
            both = [run for run in runs if run.label in tracks and (not shown or run.label in shown)]
            if both:
                path = part / f"{name}-against-baseline.rrd"
                write_against_baseline(path, result.signals, both, tracks, info, _page(world, about), shapes)
            elif note:
                notes.setdefault(note)
        return Artefacts(folder.publish(part, out, scenario.name), tuple(notes))


def _is_mean(finding: Finding) -> bool:
    """Whether it is the mean difference over runs: where that is worse, one of the runs is, too."""
    return finding.claim is None and finding.interval is not None


def _is_about(finding: Finding, world: World) -> bool:
    same = all(world.varied.get(key) == value for key, value in finding.varied.items())
    return same and finding.seed in (None, world.seed)


def _labels(findings: Iterable[Finding]) -> set[str]:
    """Return the controllers whose runs differ; none where a claim failed, for that compares several."""
    findings = list(findings)
    if any(finding.claim is not None for finding in findings):
        return set()
    return {finding.controller for finding in findings if finding.controller is not None}


def _only(scenario: Scenario, world: World) -> Scenario:
    """Give the scenario of one world, in which the swept keys keep their names."""
    axes = tuple(Axis(axis.key, (world.varied[axis.key],)) for axis in scenario.sweep)
    return scenario.model_copy(update={"sweep": axes, "expect": ()})


def _tracks(
    baseline: Path | None, world: int, scenario: Scenario, update: str | None
) -> tuple[Mapping[str, pa.Table], str]:
    """Read what the baseline keeps of a world, by controller; and say why there is nothing, if so."""
    import pyarrow as pa
    import pyarrow.compute as pc
    import pyarrow.parquet as pq

    if baseline is None:
        return {}, "only the recordings of now: there are no tracks of what it was compared with"
    path = tracks_file(baseline)

    def said(what: str) -> str:
        makes = "" if update is None else f"; the tracks are made by {update}"
        return f"{path} {what}: only the recordings of now{makes}"

    try:
        table = pq.read_table(path, filters=[("world", "=", world)])
        kept = (table.schema.metadata or {}).get(b"scenario_id", b"").decode()
        if kept not in ("", scenario_id(scenario)):
            return {}, said("is of another scenario")
        labels = dict.fromkeys(table["controller"].to_pylist())
        found = {label: table.filter(pc.field("controller") == label) for label in labels}
    except FileNotFoundError:
        return {}, said("is not there")
    except (OSError, pa.ArrowException, KeyError, UnicodeDecodeError) as error:
        return {}, said(f"cannot be read ({' '.join(str(error).split())})")
    return found, "" if found else said("does not hold the run")


def _page(world: World, findings: Iterable[Finding]) -> str:
    """Write what differs as Markdown."""
    where = ", ".join(f"{key} {value}" for key, value in world.varied.items()) or f"seed {world.seed}"
    lines = [f"# Against the baseline: {where}", ""]
    lines += ["| controller | what | how | tolerance |", "|---|---|---|---|"]
    for entry in worst_first(finding.json() for finding in findings):
        allowed = "" if entry["tolerance"] is None else amount(entry["tolerance"], entry["unit"], digits=2)
        what = entry["claim"] or metric_text(entry["metric"])
        cells = (entry["controller"] or "", what, values_text(entry), allowed)
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "The baseline is pale. It is kept at no more than 201 rows a run, with straight lines"]
    lines += ["between them. The distance is that between the two robots at the same time.", ""]
    return "\n".join(lines)
