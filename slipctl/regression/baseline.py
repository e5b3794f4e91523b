"""The file that holds what a scenario gave when someone last looked: numbers, tolerances and why."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

GATED = ("rms_position_error", "max_position_error", "final_position_error")
"""The metrics a baseline holds, all in metres."""

CHAOTIC_FACTOR = 3.0
"""A chaotic number counts as worse above this multiple of the largest value seen, as better below this
fraction of it."""

DEFAULTS = (("chaotic", False), ("nudged_statuses", []))


class CannotJudge(Exception):
    """There is nothing sound to compare with; the message is one line that says what and what to do."""


Finite = Annotated[float, Field(allow_inf_nan=False)]
"""A number that can be compared: nothing is ever worse than NaN or than infinity more."""


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Number(_Strict):
    """One metric of one run.

    Attributes
    ----------
    value
        The metric [m]; None where it was not finite.
    tolerance
        How far a later value may lie above [m].
    why
        Where the tolerance comes from, with the measured numbers.
    chaotic
        Whether a start moved by a nanometre changed the value so much that only its order of magnitude is
        gated.
    """

    value: Finite | None
    tolerance: Annotated[Finite, Field(ge=0.0)]
    why: str
    chaotic: bool = False


class RunBaseline(_Strict):
    """One run: which, how it ended and its numbers.

    Attributes
    ----------
    controller, varied, seed
        Which run of the scenario this is.
    status
        How it ended.
    nudged_statuses
        Other statuses that runs from a start moved by a nanometre ended with: accepted as well.
    metrics
        Metric name to number.
    """

    controller: str
    varied: dict[str, Any]
    seed: int
    status: str
    nudged_statuses: list[str] = []
    metrics: dict[str, Number]

    @field_validator("metrics")
    @classmethod
    def _every_gated_metric(cls, metrics: dict[str, Number]) -> dict[str, Number]:
        if set(metrics) != set(GATED):
            raise ValueError(f"it must hold {', '.join(GATED)}, and no other metric")
        return metrics


class Baseline(_Strict):
    """All runs of one scenario and where they come from.

    Attributes
    ----------
    format
        Version of the file format.
    scenario, scenario_id, model_id, versions
        As in the output of ``slipctl run --json``.
    machine
        Processor and operating system.
    commit
        Git commit of slipctl, where known.
    date
        Day of recording.
    reason
        What the person who recorded it said.
    runs
        One per controller, world and seed.
    """

    format: Literal[1] = 1
    scenario: str
    scenario_id: str
    model_id: str | None
    versions: dict[str, str]
    machine: dict[str, str]
    commit: str | None
    date: str
    reason: str
    runs: list[RunBaseline]


def run_key(controller: str, varied: Mapping[str, Any], seed: int) -> tuple[str, str, int]:
    """Say which run of a scenario is meant, hashably."""
    return controller, json.dumps(dict(varied), sort_keys=True), seed


def read(path: Path, source: str | None = None) -> Baseline:
    """Read the baseline of a scenario that the user called `source`, by default by the file's name.

    Raises
    ------
    CannotJudge
        The file is missing, cut off, not a baseline or holds the same run twice.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CannotJudge(
            f"no baseline {path}; record one: slipctl check {source or path.stem} --update --reason '…'"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise CannotJudge(f"baseline {path} cannot be read: {error}") from None
    try:
        baseline = Baseline.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise CannotJudge(f"baseline {path} is damaged at {where}: {first['msg']}") from None
    keys = [run_key(run.controller, run.varied, run.seed) for run in baseline.runs]
    if not keys or len(set(keys)) < len(keys):
        raise CannotJudge(f"baseline {path} is damaged: {'no runs' if not keys else 'the same run twice'}")
    return baseline


def write(baseline: Baseline, path: Path) -> None:
    """Write a baseline beside its place and rename, one line per number so that a diff can be read.

    Raises
    ------
    OSError
        The folder is not writable.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        beside.write_text(_text(baseline), encoding="utf-8")
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def _text(baseline: Baseline) -> str:
    content = baseline.model_dump(mode="json")
    runs = []
    for run in content.pop("runs"):
        numbers = run.pop("metrics")
        lines = ",\n".join(f"   {_line(name)}: {_line(_short(number))}" for name, number in numbers.items())
        run = _short(run)
        runs.append(_line(run)[:-1] + ', "metrics": {\n' + lines + "\n  }}")
    head = json.dumps(content, indent=1, ensure_ascii=False)[:-2]
    return head + ',\n "runs": [\n  ' + ",\n  ".join(runs) + "\n ]\n}\n"


def _short(table: dict[str, Any]) -> dict[str, Any]:
    """Leave out what is at its default: it is so nearly everywhere."""
    return {key: value for key, value in table.items() if (key, value) not in DEFAULTS}


def _line(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
