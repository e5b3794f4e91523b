"""The units of keys, as tables say them."""

import pytest

from slipctl.scenario import load
from slipctl.scenario.units import key_unit


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("ground.friction", "1"),
        ("ground.slope_deg", "deg"),
        ("reference.speed", "m/s"),
        ("tick", "s"),
        ("seed", "1"),
        ("controller.robust_kinematic.pole", "1/s"),
        ("controller.*.believes.wheel_radius", "m"),
    ],
)
def test_a_key_has_its_unit(key, unit):
    assert key_unit(load("friction-sweep"), key) == unit
