"""Which metrics are gated, which way is worse, and when a number says nothing."""

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
"""Every gated metric, and the smallest movement that can make it chaotic, in the metric's unit (assumed):
below a tenth of a millimetre or milliradian, or a hundredth of a share, no run counts as unpredictable."""

GATED = tuple(NOTEWORTHY)
"""The metrics a baseline holds, in the order of `slipctl.metrics.UNITS`."""

LARGER_IS_BETTER = frozenset({"guarantee_fraction"})
"""Of all others, less is better."""

CHAOTIC = 0.2
"""Share of the value. A number that moves by more from a start moved by a nanometre says only its order of
magnitude (assumed)."""


def is_chaotic(metric: str, value: float | None, spread: float | None) -> bool:
    """Say whether a number moved so far that it cannot be gated.

    What half the timestep does is no part of it: on good grip, where errors are of a millimetre, the physics
    step is a fifth of them, yet the same step gives the same number to eight digits.

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
    return spread > max(CHAOTIC * abs(value), NOTEWORTHY[metric])
