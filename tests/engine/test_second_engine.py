"""MuJoCo against PyBullet: within 10 % where both model the same contact, and the reasons where not."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="the second engine is an extra: pip install 'slipctl[engine]'")

from slipctl.theory.slip import measure_slip
from tests.engine.bullet import Bullet
from tests.engine.compare import Statistics, Track, in_bullet, in_mujoco
from tests.engine.drives import DRIVES, TICK, Drive, circle, grip_limit, locked, weave
from tests.engine.fixtures import Fixture, fixtures, measured
from tests.engine.page import BEGIN, END, LEAST, REASONS, SLIPS, TURNED, renewed, replayed, tables
from tests.engine.planar import planar
from tests.engine.robot import Robot, magellan_pro

PAGE = Path(__file__).parents[2] / "docs" / "second-engine.md"
BY_NAME = {drive.name: drive for drive in DRIVES}
Tracks = dict[str, tuple[Track, Track]]


@pytest.fixture(scope="module")
def robot() -> Robot:
    return magellan_pro()


@pytest.fixture(scope="module")
def tracks(robot: Robot) -> Tracks:
    return replayed(robot)


def rms(track: Track, slip: str) -> float:
    return Statistics.of(getattr(track, slip)).rms


def test_both_engines_hold_the_same_robot(robot: Robot) -> None:
    """At rest both stand alike: loads, and the wheels' share of the weight."""
    with Bullet(robot, 0.8) as world:
        world.start(0.0, np.zeros(2), 0.0, np.zeros(2))
        world.step(np.zeros(2), 500)
        load = world.load()
    assert robot.mass == pytest.approx(18.2)
    assert robot.yaw_inertia == pytest.approx(0.39375)
    assert robot.com_height == pytest.approx(0.10, rel=1e-3)
    assert load == pytest.approx([robot.tyre.load, robot.tyre.load, 2.0 * robot.caster.load], rel=1e-4)
    assert load[:2].sum() == pytest.approx(0.8 * 18.2 * 9.81, rel=1e-3)


@pytest.mark.parametrize("fixture", fixtures(), ids=lambda fixture: fixture.name)
def test_friction_alone_gives_both_engines_the_same_acceleration(fixture: Fixture, robot: Robot) -> None:
    """The issue asks for 10 %; both are far nearer, to each other and to the closed form."""
    mujoco, bullet = measured(fixture, robot)
    assert bullet == pytest.approx(mujoco, rel=0.015)
    if fixture.closed_form is not None:
        assert mujoco == pytest.approx(fixture.closed_form, rel=0.006)
        assert bullet == pytest.approx(fixture.closed_form, rel=0.015)


def test_slip_is_the_same_where_the_contact_is(tracks: Tracks) -> None:
    compared = 0
    for name, (mujoco, bullet) in tracks.items():
        for slip in SLIPS:
            if REASONS[name].get(slip, "").startswith("same") and rms(mujoco, slip) > LEAST:
                assert rms(bullet, slip) == pytest.approx(rms(mujoco, slip), rel=0.10), (name, slip)
                compared += 1
    assert compared == 7


def test_every_difference_on_the_page_has_a_reason(tracks: Tracks) -> None:
    for name, (mujoco, bullet) in tracks.items():
        for slip in SLIPS:
            if max(rms(mujoco, slip), rms(bullet, slip)) > LEAST:
                assert REASONS[name][slip]


@pytest.mark.parametrize("timestep", [0.001, 0.0005])
def test_reason_a_curves_cost_lateral_slip_in_proportion_to_each_engine_s_lag(
    robot: Robot, timestep: float
) -> None:
    """v·w over MuJoCo's b_t of 800 per second, and v·w times Bullet's step."""
    drive = weave("", 0.8, 0.5, 0.1)
    turning = 0.1 * grip_limit(0.8) / math.sqrt(2.0)  # rms of v·w
    assert rms(in_mujoco(drive, timestep), "lateral") == pytest.approx(turning / 800.0, rel=0.01)
    assert rms(in_bullet(robot, drive, timestep), "lateral") == pytest.approx(turning * timestep, rel=0.01)


def test_reason_b_mujoco_s_tyre_flattens_under_load(robot: Robot) -> None:
    """The contact in the middle of the overlap changes the rolling radii of a leaning robot by ΔN/2K."""
    drive = circle("", 0.3, 1.0, 0.8)
    shift = robot.mass * 0.8 * grip_limit(0.3) * robot.com_height / (2.0 * robot.half_track)
    flatter = shift / (2.0 * robot.tyre.stiffness)
    yaw_slip = flatter / robot.wheel_radius / robot.half_track
    mujoco, bullet = (track.after(1.0) for track in (in_mujoco(drive, 0.00025), in_bullet(robot, drive)))
    assert mujoco.yaw.mean() == pytest.approx(-yaw_slip, rel=0.06)
    assert abs(bullet.yaw).max() < 0.01 * yaw_slip


def test_reason_c_a_dash_slips_by_the_body_s_pitching(robot: Robot) -> None:
    """A wheel's rate is measured against the body, so a pitching body seems to slip at r times its rate."""
    drive = BY_NAME["dash, 0.9 of the grip"]
    seen = []
    with Bullet(robot, drive.friction) as world:
        world.start(0.0, np.zeros(2), 0.0, np.zeros(2))
        for wheel_rate in drive.wheel_rate:
            world.step(wheel_rate, 10)
            slip = measure_slip(world.observe()).longitudinal[0]
            seen.append((slip, robot.wheel_radius * world.pitch_rate()))
    slips, pitching = np.array(seen).T
    assert abs(slips).max() > 0.01
    assert slips == pytest.approx(pitching, abs=1e-7)


@pytest.mark.parametrize(("like_bullet", "ratio"), [(False, 1.0), (True, None)])
def test_reason_d_friction_points_elsewhere_in_bullet(
    robot: Robot, like_bullet: bool, ratio: float | None
) -> None:
    """Heading along the friction directions, a locked wheel yields twelve times as easily along as across."""
    drive = locked("", 0.2, 45.0)
    track = in_bullet(robot, drive) if like_bullet else in_mujoco(drive)
    lost, velocity = track.acceleration(0.05, 0.15), track.velocity[round(0.1 / TICK) - 1]
    expected = ratio or robot.inverse_mass[0] / robot.inverse_mass[1]
    assert expected > 10.0 or not like_bullet
    assert (lost[1] / lost[0]) / (velocity[1] / velocity[0]) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", [name for name, reasons in REASONS.items() if reasons is TURNED])
def test_reason_d_explains_both_engines(robot: Robot, tracks: Tracks, name: str) -> None:
    """A model of three freedoms gives MuJoCo's slip with one rule and Bullet's with the other."""
    for track, like_bullet in zip(tracks[name], (False, True), strict=True):
        reckoned = planar(robot, BY_NAME[name], like_bullet)
        for slip in ("longitudinal", "lateral"):
            assert rms(reckoned, slip) == pytest.approx(rms(track, slip), rel=0.10), (like_bullet, slip)


def test_bullet_s_pyramid_is_no_fairer(robot: Robot) -> None:
    """Two fifths too strong at 45°, which is why the page's runs use the cone."""
    drive: Drive = locked("", 0.3, 45.0)
    cone, pyramid = (in_bullet(robot, drive, cone=cone).steepest() for cone in (True, False))
    assert cone == pytest.approx(grip_limit(0.3), rel=0.01)
    assert pyramid == pytest.approx(math.sqrt(2.0) * grip_limit(0.3), rel=0.01)


def rows(text: str) -> dict[str, list[float]]:
    """Return the numbers of every table row by its words; percentages are left out."""
    found: dict[str, list[float]] = {}
    for line in text.splitlines():
        if line.startswith("| ") and re.search(r"\d", line):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            label, rest = " ".join(cells[:2]), [cell for cell in cells[2:] if "%" not in cell]
            numbers = [float(number) for cell in rest for number in re.findall(r"-?\d+\.?\d*", cell)]
            label = f"{len(cells)} {len(numbers)} {cells[0] if len(cells) in (4, 5) else label}"
            assert label not in found
            found[label] = numbers
    return found


def test_the_page_says_what_is_measured(robot: Robot, tracks: Tracks) -> None:
    text = PAGE.read_text(encoding="utf-8")
    printed = rows(text[text.index(BEGIN) : text.index(END)])
    measured_now = rows(tables(robot, tracks))
    assert len(printed) > 40
    assert printed.keys() == measured_now.keys()
    for label, numbers in printed.items():
        assert numbers == pytest.approx(measured_now[label], rel=0.03, abs=0.02), label


def test_new_tables_replace_the_old_ones_and_nothing_else() -> None:
    assert renewed(f"a\n{BEGIN}\nold\n{END}\nb\n", "new") == f"a\n{BEGIN}\n\nnew\n\n{END}\nb\n"
    with pytest.raises(ValueError, match="lacks"):
        renewed("a page without marks", "new")
