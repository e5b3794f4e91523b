"""Seeded mistakes and who must see them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from slipctl.tick import Array, Decision, Slip
from tests.detectors import figure_eight_on_grip, flat_round_trip, measured_slip, section_five_a, wheels


@dataclass(frozen=True)
class Mutant:
    """A mistake: what it replaces (module and name), by what, and who sees it."""

    name: str
    module: str
    attribute: str
    mistake: Callable[[Any], Any]
    seen_by: tuple[Callable[[], Any], ...]


def on_slip(**factors: float) -> Callable[[Any], Any]:
    """Scale components of the slip that a plant meets."""

    def mistake(original: Any) -> Any:
        def wrong(v: Array, slip: Slip, c: Array, s: Array) -> Any:
            return original(v, replace(slip, **{k: f * getattr(slip, k) for k, f in factors.items()}), c, s)

        return wrong

    return mistake


def on_result(change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda original: lambda *arguments: change(original(*arguments))


def on_arguments(change: Callable[..., tuple[Any, ...]]) -> Callable[[Any], Any]:
    return lambda original: lambda *arguments: original(*change(*arguments))


def twice_the_half_track(original: Any) -> Any:
    return lambda geometry, *rest: original(replace(geometry, half_track=2.0 * geometry.half_track), *rest)


def forgetful(original: Any) -> Any:
    def wrong(law: Any, memory: Any, *rest: Any) -> Decision:
        return replace(original(law, memory, *rest), memory=memory)

    return wrong


LOOP, WHEELED = (section_five_a,), (wheels, figure_eight_on_grip)
ODE, FLAT, ROBUST, BUILDERS = (
    "slipctl.plants.ode",
    "slipctl.control.flat",
    "slipctl.control.robust_kinematic",
    "tests.builders",
)
WHEEL, SLIP = "slipctl.theory.robot", "slipctl.theory.slip"
MUTANTS = [
    Mutant("lateral slip flipped in the plant", ODE, "slipping_velocity", on_slip(lateral=-1.0), LOOP),
    Mutant(
        "longitudinal slip flipped in the plant", ODE, "slipping_velocity", on_slip(longitudinal=-1.0), LOOP
    ),
    Mutant(
        "lateral slip flipped in the measurement",
        SLIP,
        "measure_slip",
        on_result(lambda slip: replace(slip, lateral=-slip.lateral)),
        (measured_slip,),
    ),
    Mutant(
        "yaw slip flipped in the measurement",
        SLIP,
        "measure_slip",
        on_result(lambda slip: replace(slip, yaw=-slip.yaw)),
        (measured_slip,),
    ),
    Mutant(
        "yaw slip in degrees",
        SLIP,
        "Affine.at",
        on_result(lambda slip: replace(slip, yaw=np.degrees(slip.yaw))),
        LOOP,
    ),
    Mutant(
        "track for half-track in the command",
        WHEEL,
        "WheelGeometry.wheel_rates",
        twice_the_half_track,
        WHEELED,
    ),
    Mutant(
        "track for half-track in the measurement",
        WHEEL,
        "WheelGeometry.body_rates",
        twice_the_half_track,
        (wheels,),
    ),
    Mutant(
        "left and right swapped in the command",
        WHEEL,
        "WheelGeometry.wheel_rates",
        on_result(lambda rates: rates[..., ::-1]),
        WHEELED,
    ),
    Mutant(
        "left and right swapped in the measurement",
        WHEEL,
        "WheelGeometry.body_rates",
        on_arguments(lambda geometry, rates: (geometry, rates[..., ::-1])),
        (wheels,),
    ),
    Mutant(
        "diameter for radius",
        WHEEL,
        "WheelGeometry.wheel_rates",
        on_result(lambda rates: rates / 2.0),
        WHEELED,
    ),
    Mutant(
        "yaw rate commanded in degrees",
        FLAT,
        "invert_decoupling",
        on_result(lambda inputs: (inputs[0], np.degrees(inputs[1]))),
        (section_five_a, figure_eight_on_grip),
    ),
    Mutant(
        "headings of the plan in degrees",
        "slipctl.theory.reference",
        "PointToPoint.at",
        on_arguments(lambda plan, times: (replace(plan, start=plan.start * [1, 1, 180.0 / np.pi, 1]), times)),
        LOOP,
    ),
    Mutant("gains halved", BUILDERS, "chain_gains", on_result(lambda gains: gains / 2.0), LOOP),
    Mutant(
        "position gain halved", BUILDERS, "chain_gains", on_result(lambda gains: gains * [0.5, 1.0]), LOOP
    ),
    Mutant("gains swapped", BUILDERS, "chain_gains", on_result(lambda gains: gains[:, ::-1]), LOOP),
    Mutant(
        "boundary layer doubled",
        ROBUST,
        "corrective_input",
        on_arguments(lambda w, rho, e: (w, rho, 2 * e)),
        LOOP,
    ),
    Mutant(
        "robust gain halved",
        ROBUST,
        "corrective_input",
        on_arguments(lambda w, rho, e: (w, rho / 2, e)),
        LOOP,
    ),
    Mutant("corrective term flipped", ROBUST, "corrective_input", on_result(lambda term: -term), LOOP),
    Mutant("corrective term left out", ROBUST, "corrective_input", on_result(lambda term: 0.0 * term), LOOP),
    Mutant("Lyapunov weights swapped", BUILDERS, "lyapunov_matrix", on_result(lambda p: p[::-1]), LOOP),
    Mutant("Lyapunov matrix doubled", BUILDERS, "lyapunov_matrix", on_result(lambda p: 2.0 * p), LOOP),
    Mutant(
        "velocity error left out",
        "slipctl.control.nominal_kinematic",
        "nominal_input",
        on_arguments(lambda reference, e1, e2, *gains: (reference, e1, 0.0 * e2, *gains)),
        LOOP,
    ),
    Mutant(
        "planned acceleration left out",
        "slipctl.control.nominal_kinematic",
        "nominal_input",
        on_arguments(lambda plan, *rest: (replace(plan, acceleration=0.0 * plan.acceleration), *rest)),
        LOOP,
    ),
    Mutant(
        "error desired minus actual",
        "slipctl.control.nominal_kinematic",
        "flat_errors",
        on_result(lambda errors: (-errors[0], -errors[1])),
        (section_five_a, figure_eight_on_grip),
    ),
    Mutant(
        "memory not handed on",
        "slipctl.control.nominal_kinematic",
        "NominalKinematic.update",
        forgetful,
        (section_five_a, figure_eight_on_grip),
    ),
    Mutant(
        "heading by an arc tangent of one argument",
        "slipctl.theory.flatness",
        "np",
        lambda original: _WithoutQuadrants(original),
        (flat_round_trip,),
    ),
]


class _WithoutQuadrants:
    """numpy with (9) as printed."""

    def __init__(self, original: Any):
        self._original = original

    def __getattr__(self, name: str) -> Any:
        if name == "arctan2":
            return lambda y, x: self._original.arctan(y / x)
        return getattr(self._original, name)
