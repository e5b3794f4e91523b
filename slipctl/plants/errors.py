"""What is wrong with a model file."""

from __future__ import annotations


class ModelError(ValueError):
    """A model file that cannot be read, or that lacks a part slipctl needs."""


class UnusableModel(ModelError):
    """A model file that can be read, but is no robot that slipctl can drive; the message says why."""
