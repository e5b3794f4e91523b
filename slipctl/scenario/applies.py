"""Which keys the rest of a file leaves without effect: refused, not swept, left out of dumps."""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl.scenario.base import lookup
from slipctl.scenario.controllers import DYNAMIC_KINDS, GENERAL_KEYS, KINEMATIC_KINDS
from slipctl.scenario.own_robot import ignored_keys
from slipctl.scenario.problems import Problem, show
from slipctl.scenario.sensing import ACCELERATION_KEYS, CAMERA_KEYS
from slipctl.scenario.structure import Path, dotted
from slipctl.scenario.values import controllers, has

_COMPENSATED = ("wheel_inertia", "joint_friction")
_COMPENSATION = ("compensate_wheels", *_COMPENSATED)


def ignored(raw: Mapping[str, Any]) -> dict[Path, str]:
    """Paths of keys that would have no effect, each with the reason; whether a file gives them or not."""
    return {
        path: reason for rule in (ignored_keys, _plant, _drive, _sensing, _laws) for path, reason in rule(raw)
    }


def ignored_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Tell of the keys that a file gives though they would have no effect."""
    for path, reason in ignored(raw).items():
        if has(raw, *path):
            what = f"[{path[0]}]" if len(path) == 1 else str(path[-1])
            value = lookup(raw, *path)
            yield Problem(dotted(path, raw), show(value), f"no {what}, which would be ignored: {reason}")


def _plant(raw: Mapping[str, Any]) -> Iterator[tuple[Path, str]]:
    kind = lookup(raw, "plant", "kind")
    if kind in ("kinematic_ode", "dynamic_ode"):
        yield ("ground",), f'{kind} has no floor (plant.kind = "mujoco" has one)'
        yield ("disturbance",), f'{kind} has no forces (plant.kind = "mujoco" has)'
    if kind == "kinematic_ode":
        yield ("robot", "torque_limit"), 'kinematic_ode has no torques (plant.kind = "mujoco" has)'
    if kind == "dynamic_ode":
        for key in _COMPENSATION:
            reason = 'dynamic_ode has wheels without inertia and friction (plant.kind = "mujoco" has both)'
            yield ("robot", key), reason


def _drive(raw: Mapping[str, Any]) -> Iterator[tuple[Path, str]]:
    if lookup(raw, "robot", "drive") == "wheel_speed":
        for key in _COMPENSATION:
            yield ("robot", key), "wheel speeds are commanded, not torques"
        for key in ACCELERATION_KEYS:
            yield ("sensing", key), "no law for wheel_speed looks at the acceleration"
    elif lookup(raw, "robot", "compensate_wheels") is False:
        for key in _COMPENSATED:
            yield ("robot", key), "compensate_wheels = false leaves it alone"


def _sensing(raw: Mapping[str, Any]) -> Iterator[tuple[Path, str]]:
    if lookup(raw, "sensing", "pose") in (None, True, "true"):
        for key in CAMERA_KEYS:
            yield ("sensing", key), 'there is a camera only with pose = "odometry_camera"'
    if lookup(raw, "sensing", "acceleration") == "model":
        for key in ("acceleration_noise", "acceleration_delay"):
            yield ("sensing", key), 'acceleration = "model" measures none'


def _laws(raw: Mapping[str, Any]) -> Iterator[tuple[Path, str]]:
    scaled = lookup(raw, "reference", "time_scaling")
    for path, _, entry in controllers(raw):
        kind = entry.get("kind")
        if kind in KINEMATIC_KINDS:
            for key in ("mass", "yaw_inertia"):
                yield (*path, "believes", key), f"{kind} knows no masses"
            if scaled is None or scaled is False:
                reason = "the path's own time is that of the run unless reference.time_scaling = true"
                yield (*path, "time_scaled"), reason
        if kind in DYNAMIC_KINDS and entry.get("uncertainty") in ("paper", "proportional"):
            for key in GENERAL_KEYS:
                yield (*path, key), f'uncertainty = "{entry["uncertainty"]}" needs no such bound'
