"""The fixtures on models that are right, and on models spoilt one way at a time."""

import functools
import re
from pathlib import Path

import pytest

from slipctl.certify.fixture import Bench, Check
from slipctl.certify.fixtures import FIXTURES
from slipctl.plants.model import find_model

NAMED = {fixture.name: fixture for fixture in FIXTURES}
SHIPPED = find_model("magellan_pro")


@functools.cache
def shipped_bench() -> Bench:
    return Bench(SHIPPED, 0.001)


def tried(folder, edits, *names) -> dict[str, Check]:
    """Checks of the shipped robot with edits to its file."""
    text = SHIPPED.read_text(encoding="utf-8")
    for old, new in edits:
        text, count = re.subn(old, new, text)
        assert count, old
    path = folder / "spoilt.xml"
    path.write_text(text, encoding="utf-8")
    bench = Bench(path, 0.001)
    return {name: NAMED[name].check(bench) for name in names}


def published() -> dict[str, float]:
    """What the table of docs/physics.md says was measured."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "physics.md").read_text(encoding="utf-8")
    table = page.split("<!-- certificate")[1].split("<!-- end of certificate")[0]
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines() if line[:1] == "|"
    ]
    return {row[0]: float(row[2].split()[0]) for row in rows[2:]}


@pytest.mark.parametrize("name", NAMED)
def test_the_shipped_robot_passes_as_the_page_says(name):
    check = NAMED[name].check(shipped_bench())
    assert check.passed, check
    assert check.reason == ""
    assert check.measured is not None
    rounding = 1e-4 * abs(check.measured) + (0.0 if check.relative else 0.05 * check.tolerance)
    assert check.measured == pytest.approx(published()[name.replace("_", " ")], abs=rounding + 1e-9)


def test_the_page_has_every_fixture_and_small_pictures():
    assert list(published()) == [name.replace("_", " ") for name in NAMED]
    figures = Path(__file__).resolve().parents[2] / "docs" / "figures"
    pictures = sorted(figures.glob("trap-*.png"))
    assert [picture.stem for picture in pictures] == ["trap-cone", "trap-curves", "trap-hopping"]
    assert all(picture.stat().st_size <= 60_000 for picture in pictures)


def test_tolerances_are_those_that_were_promised():
    promised = {
        "sliding_deceleration_longitudinal": 1e-3,
        "sliding_deceleration_lateral": 1e-3,
        "sliding_deceleration_45_deg": 1e-3,
        "sliding_isotropy": 5e-3,
        "break_away_longitudinal": 3e-3,
        "break_away_lateral": 3e-3,
        "creep_at_0.9_of_threshold": 0.01,
        "traction_at_1.2_of_limit": 5e-3,
        "traction_at_2_of_limit": 5e-3,
        "lateral_limit": 0.01,
        "airborne_steps_friction_0.2": 0.0,
        "airborne_steps_friction_0.7": 0.0,
        "slip_on_the_papers_path": 0.03,
        "film_constant": 1e-3,
        "creep_law_uphill": 0.02,
        "creep_law_across": 0.02,
        "belt_tracking_slip_0.1": 0.02,
        "belt_tracking_slip_0.4": 0.02,
    }
    assert {name: NAMED[name].tolerance for name in promised} == promised
    absolute = {"creep_at_0.9_of_threshold", "slip_on_the_papers_path"}
    absolute |= {name for name in promised if name.startswith("airborne")}
    assert {name for name in promised if not NAMED[name].relative} == absolute


@pytest.mark.parametrize(
    ("edits", "failing", "passing"),
    [
        # the pyramidal cone
        (
            [
                ('cone="elliptic"', 'cone="pyramidal"'),
                ('impratio="1e6"', 'impratio="1"'),
                ('friction="0.8 0.8', 'friction="0.2 0.2'),
                # a pyramid is stiffer by 1/(2μ²): the same tyre needs other numbers
                ("-10807.6704 -83.167957", "-864.613632 -23.5234505"),
            ],
            ["sliding_isotropy", "sliding_deceleration_45_deg"],
            ["mass"],
        ),
        # little impratio: stick creeps
        ([('impratio="1e6"', 'impratio="1"')], ["creep_at_0.9_of_threshold"], ["mass", "rolling_radius"]),
        # a stiff tyre: default solref and solimp
        (
            [
                (
                    r'solref="-10807[^"]*" solimp="[^"]*"\s*solreffriction="-1e-9 -1.6"',
                    'solreffriction="-1e-9 -760"',
                )
            ],
            ["airborne_steps_friction_0.2", "airborne_steps_friction_0.7", "load_chatter_friction_0.2"],
            ["mass", "yaw_inertia"],
        ),
        # friction that takes slip away slowly: curves cost slip, and only that
        (
            [('solreffriction="-1e-9 -1.6"', 'solreffriction="-1e-9 -0.2"')],
            ["slip_on_the_papers_path"],
            ["curve_slip_floor", "airborne_steps_friction_0.7"],
        ),
        # wheels of cylinders, which touch at two points and scrub
        (
            [
                (
                    '<geom type="sphere" size="0.082857084"',
                    '<geom type="cylinder" zaxis="0 1 0" size="0.082857084 0.02"',
                )
            ],
            ["curve_slip_floor"],
            ["mass"],
        ),
        # a caster that brakes
        (
            [('<pair condim="1"', '<pair condim="3" friction="0.3 0.3 0.005 0.0001 0.0001"')],
            ["sliding_deceleration_longitudinal", "sliding_deceleration_lateral", "lateral_limit"],
            ["mass"],
        ),
        # one axle drags: left and right are not alike
        ([('<joint name="left_axle"', '<joint damping="2" name="left_axle"')], ["mirror_symmetry"], ["mass"]),
    ],
    ids=["pyramid", "impratio", "stiff", "soft_friction", "cylinders", "braking_caster", "lame"],
)
def test_a_spoilt_robot_fails_where_it_should(tmp_path, edits, failing, passing):
    checks = tried(tmp_path, edits, *failing, *passing)
    for name in failing:
        assert not checks[name].passed, checks[name]
        assert checks[name].measured is not None
        assert len(checks[name].reason) > 20
    for name in passing:
        assert checks[name].passed, checks[name]


def test_a_base_that_is_fixed_fails_with_the_reason(tmp_path):
    checks = tried(tmp_path, [('<freejoint name="base"/>', "")], "mass", "slip_on_the_papers_path")
    for check in checks.values():
        assert not check.passed
        assert "free" in check.reason
        assert check.measured is None


def test_the_naive_robot_fails_with_readable_reasons():
    bench = Bench(find_model("naive_magellan"), 0.001)
    wrong = {
        "sliding_isotropy": "elliptic",
        "airborne_steps_friction_0.2": "hops",
        "airborne_steps_friction_0.7": "hops",
        "creep_at_0.9_of_threshold": "impratio",
        "slip_on_the_papers_path": "scrub",
        "film_constant": "solreffriction",
    }
    for name, word in wrong.items():
        check = NAMED[name].check(bench)
        assert not check.passed, check
        assert word in check.reason
    # its body is that of the shipped robot
    for name in ("mass", "yaw_inertia", "centre_of_mass_height"):
        assert NAMED[name].check(bench).measured == pytest.approx(NAMED[name].check(shipped_bench()).measured)


def test_airborne_steps_count_both_directions_of_the_naive_robot():
    check = NAMED["airborne_steps_friction_0.2"].check(Bench(find_model("naive_magellan"), 0.001))
    assert check.measured is not None
    assert 1500 < check.measured <= 3000
