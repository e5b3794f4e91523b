"""The rules between the keys of a control law and those around it."""

from collections.abc import Iterator, Mapping
from math import hypot
from typing import Any

from slipctl.scenario.base import lookup, number
from slipctl.scenario.controllers import GENERAL_REQUIRED, SLIP_BOUND_LIMIT
from slipctl.scenario.problems import Problem, quote
from slipctl.scenario.structure import KINDS, Path, dotted
from slipctl.scenario.values import controllers, has, value_at

_DRIVES = {
    "nominal_kinematic": "wheel_speed",
    "robust_kinematic": "wheel_speed",
    "nominal_dynamic": "wheel_torque",
    "robust_dynamic": "wheel_torque",
    "kinematic_ode": "wheel_speed",
    "dynamic_ode": "wheel_torque",
}


def law_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything wrong between the keys of the controllers, and with what they meet."""
    for rule in (_labels, _slip_bounds, _speed_floors, _drive):
        yield from rule(raw)


def _labels(raw: Mapping[str, Any]) -> Iterator[Problem]:
    seen: dict[str, Path] = {}
    for path, label, _ in controllers(raw):
        if label and label in seen:
            first = dotted(seen[label], raw)
            yield Problem(
                dotted((*path, "label"), raw), f"{quote(label)}, as at {first}", "a label of its own"
            )
        seen.setdefault(label, path)


def _slip_bounds(raw: Mapping[str, Any]) -> Iterator[Problem]:
    for path, _, entry in controllers(raw):
        form, bound = entry.get("uncertainty"), number(entry.get("slip_bound"))
        limit = SLIP_BOUND_LIMIT.get(form) if isinstance(form, str) else None
        key = dotted((*path, "slip_bound"), raw)
        if limit is not None and bound is not None and bound >= limit:
            yield Problem(key, f"{bound:g}", f'a number ≥ 0 and < {limit:.4g} for "{form}"')
        if form == "general" and entry.get("kind") == "robust_dynamic":
            for name in GENERAL_REQUIRED:
                if not has(raw, *path, name):
                    found = 'nothing, though uncertainty = "general" needs it'
                    yield Problem(dotted((*path, name), raw), found, "a number ≥ 0")
            coupling = value_at(raw, *path, "coupling_bound")
            if bound is None or coupling is None or min(bound, coupling) < 0:
                continue
            gain = hypot(coupling, bound + coupling)
            if gain >= 1:
                found = f"{bound:g} with a coupling_bound of {coupling:g}, a gain of {gain:.4g}"
                allowed = "bounds with hypot(coupling_bound, slip_bound + coupling_bound) < 1"
                yield Problem(key, found, allowed)


def _speed_floors(raw: Mapping[str, Any]) -> Iterator[Problem]:
    speed_limit = value_at(raw, "robot", "speed_limit")
    at_rest = lookup(raw, "start", "at_rest") is True
    scaled = lookup(raw, "reference", "time_scaling") is True
    for path, _, entry in controllers(raw):
        floor, key = value_at(raw, *path, "speed_floor"), dotted((*path, "speed_floor"), raw)
        if floor is not None and speed_limit is not None and 0 < speed_limit <= floor:
            yield Problem(key, f"{floor:g}", f"a number below robot.speed_limit, {speed_limit:g} [m/s]")
        allowed = "a number > 0 [m/s], as the law divides by the speed, which is 0 at rest"
        if floor == 0 and scaled and entry.get("time_scaled") is False:
            found = "0, no speed floor, together with reference.time_scaling and time_scaled = false"
            yield Problem(key, found, allowed)
        elif floor == 0 and at_rest and not scaled:
            yield Problem(key, "0, no speed floor, together with start.at_rest", allowed)


def _drive(raw: Mapping[str, Any]) -> Iterator[Problem]:
    drive = lookup(raw, "robot", "drive")
    if drive not in ("wheel_speed", "wheel_torque"):
        return
    users = [(path, entry.get("kind")) for path, _, entry in controllers(raw)]
    for path, kind in [(("plant",), lookup(raw, "plant", "kind")), *users]:
        needs = _DRIVES.get(kind, drive) if isinstance(kind, str) else drive
        if needs != drive:
            fits = [other for other in KINDS[str(path[0])] if _DRIVES.get(other, drive) == drive]
            instead = f" or a kind that fits {drive}: {', '.join(fits)}" if fits else ""
            found = f"{quote(str(kind))}, which does not fit robot.drive {quote(drive)}"
            yield Problem(dotted((*path, "kind"), raw), found, f"robot.drive = {quote(needs)}{instead}")
