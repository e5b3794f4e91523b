"""Amounts of a finding in the units that people think in, with the digits that tell two values apart."""

from __future__ import annotations

import math
from collections.abc import Sequence

FOR_PEOPLE = {"m": (1e3, "mm"), "rad": (180.0 / math.pi, "°"), "m/s": (1e3, "mm/s")}
"""Factor and name of the unit that stands in for another where people read."""

MOST_DIGITS = 15
"""Digits that matter in a double."""

Value = float | str | None


def amount(value: Value, unit: str | None, digits: int = 3) -> str:
    """Write one value with its unit: ``12.3 mm``; statuses as they are, and None as ``not finite``."""
    if isinstance(value, str) or value is None:
        return _plain(value)
    factor, name = _people(unit)
    return _join(_digits([factor * value], digits)[0], name)


def change_text(baseline: Value, current: Value, unit: str | None) -> str:
    """Write two values side by side, with as many digits as tell them apart: ``12.34 → 12.36 mm``."""
    if isinstance(baseline, str | None) or isinstance(current, str | None):
        return f"{amount(baseline, unit)} → {amount(current, unit)}"
    factor, name = _people(unit)
    before, after = _digits([factor * baseline, factor * current])
    return _join(f"{before} → {after}", name)


def interval_text(interval: Sequence[float], unit: str | None) -> str:
    """Write an interval by its ends: ``2.1 to 2.4 mm``."""
    factor, name = _people(unit)
    low, high = interval
    first, last = _digits([factor * low, factor * high])
    return _join(f"{first} to {last}", name)


def share_text(baseline: Value, current: Value) -> str:
    """Write by what share of the first the second differs: ``+18 %``, ``×12``; "" where that says nothing."""
    share = relative_change(baseline, current)
    if share is None:
        return ""
    if share >= 9.0:
        return f"×{share + 1.0:.3g}"
    percent = 100.0 * share
    return f"{percent:+.0f} %" if abs(percent) >= 9.5 else f"{percent:+.2g} %"


def relative_change(baseline: Value, current: Value) -> float | None:
    """Return (current − baseline)/|baseline|; None where one of them is no number or the first is 0."""
    numbers = [value for value in (baseline, current) if isinstance(value, int | float)]
    if len(numbers) < 2 or numbers[0] == 0.0:
        return None
    return (numbers[1] - numbers[0]) / abs(numbers[0])


def _people(unit: str | None) -> tuple[float, str]:
    if unit is None or unit == "1" or " or " in unit:  # of what a law commands, the unit depends on the law
        return 1.0, ""
    return FOR_PEOPLE.get(unit, (1.0, unit))


def _plain(value: str | None) -> str:
    return "not finite" if value is None else value.replace("_", " ")


def _join(text: str, unit: str) -> str:
    return f"{text}{unit}" if unit == "°" else f"{text} {unit}".rstrip()


def _digits(values: list[float], digits: int = 3) -> list[str]:
    """Write numbers alike: so many digits of the largest, or two of how far they are apart if more."""
    largest = max(map(abs, values))
    if largest == 0.0:
        return ["0" for _ in values]
    apart = max(values) - min(values)
    if apart > 0.0:
        digits = max(digits, _power(largest) - _power(apart) + 2)
    digits = min(digits, MOST_DIGITS)
    if 1e-3 <= largest < 1e6:
        return [f"{value:.{max(0, digits - 1 - _power(largest))}f}" for value in values]
    return [f"{value:.{digits}g}" for value in values]


def _power(value: float) -> int:
    return math.floor(math.log10(value))
