"""Entities as chunks, the units of a recording: what Rerun's shorthands write, for less work per entity.

A recording has hundreds of entities. The shorthands build an archetype for each of them and check it part by
part; here what does not change is built once per process, and one time column serves all series with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray
from rerun.chunk import Chunk

from slipctl.view.tracks import Array, nanoseconds

_SCALARS = rr.Scalars.descriptor_scalars()


@dataclass(frozen=True)
class Clock:
    """The rows that several entities share.

    Attributes
    ----------
    rows : (N,) int array
        Rows of the track.
    times : rerun.TimeColumn
        Their times.
    offsets : (N + 1,) int32 array
        One value per row.
    """

    rows: NDArray[np.intp]
    times: rr.TimeColumn
    offsets: NDArray[np.int32]

    @classmethod
    def of(cls, time: Array, rows: NDArray[np.intp]) -> Clock:
        """Return the clock of some rows of a track with the times `time` (T,) [s]."""
        times = rr.TimeColumn("sim_time", duration=nanoseconds(time[rows]))
        return cls(rows, times, np.arange(len(rows) + 1, dtype=np.int32))


def scalars(entity: str, clock: Clock, values: Array) -> Chunk:
    """Return one series of a plot: the values (T,) in the rows of the clock, bit for bit."""
    batch = rr.components.ScalarBatch(pa.array(values[clock.rows]))
    column = rr.ComponentColumn(_SCALARS, batch, offsets=clock.offsets)
    return Chunk.from_columns(entity, [clock.times], [column])


def lasting(entity: str, build: Callable[..., rr.AsComponents], **fields: Any) -> Chunk:
    """Return what holds at all times, as ``rec.log(entity, build(**fields), static=True)`` writes it.

    Styles and shapes are the same in every world of a sweep: their components are built once and kept. So
    this is for what recordings have in common. The chunk is a new one: in a file, chunks lie in the order
    in which they were made, which must not depend on earlier recordings.

    Parameters
    ----------
    entity : str
    build : callable
        An archetype, or its ``from_fields``.
    **fields
        Its arguments: plain values, tuples for lists.
    """
    return Chunk.from_columns(entity, [], _components(build, **fields))


@lru_cache(maxsize=2048)
def _components(build: Callable[..., rr.AsComponents], **fields: Any) -> tuple[rr.ComponentColumn, ...]:
    return tuple(_Kept(part) for part in build(**fields).as_component_batches())


class _Kept(rr.ComponentColumn):
    """A column of one row whose array is made once."""

    def __init__(self, part: rr.DescribedComponentBatch) -> None:
        super().__init__(part.component_descriptor(), part, lengths=[len(part.as_arrow_array())])
        self._array = super().as_arrow_array()

    def as_arrow_array(self) -> pa.Array:
        return self._array


def strips(points: Array, lengths: NDArray[np.intp]) -> rr.components.LineStrip3DBatch:
    """Return lines of `lengths` (L,) points each, one after the other in `points` (sum of lengths, 3)."""
    single = rr.encodings.Vec3DBatch(points).as_arrow_array()
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    kind = pa.list_(pa.field("item", single.type, nullable=False))
    return rr.components.LineStrip3DBatch(pa.ListArray.from_arrays(offsets, single, type=kind))
