"""Seeded mistakes, one at a time: each must show, or the tests could not fail.

A mistake shows if it moves an error of a closed loop (maximum, RMS, final) beyond the 2 % that the tests of
Sections V-A and V-B allow, or if an identity breaks.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.mutants import MUTANTS as KINEMATIC
from tests.mutants_dynamic import MUTANTS as DYNAMIC

MUTANTS = [*KINEMATIC, *DYNAMIC]

TOLERANCE = 0.02


@functools.cache
def healthy(detector: Callable[[], Any]) -> Any:
    return detector()


def shows(detector: Callable[[], Any], answer: Any) -> bool:
    """Tell whether a detector's answer would fail a test."""
    if isinstance(answer, float):
        return not answer < 1e-9
    return bool((~(np.abs(answer - healthy(detector)) <= TOLERANCE * np.abs(healthy(detector)))).any())


def test_nothing_shows_without_a_mistake():
    for detector in {detector for mutant in MUTANTS for detector in mutant.seen_by}:
        assert not shows(detector, detector()), detector.__name__


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_mistake_shows(mutant, monkeypatch):
    for detector in mutant.seen_by:
        healthy(detector)
    owner: Any = importlib.import_module(mutant.module)
    *path, attribute = mutant.attribute.split(".")
    for name in path:
        owner = getattr(owner, name)
    monkeypatch.setattr(owner, attribute, mutant.mistake(getattr(owner, attribute)))
    for detector in mutant.seen_by:
        assert shows(detector, detector()), detector.__name__
