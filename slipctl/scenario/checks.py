"""The rules that span several keys.

They read the raw tables, not the models, so that they also speak up where other keys are wrong: a file's
problems come all at once. A rule whose keys are themselves missing or wrong keeps silent.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl import shipped
from slipctl.scenario.base import lookup, number
from slipctl.scenario.controllers import SLIP_BOUND_LIMIT
from slipctl.scenario.path_speed import slowest
from slipctl.scenario.problems import Problem, later, nearest, quote, show
from slipctl.scenario.structure import KINDS, Path, dotted, table_at

TICK_LIMIT = 10_000_000
"""Largest number of control ticks of one run (their signals would no longer fit into memory)."""

_DRIVES = {
    "nominal_kinematic": "wheel_speed",
    "robust_kinematic": "wheel_speed",
    "nominal_dynamic": "wheel_torque",
    "robust_dynamic": "wheel_torque",
    "kinematic_ode": "wheel_speed",
    "dynamic_ode": "wheel_torque",
}


def rule_problems(raw: Mapping[str, Any]) -> list[Problem]:
    """Everything wrong between the keys of a file."""
    rules = (_model, _plant, _ground, _times, _reference, _controllers, _drive, _start)
    return [problem for rule in rules for problem in rule(raw)]


def value_at(raw: Any, *path: str | int) -> float | None:
    """Finite number at a path, its default where the file leaves it out, None where there is none."""
    value = lookup(raw, *path)
    if value is None:
        table = table_at(path[:-1], raw)
        field = None if table is None else table.model_fields.get(str(path[-1]))
        value = None if field is None or field.is_required() else field.default
    return number(value)


def _has(raw: Any, table: str, key: str) -> bool:
    entry = lookup(raw, table)
    return isinstance(entry, Mapping) and key in entry


def _model(raw: Mapping[str, Any]) -> Iterator[Problem]:
    model, names = lookup(raw, "robot", "model"), shipped.model_names()
    if isinstance(model, str) and model and model not in names:
        if "/" in model or "\\" in model or model.lower().endswith((".xml", ".mjcf", ".urdf")):
            yield later("robot.model", f"{show(model)}, a model by its path", names)
        else:
            yield Problem("robot.model", show(model), ", ".join(map(quote, names)), nearest(model, names))


def _plant(raw: Mapping[str, Any]) -> Iterator[Problem]:
    if lookup(raw, "plant", "kind") != "kinematic_ode":
        return
    if "ground" in raw:
        instead = (
            'no [ground], as kinematic_ode has no floor and would ignore it (plant.kind = "mujoco" has one)'
        )
        yield Problem("ground", show(raw["ground"]), instead)
    if _has(raw, "robot", "torque_limit"):
        instead = (
            'no torque_limit, as kinematic_ode has no torques and would ignore it (plant.kind = "mujoco" has)'
        )
        yield Problem("robot.torque_limit", show(lookup(raw, "robot", "torque_limit")), instead)


def _ground(raw: Mapping[str, Any]) -> Iterator[Problem]:
    sides = [key for key in ("friction_left", "friction_right") if _has(raw, "ground", key)]
    if sides and _has(raw, "ground", "friction"):
        yield Problem(
            "ground.friction",
            f"it together with {' and '.join(sides)}",
            "friction, or friction_left and friction_right",
        )
    if len(sides) == 1:
        other = "friction_right" if sides == ["friction_left"] else "friction_left"
        yield Problem(f"ground.{other}", f"nothing, though {sides[0]} is given", "both, or friction alone")
    if _has(raw, "ground", "film") and _has(raw, "ground", "creep_stiffness"):
        yield Problem("ground.film", "it together with creep_stiffness", "one of film and creep_stiffness")


def _times(raw: Mapping[str, Any]) -> Iterator[Problem]:
    tick = value_at(raw, "tick")
    if tick is None or tick <= 0:
        return
    timestep = value_at(raw, "plant", "timestep")
    if lookup(raw, "plant", "kind") == "mujoco" and timestep is not None and timestep > 0:
        steps = tick / timestep
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
            lower = max(1, int(steps))
            yield Problem(
                "tick",
                f"{tick:g} s, {steps:.6g} times the timestep",
                f"a multiple of plant.timestep ({timestep:g} s), such as "
                f"{lower * timestep:.9g} or {(lower + 1) * timestep:.9g} s",
            )
    given = "duration" in raw
    duration = value_at(raw, "duration") if given else _natural_duration(raw)
    if duration is None or duration <= 0:
        return
    whose = "duration" if given else "the reference's duration"
    if tick > duration:
        yield Problem("tick", f"{tick:g} s", f"at most {whose}, {duration:.6g} s")
    elif duration / tick > TICK_LIMIT:
        allowed = f"at most {TICK_LIMIT:,} ticks a run: a longer tick or a shorter duration"
        yield Problem(
            "tick", f"{tick:g} s, {duration / tick:.4g} ticks in {whose}, {duration:.6g} s", allowed
        )


def _natural_duration(raw: Mapping[str, Any]) -> float | None:
    table = table_at(("reference",), raw)
    if table is None:
        return None
    numbers = {
        name: value for name in table.model_fields if (value := value_at(raw, "reference", name)) is not None
    }
    try:
        return number(getattr(table.model_construct(None, **numbers), "natural_duration", None))
    except (AttributeError, TypeError, ZeroDivisionError, OverflowError):
        return None


def _reference(raw: Mapping[str, Any]) -> Iterator[Problem]:
    kind = lookup(raw, "reference", "kind")
    if kind == "circle" and value_at(raw, "reference", "radius") == 0:
        yield Problem("reference.radius", "0", "a number > 0 (turns left) or < 0 (turns right) [m]")
    if kind == "point_to_point":
        ends = [
            [value_at(raw, "reference", end, key) for key in ("x", "y", "heading_deg", "speed")]
            for end in ("start", "goal")
        ]
        start, goal = ([entry for entry in end if entry is not None] for end in ends)
        duration = value_at(raw, "reference", "duration")
        if (
            len(start) == len(goal) == 4
            and min(start[3], goal[3]) > 0
            and duration is not None
            and duration > 0
        ):
            speed, time = slowest(start, goal, duration)
            if speed < 1e-4:
                yield Problem(
                    "reference",
                    f"a path that stands still at t = {time:.4g} s",
                    "a path whose speed stays above 0, as the flat map is singular at v = 0 (change "
                    "duration, headings or speeds)",
                )


def controllers(raw: Mapping[str, Any]) -> list[tuple[Path, str, Mapping[str, Any]]]:
    """Path, label and table of each listed controller that is a table."""
    listed = lookup(raw, "controller")
    entries = listed if isinstance(listed, list | tuple) else []
    tables = [
        (("controller", index), entry) for index, entry in enumerate(entries) if isinstance(entry, Mapping)
    ]
    return [(path, str(entry.get("label", entry.get("kind", ""))), entry) for path, entry in tables]


def _controllers(raw: Mapping[str, Any]) -> Iterator[Problem]:
    seen: dict[str, Path] = {}
    speed_limit = value_at(raw, "robot", "speed_limit")
    for path, label, entry in controllers(raw):
        if label and label in seen:
            first = dotted(seen[label], raw)
            yield Problem(
                dotted((*path, "label"), raw), f"{quote(label)}, as at {first}", "a label of its own"
            )
        seen.setdefault(label, path)
        form, bound = entry.get("uncertainty"), number(entry.get("slip_bound"))
        limit = SLIP_BOUND_LIMIT.get(form) if isinstance(form, str) else None
        if limit is not None and bound is not None and bound >= limit:
            yield Problem(
                dotted((*path, "slip_bound"), raw),
                f"{bound:g}",
                f'a number ≥ 0 and < {limit:.4g} for "{form}"',
            )
        floor = value_at(raw, *path, "speed_floor")
        if floor is not None and speed_limit is not None and 0 < speed_limit <= floor:
            key = dotted((*path, "speed_floor"), raw)
            yield Problem(key, f"{floor:g}", f"a number below robot.speed_limit, {speed_limit:g} [m/s]")


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


def _start(raw: Mapping[str, Any]) -> Iterator[Problem]:
    if lookup(raw, "start", "at_rest") is not True:
        return
    for path, _, _ in controllers(raw):
        if value_at(raw, *path, "speed_floor") == 0:
            yield Problem(
                dotted((*path, "speed_floor"), raw),
                "0, no speed floor, together with start.at_rest",
                "a number > 0 [m/s], as the law divides by the speed, which is 0 at rest",
            )
