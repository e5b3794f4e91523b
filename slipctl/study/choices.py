"""What the paper leaves open, one choice at a time: Φ, the start, the tick and what the law gets to see."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from slipctl import scenario as files
from slipctl.experiment import assemble
from slipctl.study.runs import StudyRun, closed_loop, controller_tables, edited, medians, run_all
from slipctl.study.sections import DYNAMIC, KINEMATIC, shortened
from slipctl.theory.robust import chain_gains, largest_calm_tick, lyapunov_matrix
from slipctl.tick import Start

TICKS = (0.001, 0.005, 0.01, 0.02, 0.05)
"""Control periods to compare [s]; quick studies take the two longest."""

STIFF_POLE = -4.0
"""Pole of the retuned linear law [1/s]."""

SEEDS = 20
"""How many seeds of the noise."""

NOISE = {
    "sensing.position_noise": 0.001,
    "sensing.heading_noise_deg": math.degrees(0.003),
    "sensing.velocity_noise": 0.005,
}
"""Noise under which laws are compared: 1 mm, 3 mrad, 5 mm/s (assumed; a good overhead camera and filter)."""

Rows = list[dict[str, Any]]
Sections = Mapping[str, Mapping[str, StudyRun]]


def ticks_of(quick: bool) -> tuple[float, ...]:
    """Return the control periods to compare."""
    return TICKS[-2:] if quick else TICKS


def tick_lengths(quick: bool) -> Rows:
    """Vary the control period: nominal, robust (59), discontinuous (47) and the retuned linear law."""
    scenario = files.load(KINEMATIC)
    nominal, robust = list(controller_tables(scenario).values())[:2]
    laws = [
        {**nominal, "label": "nominal"},
        {**robust, "label": "robust"},
        {**robust, "label": "discontinuous", "boundary_layer": 0.0},
        {**nominal, "label": "linear", "pole": STIFF_POLE},
    ]
    rows = []
    for tick in ticks_of(quick):
        runs = run_all(shortened(edited(scenario, {"tick": tick}, laws), quick))
        calm = calm_ticks(runs["robust"], float(robust["boundary_layer"]), float(robust["pole"]))
        rows += [{"tick": tick, "law": label, **run.summary(), **calm} for label, run in runs.items()]
    return rows


def calm_ticks(run: StudyRun, boundary_layer: float, pole: float) -> dict[str, float]:
    """Return the tick above which a boundary layer chatters [s]: of the whole run, and after its first half.

    After the beginning, where the error is outside the layer, only the second number counts.
    """
    corner = lyapunov_matrix(chain_gains(np.array([pole]), 2)[0])[1, 1]
    gain = run["decision.robust_gain"]
    sigma = (run["slip.longitudinal"] - 1j * run["slip.lateral"]) / run["motion.forward_speed"]
    largest = largest_calm_tick(np.full_like(gain, boundary_layer), gain, np.full_like(gain, corner), sigma)
    return {"calm_tick": float(largest.min()), "late_calm_tick": float(largest[len(largest) // 2 :].min())}


def dynamic_ticks(quick: bool) -> Rows:
    """Vary the control period of the dynamic laws."""
    scenario = files.load(DYNAMIC)
    nominal, robust = list(controller_tables(scenario).values())[:2]
    laws = [{**nominal, "label": "nominal"}, {**robust, "label": "robust"}]
    rows = []
    for tick in ticks_of(quick):
        runs = run_all(shortened(edited(scenario, {"tick": tick}, laws), quick))
        rows += [{"tick": tick, "law": label, **run.summary()} for label, run in runs.items()]
    return rows


def starts(quick: bool, sections: Sections) -> Rows:
    """Start at the planned state with slip already acting, and at the state whose slipping motion fits."""
    rows = []
    for name, runs in own_laws(sections).items():
        matched = closed_loop(own(name, quick), start=matched_start(own(name, quick)))
        for kind, found in (("planned", runs), ("matched", matched)):
            rows += [
                {"scenario": name, "start": kind, "law": run.label, **run.summary()} for run in found.values()
            ]
    return rows


def own(name: str, quick: bool) -> files.Scenario:
    """Return a shipped scenario as the sections run it, its laws labelled `nominal` and `robust`."""
    scenario = files.load(name)
    tables = zip(("nominal", "robust"), controller_tables(scenario).values(), strict=True)
    return shortened(edited(scenario, {}, [{**table, "label": label} for label, table in tables]), quick)


def own_laws(sections: Sections) -> dict[str, dict[str, StudyRun]]:
    """Return the runs of the laws that the shipped scenarios list, by scenario."""
    found = {}
    for name, section, robust in ((KINEMATIC, "kinematic", "paper"), (DYNAMIC, "dynamic", "proportional")):
        runs = sections[section]
        found[name] = {
            label: replace(runs[key], label=label)
            for label, key in (("nominal", "nominal"), ("robust", robust))
        }
    return found


def matched_start(scenario: files.Scenario) -> Start:
    """Return the start from which Ḟ and F̈ are the planned ones under proportional slip.

    With σ = α_t − iα_s constant, Ḟ = v(1+σ)e^{iθ}: the speed is divided by |1+σ| and the heading turned back
    by arg(1+σ); the yaw rate is less by what the slip turns.
    """
    worlds = files.worlds(scenario)
    planned = assemble.references(worlds)
    start = assemble.start(worlds, planned)
    slip = scenario.slip
    if slip is None or slip.kind != "proportional":
        raise ValueError("only proportional slip has a matched start")
    ratio = complex(1.0 + slip.longitudinal, -slip.lateral)
    speed = start.forward_speed / abs(ratio)
    heading = start.heading - math.atan2(ratio.imag, ratio.real)
    acceleration = planned.acceleration[0]
    return Start(
        position=start.position,
        heading=heading,
        forward_speed=speed,
        yaw_rate=start.yaw_rate - slip.yaw * speed,
        forward_acceleration=np.cos(heading) * acceleration[:, 0] + np.sin(heading) * acceleration[:, 1],
    )


def feedback(quick: bool, sections: Sections) -> Rows:
    """Let the laws see the true velocity or the odometry's, the true acceleration or the model's."""
    worse = {KINEMATIC: ("velocity", "odometry"), DYNAMIC: ("acceleration", "model")}
    rows = []
    for name, runs in own_laws(sections).items():
        key, source = worse[name]
        blind = run_all(edited(own(name, quick), {f"sensing.{key}": source}))
        for kind, found in (("true", runs), (source, blind)):
            rows += [
                {"scenario": name, "signal": key, "source": kind, "law": run.label, **run.summary()}
                for run in found.values()
            ]
    return rows


def higher_gains(quick: bool) -> Rows:
    """Hold the robust law against a linear law with faster poles, at equal tick, noise and start."""
    base = files.load(KINEMATIC)
    nominal, robust = list(controller_tables(base).values())[:2]
    laws = [{**robust, "label": "robust"}, {**nominal, "label": "linear", "pole": STIFF_POLE}]
    rows = []
    for tick in (0.01, 0.02):
        scenario = shortened(edited(base, {"tick": tick}, laws), quick)
        for kind, start in (("planned", None), ("matched", matched_start(scenario))):
            rows += [
                {"tick": tick, "start": kind, "noise": False, "law": label, **run.summary()}
                for label, run in closed_loop(scenario, start=start).items()
            ]
        noisy = edited(scenario, NOISE)
        for label, metrics in medians(noisy, range(1, (2 if quick else SEEDS) + 1)).items():
            numbers = {
                "rms_mm": 1e3 * metrics["rms_position_error"],
                "max_mm": 1e3 * metrics["max_position_error"],
                "final_mm": 1e3 * metrics["final_position_error"],
                "variation": metrics["command_variation"],
            }
            rows.append({"tick": tick, "start": "planned", "noise": True, "law": label, **numbers})
    return rows


def linear_bounds(run: StudyRun, ratio: complex, yaw_fraction: float) -> list[dict[str, float]]:
    """Return the ultimate bound on the position error of a *linear* law, for both poles.

    Whatever the gains, e₁ obeys ë₁ + 2pė₁ + p²e₁ = η with η = σv + (1+σ)i v w_s E for constant σ. The map
    from η to v̂ has peak gain 1.2707 for a double pole, so sup‖η‖ ≤ (q sup‖F̈_d‖ + g)/(1 − 1.2707 q), and
    sup‖e₁‖ ≤ sup‖η‖/p²: uniformly ultimately bounded for |σ| < 0.787, with any gains (derived).

    Parameters
    ----------
    run : StudyRun
        Its reference and speeds are used.
    ratio : complex
        σ [1].
    yaw_fraction : float
        w_s/v [rad/m].
    """
    acceleration = run.pair("reference.acceleration")
    push = float(np.sqrt((acceleration**2).sum(axis=1)).max())
    slip_ratio = abs(ratio)
    turn = abs(1.0 + ratio) * yaw_fraction * float((run["motion.forward_speed"] ** 2).max())
    uncertainty = (slip_ratio * push + turn) / (1.0 - 1.2707 * slip_ratio)
    return [{"pole": pole, "bound_mm": 1e3 * uncertainty / pole**2} for pole in (-0.5, STIFF_POLE)]
