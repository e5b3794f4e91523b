"""What was found in a robot's model file, as a table for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.text import Text


def lines(seen: Mapping[str, Any]) -> Iterator[Text]:
    """Yield what ``slipctl inspect`` prints.

    Parameters
    ----------
    seen : mapping
        As of `slipctl.plants.inspection.Inspection.json`.
    """
    yield Text(str(seen["model"]), style="bold")
    rows = list(_rows(seen))
    width = max((len(name) for name, _ in rows), default=0)
    for name, value in rows:
        yield Text(f"{name.ljust(width)}  {value}")
    for note in seen["notes"]:
        yield Text(f"note: {note}")
    for warning in seen["warnings"]:
        yield Text(f"warning: {warning}", style="yellow")
    yield Text("usable" if seen["usable"] else "not usable", style="green" if seen["usable"] else "red")


def _rows(seen: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    if seen["free_joint"] is not None:
        yield "free joint", {"file": "in the file", "added": "added"}[seen["free_joint"]]
    if seen["wheel_radius"] is None:
        return
    for side, wheel in zip(("left", "right"), seen["wheels"], strict=True):
        turns = "ahead" if wheel["sign"] > 0 else "back"
        count = wheel["contacts"]
        touches = f"r {wheel['radius']:.4f} m on {count} contact{'s' if count != 1 else ''}"
        yield f"{side} wheel", f"{wheel['joint']}, positive drives {turns}, {touches}"
    yield "wheel radius", f"{seen['wheel_radius']:.4f} m"
    yield "half track", f"{seen['half_track']:.4f} m"
    yield "mass", f"{seen['mass']:.3f} kg, {seen['mass_in_file']:.3f} kg in the file"
    yield "yaw inertia", f"{seen['yaw_inertia']:.5g} kg m²"
    yield "weight on the wheels", f"{seen['weight_share']:.1%}"
    for caster in seen["casters"]:
        kind = "swivels or rolls" if caster["moves"] else "brakes" if caster["brakes"] else "slides freely"
        share = f"{caster['weight_share']:.1%} of the weight"
        touch = f"condim {caster['condim']}, friction {caster['friction']:g}"
        yield f"caster {caster['geom']}", f"{kind}, {touch}, {share}"
    yield "servo", f"kv {seen['servo']:.3g} N m s/rad, torque limit {seen['torque_limit']:.3g} N m"
    yield "servo droop", f"{seen['servo_droop']:.2%}"
    yield "at the torque limit", f"{seen['saturation']:.0%} of the arc"
    yield "yaw realised", f"{seen['yaw_realised']:.2%} of the wheels' in an arc of 5 s"
