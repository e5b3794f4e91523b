"""Plausible signals with the columns of a run, without running anything."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

PAIRS = {
    "reference.position": "m", "reference.velocity": "m/s", "reference.acceleration": "m/s²",
    "motion.position": "m", "motion.velocity": "m/s",
    "decision.nominal_input": "m/s²", "decision.robust_input": "m/s²", "decision.weighted_error": "1",
}  # fmt: skip


def signals(run: int, duration=4.0, tick=0.01, robust=True, mujoco=True, grip=0.6, seed=0) -> pa.Table:
    """A figure-eight of 2 m, driven with a decaying error and an episode of slip in the middle."""
    rng = np.random.default_rng(seed + run)
    t = np.arange(round(duration / tick) + 1) * tick
    phase = 2 * np.pi * t / duration
    rate = 2 * np.pi / duration
    fx, fy = np.sin(phase), 0.5 * np.sin(2 * phase)
    dx, dy = rate * np.cos(phase), rate * np.cos(2 * phase)
    ax, ay = -(rate**2) * np.sin(phase), -2 * rate**2 * np.sin(2 * phase)
    heading, speed = np.unwrap(np.arctan2(dy, dx)), np.hypot(dx, dy)
    yaw = np.gradient(heading, tick)
    size = 0.02 if robust else 0.06
    error = size * np.exp(-3 * t) + 0.3 * size * (1 - grip) * np.sin(5 * t) ** 2
    bump = np.exp(-(((t - duration / 2) / 0.3) ** 2)) * (1 - grip)
    slip_t, slip_s = 0.3 * speed * bump, 0.25 * speed * bump * np.sign(yaw)
    v = speed - slip_t
    wheels = np.stack([v - 0.1624 * yaw, v + 0.1624 * yaw]) / 0.0825
    eta = 0.05 * speed + 0.2 * bump
    robust_input = 2.0 * np.exp(-8 * t) + 0.3 * eta
    columns: dict[str, tuple[np.ndarray, str]] = {
        "reference.position.x": (fx, "m"), "reference.position.y": (fy, "m"),
        "reference.velocity.x": (dx, "m/s"), "reference.velocity.y": (dy, "m/s"),
        "reference.acceleration.x": (ax, "m/s²"), "reference.acceleration.y": (ay, "m/s²"),
        "reference.heading": (heading, "rad"), "reference.forward_speed": (speed, "m/s"),
        "reference.yaw_rate": (yaw, "rad/s"),
        "motion.position.x": (fx - error * np.sin(heading), "m"), "motion.position.y": (fy + error * np.cos(heading), "m"),
        "motion.velocity.x": (dx, "m/s"), "motion.velocity.y": (dy, "m/s"),
        "motion.heading": (heading + 0.5 * error, "rad"), "motion.heading_rate": (yaw, "rad/s"),
        "motion.forward_speed": (v, "m/s"), "motion.yaw_rate": (yaw, "rad/s"),
        "slip.longitudinal": (slip_t, "m/s"), "slip.lateral": (slip_s, "m/s"), "slip.yaw": (0.1 * bump, "rad/s"),
        "slip.ratio": (np.hypot(slip_t, slip_s) / np.maximum(np.abs(v), 0.05), "1"),
        "decision.nominal_input.x": (ax - 4 * error, "m/s²"), "decision.nominal_input.y": (ay, "m/s²"),
        "decision.robust_input.x": (robust * robust_input, "m/s²"), "decision.robust_input.y": (0 * t, "m/s²"),
        "decision.forward_speed": (v, "m/s"), "decision.yaw_rate": (yaw, "rad/s"),
        "wheel.rate.left": (wheels[0], "rad/s"), "wheel.rate.right": (wheels[1], "rad/s"),
        "wheel.rate_command.left": (np.roll(wheels[0], -2), "rad/s"), "wheel.rate_command.right": (np.roll(wheels[1], -2), "rad/s"),
        "error.position": (error, "m"), "error.cross_track": (-error, "m"), "error.heading": (0.5 * error, "rad"),
        "guarantee.uncertainty": (eta, "m/s²"),
    }  # fmt: skip
    if mujoco:
        sliding, load = bump > 0.2, 71 + rng.normal(0, 0.3, (2, len(t)))
        drive, side = 8 * np.sin(phase), 25 * np.sin(2 * phase)
        half, lean = heading / 2, 0.01 * np.sin(phase)
        columns |= {
            "wheel.torque.left": (0.4 * np.sin(phase), "N·m"), "wheel.torque.right": (0.5 * np.sin(phase), "N·m"),
            "wheel.normal_force.left": (load[0], "N"), "wheel.normal_force.right": (load[1], "N"),
            "wheel.longitudinal_force.left": (drive, "N"), "wheel.longitudinal_force.right": (1.1 * drive, "N"),
            "wheel.lateral_force.left": (side, "N"), "wheel.lateral_force.right": (side, "N"),
            "wheel.angle.left": (np.cumsum(wheels[0]) * tick, "rad"), "wheel.angle.right": (np.cumsum(wheels[1]) * tick, "rad"),
            "body.height": (0.0825 + 0 * t, "m"),
            "body.quaternion.w": (np.cos(half) * np.cos(lean), "1"), "body.quaternion.x": (np.cos(half) * np.sin(lean), "1"),
            "body.quaternion.y": (np.sin(half) * np.sin(lean), "1"), "body.quaternion.z": (np.sin(half) * np.cos(lean), "1"),
        }  # fmt: skip
    arrays: dict[str, tuple[pa.Array, str]] = {
        "run": (pa.array(np.full(len(t), run, np.int32)), ""),
        "time": (pa.array(t), "s"),
    }
    arrays |= {name: (pa.array(np.asarray(values, float)), unit) for name, (values, unit) in columns.items()}
    nothing = pa.nulls(len(t), pa.float64())
    arrays["decision.robust_gain"] = (pa.array(0.2 + eta) if robust else nothing, "m/s²")
    arrays["decision.weighted_error.x"] = (pa.array(error) if robust else nothing, "1")
    arrays["decision.saturated"] = (pa.array((t > 0.4 * duration) & (t < 0.45 * duration)), "")
    arrays["guarantee.held"] = (pa.array(eta < 0.2 + eta) if robust else pa.nulls(len(t), pa.bool_()), "")
    if mujoco:
        arrays["wheel.sliding.left"] = (pa.array(sliding), "")
        arrays["wheel.sliding.right"] = (pa.array(sliding & (bump > 0.25)), "")
    fields = [
        pa.field(name, array.type, metadata={"unit": unit} if unit else None) for name, (array, unit) in arrays.items()
    ]
    return pa.Table.from_arrays([array for array, _ in arrays.values()], schema=pa.schema(fields))


def join(*tables: pa.Table) -> pa.Table:
    """The signals of several runs, as in one file: columns that a run lacks are null."""
    return pa.concat_tables(tables, promote_options="default")
