"""The scenario of a run folder or of an unfinished one, to run some of its worlds again."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

from pydantic import ValidationError

from slipctl import scenario as files
from slipctl.experiment.errors import ResumeError
from slipctl.experiment.folder import MANIFEST
from slipctl.experiment.store import PLAN, UNFINISHED


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


def check_unfinished(folder: Path) -> None:
    """Refuse to go on with what has become a run folder since.

    Parameters
    ----------
    folder : pathlib.Path
        What was named to go on with.

    Raises
    ------
    ResumeError
        Where it is not there any more, and a run folder beside it has its name.
    """
    name, mark, _ = folder.name.partition(UNFINISHED)
    if not mark or folder.exists():
        return
    is_one = re.compile(rf"{re.escape(name)}(-[0-9]+)?")
    finished = [path.parent for path in folder.parent.glob(f"*/{MANIFEST}")]
    beside = [path for path in finished if is_one.fullmatch(path.name)]
    if beside:
        newest = max(beside, key=lambda path: (path / MANIFEST).stat().st_mtime)
        raise ResumeError(f"{folder} is finished already: see {newest}")


def replay_command(folder: Path, world: int) -> str:
    """Return the one command that runs exactly this world again, with a recording."""
    return f"slipctl run {shlex.quote(str(folder))} --world {world}"
