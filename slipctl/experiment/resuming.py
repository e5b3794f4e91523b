"""Whether an unfinished experiment can be gone on with here."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from slipctl import scenario as files
from slipctl.experiment import assemble
from slipctl.experiment.chunk import Setup
from slipctl.experiment.errors import ResumeError
from slipctl.experiment.executors.order import version_problem
from slipctl.experiment.machine import exact_versions, machine
from slipctl.experiment.plan import read_plan
from slipctl.experiment.retry import copied, plan_to_retry
from slipctl.experiment.store import Store, tidy


def taken_over(folder: Path) -> tuple[Setup, Store, Path | None]:
    """Return what the chunks of a folder need, the unfinished folder, and the run folder it was copied from.

    Parameters
    ----------
    folder : pathlib.Path
        An unfinished folder, or a run folder in which worlds were set aside: of this a copy is made.

    Raises
    ------
    ResumeError
        Where it is neither, is in use, is damaged, or cannot be gone on with here.
    OutputError
        Where nothing can be written beside a run folder.
    StorageError
        Where there is no room for the copy.
    """
    content = plan_to_retry(folder)
    if content is not None:
        tidy(folder)  # the process may have died between its last two steps
        setup = same_as_before(folder, content)
        return setup, copied(folder, content, setup.plan), folder
    store = Store.open(folder)
    try:
        return same_as_before(store.folder, store.plan), store, None
    except BaseException:
        store.close()
        raise


def same_as_before(folder: Path, content: Mapping[str, Any]) -> Setup:
    """Return what the chunks of an unfinished experiment need, if it is the same as when it was begun.

    Parameters
    ----------
    folder : pathlib.Path
        For messages.
    content : mapping
        Of its plan file.

    Raises
    ------
    ResumeError
        Where versions, scenario or model are others: the rest would not fit what is there.
    """
    try:
        wrong = version_problem(content["versions"], exact_versions())
        if wrong is not None:
            raise ResumeError(f"{folder} was begun with other versions: here {wrong}")
        if content["own_laws"]:
            raise ResumeError(
                f"{folder} has own laws ({', '.join(content['own_laws'])}), which are not in it: run it again"
            )
        then, now = content["machine"]["family"], machine()["family"]
        plan = read_plan(content)
        begun = content["scenario_id"], content["model_id"]
    except (KeyError, TypeError, ValidationError, ValueError) as error:
        raise ResumeError(f"the plan in {folder} cannot be read: {error!r}") from error
    robot = assemble.read_robot(plan.scenario)
    here = files.scenario_id(plan.scenario), robot.model_id
    for name, its, found in zip(("scenario", "model"), begun, here, strict=True):
        if its != found:
            raise ResumeError(
                f"{folder} was begun with another {name}: {its} then, {found} now; "
                "a file that the scenario names has changed"
            )
    if then != now:
        # the last digit of a sine may differ: nothing is wrong with it, but the bytes are not the same
        print(
            f"{folder} was begun on another family of processor ({then}, here {now}): "
            "the last digits of what is left to do may differ",
            file=sys.stderr,
        )
    return Setup(plan, robot)
