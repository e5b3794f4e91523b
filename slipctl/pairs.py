"""Two numbers per world, as one array."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def pair(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return two (N,) arrays as one (N, 2) array.

    `np.stack` takes four times as long, and a tick makes a dozen pairs. In memory each of the two lies in one
    piece, which is how they are read again.

    Parameters
    ----------
    first, second : (N,) arrays
        Or histories (N, T) of them, which become (N, T, 2).
    """
    both = np.array((first, second))
    return both.T if both.ndim == 2 else last_axis(both)


def last_axis(both: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a (2, …) array as a view (…, 2)."""
    return both.T if both.ndim == 2 else both.transpose(*range(1, both.ndim), 0)


def for_both(columns: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Return each of K numbers per world (N, K) as an (N, 2) array: once for x and once for y.

    That is for numbers that stay the same: to multiply pairs by pairs takes half as long as by a column.
    """
    return tuple(pair(column, column) for column in columns.T)
