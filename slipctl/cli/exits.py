"""Exit statuses, and which error means which."""

from __future__ import annotations

import sys
import traceback
from enum import IntEnum


class Exit(IntEnum):
    """What the exit status says."""

    GOOD = 0
    GATE_FAILED = 1
    BAD_INPUT = 2
    NOT_JUDGED = 3
    INTERRUPTED = 130


DEFECT = "this is a defect of slipctl, not of your input"
"""Said where something was raised that the user cannot put right."""


class BadInput(Exception):
    """The user asked for something that cannot be done; the message says what can."""


def explain(error: Exception) -> Exit:
    """Say on standard error what went wrong, and return the exit status for it.

    What the user can put right is a message. Anything else is a defect of slipctl: it is shown with its
    traceback and ends as "could not be judged", because 1 would tell a CI job that a gate had failed.
    """
    try:
        from slipctl.experiment.errors import ClusterError, ResumeError, StorageError, WorkerError
        from slipctl.experiment.folder import OutputError
        from slipctl.experiment.plan import SignalsChoiceError
        from slipctl.experiment.record import RecordChoiceError
        from slipctl.plants.errors import ModelError
        from slipctl.scenario import ScenarioError
        from slipctl.view import RecordingError, ViewerError
    except Exception:  # slipctl itself is broken, which is what ended the command in the first place
        return _defect(error)

    choices = RecordChoiceError | SignalsChoiceError
    if isinstance(
        error, BadInput | ScenarioError | OutputError | choices | ModelError | ResumeError | ClusterError
    ):
        _say(error, str(error))
        return Exit.BAD_INPUT
    if isinstance(error, RecordingError | ViewerError | StorageError | WorkerError):
        _say(error, str(error))
        return Exit.NOT_JUDGED
    if isinstance(error, OSError):
        _say(error, f"could not go on: {error}")
        return Exit.NOT_JUDGED
    return _defect(error)


def _say(error: Exception, message: str) -> None:
    """Say what happened, and what was added on how to go on, which the message may say already."""
    print(message, file=sys.stderr)
    for note in getattr(error, "__notes__", ()):
        if note.startswith("what is finished") and "--resume" not in message:
            print(note, file=sys.stderr)


def _defect(error: Exception) -> Exit:
    traceback.print_exception(error)
    print(DEFECT, file=sys.stderr)
    return Exit.NOT_JUDGED
