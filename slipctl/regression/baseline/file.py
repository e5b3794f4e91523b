"""The file that holds what a scenario gave when someone last looked: numbers, tolerances and why."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from slipctl.experiment import durable
from slipctl.regression.baseline.gated import GATED, LARGER_IS_BETTER, allowances, is_chaotic
from slipctl.report.judged import update_command

FORMAT = 2
"""Version of the file. Format 1 held three metrics and guessed tolerances."""


ROUNDING = 1e-9
"""Relative: a tolerance that is computed again may differ by as much."""


class CannotJudge(Exception):
    """There is nothing sound to compare with; the message is one line that says what and what to do."""


Finite = Annotated[float, Field(allow_inf_nan=False)]
"""A number that can be compared: nothing is ever worse than NaN or than infinity more."""

Size = Annotated[Finite, Field(ge=0.0)]


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Number(_Strict):
    """One metric of one run. All numbers are in the metric's unit, see `slipctl.metrics.UNITS`.

    Attributes
    ----------
    value
        The metric; None where it was not finite, which it always is in a run that completed, or where the law
        has no theorem to guarantee anything.
    tolerance
        How far a later value may be worse: same engine, same family of processor.
    tolerance_elsewhere
        The same for another engine, operating system or family of processor.
    spread
        Largest difference seen from starts moved by a nanometre or a nanoradian and on one to three threads;
        None where one of those runs ended otherwise, so that there is nothing to subtract.
    halving
        Difference seen with half the timestep; None where the plant has none, or the number was not finite.
    gate
        ``number``: judged by the tolerance. ``verdict``: chaotic, kept for information only; the run is
        judged by its status and by the scenario's claims.
    why
        Where the tolerance comes from, with the measured numbers.
    """

    value: Finite | None
    tolerance: Size
    tolerance_elsewhere: Size
    spread: Size | None = None
    halving: Size | None = None
    gate: Literal["number", "verdict"] = "number"
    why: str

    @model_validator(mode="after")
    def _tolerance_covers_what_was_seen(self) -> Self:
        if self.gate == "number":
            if (self.spread or 0.0) > self.tolerance:
                raise ValueError(
                    f"the spread {self.spread:g} is larger than the tolerance {self.tolerance:g}"
                )
            if (self.halving or 0.0) > self.tolerance_elsewhere:
                said = f"{self.halving:g} is larger than the tolerance elsewhere {self.tolerance_elsewhere:g}"
                raise ValueError(f"the difference at half the timestep {said}")
        if self.tolerance > self.tolerance_elsewhere:
            raise ValueError("the tolerance elsewhere is smaller than the tolerance")
        return self


class RunBaseline(_Strict):
    """One run: which, how it ended and its numbers.

    Attributes
    ----------
    controller, varied, seed
        Which run of the scenario this is.
    status
        How it ended.
    statuses_seen
        Other statuses that the runs behind the tolerances ended with: said, but a change fails all the same.
    ticks
        How long it lasted.
    metrics
        Metric name to number.
    """

    controller: str
    varied: dict[str, Any]
    seed: int
    status: str
    ticks: Annotated[int, Field(ge=0)]
    statuses_seen: list[str] = []
    metrics: dict[str, Number]

    @field_validator("metrics")
    @classmethod
    def _every_gated_metric(cls, metrics: dict[str, Number]) -> dict[str, Number]:
        if set(metrics) != set(GATED):
            raise ValueError(f"it must hold {', '.join(GATED)}, and no other metric")
        return metrics

    @model_validator(mode="after")
    def _gated_by_what_was_seen(self) -> Self:
        for metric, number in self.metrics.items():
            chaotic = is_chaotic(metric, number.value, number.spread)
            if number.value is None and not self._ended_early and metric not in LARGER_IS_BETTER:
                raise ValueError(f"{metric} has no value though the run completed")
            if number.gate == "number":
                if chaotic or self.statuses_seen:
                    raise ValueError(f"{metric} moved so far that it cannot be gated on its number")
                self._see_tolerances(metric, number)
            # a number that is not finite nearby leaves no spread; such a run did not complete
            elif not (chaotic or self.statuses_seen or (number.spread is None and self._ended_early)):
                raise ValueError(f"{metric} is gated on verdicts only, but it hardly moved")
        return self

    @property
    def _ended_early(self) -> bool:
        return self.status != "completed"

    def _see_tolerances(self, metric: str, number: Number) -> None:
        """See that the tolerances of a number are not wider than what was measured allows."""
        if number.value is None:
            allowed = 0.0
        elif number.spread is None:
            raise ValueError(f"{metric} has a tolerance, but no spread that it was made from")
        else:
            allowed = max(allowances(metric, number.value, number.spread, self.ticks).values())
        elsewhere = max(allowed, number.halving or 0.0)
        for name, given, most in (
            ("tolerance", number.tolerance, allowed),
            ("tolerance elsewhere", number.tolerance_elsewhere, elsewhere),
        ):
            if given > most * (1.0 + ROUNDING):
                raise ValueError(
                    f"the {name} of {metric} is {given:g}, but what was measured allows {most:g}"
                )


class Baseline(_Strict):
    """All runs of one scenario and where they come from.

    Attributes
    ----------
    format
        Version of the file format.
    scenario, scenario_id, model_id, versions
        As in the output of ``slipctl run --json``.
    machine
        Operating system, architecture, processor and its family, see `slipctl.experiment.machine`.
    commit
        Git commit of the repository that holds the file, if any: twelve digits, and ``-dirty`` where
        tracked files other than baselines differed from it.
    date
        Day of recording.
    reason
        What the person who recorded it said.
    runs
        One per controller, world and seed.
    """

    format: Literal[2] = FORMAT
    scenario: str
    scenario_id: str
    model_id: str | None
    versions: dict[str, str]
    machine: dict[str, str]
    commit: str | None
    date: str
    reason: str
    runs: list[RunBaseline]

    @field_validator("format", mode="before")
    @classmethod
    def _whole_format(cls, value: Any) -> Any:
        if type(value) is not int:  # 2.0 is equal to 2, but no slipctl wrote it
            raise ValueError(f"the format is a whole number, not {value!r}")
        return value


def run_key(controller: str, varied: Mapping[str, Any], seed: int) -> tuple[str, str, int]:
    """Say which run of a scenario is meant, hashably."""
    return controller, json.dumps(dict(varied), sort_keys=True), seed


def read(path: Path, source: str | None = None, command: str | None = None) -> Baseline:
    """Read the baseline of a scenario that the user called `source`, by default by the file's name.

    Messages name the `command` that records it, by default that of `slipctl check`.

    Raises
    ------
    CannotJudge
        The file is missing, cut off, of another format, not a baseline, holds the same run twice, or its
        tolerances are not those that follow from what was measured.
    """
    name = source or path.stem
    once = command or f"slipctl check {shlex.quote(name)} --record"
    again = f"record it again: {command or update_command(name)}"
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CannotJudge(f"no baseline {path}; record one: {once}") from None
    except UnicodeDecodeError:
        raise CannotJudge(f"baseline {path} is damaged: it is not UTF-8 text; {again}") from None
    except OSError as error:
        if path.is_dir():
            said = f"a folder is in place of the baseline {path}; move it away and record one: {once}"
            raise CannotJudge(said) from None
        why = error.strerror or error
        raise CannotJudge(f"baseline {path} cannot be read: {why}; let it be read, or {again}") from None
    found = _format(text)
    if isinstance(found, int) and found > FORMAT:
        raise CannotJudge(
            f"baseline {path} is of format {found}, newer than this slipctl, which reads format {FORMAT}; "
            "use a newer slipctl"
        )
    if found == 1:
        raise CannotJudge(f"baseline {path} is of format 1, whose tolerances were not measured; {again}")
    try:
        baseline = Baseline.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        message = " ".join(first["msg"].removeprefix("Value error, ").split())
        raise CannotJudge(f"baseline {path} is damaged at {where}: {message}; {again}") from None
    keys = [run_key(run.controller, run.varied, run.seed) for run in baseline.runs]
    if not keys or len(set(keys)) < len(keys):
        wrong = "no runs" if not keys else "the same run twice"
        raise CannotJudge(f"baseline {path} is damaged: {wrong}; {again}")
    return baseline


def _format(text: str) -> Any:
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return content.get("format") if isinstance(content, dict) else None


def write(baseline: Baseline, path: Path) -> None:
    """Write a baseline beside its place and rename, one line per number so that a diff can be read.

    Raises
    ------
    OSError
        The folder is not writable.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    durable.write_bytes(path, _text(baseline).encode("utf-8"))


def _text(baseline: Baseline) -> str:
    content = baseline.model_dump(mode="json")
    runs = []
    for run in content.pop("runs"):
        numbers = run.pop("metrics")
        lines = ",\n".join(f"   {_line(name)}: {_line(number)}" for name, number in numbers.items())
        runs.append(_line(run)[:-1] + ', "metrics": {\n' + lines + "\n  }}")
    head = json.dumps(content, indent=1, ensure_ascii=False)[:-2]
    return head + ',\n "runs": [\n  ' + ",\n  ".join(runs) + "\n ]\n}\n"


def _line(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
