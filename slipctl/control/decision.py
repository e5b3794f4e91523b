"""What a kinematic law remembers and decides in one tick."""

from __future__ import annotations

from dataclasses import dataclass

from slipctl.tick import Array, Command


@dataclass(frozen=True)
class SpeedMemory:
    """The prolonged state of the law.

    Attributes
    ----------
    forward_speed : (N,) array
        The commanded speed v_k [m/s].
    """

    forward_speed: Array


@dataclass(frozen=True)
class DecisionTrace:
    """Why a law decided as it did; what a law does not have is None.

    Attributes
    ----------
    nominal_input, robust_input : (N, 2) arrays
        v̂ and Δv [m/s²].
    saturated : (N,) bool array
        Whether a limit changed the command.
    robust_gain : (N,) array or None
        ρ [m/s²].
    weighted_error : (N, 2) array or None
        JᵀPe, the vector whose length the boundary layer bounds.
    """

    nominal_input: Array
    robust_input: Array
    saturated: Array
    robust_gain: Array | None = None
    weighted_error: Array | None = None


@dataclass(frozen=True)
class Decision:
    """Command, memory for the next tick, and the reasons."""

    command: Command
    memory: SpeedMemory
    trace: DecisionTrace
