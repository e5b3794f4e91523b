"""Where a point-to-point path is slowest: at v = 0 the flat map is singular."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import cos, hypot, radians, sin, sqrt


def slowest(start: Sequence[float], goal: Sequence[float], duration: float) -> tuple[float, float]:
    """Smallest speed on the cubic path between two ends, and when.

    Parameters
    ----------
    start, goal
        x [m], y [m], heading [deg], speed [m/s] at each end.
    duration
        Time between them [s].

    Returns
    -------
    speed, time
        Smallest ‖Ḟ‖ [m/s] for 0 ≤ t ≤ duration, and its time [s].
    """
    axes = [_velocity(start, goal, duration, index, turn) for index, turn in ((0, cos), (1, sin))]

    def speed(part: float) -> float:
        return hypot(*(a + part * (b + part * c) for a, b, c in axes))

    # d‖Ḟ‖²/ds is a cubic in s; between the zeros of its own derivative, a quadratic, it is monotone.
    slope = [
        sum(a * b for a, b, _ in axes),
        sum(b * b + 2 * a * c for a, b, c in axes),
        sum(3 * b * c for _, b, c in axes),
        sum(2 * c * c for _, _, c in axes),
    ]
    turns = [part for part in _quadratic_roots(slope[1], 2 * slope[2], 3 * slope[3]) if 0 < part < 1]
    edges = [0.0, *sorted(turns), 1.0]
    parts = [*edges, *(_zero(slope, low, high) for low, high in pairwise(edges))]
    best = min(parts, key=speed)
    return speed(best), best * duration


def _velocity(
    start: Sequence[float], goal: Sequence[float], duration: float, index: int, turn: Callable[[float], float]
) -> tuple[float, float, float]:
    """Coefficients of one component of Ḟ in s = t / duration: a + b s + c s² [m/s]."""
    first, last = (end[3] * turn(radians(end[2])) for end in (start, goal))
    mean = (goal[index] - start[index]) / duration
    return first, 6 * mean - 4 * first - 2 * last, 3 * (first + last) - 6 * mean


def _quadratic_roots(constant: float, linear: float, square: float) -> list[float]:
    if square == 0:
        return [-constant / linear] if linear else []
    discriminant = linear * linear - 4 * square * constant
    if discriminant < 0:
        return []
    return [(-linear + sign * sqrt(discriminant)) / (2 * square) for sign in (-1, 1)]


def _zero(cubic: Sequence[float], low: float, high: float) -> float:
    """Zero of a monotone piece of a cubic by bisection; its lower end where the sign does not change."""

    def value(part: float) -> float:
        return cubic[0] + part * (cubic[1] + part * (cubic[2] + part * cubic[3]))

    rising = value(high) > value(low)
    if value(low) * value(high) > 0:
        return low
    for _ in range(60):
        middle = (low + high) / 2
        if (value(middle) < 0) == rising:
            low = middle
        else:
            high = middle
    return (low + high) / 2
