"""Finished runs, put to disk or kept in memory in the order of their indices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipctl.experiment.batch import Run

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

SIGNALS = "signals.parquet"


@dataclass
class Collector:
    """Takes finished runs; one row group per run, so that the bytes do not depend on how worlds were batched.

    Attributes
    ----------
    folder : pathlib.Path or None
        Where `signals.parquet` goes; None keeps the tables in memory.
    runs : list of Run
        What has finished. The signals of runs that are on disk are dropped from memory.
    interrupted : bool
    """

    folder: Path | None
    runs: list[Run] = field(default_factory=list)
    interrupted: bool = False
    _waiting: list[Run] = field(default_factory=list)
    _tables: list[pa.Table] = field(default_factory=list)
    _writer: pq.ParquetWriter | None = None

    def add(self, runs: Sequence[Run]) -> None:
        """Take the runs of one controller of a batch."""
        self._waiting += runs

    def flush(self) -> None:
        """Write what a batch left, ordered by run index."""
        for run in sorted(self._waiting, key=lambda run: run.index):
            self._write(run.signals)
            self.runs.append(replace(run, signals=run.signals.slice(0, 0)))
        self._waiting.clear()

    def _write(self, table: pa.Table) -> None:
        if self.folder is None:
            self._tables.append(table)
            return
        import pyarrow.parquet as pq

        if self._writer is None:
            # no dictionary: measured values hardly ever repeat
            self._writer = pq.ParquetWriter(
                self.folder / SIGNALS, table.schema, compression="zstd", use_dictionary=False
            )
        self._writer.write_table(table, row_group_size=max(1, table.num_rows))

    def close(self) -> pa.Table:
        """Write what an interruption left finished, and return all signals."""
        import pyarrow as pa

        self.flush()
        if self._writer is not None:
            self._writer.close()
        if self.folder is None:
            return pa.concat_tables(self._tables)
        import pyarrow.parquet as pq

        return pq.read_table(self.folder / SIGNALS, memory_map=True)
