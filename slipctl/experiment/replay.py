"""The scenario of a run folder or of an unfinished one, to run some of its worlds again."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

from pydantic import ValidationError

from slipctl import scenario as files
from slipctl.experiment.errors import ResumeError
from slipctl.experiment.result import MANIFEST
from slipctl.experiment.store import PLAN


def scenario_of(folder: Path) -> files.Scenario:
    """Return the scenario that a folder was made from, with the same worlds.

    Parameters
    ----------
    folder : pathlib.Path
        A run folder, or what is left of one.

    Raises
    ------
    ResumeError
        Where it is none, or a file that the scenario names has changed since.
    """
    for name in (MANIFEST, PLAN):
        path = folder / name
        if not path.is_file():
            continue
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            scenario = files.reread(content["scenario_given"])
            its = content["scenario_id"]
        except (ValueError, KeyError, TypeError, ValidationError) as error:
            raise ResumeError(f"{path} does not hold a scenario: {error!r}") from error
        now = files.scenario_id(scenario)
        if now != its:
            raise ResumeError(
                f"{path} is of another scenario: {its} then, {now} now; a file that it names has changed"
            )
        return scenario
    raise ResumeError(f"{folder} is no run folder: it has neither {MANIFEST} nor {PLAN}")


def replay_command(folder: Path, world: int) -> str:
    """Return the one command that runs exactly this world again, with a recording."""
    return f"slipctl run {shlex.quote(str(folder))} --world {world}"
