"""The runs behind the figures: Sections V-A, V-B and VI as the shipped scenarios state them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from slipctl import scenario as files
from slipctl.study.runs import StudyRun, controller_tables, edited, run_all
from slipctl.study.targets import TARGETS

KINEMATIC, DYNAMIC, EXPERIMENT = "paper-kinematic", "paper-dynamic", "paper-experiment"

QUICK_DURATION = 0.4
"""Length of every run of a quick study [s]: enough to see that all parts work."""

Section = dict[str, StudyRun]


def shortened(scenario: files.Scenario, quick: bool) -> files.Scenario:
    """Return the scenario, cut short where the study is quick."""
    return edited(scenario, {"duration": QUICK_DURATION}) if quick else scenario


def with_bounds(scenario: files.Scenario, bounds: tuple[str, ...]) -> files.Scenario:
    """Return the scenario with its first law and one robust law per bound ρ, labelled by the bound."""
    nominal, robust = list(controller_tables(scenario).values())[:2]
    laws = [{**nominal, "label": "nominal"}]
    laws += [{**robust, "label": bound, "uncertainty": bound} for bound in bounds]
    return edited(scenario, {}, laws)


def kinematic(quick: bool) -> Section:
    """Run Section V-A with every form of ρ."""
    scenario = with_bounds(files.load(KINEMATIC), ("paper", "independent", "slip_ratio"))
    return run_all(shortened(scenario, quick))


def dynamic(quick: bool) -> Section:
    """Run Section V-B with the paper's and the rigorous ρ."""
    scenario = with_bounds(files.load(DYNAMIC), ("paper", "proportional"))
    return run_all(shortened(scenario, quick))


def experiment(quick: bool) -> Section:
    """Run Section VI once, with the shipped seed; the laws are labelled `nominal` and `robust`."""
    scenario = files.load(EXPERIMENT)
    laws = zip(("nominal", "robust"), controller_tables(scenario).values(), strict=False)
    scenario = edited(scenario, {}, [{**table, "label": label} for label, table in laws])
    return run_all(shortened(scenario, quick))


def measured(run: StudyRun) -> dict[str, float]:
    """Return what the targets speak of, in their units.

    A run too short for a number, such as what happens after 5 s, leaves it out.
    """
    gap = run.pair("motion.position") - run.pair("reference.position")
    numbers = {
        "max_x": 1e3 * float(np.abs(gap[:, 0]).max()),
        "max_y": 1e3 * float(np.abs(gap[:, 1]).max()),
        "max": 1e3 * run.metric("max_position_error"),
        "rms": 1e3 * run.metric("rms_position_error"),
        "final": 1e3 * run.metric("final_position_error"),
        "min_speed": run.metric("min_forward_speed"),
        "heading_offset": float(run["error.heading"][-1]),
        "first_slip": float(run["slip.longitudinal"][0]),
        "least_slip": float(run["slip.longitudinal"].min()),
        "max_nominal_input": float(length(run, "decision.nominal_input").max()),
        "max_robust_input": float(length(run, "decision.robust_input").max()),
    }
    late = run["time"] >= 5.0
    if late.any():
        numbers["late_robust_input"] = float(length(run, "decision.robust_input")[late].max())
        numbers["late_max"] = 1e3 * float(run["error.position"][late].max())
    if "wheel.torque_command.left" in run.columns:
        sides = [np.abs(run[f"wheel.torque_command.{side}"]).max() for side in ("left", "right")]
        numbers["max_torque"] = float(max(sides))
    return numbers


def length(run: StudyRun, column: str) -> np.ndarray:
    """Return the length of a vector column, (T + 1,)."""
    pair = run.pair(column)
    return np.sqrt(pair[:, 0] ** 2 + pair[:, 1] ** 2)


def compare(sections: Mapping[str, Section]) -> list[dict[str, Any]]:
    """Return every target beside what was measured, in the order of the targets.

    A number that a run is too short for is None; a target whose run is missing is left out.
    """
    rows = []
    for target in TARGETS:
        section, label = target.case.split("/")
        if label not in sections.get(section, {}):
            continue
        value = measured(sections[section][label]).get(target.quantity)
        rows.append(
            {
                "case": target.case,
                "quantity": target.quantity,
                "unit": target.unit,
                "target": target.value,
                "source": target.source,
                "measured": value,
                "upper": target.upper,
                "met": None if value is None else target.met(value),
            }
        )
    return rows
