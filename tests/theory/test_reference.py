import math
import warnings

import numpy as np
import pytest

from slipctl.theory.reference import (
    Circle,
    FigureEight,
    Line,
    Placement,
    Plan,
    PointToPoint,
    figure_eight_rate,
)
from tests.builders import at_origin, full, table_one

PLACED = Placement(np.array([1.0, -2.0]), np.array([0.5, 3.0]), np.array([0.7, -2.4]))


def point_to_point(placement: Placement) -> PointToPoint:
    worlds = len(placement.x)
    start = np.tile([0.1, -0.2, 0.4, 0.3], (worlds, 1))
    goal = np.tile([2.0, 1.0, -1.0, 0.5], (worlds, 1))
    return PointToPoint(start, goal, np.linspace(5.0, 6.0, worlds), placement)


def quintic(placement: Placement) -> PointToPoint:
    """Return a plan whose ends also have a yaw rate and an acceleration."""
    worlds = len(placement.x)
    start = np.tile([0.1, -0.2, 0.4, 0.3, 0.6, -0.1], (worlds, 1))
    goal = np.tile([2.0, 1.0, -1.0, 0.5, -0.7, 0.2], (worlds, 1))
    return PointToPoint(start, goal, np.linspace(5.0, 6.0, worlds), placement)


PLANS = {
    "point_to_point": point_to_point,
    "quintic": quintic,
    "line": lambda p: Line(np.linspace(0.5, 1.5, len(p.x)), p),
    "circle": lambda p: Circle(full(len(p.x), 0.8), np.linspace(0.7, -1.3, len(p.x)), p),
    "figure_eight": lambda p: FigureEight(
        np.linspace(2.0, 3.0, len(p.x)), np.linspace(1.0, 0.5, len(p.x)), p
    ),
}


@pytest.fixture(params=sorted(PLANS))
def build(request):
    return PLANS[request.param]


def central_difference(field, step):
    return (field[:, 2:] - field[:, :-2]) / (2.0 * step)


def test_derivatives_are_those_of_the_position(build):
    """Central differences of cubics and of sines at this step err by less than 1e-8."""
    step = 1e-4
    for begin in (0.3, 2.0, 9.0):  # the last one beyond the end of the point-to-point plan
        at = build(PLACED).at(begin + step * np.arange(-5, 6))
        np.testing.assert_allclose(
            central_difference(at.position, step), at.velocity[:, 1:-1], rtol=0, atol=1e-8
        )
        np.testing.assert_allclose(
            central_difference(at.velocity, step), at.acceleration[:, 1:-1], rtol=0, atol=1e-8
        )
        np.testing.assert_allclose(
            central_difference(at.acceleration, step), at.jerk[:, 1:-1], rtol=0, atol=1e-7
        )
        assert (2, 11, 2) == at.position.shape == at.velocity.shape == at.acceleration.shape == at.jerk.shape


def test_placement_turns_and_moves(build):
    """A placed plan is R(heading) times the plan at the origin, plus the origin; R has no say in lengths."""
    times = np.linspace(0.0, 12.0, 50)
    plain, placed = build(at_origin(2)).at(times), build(PLACED).at(times)
    turn = np.exp(1j * PLACED.heading)[:, None]
    origin = (PLACED.x + 1j * PLACED.y)[:, None]
    for name, offset in (("position", origin), ("velocity", 0.0), ("acceleration", 0.0), ("jerk", 0.0)):
        before, after = getattr(plain, name), getattr(placed, name)
        moved = turn * (before[..., 0] + 1j * before[..., 1]) + offset
        np.testing.assert_allclose(after[..., 0] + 1j * after[..., 1], moved, rtol=0, atol=1e-13)


def test_a_world_does_not_feel_the_others(build):
    times = np.linspace(0.0, 12.0, 20)
    alone = build(Placement(PLACED.x[:1], PLACED.y[:1], PLACED.heading[:1])).at(times)
    np.testing.assert_array_equal(build(PLACED).at(times).position[:1], alone.position)


def test_table_one_meets_its_end_conditions():
    at = table_one().at(np.array([0.0, 20.0]))
    np.testing.assert_allclose(at.position[0], [[0.0, 0.0], [1.2, 1.5]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(at.velocity[0], [[0.0, 0.15], [0.0, 0.15]], rtol=0, atol=1e-15)


def test_table_one_is_a_cubic():
    """Its coefficients from Table I by hand."""
    times = np.linspace(0.0, 20.0, 41)
    at = table_one().at(times)
    np.testing.assert_allclose(at.position[0, :, 0], 0.009 * times**2 - 0.0003 * times**3, rtol=0, atol=1e-13)
    y = 0.15 * times - 0.01125 * times**2 + 0.000375 * times**3
    np.testing.assert_allclose(at.position[0, :, 1], y, rtol=0, atol=1e-13)


def test_table_one_keeps_off_the_singularity():
    """theory: inf ‖Ḟ_d‖ = 0.0937 m/s, well above the speed floor of 0.05."""
    velocity = table_one().at(np.linspace(0.0, 20.0, 20001)).velocity[0]
    assert np.hypot(*velocity.T).min() == pytest.approx(0.0937, abs=5e-5)


def test_point_to_point_ends_at_its_poses_and_goes_on_at_its_final_velocity():
    plan = point_to_point(at_origin(2))
    for world, total in enumerate(plan.duration):
        at = plan.at(np.array([0.0, total, total + 1.0, total + 3.0]))
        position, velocity, acceleration = (
            field[world] for field in (at.position, at.velocity, at.acceleration)
        )
        arriving = 0.5 * np.array([math.cos(-1.0), math.sin(-1.0)])
        np.testing.assert_allclose(position[0], [0.1, -0.2], rtol=0, atol=1e-14)
        np.testing.assert_allclose(
            velocity[0], [0.3 * math.cos(0.4), 0.3 * math.sin(0.4)], rtol=0, atol=1e-14
        )
        np.testing.assert_allclose(position[1], [2.0, 1.0], rtol=0, atol=1e-13)
        np.testing.assert_allclose(velocity[1:], [arriving] * 3, rtol=0, atol=1e-13)
        np.testing.assert_allclose(position[2] - position[1], arriving, rtol=0, atol=1e-13)
        np.testing.assert_allclose(position[3] - position[1], 3.0 * arriving, rtol=0, atol=1e-13)
        assert acceleration[1].any()
        assert not acceleration[2:].any()


def test_quintic_ends_at_its_poses_yaw_rates_and_accelerations():
    """F̈ = ū₁ t + v ū₂ n at both ends, (11), in complex numbers."""
    plan = quintic(at_origin(2))
    for world, total in enumerate(plan.duration):
        at = plan.at(np.array([0.0, total]))
        for row, pose in enumerate((plan.start[world], plan.goal[world])):
            x, y, heading, speed, yaw_rate, push = pose
            facing = np.exp(1j * heading)
            for field, expected in (
                (at.position, x + 1j * y),
                (at.velocity, speed * facing),
                (at.acceleration, (push + 1j * speed * yaw_rate) * facing),
            ):
                got = field[world, row, 0] + 1j * field[world, row, 1]
                assert got == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("build_polynomial", [point_to_point, quintic])
def test_worlds_may_ask_for_times_of_their_own(build_polynomial):
    plan = build_polynomial(PLACED)
    own = np.array([[0.0, 1.0, 5.0, 7.0], [0.5, 2.0, 6.0, 8.0]])
    at = plan.at(own)
    for world in range(2):
        alone = plan.at(own[world])
        for name in ("position", "velocity", "acceleration", "jerk"):
            np.testing.assert_array_equal(getattr(at, name)[world], getattr(alone, name)[world])


@pytest.mark.parametrize("build_polynomial", [point_to_point, quintic])
def test_the_last_instant_still_has_the_polynomial_s_acceleration(build_polynomial):
    plan = build_polynomial(at_origin(1))
    total = float(plan.duration[0])
    at = plan.at(np.array([total - 1e-9, total, total + 1e-9]))
    for field in (at.acceleration[0], at.jerk[0]):
        np.testing.assert_allclose(field[1], field[0], rtol=0, atol=1e-7)
        assert np.abs(field[1]).max() > 0.1
        assert not field[2].any()


def test_a_cubic_may_begin_and_end_at_rest():
    """Half of the way at half the time, fastest there; nothing is divided by the speed."""
    ends = np.array([[0.0, 0.0, 0.3, 0.0]]), np.array([[2.0, 1.0, 0.3, 0.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        at = PointToPoint(*ends, full(1, 4.0), at_origin(1)).at(np.array([0.0, 2.0, 4.0]))
    np.testing.assert_allclose(at.position[0], [[0.0, 0.0], [1.0, 0.5], [2.0, 1.0]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(at.velocity[0], [[0.0, 0.0], [0.75, 0.375], [0.0, 0.0]], rtol=0, atol=1e-14)


def test_line():
    at = Line(np.array([2.0]), Placement(np.array([1.0]), np.array([1.0]), np.array([math.pi / 2.0]))).at(
        np.array([0.0, 1.5])
    )
    np.testing.assert_allclose(at.position[0], [[1.0, 1.0], [1.0, 4.0]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(at.velocity[0], [[0.0, 2.0]] * 2, rtol=0, atol=1e-15)
    assert not at.acceleration.any()
    assert not at.jerk.any()


@pytest.mark.parametrize(("radius", "side"), [(0.5, 1.0), (-0.5, -1.0)])
def test_circle_turns_left_for_a_positive_radius(radius, side):
    speed, lap = 0.8, 2.0 * math.pi * 0.5 / 0.8
    plan = Circle(full(1, speed), full(1, radius), at_origin(1))
    at = plan.at(lap * np.array([0.0, 0.25, 0.5, 1.0, 7.0]))
    expected = [[0.0, 0.0], [0.5, side * 0.5], [0.0, side * 1.0], [0.0, 0.0], [0.0, 0.0]]
    np.testing.assert_allclose(at.position[0], expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(at.velocity[0, 0], [speed, 0.0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(at.acceleration[0, 0], [0.0, side * speed**2 / 0.5], rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.hypot(*at.velocity[0].T), speed, rtol=1e-14)


def test_figure_eight_starts_into_the_first_quadrant_with_its_speed():
    plan = FigureEight(full(1, 2.0), full(1, 1.0), at_origin(1))
    at = plan.at(np.array([0.0, 0.05]))
    assert not at.position[0, 0].any()
    assert np.hypot(*at.velocity[0, 0]) == pytest.approx(1.0, rel=1e-15)
    np.testing.assert_allclose(at.velocity[0, 0], math.sqrt(0.5), rtol=1e-15)
    assert (at.position[0, 1] > 0.0).all()


def test_figure_eight_has_its_length_height_and_period():
    length, speed = 3.0, 0.7
    period = 2.0 * math.pi / float(figure_eight_rate(full(1, length), full(1, speed))[0])
    assert period == pytest.approx(2.0 * math.pi * (length / 2.0) * math.sqrt(2.0) / speed)
    times = np.linspace(0.0, period, 4001)
    plan: Plan = FigureEight(full(1, length), full(1, speed), at_origin(1))
    at, later = plan.at(times), plan.at(times + 2.0 * period)
    assert np.ptp(at.position[0, :, 0]) == pytest.approx(length, rel=1e-6)
    assert np.ptp(at.position[0, :, 1]) == pytest.approx(length / 2.0, rel=1e-6)
    for name in ("position", "velocity", "acceleration"):
        np.testing.assert_allclose(getattr(later, name), getattr(at, name), rtol=0, atol=1e-12)


def test_figure_eight_of_the_friction_sweep_asks_for_its_known_acceleration():
    """Length 2 m at 1 m/s: peak 1.06 m/s²."""
    plan = FigureEight(full(1, 2.0), full(1, 1.0), at_origin(1))
    acceleration = plan.at(np.linspace(0.0, 9.0, 9001)).acceleration[0]
    assert np.hypot(*acceleration.T).max() == pytest.approx(1.06, abs=0.005)
