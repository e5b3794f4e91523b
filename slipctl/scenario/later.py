"""What the file format names but this release does not have yet: refused by name, never skipped."""

from fnmatch import fnmatchcase

LATER_VALUES: dict[str, tuple[str, ...]] = {
    "plant.kind": ("dynamic_ode",),
    "robot.drive": ("wheel_torque",),
    "slip.kind": ("patches", "series"),
    "reference.kind": ("waypoints",),
    "controller.kind": ("nominal_dynamic", "robust_dynamic", "eso", "kanayama"),
    "controller.uncertainty": ("proportional", "general"),
    "sensing.pose": ("odometry_camera",),
    "sensing.velocity": ("odometry", "differentiated"),
    "sensing.acceleration": ("imu", "model"),
}
"""Values of a key (array indices left out) that come later."""

_LATER_KEYS: dict[str, str] = {
    "disturbance": "[[disturbance]] (pushes)",
    "ground.patch": "[[ground.patch]] (patches of the floor)",
    "controller.believes": "believes (a law that is wrong about its robot)",
    "controller.yaw_slip_bound": "yaw_slip_bound (of the dynamic law)",
    "controller.lateral_slip*_bound": "a lateral slip bound (of the dynamic law)",
    "controller.coupling_bound": "coupling_bound (of the dynamic law)",
    "reference.start.yaw_rate": "yaw_rate at the start (a quintic path)",
    "reference.start.acceleration": "acceleration at the start (a quintic path)",
    "reference.goal.yaw_rate": "yaw_rate at the goal (a quintic path)",
    "reference.goal.acceleration": "acceleration at the goal (a quintic path)",
    "sensing.camera_*": "the camera",
    "sensing.*delay": "a sensing delay",
    "sensing.*noise*": "sensing noise",
}


def later_key(key: str) -> str | None:
    """Tell what a key (array indices left out) is, where it comes with a later release; else None."""
    return next((what for pattern, what in _LATER_KEYS.items() if fnmatchcase(key, pattern)), None)


def later_value(key: str, value: object) -> bool:
    """Whether a value of a key (array indices left out) comes with a later release."""
    return isinstance(value, str) and value in LATER_VALUES.get(key, ())
