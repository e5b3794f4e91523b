"""What the file format names but this release does not have yet: refused by name, never skipped."""

from fnmatch import fnmatchcase

LATER_VALUES: dict[str, tuple[str, ...]] = {
    "slip.kind": ("patches",),
    "reference.kind": ("waypoints",),
    "controller.kind": ("eso", "kanayama"),
}
"""Values of a key (array indices left out) that come later."""

_LATER_KEYS: dict[str, str] = {
    "ground.terrain*": "[ground.terrain] (uneven floor)",
}


def later_key(key: str) -> str | None:
    """Tell what a key (array indices left out) is, where it comes with a later release; else None."""
    return next((what for pattern, what in _LATER_KEYS.items() if fnmatchcase(key, pattern)), None)


def later_value(key: str, value: object) -> bool:
    """Whether a value of a key (array indices left out) comes with a later release."""
    return isinstance(value, str) and value in LATER_VALUES.get(key, ())
