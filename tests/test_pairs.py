"""Two numbers per world, as one array."""

from __future__ import annotations

import numpy as np
import pytest

from slipctl.pairs import for_both, last_axis, pair


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


def test_two_of_anything_are_seen_along_the_last_axis():
    for shape in ((2,), (2, 5), (2, 3, 5)):
        both = np.arange(float(np.prod(shape))).reshape(shape)
        seen = last_axis(both)
        assert np.array_equal(seen, np.moveaxis(both, 0, -1))
        assert np.shares_memory(seen, both)


def test_numbers_of_every_world_are_there_once_for_each_coordinate():
    first, second, third = for_both(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]))
    assert first.tolist() == [[1.0, 1.0], [4.0, 4.0]]
    assert second.tolist() == [[2.0, 2.0], [5.0, 5.0]]
    assert third.tolist() == [[3.0, 3.0], [6.0, 6.0]]


def test_parts_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match="inhomogeneous"):
        pair(np.zeros(2), np.zeros(3))
