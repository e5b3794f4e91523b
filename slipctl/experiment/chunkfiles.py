"""Finished chunks as files: what was asked for is written into each, and what would show damage.

chunks/000012.signals    signals of chunk 12, in batches of whole runs; none where no run has any
chunks/000012.arrow      its rows of metrics: there last, so that both are whole

A chunk in which a byte has changed is simulated again.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from slipctl.experiment import durable
from slipctl.experiment.chunk import Output
from slipctl.experiment.errors import StorageError
from slipctl.experiment.plan import GROUP_ROWS, Chunk

if TYPE_CHECKING:
    import pyarrow as pa

CHUNKS = "chunks"
"""Folder of the files, inside that of the experiment."""

NO_FILE = "no file"
"""Said in place of the checksum of signals that there are none of."""


class ChunkFiles:
    """Where chunks are put; what worker processes on the same disk know of the folder.

    Attributes
    ----------
    folder : pathlib.Path
        The unfinished folder.
    asked : mapping
        Text of what decides what is in a chunk, by name. It is written into every chunk: one of another
        scenario, or with other options, is not taken for a finished one.
    """

    def __init__(self, folder: Path, asked: Mapping[str, str]) -> None:
        self.folder, self.asked = folder, dict(asked)

    def keep(self, output: Output) -> None:
        """Put a finished chunk on the disk.

        Raises
        ------
        StorageError
            Where that cannot be done.
        """
        chunk = output.chunk
        try:
            checksum = NO_FILE
            if output.signals:
                checksum = _write(self._signals(chunk), _pieces(output.signals))
            else:  # a worker that died may have left some
                self._signals(chunk).unlink(missing_ok=True)
            marked = output.metrics.replace_schema_metadata(
                {
                    **self._mark(chunk),
                    b"metrics_checksum": _checksum(output.metrics),
                    b"signals_checksum": checksum.encode(),
                }
            )
            _write(self._metrics(chunk), iter((marked,)))
        except OSError as error:
            raise storage_error(self.folder, error) from error

    def metrics(self, chunk: Chunk) -> pa.Table | None:
        """Return the rows of a chunk's runs; None where they are not there, not whole, or of something else.

        Raises
        ------
        OSError
            Where the disk does not let it be read: whether it is whole is then not known.
        """
        import pyarrow as pa

        try:
            content = self._metrics(chunk).read_bytes()
        except FileNotFoundError:
            return None
        try:
            # from memory: what is raised from here on is said of the content, not of the disk
            table = pa.ipc.open_file(content).read_all()
            table.validate(full=True)
            said = table.schema.metadata or {}
            whole = said.get(b"metrics_checksum") == _checksum(table)
        except (OSError, ValueError, pa.ArrowException):
            return None
        mark = self._mark(chunk)
        return table if whole and {name: said.get(name) for name in mark} == mark else None

    def whole(self, chunk: Chunk) -> bool:
        """Whether a chunk is there with every byte of its signals, which are all read for it.

        Raises
        ------
        OSError
            Where the disk does not let it be read.
        """
        table = self.metrics(chunk)
        if table is None:
            return False
        said = _signals_checksum(table)
        if said == NO_FILE:
            return True
        found = _Summed(None)
        try:
            with self._signals(chunk).open("rb") as file:
                while piece := file.read(1 << 20):
                    found.write(piece)
        except FileNotFoundError:
            return False
        return found.text() == said

    def signals(self, chunk: Chunk, mapped: bool = True) -> Iterator[pa.Table]:
        """Yield the signals of a chunk, one run or several at a time.

        Parameters
        ----------
        chunk : Chunk
        mapped : bool
            Whether the file is mapped, or read into memory: it may then be replaced, on Windows too.

        Raises
        ------
        StorageError
            Where they are no longer there.
        """
        import pyarrow as pa

        table = self.metrics(chunk)
        if table is not None and _signals_checksum(table) == NO_FILE:
            return
        try:
            path = self._signals(chunk)
            reader = pa.ipc.open_file(pa.memory_map(str(path), "r") if mapped else path.read_bytes())
        except (OSError, pa.ArrowException) as error:
            # all was whole when it was begun or gone on with: whoever goes on does this chunk again
            raise StorageError(
                f"{self._signals(chunk)} cannot be read any more ({error}); "
                f"go on: {resume_command(self.folder)}"
            ) from error
        for index in range(reader.num_record_batches):
            yield pa.Table.from_batches([reader.get_batch(index)])

    def _mark(self, chunk: Chunk) -> dict[bytes, bytes]:
        worlds = f"{chunk.worlds[0]} to {chunk.worlds[-1]}"
        return {name.encode(): text.encode() for name, text in {**self.asked, "worlds": worlds}.items()}

    def _metrics(self, chunk: Chunk) -> Path:
        return self.folder / CHUNKS / f"{chunk.index:06d}.arrow"

    def _signals(self, chunk: Chunk) -> Path:
        return self.folder / CHUNKS / f"{chunk.index:06d}.signals"


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


class _Summed(io.RawIOBase):
    """Passes on what is written, and keeps a checksum of it."""

    def __init__(self, file: IO[bytes] | None) -> None:
        self._file, self._sum, self._size = file, 0, 0

    def writable(self) -> bool:
        return True

    def write(self, content: Any) -> int:
        size = memoryview(content).nbytes
        self._sum, self._size = zlib.crc32(content, self._sum), self._size + size
        if self._file is not None:
            self._file.write(content)
        return size

    def tell(self) -> int:
        return self._size

    def text(self) -> str:
        return f"crc32 {self._sum:08x} of {self._size} bytes"


def _write(path: Path, tables: Iterator[pa.Table]) -> str:
    """Put tables into a file and return its checksum."""
    import pyarrow as pa

    sums: list[str] = []

    def fill(file: IO[bytes]) -> None:
        summed = _Summed(file)
        first = next(tables)
        with pa.ipc.new_file(summed, first.schema) as writer:
            writer.write_table(first.combine_chunks())
            for table in tables:
                writer.write_table(table.combine_chunks())
        sums.append(summed.text())

    durable.write(path, fill)
    return sums[-1]


def _checksum(table: pa.Table) -> bytes:
    """Return the checksum of rows, whatever is said about them; the same when they are read again."""
    import pyarrow as pa

    bare = table.replace_schema_metadata(None).combine_chunks()
    summed = _Summed(None)
    with pa.ipc.new_stream(summed, bare.schema) as writer:
        writer.write_table(bare)
    return summed.text().encode()


def _signals_checksum(table: pa.Table) -> str:
    return (table.schema.metadata or {}).get(b"signals_checksum", b"").decode(errors="replace")


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
