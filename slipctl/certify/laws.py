"""What a plant lays under the wheels, film, tyre creep and a moving floor; and slip on the paper's path."""

from __future__ import annotations

import math

import numpy as np

from slipctl.certify.fixture import Bench, Fixture
from slipctl.certify.rig import Rig
from slipctl.control.drive import DriveLimits
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.ode import KinematicOde
from slipctl.simulate import Plant, Row, simulate
from slipctl.theory.flatness import flat_to_state
from slipctl.theory.reference import Placement, PointToPoint
from slipctl.theory.robot import GRAVITY
from slipctl.theory.robust import chain_gains
from slipctl.theory.slip import ProportionalSlip, measure_slip
from slipctl.tick import Array, Motion, Reference, Slip, SpeedCommand, Start, WheelContact

TICK = 0.01
"""Control period [s]."""


def _full(value: float) -> Array:
    return np.full(1, float(value))


def _ground(
    bench: Bench,
    friction: float,
    slope: float = 0.0,
    downhill: float = 0.0,
    film: float = math.nan,
    creep: float = math.nan,
) -> Ground:
    return Ground(np.full((1, 2), friction), _full(film), _full(creep), _full(slope), _full(downhill))


def _drive(
    bench: Bench,
    ground: Ground,
    speed: float,
    yaw_rate: float,
    duration: float,
    law: ProportionalSlip | None = None,
) -> tuple[Motion, WheelContact, Slip]:
    """Return the end of a drive at constant wheel speeds."""
    plant = MujocoPlant.build(bench.path, ground=ground, slip_law=law, timestep=bench.timestep)
    zero = np.zeros(1)
    state = plant.start(Start(np.zeros((1, 2)), zero, _full(speed), _full(yaw_rate), zero))
    rates = bench.specimen.rest.geometry.wheel_rates(_full(speed), _full(yaw_rate))
    told = SpeedCommand(zero, _full(speed), _full(yaw_rate), rates)
    for _ in range(round(duration / TICK)):
        state = plant.step(state, told, TICK)
    motion = plant.observe(state)
    return motion, plant.details(state)[1], measure_slip(motion)


def _film(bench: Bench) -> float:
    """Return a film that yields 0.1 m/s where the ground slopes by 3 degrees [N·s/m]."""
    return round(bench.specimen.rest.mass * GRAVITY * math.sin(math.radians(3.0)) / 2.0 / 0.05, 0)


def film_straight(bench: Bench) -> tuple[float, float]:
    """Return the weight's pull down 3 degrees over the slip it causes, per wheel, and the film [N·s/m]."""
    film = _film(bench)
    slope = math.radians(3.0)
    _, _, slip = _drive(bench, _ground(bench, 0.8, slope, math.pi, film), 0.3, 0.0, 3.0)
    force = bench.specimen.rest.mass * GRAVITY * math.sin(slope)
    return force / (-2.0 * float(slip.longitudinal[0])), film


def film_turning(bench: Bench) -> tuple[float, float]:
    """Return the curve's force over the lateral slip it causes, per wheel, and the film [N·s/m]."""
    film = _film(bench)
    _, contact, slip = _drive(bench, _ground(bench, 0.8, film=film), 0.5, 0.6, 3.0)
    return float(contact.lateral_force.sum()) / (2.0 * float(slip.lateral[0])), film


def _creep(bench: Bench, downhill: float) -> tuple[float, float]:
    rest = bench.specimen.rest
    stiffness = round(2.5 * rest.mass * GRAVITY)
    slope = math.radians(4.0)
    motion, contact, slip = _drive(
        bench, _ground(bench, 0.2, slope, downhill, creep=stiffness), 1.0, 0.0, 1.5
    )
    force = np.hypot(contact.longitudinal_force[0], contact.lateral_force[0])
    rim = rest.radius * motion.wheel_rate[0]
    arm = np.array([rest.half_track, -rest.half_track])
    # over the floor, at each wheel: a robot whose mass is not over its axle turns a little
    rolled = (rim[0] + rim[1]) / 2.0
    ahead = rolled - slip.longitudinal[0] - motion.heading_rate[0] * arm - rim
    ratio = np.hypot(ahead, slip.lateral[0]) / np.abs(rim)
    return float(force.sum() / ratio.sum()), stiffness


def creep_uphill(bench: Bench) -> tuple[float, float]:
    """Return friction over slip ratio of the wheels, driving up 4 degrees, and the stiffness [N]."""
    return _creep(bench, math.pi)


def creep_across(bench: Bench) -> tuple[float, float]:
    """Return the same, driving across the slope [N]."""
    return _creep(bench, math.pi / 2.0)


FRACTIONS = (0.4, 0.3, 0.2)
"""v_t and v_s in shares of the speed [1], w_s per speed [rad/m]."""


def _belt(bench: Bench) -> Slip:
    law = ProportionalSlip(*(_full(value) for value in FRACTIONS))
    return _drive(bench, _ground(bench, 0.8), 0.3, 0.0, 1.0, law)[2]


def belt_longitudinal(bench: Bench) -> tuple[float, float]:
    """Return v_t of a robot at 0.3 m/s on a moving floor, and what the floor was told [mm/s]."""
    return 1e3 * float(_belt(bench).longitudinal[0]), 300.0 * FRACTIONS[0]


def belt_lateral(bench: Bench) -> tuple[float, float]:
    """Return v_s likewise [mm/s]."""
    return 1e3 * float(_belt(bench).lateral[0]), 300.0 * FRACTIONS[1]


def belt_yaw(bench: Bench) -> tuple[float, float]:
    """Return w_s likewise [mrad/s]."""
    return 1e3 * float(_belt(bench).yaw[0]), 300.0 * FRACTIONS[2]


def _paper_path() -> tuple[Reference, Start]:
    """Return Table I's path of Ryu & Agrawal, rows (T + 1, 1, 2), and its start."""
    zero = np.zeros(1)
    ends = [np.array([[x, y, math.pi / 2.0, 0.15]]) for x, y in ((0.0, 0.0), (1.2, 1.5))]
    plan = PointToPoint(ends[0], ends[1], _full(20.0), Placement(zero, zero, zero))
    planned = plan.at(np.arange(2001, dtype=np.float64) * TICK).each(
        lambda array: np.ascontiguousarray(np.swapaxes(array, 0, 1))
    )
    speed, heading, push, turn = flat_to_state(planned.velocity[0], planned.acceleration[0])
    return planned, Start(planned.position[0], heading, speed, turn, push)


def _tracked(bench: Bench, plant: Plant) -> float:
    """Return the RMS position error of the nominal law on the paper's path [m]."""
    planned, start = _paper_path()
    drive = DriveLimits(bench.specimen.rest.geometry, _full(2.5), _full(6.0), _full(0.05))
    squares = []

    def write(_: int, row: Row) -> None:
        gap = row.motion.position - row.reference.position
        squares.append(float((gap * gap).sum()))

    simulate(plant, NominalKinematic(drive, chain_gains(_full(-0.5), 2)), planned, start, TICK, write)
    return math.sqrt(sum(squares) / len(squares))


def _belt_against_ode(bench: Bench, fraction: float) -> tuple[float, float]:
    law = ProportionalSlip(_full(fraction), _full(fraction), _full(fraction))
    belt = MujocoPlant.build(bench.path, ground=_ground(bench, 0.8), slip_law=law, timestep=bench.timestep)
    ode = KinematicOde(bench.specimen.rest.geometry, law, _full(50.0))
    return 1e3 * _tracked(bench, belt), 1e3 * _tracked(bench, ode)


def belt_little(bench: Bench) -> tuple[float, float]:
    """Return the nominal law's RMS error on a belt with α = 0.1, and on the analytic plant [mm]."""
    return _belt_against_ode(bench, 0.1)


def belt_much(bench: Bench) -> tuple[float, float]:
    """Return the nominal law's RMS error on a belt with α = 0.4, and on the analytic plant [mm]."""
    return _belt_against_ode(bench, 0.4)


def path_slip(bench: Bench) -> tuple[float, float]:
    """Return the larger RMS of v_t and v_s on the paper's path at μ 0.8, wheels as planned; and none [mm/s].

    Read at the ticks, as a run's signals are: within a tick the servos jerk the wheels.
    """
    planned, _ = _paper_path()
    speed, _, _, turn = flat_to_state(planned.velocity[:, 0], planned.acceleration[:, 0])
    geometry = bench.specimen.rest.geometry
    rates = geometry.wheel_rates(speed, turn)
    rig = bench.specimen.rig(0.8).stand(rolling=(float(speed[0]), float(turn[0])))

    def servo(rig: Rig, time: float) -> None:
        rig.data.ctrl[:] = rates[min(int(time / TICK + 1e-6) + 1, len(rates) - 1)]

    trace = rig.run(20.0, servo)
    along, left = trace.along(trace.velocity)
    rolled = geometry.body_rates(trace.wheel_rate)[0]
    window = slice(round(0.1 / bench.timestep), None, round(TICK / bench.timestep))
    slips = [np.sqrt((part[window] ** 2).mean()) for part in (rolled - along, left)]
    return 1e3 * float(max(slips)), 0.0


FILM = "the film is not the damper that was asked for: are the tyre pairs in the format of magellan_pro.xml?"
BELT = "the moving floor does not carry the wheels along: they creep or let go"
PATH = "slip where there should be none: creep (impratio), curves (b_t), or two contacts a wheel that scrub"

FIXTURES = (
    Fixture("film_constant", "N·s/m", 1e-3, True, "C = F / 2v", FILM, film_straight),
    Fixture("film_constant_turning", "N·s/m", 0.02, True, "C = F / 2v_s", FILM, film_turning),
    Fixture("creep_law_uphill", "N", 0.02, True, "C_κ = F / κ", FILM, creep_uphill),
    Fixture("creep_law_across", "N", 0.02, True, "C_κ = F / κ", FILM, creep_across),
    Fixture("belt_longitudinal_slip", "mm/s", 0.1, False, "as prescribed", BELT, belt_longitudinal),
    Fixture("belt_lateral_slip", "mm/s", 0.1, False, "as prescribed", BELT, belt_lateral),
    Fixture("belt_yaw_slip", "mrad/s", 0.3, False, "as prescribed", BELT, belt_yaw),
    Fixture("belt_tracking_slip_0.1", "mm", 0.02, True, "analytic plant, equation (29)", BELT, belt_little),
    Fixture("belt_tracking_slip_0.4", "mm", 0.02, True, "analytic plant, equation (29)", BELT, belt_much),
    Fixture("slip_on_the_papers_path", "mm/s", 0.03, False, "none in grip", PATH, path_slip),
)
