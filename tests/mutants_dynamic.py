"""Seeded mistakes in the dynamic model and its laws, as in `mutants`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from slipctl.theory.flatness import invert_decoupling
from slipctl.tick import Slip
from tests.detectors_dynamic import (
    accelerations,
    inverse_of_dynamics,
    ramp,
    section_five_b_begins,
    third_derivative,
    torques,
)
from tests.mutants import Mutant, forgetful, on_arguments, on_result

ODE, BUILDERS = "slipctl.plants.dynamic_ode", "tests.dynamic"
NOMINAL, ROBUST = "slipctl.control.nominal_dynamic", "slipctl.control.robust_dynamic"
SHARED = "slipctl.control.flat_dynamic"
THEORY, TORQUE, SLIP = "slipctl.theory.dynamic", "slipctl.control.torque", "slipctl.theory.slip"
LOOP, TORQUED = (section_five_b_begins,), (torques, section_five_b_begins)


def flipped_slip(name: str) -> Callable[[Any], Any]:
    def mistake(original: Any) -> Any:
        def wrong(law: Any, time: float) -> Any:
            affine = original(law, time)
            fraction = replace(affine.fraction, **{name: -getattr(affine.fraction, name)})
            return replace(affine, fraction=fraction)

        return wrong

    return mistake


def flipped_lateral(seen: tuple[Any, Any, Slip]) -> tuple[Any, Any, Slip]:
    speed, turn, slip = seen
    return speed, turn, replace(slip, lateral=-slip.lateral)


def half_track_doubled(body: Any, *rest: Any) -> tuple[Any, ...]:
    return replace(body, geometry=replace(body.geometry, half_track=2.0 * body.geometry.half_track)), *rest


def heading_rate_for_yaw_rate(motion: Any, memory: Any) -> tuple[Any, Any]:
    return replace(motion, yaw_rate=motion.heading_rate), memory


def printed_27(original: Any) -> Any:
    def wrong(v: Any, c: Any, s: Any, flat_input: Any, drift: Any) -> Any:
        first, second = invert_decoupling(v, c, s, flat_input)
        return first - drift[:, 0], second - drift[:, 1]

    return wrong


def printed_c(original: Any) -> Any:
    """C with w for Ω, though not its ẇ_s, which would need one more argument."""

    def wrong(v: Any, w: Any, mu1: Any, slip: Slip, *rest: Any) -> Any:
        c_matrix, _ = original(v, w, mu1, replace(slip, yaw=0.0 * slip.yaw), *rest)
        return c_matrix, original(v, w, mu1, slip, *rest)[1]

    return wrong


def held_torque(result: tuple[Any, ...]) -> tuple[Any, ...]:
    command, *rest = result
    return replace(command, wheel_torque_end=command.wheel_torque_start), *rest


MUTANTS = [
    Mutant(
        "lateral slip flipped in the dynamics", ODE, "DynamicOde._wheels", on_result(flipped_lateral), LOOP
    ),
    Mutant("v_t flipped in the slip", SLIP, "ProportionalSlip.affine", flipped_slip("longitudinal"), LOOP),
    Mutant("v_s flipped in the slip", SLIP, "ProportionalSlip.affine", flipped_slip("lateral"), LOOP),
    Mutant("w_s flipped in the slip", SLIP, "ProportionalSlip.affine", flipped_slip("yaw"), LOOP),
    Mutant("rate of v_s left out", ODE, "DynamicOde._lateral_rate", on_result(lambda rate: 0.0 * rate), LOOP),
    Mutant("rate of v_s flipped", ODE, "DynamicOde._lateral_rate", on_result(lambda rate: -rate), LOOP),
    Mutant("2b for b in the torques", THEORY, "Inertia.torques", on_arguments(half_track_doubled), TORQUED),
    Mutant("r for r/2 in the torques", THEORY, "Inertia.torques", on_result(lambda t: 2.0 * t), TORQUED),
    Mutant(
        "wheels swapped in the torques", THEORY, "Inertia.torques", on_result(lambda t: t[..., ::-1]), TORQUED
    ),
    Mutant(
        "axles that push instead of rub",
        THEORY,
        "Inertia.torques",
        on_arguments(lambda body, push, spin, rate: (body, push, spin, -rate)),
        (torques,),
    ),
    Mutant(
        "2b for b in the accelerations",
        THEORY,
        "Inertia.accelerations",
        on_arguments(half_track_doubled),
        (accelerations, section_five_b_begins),
    ),
    Mutant(
        "wheels swapped in the accelerations",
        THEORY,
        "Inertia.accelerations",
        on_arguments(lambda body, torque, rate: (body, torque[..., ::-1], rate)),
        (accelerations, section_five_b_begins),
    ),
    Mutant(
        "one wheel's inertia for two",
        THEORY,
        "Inertia.effective_mass",
        lambda original: property(lambda body: (original.fget(body) + body.mass) / 2.0),
        (torques,),
    ),
    Mutant(
        "one wheel's inertia for two about the vertical",
        THEORY,
        "Inertia.effective_yaw_inertia",
        lambda original: property(lambda body: (original.fget(body) + body.yaw_inertia) / 2.0),
        (torques,),
    ),
    Mutant("(27) as printed, in the law", SHARED, "invert_dynamics", printed_27, LOOP),
    Mutant("(27) as printed, in the theory", THEORY, "invert_dynamics", printed_27, (inverse_of_dynamics,)),
    Mutant("C with w for Ω", THEORY, "slip_terms", printed_c, (third_derivative,)),
    Mutant(
        "D left out",
        THEORY,
        "slip_terms",
        on_result(lambda terms: (terms[0], 0.0 * terms[1])),
        (third_derivative,),
    ),
    Mutant("drift left out", SHARED, "drift", on_result(lambda a: 0.0 * a), LOOP),
    Mutant("Ω for w in A", ROBUST, "model_drift", on_arguments(heading_rate_for_yaw_rate), LOOP),
    Mutant("A flipped", THEORY, "drift", on_result(lambda a: -a), (third_derivative,)),
    Mutant("torque held instead of ramped", TORQUE, "TorqueDrive.command", on_result(held_torque), (ramp,)),
    Mutant(
        "F̈ error flipped",
        NOMINAL,
        "flat_errors",
        on_result(lambda errors: (errors[0], errors[1], -errors[2])),
        LOOP,
    ),
    Mutant(
        "F̈ error flipped in the robust law",
        ROBUST,
        "flat_errors",
        on_result(lambda errors: (errors[0], errors[1], -errors[2])),
        LOOP,
    ),
    Mutant(
        "Ḟ error left out",
        NOMINAL,
        "flat_errors",
        on_result(lambda errors: (errors[0], 0.0 * errors[1], errors[2])),
        LOOP,
    ),
    Mutant(
        "planned jerk left out",
        NOMINAL,
        "NominalDynamic.update",
        on_arguments(
            lambda law, memory, plan, *rest: (law, memory, replace(plan, jerk=0.0 * plan.jerk), *rest)
        ),
        LOOP,
    ),
    Mutant("memory not handed on in a torque law", NOMINAL, "NominalDynamic.update", forgetful, LOOP),
    Mutant(
        "gains of three integrators swapped", BUILDERS, "chain_gains", on_result(lambda k: k[:, ::-1]), LOOP
    ),
    Mutant(
        "Lyapunov weights of another row",
        BUILDERS,
        "lyapunov_matrix",
        on_result(lambda p: np.roll(p, 1, 1)),
        LOOP,
    ),
    Mutant(
        "dynamic corrective term flipped", ROBUST, "corrective_input", on_result(lambda term: -term), LOOP
    ),
    Mutant(
        "dynamic corrective term left out",
        ROBUST,
        "corrective_input",
        on_result(lambda term: 0.0 * term),
        LOOP,
    ),
    Mutant(
        "dynamic gain halved",
        ROBUST,
        "corrective_input",
        on_arguments(lambda w, rho, layer: (w, rho / 2.0, layer)),
        LOOP,
    ),
    Mutant(
        "dynamic boundary layer doubled",
        ROBUST,
        "corrective_input",
        on_arguments(lambda w, rho, layer: (w, rho, 2.0 * layer)),
        LOOP,
    ),
    Mutant(
        "ρ without μ₁",
        ROBUST,
        "DynamicState",
        lambda original: lambda **state: original(**{**state, "acceleration": 0.0 * state["acceleration"]}),
        LOOP,
    ),
    Mutant(
        "ρ without w",
        ROBUST,
        "DynamicState",
        lambda original: lambda **state: original(**{**state, "yaw_rate": 0.0 * state["yaw_rate"]}),
        LOOP,
    ),
]
