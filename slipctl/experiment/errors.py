"""Why an experiment stopped before its end, and what is left of it."""

from __future__ import annotations

from pathlib import Path


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended an experiment; what had finished is kept.

    Parameters
    ----------
    folder, done, total
        As below.

    Attributes
    ----------
    folder : pathlib.Path
        Where it is kept; `slipctl.experiment.resume` goes on there.
    done, total : int
        Worlds that are kept, and worlds in all.
    finished : bool
        Whether it came so late that `folder` is the run folder, with everything in it.
    """

    def __init__(self, folder: Path, done: int, total: int, finished: bool = False) -> None:
        self.folder, self.done, self.total, self.finished = folder, done, total, finished
        super().__init__(
            f"the run folder is finished: {folder}"
            if finished
            else f"{done} of {total} worlds are kept in {folder}"
        )


class StorageError(Exception):
    """Something could not be put on disk; the message says what, where and how to go on."""


class ResumeError(Exception):
    """An unfinished experiment cannot be gone on with; the message says why and what can be done."""


class WorkerError(Exception):
    """The processes that simulate cannot do their work; the message says why."""


class StillDeadly(WorkerError):
    """Worlds that were tried once more ended their processes again; the run folder is as it was."""


class ClusterError(Exception):
    """A cluster cannot be used as it is; the message says what to change."""
