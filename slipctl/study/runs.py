"""What every study does: change a scenario, run it, and look at the columns of one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipctl import scenario as files
from slipctl.experiment import assemble, run
from slipctl.experiment.batch import STATUS_NAMES
from slipctl.metrics import UNITS, measure
from slipctl.recording import Columns, Recorder, with_errors
from slipctl.scenario.grid import with_values
from slipctl.scenario.loading import tables_of
from slipctl.simulate import Plant, simulate
from slipctl.tick import Array, Start, Status


@dataclass(frozen=True)
class StudyRun:
    """One world under one law, finished.

    Attributes
    ----------
    label, status : str
    metrics : dict
        As in `slipctl.metrics`.
    columns : dict of (T + 1,) arrays
        By column name, and `time` [s]; rows after the end are left out.
    """

    label: str
    status: str
    metrics: dict[str, float | None]
    columns: Columns

    def __getitem__(self, column: str) -> Array:
        return self.columns[column]

    def pair(self, column: str) -> Array:
        """Return a vector column as (T + 1, 2)."""
        return np.stack([self.columns[f"{column}.x"], self.columns[f"{column}.y"]], axis=-1)

    def metric(self, name: str) -> float:
        """Return a metric; not-a-number where there is none."""
        value = self.metrics[name]
        return float("nan") if value is None else value

    def summary(self) -> dict[str, float]:
        """Return what the pages print of a run, in millimetres and rad/s."""
        return {
            "rms_mm": 1e3 * self.metric("rms_position_error"),
            "max_mm": 1e3 * self.metric("max_position_error"),
            "final_mm": 1e3 * self.metric("final_position_error"),
            "variation": self.metric("command_variation"),
        }


def edited(
    scenario: files.Scenario,
    values: Mapping[str, Any],
    controllers: Sequence[Mapping[str, Any]] | None = None,
) -> files.Scenario:
    """Return a scenario with some dotted keys set, read and judged anew.

    Parameters
    ----------
    scenario : Scenario
    values : mapping
        Dotted key to value; a value of None takes the key out.
    controllers : sequence of mappings, optional
        Tables that replace all controllers.

    Raises
    ------
    slipctl.scenario.ScenarioError
        Where the result is no valid scenario.
    """
    tables = {**tables_of(scenario), "sweep": {}}
    if controllers is not None:
        tables["controller"] = [dict(table) for table in controllers]
    gone = [key for key, value in values.items() if value is None]
    tables = with_values(tables, {key: value for key, value in values.items() if value is not None})
    for key in gone:
        *path, last = key.split(".")
        table = tables
        for part in path:
            table[part] = dict(table.get(part, {}))
            table = table[part]
        table.pop(last, None)
    return files.read(tables, scenario.name, scenario.name)


def controller_tables(scenario: files.Scenario) -> dict[str, dict[str, Any]]:
    """Return the controllers' tables as given, by label."""
    return {
        config.label: {**config.model_dump(exclude_unset=True), "label": config.label}
        for config in scenario.controller
    }


def closed_loop(
    scenario: files.Scenario,
    *,
    only: str | None = None,
    start: Start | None = None,
    plant: Plant | None = None,
) -> dict[str, StudyRun]:
    """Run the one world of a scenario under its laws, perhaps from another start or on another plant.

    Parameters
    ----------
    scenario : Scenario
        Without a sweep.
    only : str, optional
        Label of the one law to run.
    start : Start, optional
        In place of the planned one.
    plant : Plant, optional
        In place of the scenario's.

    Returns
    -------
    dict
        By label; without the columns of the guarantee.
    """
    worlds = files.worlds(scenario)
    robot = assemble.read_robot(scenario)
    planned = assemble.references(worlds)
    rows = len(planned.position)
    sensor = None if assemble.sees_the_truth(worlds) else assemble.sensor(worlds, robot.geometry, rows)
    runs = {}
    for index, config in enumerate(scenario.controller):
        if only is not None and config.label != only:
            continue
        law = assemble.law(worlds, index, robot)
        recorder = Recorder(rows, 1)
        ending = simulate(
            plant or assemble.plant(worlds, robot, 1),
            law.controller,
            planned,
            start or assemble.start(worlds, planned),
            scenario.tick,
            recorder.write,
            sensor=sensor,
        )
        columns = with_errors(recorder.columns())
        last = int(ending.last_row[0])
        runs[config.label] = StudyRun(
            label=config.label,
            status=STATUS_NAMES[Status(int(ending.status[0]))],
            metrics=measure(columns, 0, last),
            columns={name: values[0, : last + 1] for name, values in columns.items()}
            | {"time": np.arange(last + 1) * scenario.tick},
        )
    return runs


def run_all(scenario: files.Scenario) -> dict[str, StudyRun]:
    """Run the one world of a scenario as `slipctl run` does; by label."""
    result = run(scenario)
    runs = {}
    for row in result.metrics.to_pylist():
        signals = result.run_signals(row["run"])
        columns = {
            name: np.array(signals.column(name).to_pylist(), dtype=float)
            if signals.column(name).null_count
            else signals.column(name).to_numpy()
            for name in signals.column_names
        }
        metrics = {name: row[name] for name in UNITS}
        runs[row["controller"]] = StudyRun(row["controller"], row["status"], metrics, columns)
    return runs


def medians(scenario: files.Scenario, seeds: Sequence[int]) -> dict[str, dict[str, float]]:
    """Return the median of every metric over seeds, by label."""
    result = run(files.override(scenario, {"seed": list(seeds)}))
    rows = result.metrics.to_pylist()
    labels = dict.fromkeys(row["controller"] for row in rows)
    return {
        label: {
            name: float(np.median([row[name] for row in rows if row["controller"] == label]))
            for name in UNITS
            if all(row[name] is not None for row in rows if row["controller"] == label)
        }
        for label in labels
    }
