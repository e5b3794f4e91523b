"""What the file format names but this release does not have yet: refused by name, never skipped."""

LATER_VALUES: dict[str, tuple[str, ...]] = {
    "slip.kind": ("patches",),
    "reference.kind": ("waypoints",),
    "controller.kind": ("eso", "kanayama"),
}
"""Values of a key (array indices left out) that come later."""


def later_value(key: str, value: object) -> bool:
    """Whether a value of a key (array indices left out) comes with a later release."""
    return isinstance(value, str) and value in LATER_VALUES.get(key, ())
