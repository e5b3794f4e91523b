"""The folder of an unfinished experiment: its plan, its finished chunks, and nobody else at work on it.

    NAME.unfinished/plan.json                what is to be done, with the versions that do it
    NAME.unfinished/chunks/000012.arrow      rows of metrics of chunk 12: there last, so that it is whole
    NAME.unfinished/chunks/000012.signals    its signals, in batches of whole runs

When all is done the results are put beside these, the folder is renamed, and these are removed.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from slipctl.experiment import durable
from slipctl.experiment.chunk import Output
from slipctl.experiment.errors import ResumeError, StorageError
from slipctl.experiment.folder import OutputError, publish
from slipctl.experiment.lock import NAME as LOCK
from slipctl.experiment.lock import FolderLock
from slipctl.experiment.plan import GROUP_ROWS, Chunk, canonical_json
from slipctl.experiment.result import MANIFEST

if TYPE_CHECKING:
    import pyarrow as pa

PLAN = "plan.json"
CHUNKS = "chunks"
UNFINISHED = ".unfinished"
FORMAT = 1


class ChunkFiles:
    """Where chunks are put; what worker processes on the same disk know of the folder.

    Attributes
    ----------
    folder : pathlib.Path
        The unfinished folder.
    scenario_id : str
        Written into every chunk: one of another scenario is not taken for a finished one.
    """

    def __init__(self, folder: Path, scenario_id: str) -> None:
        self.folder, self.scenario_id = folder, scenario_id

    def keep(self, output: Output) -> None:
        """Put a finished chunk on the disk.

        Raises
        ------
        StorageError
            Where that cannot be done.
        """
        try:
            if output.signals:
                pieces = _pieces(output.signals)
                durable.write(self._signals(output.chunk), lambda file: _write(file, pieces))
            marked = output.metrics.replace_schema_metadata(self._mark(output.chunk))
            durable.write(self._metrics(output.chunk), lambda file: _write(file, iter((marked,))))
        except OSError as error:
            raise storage_error(self.folder, error) from error

    def metrics(self, chunk: Chunk) -> pa.Table | None:
        """Return the rows of a chunk's runs; None where it is not there, or not whole.

        Raises
        ------
        OSError
            Where the disk does not let it be read: whether it is whole is then not known.
        """
        import pyarrow as pa

        try:
            content = self._metrics(chunk).read_bytes()
            if self._signals(chunk).exists():
                self._signals(chunk).open("rb").close()
        except FileNotFoundError:
            return None
        try:
            # from memory: what is raised from here on is said of the content, not of the disk
            table = pa.ipc.open_file(content).read_all()
            if self._signals(chunk).exists():
                _read(self._signals(chunk))
        except (OSError, pa.ArrowException):
            return None
        return table if table.schema.metadata == self._mark(chunk) else None

    def signals(self, chunk: Chunk) -> Iterator[pa.Table]:
        """Yield the signals of a chunk, one run or several at a time; mapped, not read into memory."""
        import pyarrow as pa

        if not self._signals(chunk).exists():
            return
        reader = _read(self._signals(chunk))
        for index in range(reader.num_record_batches):
            yield pa.Table.from_batches([reader.get_batch(index)])

    def _mark(self, chunk: Chunk) -> dict[bytes, bytes]:
        worlds = f"{chunk.worlds[0]} to {chunk.worlds[-1]}"
        return {b"scenario_id": self.scenario_id.encode(), b"worlds": worlds.encode()}

    def _metrics(self, chunk: Chunk) -> Path:
        return self.folder / CHUNKS / f"{chunk.index:06d}.arrow"

    def _signals(self, chunk: Chunk) -> Path:
        return self.folder / CHUNKS / f"{chunk.index:06d}.signals"


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
        super().__init__(folder, plan["scenario_id"])
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
        try:
            out.mkdir(parents=True, exist_ok=True)
            folder = _new_folder(out, name)
            try:
                lock = FolderLock(folder)
                (folder / CHUNKS).mkdir()
                durable.write_bytes(folder / PLAN, canonical_json({"format": FORMAT, **plan}).encode())
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
            Where it is none, is finished, or another process is at work on it.
        """
        path = folder / PLAN
        if (folder / MANIFEST).is_file() and UNFINISHED not in folder.resolve().name:
            _tidy(folder)  # the process may have died between its last two steps
            raise ResumeError(f"{folder} is finished: there is nothing to go on with")
        if not path.is_file():
            raise ResumeError(f"{folder} is no unfinished sweep: it has no {PLAN}{_there_are(folder)}")
        lock = FolderLock(folder)
        try:
            plan = json.loads(path.read_text(encoding="utf-8"))
            if not isinstance(plan["scenario_id"], str) or plan["format"] != FORMAT:
                raise ResumeError(f"{path}: found format {plan['format']}, allowed is {FORMAT}")
            for left in folder.rglob(f"*{durable.PART}"):
                left.unlink(missing_ok=True)
        except (ValueError, KeyError, TypeError) as error:
            lock.release()
            raise ResumeError(f"{path} cannot be read: {error}") from error
        except BaseException:
            lock.release()
            raise
        return cls(folder, lock, plan)

    def chunk_files(self) -> ChunkFiles:
        """Return what other processes on the same disk need to put chunks here."""
        return ChunkFiles(self.folder, self.scenario_id)

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
        _tidy(self.published)
        self._lock.release()
        (self.published / LOCK).unlink(missing_ok=True)
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


def storage_error(folder: Path, error: OSError) -> StorageError:
    """Say what could not be written, and how to go on."""
    full = error.errno in durable.FULL
    what = "the disk is full" if full else f"cannot write: {error.strerror or error}"
    todo = "make room, then go on" if full else "put it right, then go on"
    return StorageError(f"{what}; what is finished is kept in {folder}\n{todo}: {resume_command(folder)}")


def resume_command(folder: Path) -> str:
    """Return the one command that goes on with an unfinished folder."""
    import shlex

    return f"slipctl sweep --resume {shlex.quote(str(folder))}"


def _tidy(finished: Path) -> None:
    """Remove from a run folder what was needed to go on only."""
    (finished / PLAN).unlink(missing_ok=True)
    shutil.rmtree(finished / CHUNKS, ignore_errors=True)


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


def _pieces(tables: Sequence[pa.Table]) -> Iterator[pa.Table]:
    """Yield the signals of runs together until they are enough rows: a batch costs time for every column."""
    import pyarrow as pa

    waiting, rows = [], 0
    for table in tables:
        waiting.append(table)
        rows += table.num_rows
        if rows >= GROUP_ROWS:
            yield pa.concat_tables(waiting)
            waiting, rows = [], 0
    if waiting:
        yield pa.concat_tables(waiting)


def _write(file: IO[bytes], tables: Iterator[pa.Table]) -> None:
    import pyarrow as pa

    writer = None
    for table in tables:
        writer = writer or pa.ipc.new_file(file, table.schema)
        writer.write_table(table.combine_chunks())
    assert writer is not None, "there is at least one table"
    writer.close()


def _read(path: Path) -> pa.ipc.RecordBatchFileReader:
    import pyarrow as pa

    return pa.ipc.open_file(pa.memory_map(str(path), "r"))
