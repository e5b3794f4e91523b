"""Where a point-to-point path is slowest: at v = 0 the flat map is singular."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from math import cos, hypot, radians, sin


@lru_cache(maxsize=1024)  # every world of a sweep is asked for, and few sweeps vary the path
def slowest(start: tuple[float, ...], goal: tuple[float, ...], duration: float) -> tuple[float, float]:
    """Smallest speed on the polynomial path between two ends, and when.

    Parameters
    ----------
    start, goal
        x [m], y [m], heading [deg], speed [m/s] at each end (a cubic path); for a quintic one also yaw rate
        [rad/s] and forward acceleration [m/s²].
    duration
        Time between them [s].

    Returns
    -------
    speed, time
        Smallest ‖Ḟ‖ [m/s] for 0 ≤ t ≤ duration, and its time [s].
    """
    axes = [_velocity(start, goal, duration, index) for index in (0, 1)]
    square = [0.0] * (2 * len(axes[0]) - 1)
    for axis in axes:
        for power, a in enumerate(axis):
            for other, b in enumerate(axis):
                square[power + other] += a * b
    parts = [0.0, *_zeros(_derivative(square)), 1.0]

    def speed(part: float) -> float:
        return hypot(*(_at(axis, part) for axis in axes))

    best = min(parts, key=speed)
    return speed(best), best * duration


def _velocity(start: Sequence[float], goal: Sequence[float], duration: float, axis: int) -> list[float]:
    """Coefficients of one component of Ḟ [m/s] in s = t / duration, constant first."""
    along, across = ((cos, sin), (sin, cos))[axis]
    sign = (-1.0, 1.0)[axis]
    first, last = (end[3] * along(radians(end[2])) for end in (start, goal))
    mean = (goal[axis] - start[axis]) / duration
    if len(start) == 4:
        return [first, 6 * mean - 4 * first - 2 * last, 3 * (first + last) - 6 * mean]
    bends = [
        duration * (end[5] * along(radians(end[2])) + sign * end[3] * end[4] * across(radians(end[2])))
        for end in (start, goal)
    ]
    # F = F₀ + duration (first s + bend₀ s²/2 + a s³ + b s⁴ + c s⁵) meets position, velocity and bend at s = 1
    gap, turn, bend = mean - first - bends[0] / 2, last - first - bends[0], bends[1] - bends[0]
    a, b, c = 10 * gap - 4 * turn + bend / 2, -15 * gap + 7 * turn - bend, 6 * gap - 3 * turn + bend / 2
    return [first, bends[0], 3 * a, 4 * b, 5 * c]


def _at(polynomial: Sequence[float], part: float) -> float:
    value = 0.0
    for coefficient in reversed(polynomial):
        value = value * part + coefficient
    return value


def _derivative(polynomial: Sequence[float]) -> list[float]:
    return [power * coefficient for power, coefficient in enumerate(polynomial)][1:]


def _zeros(polynomial: Sequence[float]) -> list[float]:
    """Zeros between 0 and 1: between the zeros of its own derivative a polynomial is monotone."""
    if len(polynomial) < 2 or not any(polynomial[1:]):
        return []
    edges = [0.0, *_zeros(_derivative(polynomial)), 1.0]
    return [_zero(lambda part: _at(polynomial, part), low, high) for low, high in pairwise(edges)]


def _zero(value: Callable[[float], float], low: float, high: float) -> float:
    """Zero of a monotone function by bisection; the end nearer to zero where the sign does not change."""
    first, last = value(low), value(high)
    if first * last > 0 or first == last:
        return low if abs(first) <= abs(last) else high
    for _ in range(60):
        middle = (low + high) / 2
        if (value(middle) < 0) == (last > first):
            low = middle
        else:
            high = middle
    return (low + high) / 2
