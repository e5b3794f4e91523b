"""Columns as Arrow tables, one per world."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from slipctl.recording.signals import FLAT_INPUTS, LAW_COLUMNS, PATH_COLUMNS, UNITS, Columns

if TYPE_CHECKING:
    import pyarrow as pa


def signal_tables(
    runs: Sequence[int],
    columns: Columns,
    last_rows: Sequence[int],
    tick: float,
    numbers: Sequence[int] | None = None,
) -> list[pa.Table]:
    """Return the rows of every world of a simulation as a table with units in the field metadata.

    Parameters
    ----------
    runs : sequence of int
        Index of the run of every world, written in the column `run`.
    columns : dict of (N, T) arrays
        Not copied: they must not change any more.
    last_rows : sequence of int
        The last row that counts, of every world; rows after it are left out.
    tick : float
        [s].
    numbers : sequence of int, optional
        Which ticks the T columns are; 0 … T − 1 unless told otherwise.

    Returns
    -------
    list of pyarrow.Table
        The same schema for every law on a plant: what a law does not have is null. Bodies and contacts are
        left out where the plant has none.
    """
    import pyarrow as pa

    worlds, rows = columns["error.position"].shape
    # the uncertainty of a tick needs the next row, which the last row does not have
    told = np.ones((worlds, rows), dtype=bool)
    told[np.arange(worlds), last_rows] = False
    has_tick = _bits(told)
    arrays = [
        pa.array(np.repeat(np.array(runs, dtype=np.int32), rows)),
        _times(worlds, tick, range(rows) if numbers is None else tuple(numbers)),
    ]
    jerks = "decision.acceleration" in columns
    absent = LAW_COLUMNS | (PATH_COLUMNS if "reference.path_time" in columns else set())
    names = tuple(name for name in UNITS if name in columns or name in absent)
    schema = _schema(names, jerks)
    for name, kind in zip(names, schema.types[2:], strict=True):
        if name not in columns:
            arrays.append(pa.nulls(worlds * rows, kind))
            continue
        values = np.ascontiguousarray(columns[name])
        data = _bits(values) if kind == pa.bool_() else pa.py_buffer(values)
        valid = has_tick if name.startswith("guarantee.") else None
        arrays.append(pa.Array.from_buffers(kind, worlds * rows, [valid, data]))
    batch = pa.RecordBatch.from_arrays(arrays, schema=schema)  # sliced in a third of a table's time
    return [
        pa.Table.from_batches([batch.slice(world * rows, last + 1)]) for world, last in enumerate(last_rows)
    ]


@lru_cache(maxsize=8)
def _times(worlds: int, tick: float, numbers: range | tuple[int, ...]) -> pa.Array:
    """Return the times of some ticks, once for every world [s]."""
    import pyarrow as pa

    return pa.array(np.tile(np.array(numbers) * tick, worlds))


@lru_cache(maxsize=16)
def _schema(names: tuple[str, ...], jerks: bool) -> pa.Schema:
    """Return run, time and the columns `names`, with their units."""
    import pyarrow as pa

    fields = [pa.field("run", pa.int32(), metadata={"unit": "1"})]
    fields.append(pa.field("time", pa.float64(), metadata={"unit": "s"}))
    for name in names:
        unit = UNITS[name]
        if jerks and name.removesuffix(".x").removesuffix(".y") in FLAT_INPUTS:
            unit = "m/s³"
        kind = pa.bool_() if unit == "bool" else pa.float64()
        fields.append(pa.field(name, kind, metadata={"unit": unit}))
    return pa.schema(fields)


def _bits(flags: NDArray[np.bool_]) -> pa.Buffer:
    import pyarrow as pa

    return pa.py_buffer(np.packbits(flags.reshape(-1), bitorder="little"))
