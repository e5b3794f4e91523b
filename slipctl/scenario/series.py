"""The Parquet file of a slip that is prescribed as a series over time."""

from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy import ndarray

COLUMNS = ("time", "longitudinal", "lateral", "yaw")
"""Columns of the file: time [s], v_t and v_s [m/s], w_s [rad/s]."""


class SeriesError(ValueError):
    """A file that holds no series.

    Attributes
    ----------
    found, allowed : str
        What is wrong, and what may stand there.
    """

    def __init__(self, found: str, allowed: str) -> None:
        self.found, self.allowed = found, allowed
        super().__init__(f"{found}; allowed: {allowed}")


@dataclass(frozen=True)
class Series:
    """Slip over time. Two series are equal if their content is.

    Attributes
    ----------
    content : str
        "sha256:" and the hash of the four columns as float64, whatever file they stand in.
    time : (S,) array
        [s], strictly increasing, at least two samples.
    longitudinal, lateral : (S,) arrays
        v_t and v_s [m/s], v_s positive to the right.
    yaw : (S,) array
        w_s [rad/s].
    """

    content: str
    time: "ndarray" = field(compare=False, repr=False)
    longitudinal: "ndarray" = field(compare=False, repr=False)
    lateral: "ndarray" = field(compare=False, repr=False)
    yaw: "ndarray" = field(compare=False, repr=False)


def read_series(file: str | Path) -> Series:
    """Read a series of slip.

    Parameters
    ----------
    file
        Path of a Parquet file with the columns `COLUMNS`, numbers without gaps; other columns are refused.

    Raises
    ------
    SeriesError
        If there is no such file or it is none of these.
    """
    path = Path(file)
    try:
        state = path.stat()
    except (OSError, ValueError) as error:
        raise SeriesError(f'"{path}", which does not exist', "a Parquet file") from error
    return _read(path, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=8)
def _read(path: Path, modified: int, size: int) -> Series:
    """Read a file once for all worlds of a grid; it is read again when it has changed."""
    import numpy as np
    from pyarrow import ArrowException
    from pyarrow import parquet as pq

    wanted = f"a Parquet file with the columns {', '.join(COLUMNS)}"
    try:
        table = pq.read_table(path)
    except (ArrowException, OSError, ValueError) as error:
        raise SeriesError(f'"{path}", which is not a Parquet file', wanted) from error
    if sorted(table.column_names) != sorted(COLUMNS):
        raise SeriesError(f'"{path}" with the columns {", ".join(table.column_names) or "none"}', wanted)
    columns: list[ndarray] = []
    for name in COLUMNS:
        column = table[name]
        try:
            values = np.array(column.to_numpy(), dtype=np.float64)
        except (ValueError, TypeError) as error:
            raise SeriesError(f'"{path}", whose {name} is of type {column.type}', "numbers") from error
        if column.null_count or not np.isfinite(values).all():
            raise SeriesError(f'"{path}", whose {name} has gaps, NaN or infinities', "finite numbers")
        values.setflags(write=False)
        columns.append(values)
    if len(columns[0]) < 2:
        raise SeriesError(f'"{path}" with {len(columns[0])} rows', "at least two rows")
    if not (np.diff(columns[0]) > 0).all():
        raise SeriesError(f'"{path}", whose time does not always increase', "strictly increasing times")
    digest = sha256(b"".join((values + 0.0).astype("<f8").tobytes() for values in columns))
    return Series("sha256:" + digest.hexdigest(), *columns)
