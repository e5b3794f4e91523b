"""A law of one's own runs beside the listed ones, and what it does wrong is said with its name and tick."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from slipctl import experiment, scenario
from slipctl.control.drive import DriveLimits
from slipctl.control.nominal_dynamic import NominalDynamic
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.control.plain import plain_trace
from slipctl.control.robust_kinematic import RobustKinematic
from slipctl.experiment.checked import CheckedLaw, OwnLawError
from slipctl.experiment.own import KnownRobot
from slipctl.guarantee import Hypotheses
from slipctl.theory.robust import UNCERTAINTIES, chain_gains, lyapunov_matrix
from slipctl.tick import Decision, Motion, Reference, SpeedCommand, Start

KINEMATIC = {
    "name": "small",
    "tick": 0.02,
    "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
    "plant": {"kind": "kinematic_ode"},
    "slip": {"kind": "proportional", "longitudinal": 0.2, "lateral": 0.1},
    "reference": {"kind": "line", "speed": 0.3, "distance": 0.6},
    "start": {"y_offset": 0.02},
    "controller": [
        {"kind": "nominal_kinematic", "pole": -1.0},
        {
            "kind": "robust_kinematic",
            "pole": -1.0,
            "slip_bound": 0.3,
            "boundary_layer": 0.02,
            "uncertainty": "paper",
        },
    ],
}

DYNAMIC = {
    "robot": {"model": "magellan_pro", "drive": "wheel_torque"},
    "plant": {"kind": "dynamic_ode"},
    "controller": [{"kind": "nominal_dynamic", "pole": -2.0}],
}


def small(**changes: Any) -> scenario.Scenario:
    return scenario.read({**KINEMATIC, **changes}, "small")


def nominal(robot: KnownRobot) -> NominalKinematic:
    return NominalKinematic(robot.speed_drive(), chain_gains(np.full(robot.worlds, -1.0), 2))


def nominal_torque(robot: KnownRobot) -> NominalDynamic:
    return NominalDynamic(robot.torque_drive(), chain_gains(np.full(robot.worlds, -2.0), 3))


def robust(robot: KnownRobot) -> RobustWithTheorem:
    gains = chain_gains(np.full(1, -1.0), 2)
    weights = np.stack([lyapunov_matrix(row) for row in gains])
    drive, alpha, layer = robot.speed_drive(), np.array([0.3]), np.array([0.02])
    bound = UNCERTAINTIES["paper"]
    hypotheses = Hypotheses(alpha, drive.speed_floor, "paper", layer, gains, weights)
    return RobustWithTheorem(drive, gains, weights[:, :, 1], alpha, layer, bound.bound, hypotheses)


@dataclass(frozen=True)
class RobustWithTheorem(RobustKinematic):
    hypotheses: Hypotheses


def rows(result: experiment.Result, label: str) -> list[dict[str, Any]]:
    return [run for run in result.json()["runs"] if run["controller"] == label]


def without_label(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{key: value for key, value in run.items() if key != "controller"} for run in runs]


def test_the_listed_law_as_an_own_one_gives_the_same_numbers_in_every_world() -> None:
    swept = small(sweep={"slip.lateral": [0.0, 0.1, 0.2], "robot.speed_limit": [0.31, 2.5]})
    plain = experiment.run(swept)
    result = experiment.run(swept, laws={"mine": nominal, "theirs": robust})
    assert [run["controller"] for run in result.json()["runs"][:4]] == [
        "nominal_kinematic", "robust_kinematic", "mine", "theirs",
    ]  # fmt: skip
    assert without_label(rows(result, "mine")) == without_label(rows(plain, "nominal_kinematic"))
    # a law that offers its hypotheses is judged by its theorem
    assert without_label(rows(result, "theirs")) == without_label(rows(plain, "robust_kinematic"))
    listed = [run for run in result.json()["runs"] if run["controller"] not in ("mine", "theirs")]
    assert listed == plain.json()["runs"]
    assert all(run["metrics"]["guarantee_fraction"] is None for run in rows(result, "mine"))
    assert all(run["metrics"]["guarantee_fraction"] is not None for run in rows(result, "theirs"))


def test_an_own_law_changes_no_identity_and_stands_in_the_manifest() -> None:
    result = experiment.run(small(), laws={"mine": nominal})
    assert result.json()["scenario_id"] == scenario.scenario_id(small())
    assert result.manifest["own_laws"] == {"mine": f"{__name__}.nominal"}
    assert result.manifest["controllers"] == ["nominal_kinematic", "robust_kinematic"]
    assert "own_laws" not in experiment.run(small()).manifest
    assert result.metrics["run"].to_pylist() == [0, 1, 2]
    assert result.metrics["kind"].to_pylist()[-1] == "own"
    assert result.run_signals(2).num_rows == small().ticks + 1


def test_an_instance_serves_any_number_of_worlds() -> None:
    class Straight:
        """Drives on at the planned speed, whatever happens."""

        def start(self, start: Start) -> np.ndarray:
            return start.forward_speed

        def update(self, memory: np.ndarray, reference: Any, motion: Motion, tick: float) -> Decision:
            none = np.zeros(len(memory))
            rates = np.repeat(memory[:, None], 2, axis=1) / 0.0825
            return Decision(SpeedCommand(none, memory, none, rates), memory, plain_trace(none > 0))

    law = Straight()
    one = experiment.run(small(start={}, slip={"kind": "proportional"}), laws={"straight": law})
    many = experiment.run(
        small(start={}, slip={"kind": "proportional"}, sweep={"seed": [1, 2, 3]}), laws={"straight": law}
    )
    assert len(rows(many, "straight")) == 3
    for run in [*rows(one, "straight"), *rows(many, "straight")]:
        # without slip and offset, driving on is the plan itself
        assert run["metrics"]["max_position_error"] < 1e-12
        # no flat input, so nothing is made up about one
        assert run["metrics"]["rms_robust_input"] is None


@pytest.mark.parametrize("kind", ["kinematic_ode", "mujoco"])
def test_recordings_and_tables_hold_the_own_law(tmp_path, kind) -> None:
    changes = {} if kind == "kinematic_ode" else {"slip": None, "ground": {"friction": 0.8}}
    tables = {**KINEMATIC, "plant": {"kind": kind}, **changes}
    mine = scenario.read({key: value for key, value in tables.items() if value is not None}, "small")
    result = experiment.run(mine, out=tmp_path, record="all", laws={"mine": nominal})
    assert result.folder is not None
    metrics = pq.read_table(result.folder / "metrics.parquet").to_pylist()
    assert [row["controller"] for row in metrics] == ["nominal_kinematic", "robust_kinematic", "mine"]
    signals = pq.read_table(result.folder / "signals.parquet")
    assert set(signals["run"].to_pylist()) == {0, 1, 2}
    recording = (result.folder / metrics[2]["recording"]).read_bytes()
    assert b"mine" in recording


def test_a_dynamic_law_drives_torques() -> None:
    result = experiment.run(small(**DYNAMIC), laws={"mine": nominal_torque})
    assert without_label(rows(result, "mine")) == without_label(rows(result, "nominal_dynamic"))
    with pytest.raises(
        OwnLawError, match=r"law 'mine' at tick 0 .* a SpeedCommand, .* needs a TorqueCommand"
    ):
        experiment.run(small(**DYNAMIC), laws={"mine": nominal})


@pytest.mark.parametrize("label", ["My Law", "", "a/b", "nominal_kinematic"])
def test_labels_are_checked(label) -> None:
    with pytest.raises(OwnLawError, match=r"nominal_kinematic|lower-case"):
        experiment.run(small(), laws={label: nominal})


@dataclass(frozen=True)
class Broken:
    """Does one thing wrong at tick 7."""

    law: NominalKinematic
    wrong: str

    def start(self, start: Start) -> Any:
        if self.wrong == "start":
            raise KeyError("no start")
        return self.law.start(start), 0

    def update(self, memory: Any, reference: Any, motion: Motion, tick: float) -> Any:
        memory, k = memory
        good = self.law.update(memory, reference, motion, tick)
        if k == 7:
            return self.spoil(good)
        return replace(good, memory=(good.memory, k + 1))

    def spoil(self, good: Decision) -> Any:
        turn = good.command.yaw_rate
        match self.wrong:
            case "raises":
                raise ZeroDivisionError("by nothing")
            case "none":
                return None
            case "nan":
                return replace(good, command=replace(good.command, yaw_rate=np.where(turn < 9, np.nan, turn)))
            case "infinite":
                return replace(good, command=replace(good.command, wheel_rate=good.command.wheel_rate / 0.0))
            case "shape":
                return replace(good, command=replace(good.command, yaw_rate=turn[:1]))
            case "list":
                return replace(good, command=replace(good.command, yaw_rate=list(turn)))
            case "command":
                return replace(good, command=(1.0, 2.0))
            case "trace":
                return replace(good, trace=None)
            case "trace shape":
                return replace(good, trace=replace(good.trace, nominal_input=turn))
        raise AssertionError(self.wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("raises", "at tick 7 (0.14 s) failed: ZeroDivisionError: by nothing"),
        ("none", "at tick 7 (0.14 s) gave a NoneType, needed is a slipctl.tick.Decision"),
        ("nan", "at tick 7 (0.14 s) gave a command.yaw_rate that is not finite (world 0 of its batch)"),
        ("infinite", "gave a command.wheel_rate that is not finite (world 0 of its batch)"),
        ("shape", "gave command.yaw_rate of shape (1,), needed is (2,): one row per world"),
        ("list", "gave command.yaw_rate as a list, needed is an array of shape (2,)"),
        ("command", "gave a tuple, a robot driven by wheel_speed needs a SpeedCommand"),
        ("trace", "gave a NoneType as its trace, needed is a DecisionTrace"),
        ("trace shape", "gave trace.nominal_input of shape (2,), needed is (2, 2)"),
        ("start", "failed at its start: KeyError: 'no start'"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_what_a_law_does_wrong_is_said_with_its_name_and_tick(wrong, message) -> None:
    with pytest.raises(OwnLawError) as caught:
        experiment.run(
            small(sweep={"seed": [1, 2]}), laws={"odd-one": lambda robot: Broken(nominal(robot), wrong)}
        )
    assert "law 'odd-one'" in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (3, "is a int; needed is an object with start and update"),
        (lambda robot: object(), "is a object without a method start"),
        (lambda robot: Broken, "is a type without a method start"),
        (lambda: None, "could not be made for this robot: TypeError"),
    ],
)
def test_what_is_no_law_is_refused(law, message) -> None:
    with pytest.raises(OwnLawError) as caught:
        experiment.run(small(), laws={"mine": law})
    assert message in str(caught.value)


def test_a_robot_that_is_lost_may_be_answered_with_nan() -> None:
    """A diverging world is reported by its status; it is not the law that is at fault then."""
    law = CheckedLaw("mine", nominal(_known(2)), "wheel_speed", 2)
    start = Start(*(np.zeros((2, 2)), *(np.zeros(2) for _ in range(4))))
    motion = Motion(
        *(np.zeros((2, 2)), np.zeros((2, 2)), np.tile([1.0, 0.0], (2, 1)), np.zeros(2)),
        *(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros(2), np.zeros(2)),
        acceleration=None,
    )
    reference = resting(2)
    lost = replace(motion, velocity=np.array([[0.0, 0.0], [np.nan, 0.0]]))
    memory = law.start(start)
    decision = law.update(memory, reference, lost, 0.02)
    assert decision.memory.lost.tolist() == [False, True]
    assert np.isfinite(decision.command.yaw_rate[0])
    assert not np.isfinite(decision.command.yaw_rate[1])
    # lost stays lost: its memory is spoilt
    again = law.update(decision.memory, reference, motion, 0.02)
    assert again.memory.lost.tolist() == [False, True]


@pytest.mark.parametrize(("made", "changes"), [(nominal, {}), (nominal_torque, DYNAMIC)])
def test_what_a_law_does_to_arrays_stays_with_the_law(made, changes) -> None:
    """It writes into what it was shown, and into the arrays of the command before."""

    class Careless:
        def __init__(self, robot: KnownRobot) -> None:
            self.law: Any = made(robot)

        def start(self, start: Start) -> Any:
            return self.law.start(start), None

        def update(self, memory: Any, reference: Reference, motion: Motion, tick: float) -> Decision:
            inner, given = memory
            decision = self.law.update(inner, reference, motion, tick)
            told = {name: value.copy() for name, value in vars(decision.command).items()}
            for shown in (reference, motion, given):
                for array in () if shown is None else vars(shown).values():
                    if array is not None:
                        array *= 0.5
            command = type(decision.command)(**told)
            return replace(decision, command=command, memory=(decision.memory, command))

    two_paths = small(**changes, sweep={"reference.speed": [0.2, 0.3]})
    result = experiment.run(two_paths, laws={"careless": Careless, "careful": made})
    assert without_label(rows(result, "careless")) == without_label(rows(result, "careful"))
    listed = experiment.run(two_paths).json()["runs"]
    assert [run["metrics"] for run in rows(result, "careful")] == [
        run["metrics"] for run in listed if run["controller"].startswith("nominal")
    ]


def resting(worlds: int) -> Reference:
    at_rest = np.zeros((worlds, 2))
    return Reference(at_rest, at_rest, at_rest, at_rest)


def _known(worlds: int) -> KnownRobot:
    from slipctl.experiment.assemble import read_robot

    def full(value: float) -> np.ndarray:
        return np.full(worlds, value)

    return KnownRobot(
        worlds, 0.02, "wheel_speed", read_robot(small()).inertia, full(2.5), full(6.0), full(4.0)
    )


def test_the_drive_that_a_law_is_given_has_the_limits_of_every_world() -> None:
    seen: list[DriveLimits] = []

    def law(robot: KnownRobot) -> NominalKinematic:
        seen.append(robot.speed_drive(0.07))
        assert robot.tick == 0.02
        return nominal(robot)

    experiment.run(small(sweep={"robot.speed_limit": [1.0, 2.0]}), laws={"mine": law})
    assert seen[0].speed_limit.tolist() == [1.0, 2.0]
    assert seen[0].yaw_rate_limit.tolist() == [6.0, 6.0]
    assert seen[0].speed_floor.tolist() == [0.07, 0.07]
    assert seen[0].geometry.wheel_radius == pytest.approx(0.0825)
