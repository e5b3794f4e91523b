"""The scenario file format: typed, frozen, strict.

`load` finds and reads a file, `worlds` expands its grid, `scenario_id` identifies what it means. Everything
wrong with a file is reported at once, as a `ScenarioError`.
"""

from slipctl.scenario.axes import Axis, Span
from slipctl.scenario.controllers import (
    Believes,
    Controller,
    NominalDynamic,
    NominalKinematic,
    RobustDynamic,
    RobustKinematic,
)
from slipctl.scenario.expand import Grid, World, given, reread, worlds
from slipctl.scenario.expect import Below, BelowBound, Better, Claim, Guarantee, StatusIs
from slipctl.scenario.floor import Bumps, Change, Disc, Disturbance, Patch, Rectangle, Stripes, Terrain, Waves
from slipctl.scenario.identity import canonical, dump, scenario_id
from slipctl.scenario.json_schema import json_schema
from slipctl.scenario.loading import load, read
from slipctl.scenario.model import Scenario
from slipctl.scenario.override import override, sweep_over
from slipctl.scenario.own_robot import is_path
from slipctl.scenario.problems import Problem, ScenarioError
from slipctl.scenario.references import Circle, FigureEight, Line, PointToPoint, Reference
from slipctl.scenario.sensing import Sensing
from slipctl.scenario.series import Series, SeriesError
from slipctl.scenario.slip import ProportionalSlip, SeriesSlip, SinusoidalSlip, Slip
from slipctl.scenario.tables import DynamicOde, Ground, KinematicOde, Mujoco, Plant, Robot, Start
from slipctl.scenario.templates import template

__all__ = [
    "Axis",
    "Believes",
    "Below",
    "BelowBound",
    "Better",
    "Bumps",
    "Change",
    "Circle",
    "Claim",
    "Controller",
    "Disc",
    "Disturbance",
    "DynamicOde",
    "FigureEight",
    "Grid",
    "Ground",
    "Guarantee",
    "KinematicOde",
    "Line",
    "Mujoco",
    "NominalDynamic",
    "NominalKinematic",
    "Patch",
    "Plant",
    "PointToPoint",
    "Problem",
    "ProportionalSlip",
    "Rectangle",
    "Reference",
    "Robot",
    "RobustDynamic",
    "RobustKinematic",
    "Scenario",
    "ScenarioError",
    "Sensing",
    "Series",
    "SeriesError",
    "SeriesSlip",
    "SinusoidalSlip",
    "Slip",
    "Span",
    "Start",
    "StatusIs",
    "Stripes",
    "Terrain",
    "Waves",
    "World",
    "canonical",
    "dump",
    "given",
    "is_path",
    "json_schema",
    "load",
    "override",
    "read",
    "reread",
    "scenario_id",
    "sweep_over",
    "template",
    "worlds",
]
