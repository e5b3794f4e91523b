"""The steps that both dynamic laws share: errors, model drift, inverse flat map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.control.torque import PushMemory, TorqueDrive
from slipctl.pairs import pair
from slipctl.theory.dynamic import drift, invert_dynamics
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, TorqueCommand


def flat_errors(reference: Reference, motion: Motion, memory: PushMemory) -> tuple[Array, Array, Array]:
    """Return e₁ [m], e₂ [m/s] and e₃ [m/s²] of (65), (N, 2) each.

    Where nothing measures the acceleration, e₃ uses the model's own, μ₁t + v w n, which knows nothing of
    slip, slopes or friction.
    """
    acceleration = motion.acceleration
    if acceleration is None:
        c, s = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
        turn = motion.forward_speed * motion.yaw_rate
        push = memory.acceleration
        acceleration = pair(push * c - turn * s, push * s + turn * c)
    return (
        motion.position - reference.position,
        motion.velocity - reference.velocity,
        acceleration - reference.acceleration,
    )


def weighted_sum(weights: tuple[Array, ...], errors: tuple[Array, Array, Array]) -> Array:
    """Return Σ wᵢeᵢ of three weights, each (N, 2), once per coordinate."""
    first, second, third = weights
    return first * errors[0] + second * errors[1] + third * errors[2]


def model_drift(motion: Motion, memory: PushMemory) -> Array:
    """Return A of (25) at the wheel-derived speeds and the law's μ₁, (N, 2) [m/s³]."""
    c, s = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
    return drift(motion.forward_speed, motion.yaw_rate, memory.acceleration, c, s)


def steer(
    drive: TorqueDrive, memory: PushMemory, motion: Motion, flat_input: Array, model: Array, tick: float
) -> tuple[TorqueCommand, PushMemory, NDArray[np.bool_]]:
    """Map a flat input (N, 2) to limited torques; `model` is `model_drift` (N, 2), both in m/s³.

    Returns
    -------
    command : TorqueCommand
    memory : PushMemory
    saturated : (N,) bool array
        As `TorqueDrive.command` says.
    """
    c, s = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
    speed = np.maximum(motion.forward_speed, drive.speed_floor)
    jerk, yaw_acceleration = invert_dynamics(speed, c, s, flat_input, model)
    return drive.command(memory.acceleration, jerk, yaw_acceleration, motion.wheel_rate, tick)


def decide(
    drive: TorqueDrive,
    memory: PushMemory,
    motion: Motion,
    flat_input: Array,
    model: Array,
    trace: DecisionTrace,
    tick: float,
) -> Decision[TorqueCommand]:
    """Decide as `steer` says, for the reasons in `trace`, which learns here whether the limit acted."""
    command, memory, saturated = steer(drive, memory, motion, flat_input, model, tick)
    trace = DecisionTrace(
        trace.nominal_input, trace.robust_input, saturated, trace.robust_gain, trace.weighted_error
    )
    return Decision(command, memory, trace)
