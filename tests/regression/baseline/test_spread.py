"""What is run beside a scenario, and to which of its runs each run beside belongs."""

import math

import pytest

from slipctl import experiment
from slipctl.regression.baseline.file import CannotJudge, run_key
from slipctl.regression.baseline.gated import GATED, NUDGE
from slipctl.regression.baseline.spread import Neighbour, measure, neighbours, scenarios_beside
from slipctl.regression.baseline.tracks import ticks_of_runs
from slipctl.scenario import load, scenario_id, worlds
from tests.fakes import SHORT_SCENARIO, payload, run_entry

CONTACTS = """
tick = 0.01
duration = 0.5
[robot]
model = "magellan_pro"
drive = "wheel_speed"
[plant]
kind = "mujoco"
timestep = 0.002
[reference]
kind = "circle"
speed = 0.3
radius = 0.6
[start]
x_offset = 0.01
[[controller]]
kind = "nominal_kinematic"
pole = -1.0
[[controller]]
kind = "robust_kinematic"
pole = -1.0
slip_bound = 0.4
boundary_layer = 0.05
uncertainty = "independent"
"""


def scenario_of(text, folder):
    (folder / "x.toml").write_text(text, encoding="utf-8")
    return load(folder / "x.toml")


def starts(beside):
    given = [world.scenario.start for world in worlds(beside.scenario)]
    return [(start.x_offset, start.y_offset, start.heading_offset_deg) for start in given]


def test_each_coordinate_of_the_start_is_moved_to_both_sides(tmp_path):
    x, y, heading = scenarios_beside(scenario_of(SHORT_SCENARIO, tmp_path))
    assert starts(x) == [(0, 0, 0), (NUDGE, 0, 0), (-NUDGE, 0, 0)]
    assert starts(y) == [(0, 0, 0), (0, NUDGE, 0), (0, -NUDGE, 0)]
    turned = [math.radians(degrees) for _, _, degrees in starts(heading)]
    assert turned == pytest.approx([0.0, 1e-9, -1e-9], rel=1e-12)


def test_one_to_three_threads_are_used(tmp_path):
    beside = list(scenarios_beside(scenario_of(SHORT_SCENARIO, tmp_path)))
    assert {one.threads for one in beside} == {1, 2, 3}


def test_half_the_timestep_keeps_the_tick(tmp_path):
    scenario = scenario_of(CONTACTS, tmp_path)
    *_, halved = scenarios_beside(scenario, threads=2)
    (world,) = worlds(halved.scenario)
    assert world.scenario.plant.timestep == 0.001
    assert world.scenario.tick == scenario.tick
    assert world.scenario.duration == scenario.duration
    assert halved.threads == 2


def test_a_plant_without_a_timestep_has_nothing_to_halve(tmp_path):
    keys = [beside.key for beside in scenarios_beside(scenario_of(SHORT_SCENARIO, tmp_path))]
    assert keys == ["start.x_offset", "start.y_offset", "start.heading_offset_deg"]


@pytest.mark.parametrize(
    ("sweep", "worlds_beside"),
    [
        ('"ground.friction" = [0.3, 0.8]', [6, 6, 6, 2]),
        ('"plant.timestep" = [0.002, 0.001]', [6, 6, 6, 2]),
        ('"start.x_offset" = [0.0, 0.01, 0.02]', [9, 9, 9, 3]),
        ('"start.heading_offset_deg" = [-360, 0, 360]', [9, 9, 9, 3]),
        ('seed = [1, 2]\n"plant.timestep" = [0.002, 0.001]', [12, 12, 12, 4]),
    ],
)
def test_every_run_beside_belongs_to_a_run_of_the_scenario(tmp_path, sweep, worlds_beside):
    scenario = scenario_of(f"{CONTACTS}[sweep]\n{sweep}\n", tmp_path)
    own = {run_key("c", world.varied, world.seed) for world in worlds(scenario)}
    counts = []
    for beside in scenarios_beside(scenario):
        there = worlds(beside.scenario)
        counts.append(len(there))
        origins = [
            beside.origin({"controller": "c", "varied": world.varied, "seed": world.seed}) for world in there
        ]
        assert {key for key, _ in origins} == own
        unmoved = [world for world, (_, kind) in zip(there, origins, strict=True) if kind == "threads"]
        if beside.key != "plant.timestep":
            assert len(unmoved) == len(own)
    assert counts == worlds_beside


def test_a_swept_timestep_is_halved_value_by_value(tmp_path):
    scenario = scenario_of(f'{CONTACTS}[sweep]\n"plant.timestep" = [0.002, 0.001]\n', tmp_path)
    *_, halved = scenarios_beside(scenario)
    found = {
        world.scenario.plant.timestep: beside_of
        for world in worlds(halved.scenario)
        for beside_of in [halved.origin({"controller": "c", "varied": world.varied, "seed": 0})]
    }
    assert found == {
        0.001: (run_key("c", {"plant.timestep": 0.002}, 0), "halved"),
        0.0005: (run_key("c", {"plant.timestep": 0.001}, 0), "halved"),
    }


def test_the_scenario_itself_stays_as_it_is(tmp_path):
    scenario = scenario_of(CONTACTS, tmp_path)
    before = scenario_id(scenario)
    for beside in scenarios_beside(scenario):
        assert scenario_id(beside.scenario) != before
    assert scenario_id(scenario) == before


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """The baseline runs of a short scenario with contacts, and everything that was run for them."""
    scenario = scenario_of(CONTACTS, tmp_path_factory.mktemp("contacts"))
    answers = {}

    def run(moved, threads):
        answer = experiment.run(moved, threads=threads).json()
        answers[moved.sweep[-1].key] = answer
        return answer

    result = experiment.run(scenario, threads=1)
    beside = neighbours(scenario, run)
    return result, answers, measure(result.json(), ticks_of_runs(result), beside)


def test_every_run_has_its_runs_beside(measured):
    result, answers, runs = measured
    assert [run.controller for run in runs] == ["nominal_kinematic", "robust_kinematic"]
    assert len(answers) == 4
    for entry, run in zip(result.json()["runs"], runs, strict=True):
        assert {name: run.metrics[name].value for name in GATED} == {
            name: entry["metrics"][name] for name in GATED
        }


def test_threads_change_nothing(measured):
    """The worlds that were not moved, on two, three and one threads: the very same numbers."""
    result, answers, _ = measured
    own = {run["controller"]: run["metrics"] for run in result.json()["runs"]}
    seen = 0
    for key in ("start.x_offset", "start.y_offset", "start.heading_offset_deg"):
        unmoved = 0.01 if key == "start.x_offset" else 0.0
        for run in answers[key]["runs"]:
            if run["varied"][key] == unmoved:
                assert run["metrics"] == own[run["controller"]]
                seen += 1
    assert seen == 6


def test_the_spread_is_the_largest_difference_from_a_moved_start(measured):
    result, answers, runs = measured
    for run in runs:
        own = next(r for r in result.json()["runs"] if r["controller"] == run.controller)
        for metric in GATED:
            if own["metrics"][metric] is None:
                continue
            moved = [
                abs(other["metrics"][metric] - own["metrics"][metric])
                for key, answer in answers.items()
                if key != "plant.timestep"
                for other in answer["runs"]
                if other["controller"] == run.controller
            ]
            assert run.metrics[metric].spread == max(moved)
            (halved,) = (
                other for other in answers["plant.timestep"]["runs"] if other["controller"] == run.controller
            )
            assert run.metrics[metric].halving == abs(halved["metrics"][metric] - own["metrics"][metric])


def test_a_nudge_of_a_robot_that_starts_beside_its_path_shows_in_the_error(measured):
    _, _, runs = measured
    for run in runs:
        assert 1e-11 < run.metrics["max_position_error"].spread < 1e-8


def answering(moved_run, same_start):
    """An engine whose law `a` always gives the same, and `b` what it is told, by whether its start moved."""

    def run(moved, threads):
        beside = []
        for world in worlds(moved):
            offset = next(iter(world.varied.values()))
            rms, status = same_start if offset == 0.0 else moved_run
            beside += [
                run_entry("b", rms=rms, seed=0, status=status, varied=world.varied),
                run_entry("a", rms=0.01, seed=0, varied=world.varied),
            ]
        return payload(beside)

    return run


def measured_with(run, folder):
    base = payload([run_entry(name, rms=0.01, seed=0, varied={}) for name in "ab"])
    return measure(base, [100, 100], neighbours(scenario_of(SHORT_SCENARIO, folder), run))


def test_runs_are_paired_with_their_own_neighbours(tmp_path):
    a, b = measured_with(answering((0.0101, "tipped"), (0.01, "completed")), tmp_path)
    assert (a.statuses_seen, b.statuses_seen) == ([], ["tipped"])
    assert (a.ticks, b.ticks) == (100, 100)
    assert a.metrics["rms_position_error"].spread == 0.0
    assert {number.gate for number in a.metrics.values()} == {"number"}
    assert {number.gate for number in b.metrics.values()} == {"verdict"}


@pytest.mark.parametrize(
    ("again", "said"),
    [
        ((0.0101, "completed"), r"b is not repeatable, .* rms_position_error \[m\] is 0.01, then 0.0101"),
        ((0.01, "tipped"), "b is not repeatable, .* status is completed, then tipped"),
        ((None, "completed"), "b is not repeatable, .* is 0.01, then None"),
    ],
)
def test_another_number_from_the_very_same_start_is_no_chaos(tmp_path, again, said):
    with pytest.raises(CannotJudge, match=said) as caught:
        measured_with(answering((0.01, "completed"), again), tmp_path)
    assert "\n" not in str(caught.value)


def test_rounding_otherwise_beside_other_worlds_is_repeatable(tmp_path):
    _, b = measured_with(answering((0.01, "completed"), (0.01 + 1e-12, "completed")), tmp_path)
    assert b.metrics["rms_position_error"].spread == pytest.approx(1e-12, rel=1e-3)


def measured_beside(*beside):
    """Give the one run of a result whose runs beside it differ in kind, RMS error and share of guarantee."""
    entry = run_entry("a", rms=0.01, seed=0, varied={})
    told = [
        Neighbour(
            kind, "completed", entry["metrics"] | {"rms_position_error": rms, "guarantee_fraction": share}
        )
        for kind, rms, share in beside
    ]
    (run,) = measure(payload([entry]), [100], {run_key("a", {}, 0): told})
    return run


def test_every_run_from_the_very_same_start_is_looked_at():
    """Behind a moved start and behind one that did repeat, too."""
    fine = [("nudged", 0.0101, 0.25), ("threads", 0.01, 0.25)]
    assert measured_beside(*fine).metrics["rms_position_error"].spread == pytest.approx(1e-4)
    with pytest.raises(CannotJudge, match=r"^friction-sweep: a is not repeatable"):
        measured_beside(*fine, ("threads", 0.0101, 0.25))


def test_a_share_of_ticks_repeats_to_a_tick():
    assert measured_beside(("threads", 0.01, 0.26)).metrics["guarantee_fraction"].spread == pytest.approx(
        0.01
    )
    with pytest.raises(CannotJudge, match="guarantee_fraction"):
        measured_beside(("threads", 0.01, 0.27))


def test_a_heading_of_a_whole_turn_is_moved_to_both_sides_within_it(tmp_path):
    """The file format refuses more than 360 degrees."""
    for whole in (360.0, -360.0):
        text = SHORT_SCENARIO + f"[start]\nheading_offset_deg = {whole}\n"
        *_, heading = scenarios_beside(scenario_of(text, tmp_path))
        step = math.degrees(NUDGE)
        (_, _, unmoved), *moved = starts(heading)
        assert unmoved == whole
        off = [math.remainder(degrees - whole, 360.0) for _, _, degrees in moved]
        assert off == pytest.approx([step, -step], rel=1e-5)
        assert max(abs(degrees) for _, _, degrees in starts(heading)) == 360.0


def test_each_run_beside_is_made_on_its_own_number_of_threads(tmp_path):
    asked = {}

    def run(moved, threads):
        asked[moved.sweep[-1].key] = threads
        return payload([])

    assert neighbours(scenario_of(CONTACTS, tmp_path), run, threads=7) == {}
    assert asked == {
        "start.x_offset": 2,
        "start.y_offset": 3,
        "start.heading_offset_deg": 1,
        "plant.timestep": 7,
    }


def test_every_run_needs_its_length(tmp_path):
    runs = payload([run_entry("a", rms=0.01, seed=0, varied={})])
    beside = {run_key("a", {}, 0): []}
    with pytest.raises(ValueError, match="zip"):
        measure(runs, [100, 100], beside)


def test_what_the_tables_say_survives(tmp_path):
    """A scenario that gives no `[start]` gets one beside; one that gives part of it keeps that part."""
    given = scenario_of(CONTACTS, tmp_path)
    _, y, _, _ = scenarios_beside(given)
    assert {start[0] for start in starts(y)} == {0.01}
    text = CONTACTS.replace("[start]\nx_offset = 0.01\n", "")
    left_out = scenario_of(text, tmp_path)
    assert {start[0] for start in starts(list(scenarios_beside(left_out))[1])} == {0.0}
