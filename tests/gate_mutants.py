"""Seeded mistakes in physics, laws, loop, metrics and theory, and the shipped scenario that must show it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np


@dataclass(frozen=True)
class GateMutant:
    """A mistake: what it replaces (module and name), by what, and in which scenario the gate must see it."""

    name: str
    scenario: str
    module: str
    attribute: str
    mistake: Callable[[Any], Any]


def on_result(change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda original: lambda *arguments, **named: change(original(*arguments, **named))


def on_arguments(change: Callable[..., tuple[Any, ...]]) -> Callable[[Any], Any]:
    return lambda original: lambda *arguments: original(*change(*arguments))


def on_slip(**factors: float) -> Callable[[Any], Any]:
    """Scale components of the slip that the plant meets: the second argument."""

    def change(speed: Any, slip: Any, *rest: Any) -> tuple[Any, ...]:
        return speed, replace(slip, **{key: f * getattr(slip, key) for key, f in factors.items()}), *rest

    return on_arguments(change)


def on_columns(change: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[Any], Any]:
    return on_result(lambda columns: columns | change(columns))


def on_metrics(change: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[Any], Any]:
    return on_result(lambda worlds: [metrics | change(metrics) for metrics in worlds])


def on_model(change: Callable[[Any], None]) -> Callable[[Any], Any]:
    """Change the compiled model of the engine."""

    def changed(model: Any) -> Any:
        change(model)
        return model

    return on_result(changed)


def weaker_servos(model: Any) -> None:
    model.actuator_gainprm[:, 0] *= 0.5
    model.actuator_biasprm[:, 2] *= 0.5


def impratio_one(original: Any) -> Any:
    def wrong(batch: Any, *rest: Any) -> None:
        original(batch, *rest)
        batch.expand("opt.impratio")[...] = 1.0

    return wrong


class _Late:
    """A plant that obeys each command a tick late."""

    def __init__(self, plant: Any):
        self._plant, self._last = plant, None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)

    def step(self, state: Any, command: Any, tick: float) -> Any:
        obeyed, self._last = self._last or command, command
        return self._plant.step(state, obeyed, tick)


def late(original: Any) -> Any:
    return lambda plant, *rest: original(_Late(plant), *rest)


def with_more_floor(original: Any) -> Any:
    return lambda **limits: original(**{**limits, "speed_floor": 2.0 * limits["speed_floor"]})


LAWS, ROBUST = "slipctl.experiment.assemble.laws", "slipctl.control.robust_kinematic"
NOMINAL, FLAT = "slipctl.control.nominal_kinematic", "slipctl.control.flat"
ENGINE, BATCH, ODE = "slipctl.plants.mujoco", "slipctl.experiment.batch", "slipctl.plants.ode"
WHEEL = "slipctl.theory.robot"
CREEP, LAB, REST, BELT = "tyre-creep", "paper-experiment", "rest-to-rest", "belt"

MUTANTS = [
    GateMutant("5 % of a gain lost", CREEP, LAWS, "chain_gains", on_result(lambda k: k * [0.95, 1.0])),
    GateMutant("5 % of the damping lost", CREEP, LAWS, "chain_gains", on_result(lambda k: k * [1.0, 0.95])),
    GateMutant("lateral slip flipped", REST, ODE, "slipping_velocity", on_slip(lateral=-1.0)),
    GateMutant("yaw slip of the plant 5 % larger", REST, "slipctl.theory.slip", "Affine.at",
               on_result(lambda slip: replace(slip, yaw=1.05 * slip.yaw))),
    GateMutant("lateral slip of the belt flipped", BELT, ENGINE, "floor_motion",
               on_arguments(lambda slip, *rest: (replace(slip, lateral=-slip.lateral), *rest))),
    GateMutant("half-track for track", CREEP, WHEEL, "WheelGeometry.wheel_rates",
               on_arguments(lambda g, *rest: (replace(g, half_track=g.half_track / 2.0), *rest))),
    GateMutant("track for half-track in odometry", LAB, WHEEL, "WheelGeometry.body_rates",
               on_arguments(lambda g, rates: (replace(g, half_track=2.0 * g.half_track), rates))),
    GateMutant("boundary layer doubled", CREEP, ROBUST, "corrective_input",
               on_arguments(lambda w, rho, layer: (w, rho, 2.0 * layer))),
    GateMutant("corrective term left out", CREEP, ROBUST, "corrective_input", on_result(lambda dv: 0.0 * dv)),
    GateMutant("impratio 1", BELT, ENGINE, "lay", impratio_one),
    GateMutant("tyres 5 % softer", CREEP, ENGINE, "viscosity", on_result(lambda c: 0.95 * c)),
    GateMutant("wheel servos half as stiff", CREEP, ENGINE, "compile_model", on_model(weaker_servos)),
    GateMutant("command obeyed a tick late", CREEP, BATCH, "simulate", late),
    GateMutant("planned acceleration left out", CREEP, NOMINAL, "nominal_input",
               on_arguments(lambda p, *rest: (replace(p, acceleration=0.0 * p.acceleration), *rest))),
    GateMutant("velocity error left out", LAB, NOMINAL, "nominal_input",
               on_arguments(lambda p, e1, e2, *gains: (p, e1, 0.0 * e2, *gains))),
    GateMutant("weight of the velocity error halved", CREEP, LAWS, "lyapunov_matrix",
               on_result(lambda p: p * [[1.0, 1.0], [1.0, 0.5]])),
    GateMutant("robust gain without its slip terms", CREEP, "slipctl.theory.robust", "_small_gain",
               lambda original: lambda k, a, _, nominal: k * a * nominal / (1.0 - k * a)),
    GateMutant("yaw rate 2 % short", CREEP, FLAT, "invert_decoupling",
               on_result(lambda inputs: (inputs[0], 0.98 * inputs[1]))),
    GateMutant("speed floor doubled", LAB, LAWS, "DriveLimits", with_more_floor),
    GateMutant("real velocity for that in path time", REST, "slipctl.control.time_scaled", "path_velocity",
               on_arguments(lambda v, h, rate, *rest: (v, h, np.ones_like(rate), *rest))),
    GateMutant("heading error not wrapped", CREEP, BATCH, "with_errors",
               on_columns(lambda c: {"error.heading": c["motion.heading"] - c["reference.heading"]})),
    GateMutant("distance for cross-track error", CREEP, BATCH, "with_errors",
               on_columns(lambda c: {"error.cross_track": c["error.position"]})),
    GateMutant("largest for final error", CREEP, BATCH, "measure_worlds",
               on_metrics(lambda m: {"final_position_error": m["max_position_error"]})),
    GateMutant("command variation in degrees", LAB, BATCH, "measure_worlds",
               on_metrics(lambda m: {"command_variation": np.degrees(m["command_variation"])})),
    GateMutant("guarantee demands a speed of 1 m/s", CREEP, "slipctl.guarantee.evaluate", "demands",
               on_arguments(lambda c, h, *rest: (c, replace(h, speed_floor=h.speed_floor + 1.0), *rest))),
]  # fmt: skip
