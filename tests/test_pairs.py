"""Two numbers per world, as one array."""

from __future__ import annotations

import numpy as np
import pytest

from slipctl.pairs import pair


def test_a_pair_is_a_stack_with_both_parts_in_one_piece():
    first, second = np.array([1.0, -0.0, np.nan]), np.array([4.0, 5.0, np.inf])
    made = pair(first, second)
    assert made.tobytes() == np.stack([first, second], axis=-1).tobytes()
    assert made[:, 0].flags.c_contiguous
    assert made[:, 1].flags.c_contiguous
    first[0] = 9.0
    assert made[0, 0] == 1.0


def test_a_history_becomes_pairs_of_every_instant():
    first, second = np.arange(6.0).reshape(2, 3), np.arange(6.0, 12.0).reshape(2, 3)
    assert np.array_equal(pair(first, second), np.stack([first, second], axis=-1))


def test_parts_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match="inhomogeneous"):
        pair(np.zeros(2), np.zeros(3))
