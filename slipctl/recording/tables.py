"""Columns as Arrow tables, one per world."""

from __future__ import annotations

from collections.abc import Sequence
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
        pa.array(np.tile(np.array(range(rows) if numbers is None else numbers) * tick, worlds)),
    ]
    fields = [pa.field("run", pa.int32(), metadata={"unit": "1"})]
    fields.append(pa.field("time", pa.float64(), metadata={"unit": "s"}))
    for name, unit in UNITS.items():
        if "decision.acceleration" in columns and name.removesuffix(".x").removesuffix(".y") in FLAT_INPUTS:
            unit = "m/s³"
        kind = pa.bool_() if unit == "bool" else pa.float64()
        if name in columns:
            values = np.ascontiguousarray(columns[name])
            data = _bits(values) if unit == "bool" else pa.py_buffer(values)
            valid = has_tick if name.startswith("guarantee.") else None
            array = pa.Array.from_buffers(kind, worlds * rows, [valid, data])
        elif name in LAW_COLUMNS or (name in PATH_COLUMNS and "reference.path_time" in columns):
            array = pa.nulls(worlds * rows, kind)
        else:
            continue
        arrays.append(array)
        fields.append(pa.field(name, kind, metadata={"unit": unit}))
    table = pa.Table.from_arrays(arrays, schema=pa.schema(fields))
    return [table.slice(world * rows, last + 1) for world, last in enumerate(last_rows)]


def _bits(flags: NDArray[np.bool_]) -> pa.Buffer:
    import pyarrow as pa

    return pa.py_buffer(np.packbits(flags.reshape(-1), bitorder="little"))
