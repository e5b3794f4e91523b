"""See that numbers that were made elsewhere are numbers: nothing is worse than one that is none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from slipctl.metrics import UNITS
from slipctl.regression.baseline.file import CannotJudge, Finite, run_key
from slipctl.regression.baseline.gated import GATED, LARGER_IS_BETTER

FORMAT = 1
"""Format of the run folders that can be read."""


class _Checked(BaseModel):
    model_config = ConfigDict(frozen=True, strict=True)


class _Run(_Checked):
    controller: str
    varied: dict[str, Any]
    seed: int
    status: str
    metrics: dict[str, Finite | None]

    @model_validator(mode="after")
    def _whole(self) -> Self:
        for metric in GATED:
            gone = metric in self.metrics and self.metrics[metric] is None
            if gone and self.status == "completed" and metric not in LARGER_IS_BETTER:
                raise ValueError(f"{metric} has no value though the run completed")
        return self


class _Payload(_Checked):
    scenario: str
    scenario_id: str
    model_id: str | None
    versions: dict[str, str]
    runs: list[_Run]

    @model_validator(mode="after")
    def _once(self) -> Self:
        keys = {run_key(run.controller, run.varied, run.seed) for run in self.runs}
        if len(keys) < len(self.runs):
            raise ValueError("the same run twice")
        return self


class _ScenarioFile(_Checked):
    sweep: dict[str, Any] = {}


class _Manifest(_Checked):
    scenario: str
    scenario_id: str
    model_id: str | None
    versions: dict[str, str]
    machine: dict[str, Any]
    scenario_file: _ScenarioFile
    finished: str = Field(min_length=10)
    interrupted: bool = False


def see_payload(payload: object, label: str) -> None:
    """See that something is the JSON output of a run.

    Parameters
    ----------
    payload : object
    label : str
        What it is called in the message.

    Raises
    ------
    CannotJudge
        It is not, or a number in it is not finite, or a run that completed has none.
    """
    _see(_Payload, payload, label)


def payload_of(manifest: object, rows: Sequence[Mapping[str, Any]], label: str) -> dict[str, Any]:
    """Put a run folder into the form of ``slipctl run --json``, with the metrics that it holds.

    Parameters
    ----------
    manifest : object
        What its ``manifest.json`` holds.
    rows : sequence of mapping
        Of its ``metrics.parquet``.
    label : str
        What it is called in messages.

    Raises
    ------
    CannotJudge
        It is damaged, or was written by another version of the format.
    """
    if not isinstance(manifest, dict):
        raise CannotJudge(f"{label} cannot be read: the manifest is no JSON object")
    written = manifest.get("format")
    if type(written) is not int or written != FORMAT:
        raise CannotJudge(f"{label} has format {written}; this slipctl reads format {FORMAT}")
    _see(_Manifest, manifest, label)
    swept = manifest["scenario_file"].get("sweep", {})
    try:
        runs = [
            {
                "controller": row["controller"],
                "varied": {key: row[key] for key in swept},
                "seed": row["seed"],
                "status": row["status"],
                "metrics": {name: row[name] for name in UNITS if name in row},
            }
            for row in rows
        ]
    except KeyError as error:
        raise CannotJudge(f"{label} is damaged: {error} is missing") from None
    head = {key: manifest[key] for key in ("scenario", "scenario_id", "model_id", "versions")}
    payload = head | {"runs": runs}
    see_payload(payload, label)
    return payload


def _see(model: type[_Checked], content: object, label: str) -> None:
    try:
        model.model_validate(content)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        if first["type"] == "missing":
            raise CannotJudge(f"{label} is damaged: '{where}' is missing") from None
        message = " ".join(first["msg"].removeprefix("Value error, ").split())
        raise CannotJudge(f"{label} is damaged{where and f' at {where}'}: {message}") from None
    except TypeError as error:  # what is varied cannot be told apart
        raise CannotJudge(f"{label} is damaged: {error}") from None
