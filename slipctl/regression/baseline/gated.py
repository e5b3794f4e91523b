"""Which metrics are gated, which way is worse, how far each may move, and when a number says nothing."""

from __future__ import annotations

NOTEWORTHY = {
    "rms_position_error": 1e-4,
    "max_position_error": 1e-4,
    "final_position_error": 1e-4,
    "rms_cross_track_error": 1e-4,
    "rms_heading_error": 1e-4,
    "command_variation": 1e-2,
    "guarantee_fraction": 1e-2,
}
"""Every gated metric, and the smallest tolerance that can make it chaotic, in the metric's unit (assumed):
what is allowed a tenth of a millimetre or milliradian, or a hundredth of a share, is never unpredictable."""

GATED = tuple(NOTEWORTHY)
"""The metrics a baseline holds, in the order of `slipctl.metrics.UNITS`."""

LARGER_IS_BETTER = frozenset({"guarantee_fraction"})
"""Of all others, less is better."""

NUDGE = 1e-9
"""The start is moved by this much [m, rad], to either side: far below what anybody could set up, far above
rounding. Another processor rounds otherwise by less; what grows from it means nothing."""

RELATIVE = 1e-6
"""Share of the value always allowed."""

SPREADS = 10.0
"""Multiples of the spread always allowed: a few runs show the size of a spread, not its end."""

FLOOR = NUDGE
"""Always allowed, in the metric's unit: the nudge itself."""

TICKS = 1.5
"""Ticks always allowed to turn in a share of ticks: one that stands at the edge of an inequality."""

CHAOTIC = 0.2
"""Share of the value. A number whose tolerance would be wider says only its order of magnitude (assumed)."""


def allowances(metric: str, value: float, spread: float, ticks: int) -> dict[str, float]:
    """Say how far a number may move, reason by reason: the largest is its tolerance.

    Parameters
    ----------
    metric : str
    value : float
    spread : float
        How far it moved, see `slipctl.regression.Number`.
    ticks : int
        Length of the run.

    Returns
    -------
    dict
        From each reason in words to what it allows, in the metric's unit.
    """
    return {
        f"{RELATIVE:g} of the value": RELATIVE * abs(value),
        f"{SPREADS:g} spreads": SPREADS * spread,
        **always_allowed(metric, ticks),
    }


def always_allowed(metric: str, ticks: int) -> dict[str, float]:
    """Say what is allowed to a number of any size that never moved: the reason in words, and the amount."""
    if metric in LARGER_IS_BETTER:
        return {f"{TICKS:g} of {ticks} ticks": TICKS / max(ticks, 1)}
    return {f"the floor of {FLOOR:g}": FLOOR}


def is_chaotic(metric: str, value: float | None, spread: float | None) -> bool:
    """Say whether a number moved so far that it cannot be gated.

    It cannot where its tolerance would be more than a fifth of it. What half the timestep does is no part of
    it: on good grip, where errors are of a millimetre, the physics step is a fifth of them, yet the same step
    gives the same number to eight digits.

    Parameters
    ----------
    metric : str
    value : float or None
        None where it is not finite, or where there is no such number.
    spread : float or None
        How far it moved, see `slipctl.regression.Number`.
    """
    if value is None or spread is None:
        return False
    return SPREADS * spread > max(CHAOTIC * abs(value), NOTEWORTHY[metric])


def is_repeated(metric: str, value: float | None, other: float | None, ticks: int) -> bool:
    """Say whether two numbers from the very same start are the same, rounding aside.

    The laws of slipctl give the same to the last bit. A law of one's own may round otherwise where it
    computes more worlds at a time.

    Parameters
    ----------
    metric : str
    value, other : float or None
        None where there is no such number.
    ticks : int
        Length of the run.
    """
    if value is None or other is None:
        return value is other
    return abs(other - value) <= max(allowances(metric, value, 0.0, ticks).values())
