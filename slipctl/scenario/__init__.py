"""The scenario file format: typed, frozen, strict.

`load` finds and reads a file, `worlds` expands its grid, `scenario_id` identifies what it means. Everything
wrong with a file is reported at once, as a `ScenarioError`.
"""

from slipctl.scenario.axes import Axis, Span
from slipctl.scenario.controllers import Controller, NominalKinematic, RobustKinematic
from slipctl.scenario.identity import canonical, dump, scenario_id
from slipctl.scenario.json_schema import json_schema
from slipctl.scenario.loading import World, load, read, worlds
from slipctl.scenario.model import Scenario
from slipctl.scenario.override import override, sweep_over
from slipctl.scenario.problems import Problem, ScenarioError
from slipctl.scenario.references import Circle, FigureEight, Line, PointToPoint, Reference
from slipctl.scenario.slip import ProportionalSlip, SinusoidalSlip, Slip
from slipctl.scenario.tables import Ground, KinematicOde, Mujoco, Plant, Robot, Sensing, Start
from slipctl.scenario.templates import template

__all__ = [
    "Axis",
    "Circle",
    "Controller",
    "FigureEight",
    "Ground",
    "KinematicOde",
    "Line",
    "Mujoco",
    "NominalKinematic",
    "Plant",
    "PointToPoint",
    "Problem",
    "ProportionalSlip",
    "Reference",
    "Robot",
    "RobustKinematic",
    "Scenario",
    "ScenarioError",
    "Sensing",
    "SinusoidalSlip",
    "Slip",
    "Span",
    "Start",
    "World",
    "canonical",
    "dump",
    "json_schema",
    "load",
    "override",
    "read",
    "scenario_id",
    "sweep_over",
    "template",
    "worlds",
]
