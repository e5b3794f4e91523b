"""Plausible signals with the columns of a run, without running anything."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

Array = NDArray[np.float64]
HALF_TRACK, RADIUS = 0.1624, 0.0825


def signals(
    run: int,
    duration: float = 4.0,
    tick: float = 0.01,
    robust: bool = True,
    mujoco: bool = True,
    grip: float = 0.6,
) -> pa.Table:
    """A figure-eight of 2 m, driven with a decaying error and an episode of slip in the middle."""
    t: Array = np.arange(round(duration / tick) + 1, dtype=np.float64) * tick
    rate = 2 * np.pi / duration
    phase = rate * t
    path = np.stack([np.sin(phase), 0.5 * np.sin(2 * phase)])
    velocity = rate * np.stack([np.cos(phase), np.cos(2 * phase)])
    acceleration = -(rate**2) * np.stack([np.sin(phase), 2 * np.sin(2 * phase)])
    heading, speed = np.unwrap(np.arctan2(velocity[1], velocity[0])), np.hypot(*velocity)
    yaw = np.gradient(heading, tick)
    error = (0.02 if robust else 0.06) * (np.exp(-3 * t) + 0.3 * (1 - grip) * np.sin(5 * t) ** 2)
    bump = np.exp(-(((t - duration / 2) / 0.3) ** 2)) * (1 - grip)
    eta = 0.05 * speed + 0.2 * bump
    slip = np.stack([0.3 * speed * bump, 0.25 * speed * bump * np.sign(yaw)])
    v = speed - slip[0]
    wheels = np.stack([v - HALF_TRACK * yaw, v + HALF_TRACK * yaw]) / RADIUS
    normal = np.stack([-np.sin(heading), np.cos(heading)])
    columns = {
        **_pair("reference.position", path, "m"),
        **_pair("reference.velocity", velocity, "m/s"),
        **_pair("reference.acceleration", acceleration, "m/s²"),
        "reference.heading": (heading, "rad"),
        "reference.forward_speed": (speed, "m/s"),
        "reference.yaw_rate": (yaw, "rad/s"),
        **_pair("motion.position", path + error * normal, "m"),
        **_pair("motion.velocity", velocity, "m/s"),
        "motion.heading": (heading + 0.5 * error, "rad"),
        "motion.heading_rate": (yaw, "rad/s"),
        "motion.forward_speed": (v, "m/s"),
        "motion.yaw_rate": (yaw, "rad/s"),
        "slip.longitudinal": (slip[0], "m/s"),
        "slip.lateral": (slip[1], "m/s"),
        "slip.yaw": (0.1 * bump, "rad/s"),
        "slip.ratio": (np.hypot(*slip) / np.maximum(np.abs(v), 0.05), "1"),
        **_pair("decision.nominal_input", acceleration - 4 * error, "m/s²"),
        **_pair("decision.robust_input", robust * np.stack([2 * np.exp(-8 * t) + eta, 0 * t]), "m/s²"),
        "decision.forward_speed": (v, "m/s"),
        "decision.yaw_rate": (yaw, "rad/s"),
        **_pair("wheel.rate", wheels, "rad/s", ("left", "right")),
        **_pair("wheel.rate_command", np.roll(wheels, -2, axis=1), "rad/s", ("left", "right")),
        "error.position": (error, "m"),
        "error.cross_track": (-error, "m"),
        "error.heading": (0.5 * error, "rad"),
        "guarantee.uncertainty": (eta, "m/s²"),
    }
    arrays = {name: (pa.array(values), unit) for name, (values, unit) in columns.items()}
    if mujoco:
        arrays |= _contact(t, phase, heading, wheels, bump, tick)
    nothing, unknown = pa.nulls(len(t), pa.float64()), pa.nulls(len(t), pa.bool_())
    arrays["decision.robust_gain"] = (pa.array(0.2 + eta) if robust else nothing, "m/s²")
    arrays["decision.weighted_error.x"] = (pa.array(error) if robust else nothing, "1")
    arrays["decision.saturated"] = (pa.array((t > 0.4 * duration) & (t < 0.45 * duration)), "")
    arrays["guarantee.held"] = (pa.array(t < 0.9 * duration) if robust else unknown, "")
    held = t < 0.9 * duration
    for name in ("speed_above_floor", "slip_bounded", "yaw_slip_bounded", "feedback_exact", "calm"):
        arrays[f"guarantee.{name}"] = (pa.array(held | True) if robust else unknown, "")
    for name in ("uncertainty_covered", "lyapunov_falls"):
        arrays[f"guarantee.{name}"] = (pa.array(held) if robust else unknown, "")
    arrays["guarantee.alarm"] = (pa.array(bump > 0.3) if robust else unknown, "")
    for name in ("weighted_error", "lyapunov", "monitored_slip"):
        arrays[f"guarantee.{name}"] = (pa.array(error) if robust else nothing, "1")
    arrays = {"run": (pa.array(np.full(len(t), run, np.int32)), ""), "time": (pa.array(t), "s"), **arrays}
    fields = [
        pa.field(name, array.type, metadata={"unit": unit} if unit else None)
        for name, (array, unit) in arrays.items()
    ]
    return pa.Table.from_arrays([array for array, _ in arrays.values()], schema=pa.schema(fields))


def join(*tables: pa.Table) -> pa.Table:
    """The signals of several runs, as in one file: columns that a run lacks are null."""
    return pa.concat_tables(tables, promote_options="default")


def _pair(
    stem: str, values: Array, unit: str, ends: tuple[str, str] = ("x", "y")
) -> dict[str, tuple[Array, str]]:
    return {f"{stem}.{end}": (part, unit) for end, part in zip(ends, values, strict=True)}


def _contact(
    t: Array, phase: Array, heading: Array, wheels: Array, bump: Array, tick: float
) -> dict[str, tuple[pa.Array, str]]:
    """What only MuJoCo knows; the body leans a little so that every part of the quaternion is used."""
    half, lean = heading / 2, 0.01 + 0.01 * np.sin(phase)
    sides = ("left", "right")
    columns = {
        **_pair("wheel.torque", 0.4 * np.stack([np.sin(phase), np.cos(phase)]), "N·m", sides),
        **_pair("wheel.normal_force", 71 + np.stack([np.sin(9 * t), np.cos(9 * t)]), "N", sides),
        **_pair("wheel.longitudinal_force", 8 * np.stack([np.sin(phase), np.sin(phase + 1)]), "N", sides),
        **_pair("wheel.lateral_force", 20 * np.stack([np.sin(2 * phase), np.sin(2 * phase + 1)]), "N", sides),
        **_pair("wheel.angle", np.cumsum(wheels, axis=1) * tick, "rad", sides),
        "body.height": (0.0821 + 1e-4 * np.sin(t), "m"),
        "body.quaternion.w": (np.cos(half) * np.cos(lean), "1"),
        "body.quaternion.x": (np.cos(half) * np.sin(lean), "1"),
        "body.quaternion.y": (np.sin(half) * np.sin(lean), "1"),
        "body.quaternion.z": (np.sin(half) * np.cos(lean), "1"),
    }
    arrays = {name: (pa.array(values), unit) for name, (values, unit) in columns.items()}
    arrays["wheel.sliding.left"] = (pa.array(bump > 0.2), "")
    arrays["wheel.sliding.right"] = (pa.array(bump > 0.25), "")
    return arrays
