"""The folder of an unfinished experiment: its plan, its finished chunks, and nobody else at work on it.

    NAME.unfinished/plan.json    what is to be done, with the versions that do it
    NAME.unfinished/chunks       what is done: see `slipctl.experiment.chunkfiles`

When all is done the results are put beside these, the folder is renamed, and these are removed; the plan
stays where worlds were set aside, so that they can be tried once more.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slipctl.experiment import durable
from slipctl.experiment.chunk import ended_its_process
from slipctl.experiment.chunkfiles import CHUNKS, ChunkFiles, resume_command, storage_error
from slipctl.experiment.errors import ResumeError, StorageError
from slipctl.experiment.folder import MANIFEST, OutputError, publish
from slipctl.experiment.lock import NAME as LOCK
from slipctl.experiment.lock import FolderLock
from slipctl.experiment.plan import canonical_json

__all__ = ["CHUNKS", "PLAN", "UNFINISHED", "ChunkFiles", "Store", "resume_command"]

PLAN = "plan.json"
UNFINISHED = ".unfinished"
FORMAT = 2

CHECKSUM = "checksum"
"""Key of the plan file: a hash of all its others."""


class Store(ChunkFiles):
    """An unfinished folder that this process holds.

    Attributes
    ----------
    folder : pathlib.Path
    plan : dict
        The content of its `PLAN`.
    published : pathlib.Path or None
        The run folder that it has become.
    """

    def __init__(self, folder: Path, lock: FolderLock, plan: dict[str, Any]) -> None:
        asked = {name: str(plan.get(name)) for name in ("scenario_id", "signals", "keep_going", CHECKSUM)}
        super().__init__(folder, asked)
        self.plan = plan
        self.published: Path | None = None
        self._lock = lock

    @classmethod
    def create(cls, out: Path, name: str, plan: dict[str, Any]) -> Store:
        """Make `out`/`name`.unfinished, or -2, -3 …, with the plan in it.

        Raises
        ------
        OutputError
            Where `out` cannot be made or written.
        """
        plan = {"format": FORMAT, **{key: value for key, value in plan.items() if key != CHECKSUM}}
        plan[CHECKSUM] = checksum(plan)
        try:
            out.mkdir(parents=True, exist_ok=True)
            folder = _new_folder(out, name)
            try:
                lock = FolderLock(folder)
                (folder / CHUNKS).mkdir()
                durable.write_bytes(folder / PLAN, canonical_json(plan).encode())
            except BaseException:
                shutil.rmtree(folder, ignore_errors=True)
                raise
        except OSError as error:
            if error.errno in durable.FULL:
                raise StorageError(f"the disk of {out} is full; nothing was begun") from error
            raise OutputError(
                f"cannot write to the output folder {out}: {error.strerror or error}; name another with --out"
            ) from error
        return cls(folder, lock, plan)

    @classmethod
    def open(cls, folder: Path) -> Store:
        """Take an unfinished folder over.

        Raises
        ------
        ResumeError
            Where it is none, is finished, was edited, or another process is at work on it.
        """
        if folder.name in ("", ".."):  # "." has no name, and nothing beside it to become the run folder
            folder = folder.resolve()
        if _is_finished(folder):
            tidy(folder)  # the process may have died between its last two steps
            raise ResumeError(f"{folder} is finished: there is nothing to go on with")
        if not (folder / PLAN).is_file():
            raise ResumeError(f"{folder} is no unfinished sweep: it has no {PLAN}{_there_are(folder)}")
        lock = FolderLock(folder)
        try:
            plan = plan_of(folder)
            for left in folder.rglob(f"*{durable.PART}"):
                left.unlink(missing_ok=True)
        except BaseException:
            lock.release()
            raise
        return cls(folder, lock, plan)

    def chunk_files(self) -> ChunkFiles:
        """Return what other processes on the same disk need to put chunks here."""
        return ChunkFiles(self.folder, self.asked)

    def put(self, name: str, fill: Any) -> None:
        """Write a file of results beside the chunks; `fill` writes it into an open binary file.

        Raises
        ------
        StorageError
            Where that cannot be done.
        """
        try:
            durable.write(self.folder / name, fill)
        except OSError as error:
            raise storage_error(self.folder, error) from error

    def publish(self, out: Path, name: str) -> Path:
        """Rename the folder to `out`/`name`, or -2, -3 …, and remove what was needed to go on only."""
        if os.name == "nt":  # a folder with an open file in it cannot be renamed there
            self._lock.release()
        self.published = publish(self.folder, out, name)
        durable.sync_folder(out)
        tidy(self.published)
        self._lock.release()
        return self.published

    def close(self) -> None:
        """Let another process go on with it."""
        self._lock.release()

    def listed(self) -> set[int]:
        """Return the indices of the chunks whose rows are on the disk, whole or not.

        Raises
        ------
        OSError
            Where the disk does not say.
        """
        return {int(path.stem) for path in (self.folder / CHUNKS).iterdir() if path.suffix == ".arrow"}

    def discard(self) -> None:
        """Remove the folder, which must be new: nothing in it is worth keeping."""
        self._lock.release()
        shutil.rmtree(self.folder, ignore_errors=True)


def checksum(plan: Mapping[str, Any]) -> str:
    """Return the hash of a plan file's content but for the hash itself."""
    rest = {key: value for key, value in plan.items() if key != CHECKSUM}
    return f"sha256:{hashlib.sha256(canonical_json(rest).encode()).hexdigest()}"


def plan_of(folder: Path) -> dict[str, Any]:
    """Return the content of the plan file of a folder.

    Raises
    ------
    ResumeError
        Where it is none, or was edited.
    """
    path = folder / PLAN
    try:
        plan = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(plan["scenario_id"], str) or plan["format"] != FORMAT:
            raise ResumeError(f"{path}: found format {plan['format']}, allowed is {FORMAT}")
    except (ValueError, KeyError, TypeError) as error:
        raise ResumeError(f"{path} cannot be read: {error}") from error
    if plan.get(CHECKSUM) != checksum(plan):
        raise ResumeError(
            f"{path} was edited or damaged since it was begun: "
            "what is finished would not fit what is left; put it back, or run the sweep again"
        )
    return plan


def set_aside_of(folder: Path) -> list[int]:
    """Return the worlds of a finished run folder that were set aside and can be tried once more.

    Raises
    ------
    ResumeError
        Where its manifest cannot be read.
    """
    if not (_is_finished(folder) and (folder / PLAN).is_file()):
        return []
    path = folder / MANIFEST
    try:
        failures = json.loads(path.read_text(encoding="utf-8"))["failures"]
        return sorted({entry["world"] for entry in failures if ended_its_process(entry["failure"])})
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ResumeError(f"{path} cannot be read: {error!r}") from error


def _is_finished(folder: Path) -> bool:
    return (folder / MANIFEST).is_file() and UNFINISHED not in folder.resolve().name


def tidy(finished: Path) -> None:
    """Remove from a run folder what was needed to go on only.

    Raises
    ------
    ResumeError
        Where its manifest cannot be read; nothing is removed then.
    """
    if not set_aside_of(finished):
        (finished / PLAN).unlink(missing_ok=True)
    shutil.rmtree(finished / CHUNKS, ignore_errors=True)
    with contextlib.suppress(OSError):
        (finished / LOCK).unlink()


def _new_folder(out: Path, name: str) -> Path:
    number = 1
    while True:
        folder = out / (f"{name}{UNFINISHED}" if number == 1 else f"{name}{UNFINISHED}-{number}")
        try:
            folder.mkdir()
        except FileExistsError:
            number += 1
            continue
        return folder


def _there_are(folder: Path) -> str:
    try:
        found = sorted(str(path.parent) for path in folder.parent.glob(f"*/{PLAN}"))
    except OSError:
        return ""
    return f"; there {'is' if len(found) == 1 else 'are'} {', '.join(found)}" if found else ""
