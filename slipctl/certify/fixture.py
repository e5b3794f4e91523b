"""What a fixture is, and what comes of one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from slipctl.certify.specimen import Specimen
from slipctl.plants.own import OwnModel


@dataclass(frozen=True)
class Bench:
    """The model under test.

    Attributes
    ----------
    path : Path or OwnModel
        Model file.
    timestep : float
        Physics step [s].
    """

    path: Path | OwnModel
    timestep: float

    @cached_property
    def specimen(self) -> Specimen:
        """The compiled robot; read once.

        Raises
        ------
        slipctl.plants.model.ModelError
            If it cannot be used.
        """
        return Specimen(self.path, self.timestep)


@dataclass(frozen=True)
class Fixture:
    """One question to the compiled model that has an answer in closed form.

    Attributes
    ----------
    name : str
    unit : str
        Of the measurement and of the closed form.
    tolerance : float
        In shares of the closed form where `relative`, else in `unit`.
    relative : bool
    law : str
        The closed form, in words or symbols.
    blame : str
        What is usually wrong where it fails.
    measure : callable
        Returns the measurement and the closed form's value.
    """

    name: str
    unit: str
    tolerance: float
    relative: bool
    law: str
    blame: str
    measure: Callable[[Bench], tuple[float, float]]

    def check(self, bench: Bench) -> Check:
        """Measure, and hold the measurement against the closed form. A model that cannot be tried fails."""
        reason = ""
        try:
            measured, expected = self.measure(bench)
        except (ValueError, ArithmeticError, LookupError) as error:
            measured = expected = math.nan
            reason = str(error)
        error = measured - expected
        if self.relative:
            error = error / abs(expected) if expected else math.nan
        passed = bool(abs(error) <= self.tolerance)
        return Check(
            name=self.name,
            measured=_number(measured),
            expected=_number(expected),
            error=_number(error),
            tolerance=self.tolerance,
            unit=self.unit,
            passed=passed,
            relative=self.relative,
            law=self.law,
            reason="" if passed else reason or self.blame,
        )


@dataclass(frozen=True)
class Check:
    """What came of a fixture; not-a-number is None.

    Attributes
    ----------
    name, unit, law : str
        As of the fixture.
    measured, expected : float or None
        In `unit`.
    error, tolerance : float
        Shares of `expected` where `relative`, else in `unit`.
    passed, relative : bool
    reason : str
        Why it failed; empty where it passed.
    """

    name: str
    measured: float | None
    expected: float | None
    error: float | None
    tolerance: float
    unit: str
    passed: bool
    relative: bool
    law: str
    reason: str

    def json(self) -> dict[str, Any]:
        """Return an entry of ``checks`` in the machine output."""
        return asdict(self)


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
