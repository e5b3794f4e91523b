"""The steps that every flatness-based kinematic law shares: errors, nominal input, inverse flat map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.control.drive import DriveLimits, SpeedMemory
from slipctl.theory.flatness import invert_decoupling
from slipctl.tick import Array, Decision, DecisionTrace, Motion, Reference, SpeedCommand


def flat_errors(reference: Reference, motion: Motion) -> tuple[Array, Array]:
    """Return e₁ = F − F_d [m] and e₂ = Ḟ − Ḟ_d [m/s], (38) and (39), (N, 2) each."""
    return motion.position - reference.position, motion.velocity - reference.velocity


def nominal_input(
    reference: Reference, position_error: Array, velocity_error: Array, first_gain: Array, second_gain: Array
) -> Array:
    """Return v̂ = F̈_d − K₁e₁ − K₂e₂, (43), as (N, 2) [m/s²]; K₁ and K₂ are (N, 2), once per coordinate."""
    return reference.acceleration - first_gain * position_error - second_gain * velocity_error


def steer(
    drive: DriveLimits, memory: SpeedMemory, motion: Motion, flat_input: Array, tick: float | Array
) -> tuple[SpeedCommand, SpeedMemory, NDArray[np.bool_]]:
    """Map a flat input (N, 2) [m/s²] to a limited command; the speed in B is the commanded one.

    Returns
    -------
    command : SpeedCommand
    memory : SpeedMemory
    saturated : (N,) bool array
        As `DriveLimits.command` says.
    """
    cosine, sine = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
    acceleration, turn = invert_decoupling(memory.forward_speed, cosine, sine, flat_input)
    command, speed, saturated = drive.command(memory.forward_speed, acceleration, turn, tick)
    return command, SpeedMemory(speed), saturated


def decide(
    drive: DriveLimits,
    memory: SpeedMemory,
    motion: Motion,
    flat_input: Array,
    trace: DecisionTrace,
    tick: float | Array,
) -> Decision[SpeedCommand]:
    """Decide as `steer` says, for the reasons in `trace`, which learns here whether a limit acted."""
    command, memory, saturated = steer(drive, memory, motion, flat_input, tick)
    trace = DecisionTrace(
        trace.nominal_input, trace.robust_input, saturated, trace.robust_gain, trace.weighted_error
    )
    return Decision(command, memory, trace)
