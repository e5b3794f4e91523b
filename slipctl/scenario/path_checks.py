"""The rules between the keys of the reference, and the file of a slip series."""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl.scenario.base import lookup
from slipctl.scenario.path_speed import slowest
from slipctl.scenario.problems import Problem, quote
from slipctl.scenario.series import SeriesError, read_series
from slipctl.scenario.values import has, value_at

_POSE = ("x", "y", "heading_deg", "speed")
_RATES = ("yaw_rate", "acceleration")


def reference_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything wrong between the keys of the reference."""
    kind = lookup(raw, "reference", "kind")
    if kind == "circle" and value_at(raw, "reference", "radius") == 0:
        yield Problem("reference.radius", "0", "a number > 0 (turns left) or < 0 (turns right) [m]")
    if kind == "point_to_point":
        yield from _quintic(raw)
        yield from _standstill(raw)
        drive = lookup(raw, "robot", "drive")
        if lookup(raw, "reference", "time_scaling") is True and drive == "wheel_torque":
            yield Problem(
                "reference.time_scaling",
                f"true together with robot.drive {quote(drive)}",
                'false, or robot.drive = "wheel_speed", whose laws can control in the path\'s own time',
            )


def _quintic(raw: Mapping[str, Any]) -> Iterator[Problem]:
    places = [("reference", end, key) for end in ("start", "goal") for key in _RATES]
    given = [place for place in places if has(raw, *place)]
    for place in places:
        if given and place not in given and isinstance(lookup(raw, *place[:-1]), Mapping):
            yield Problem(
                ".".join(place),
                f"nothing, though {'.'.join(given[0])} is given",
                "yaw_rate and acceleration at both ends (a quintic path), or none of them (a cubic one)",
            )


def _standstill(raw: Mapping[str, Any]) -> Iterator[Problem]:
    any_rate = any(has(raw, "reference", end, key) for end in ("start", "goal") for key in _RATES)
    keys = _POSE + _RATES if any_rate else _POSE
    ends = [[value_at(raw, "reference", end, key) for key in keys] for end in ("start", "goal")]
    start, goal = (tuple(entry for entry in end if entry is not None) for end in ends)
    duration = value_at(raw, "reference", "duration")
    whole = len(start) == len(goal) == len(keys) and min(start[3], goal[3]) > 0
    if whole and duration is not None and duration > 0:
        speed, time = slowest(start, goal, duration)
        if speed < 1e-4:
            yield Problem(
                "reference",
                f"a path that stands still at t = {time:.4g} s",
                "a path whose speed stays above 0, as the flat map is singular at v = 0 (change "
                "duration, headings or speeds)",
            )


def slip_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything wrong with the file of a slip series."""
    file = lookup(raw, "slip", "file")
    if lookup(raw, "slip", "kind") == "series" and isinstance(file, str) and file:
        try:
            read_series(file)
        except SeriesError as error:
            yield Problem("slip.file", error.found, error.allowed)
