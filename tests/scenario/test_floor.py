"""Patches, changes of the floor and pushes in the file format."""

import tomllib

import pytest

from slipctl.scenario import Bumps, Disc, Stripes, load, read, scenario_id, template, worlds
from tests.scenario.documents import EIGHT, PAPER, TORQUE, changed, only, refused

DISC = {"kind": "disc", "friction": 0.1, "x": 1.0, "y": 0.0, "radius": 0.2}
STRIPES = {"kind": "stripes", "friction": 0.1, "period": 0.4, "width": 0.1}
PUSH = {"force": 10.0, "heading_deg": 90.0, "start": 1.0, "duration": 0.5}
DRY = {"ground": {"friction": 0.5}, "sweep": None}


def floor(**ground):
    return changed(EIGHT, {**DRY, "ground": {"friction": 0.5, **ground}})


def test_patches_changes_and_pushes_are_read():
    document = floor(patch=[DISC, STRIPES], change=[{"time": 1.0, "friction": 0.2}])
    scenario = read(changed(document, {"disturbance": [PUSH]}))
    disc, stripes = scenario.ground.patch
    assert isinstance(disc, Disc)
    assert isinstance(stripes, Stripes)
    assert (stripes.x, stripes.count) == (0.0, None)
    assert (scenario.ground.change[0].film, scenario.ground.change[0].dry) == (None, False)
    assert scenario.disturbance[0].force == 10.0


@pytest.mark.parametrize(
    ("ground", "text"),
    [
        ({"patch": DISC}, "ground.patch: found a table with kind, friction, x, y, radius; "
         "allowed: an array: write [[ground.patch]], not [ground.patch]"),
        ({"patch": [{**DISC, "kind": "square"}]}, 'ground.patch[0:square].kind: found "square"; '
         'allowed: "rectangle", "disc", "stripes"'),
        ({"patch": [{**DISC, "radius": 0.0}]},
         "ground.patch[0:disc].radius: found 0.0; allowed: a number > 0 [m]"),
        ({"patch": [{**DISC, "frction": 0.1}]}, "ground.patch[0:disc].frction: found an unknown key; "
         'allowed: kind, friction, film, x, y, radius; did you mean "friction"?'),
        ({"patch": [STRIPES, {**DISC, "width": 1.0}]}, "ground.patch[1:disc].width: found a key of rectangle "
         "and stripes, which disc would ignore; allowed: kind, friction, film, x, y, radius"),
        ({"patch": [{**STRIPES, "width": 0.5}]},
         "ground.patch[0:stripes].width: found 0.5 m, not less than the "
         "period; allowed: a number < 0.4 [m], the period"),
        ({"patch": [{**DISC, "film": 50.0}], "creep_stiffness": 200.0}, "ground.patch[0:disc].film: found it "
         "together with ground.creep_stiffness; allowed: one of ground.creep_stiffness and films"),
        ({"change": [{"time": 1.0}]},
         "ground.change[0]: found no change; allowed: friction, film, or dry = true"),
        ({"change": [{"time": 2.0, "friction": 0.1}, {"time": 1.0, "friction": 0.2}]},
         "ground.change[1].time: found 1; allowed: a number > 2 [s]: changes stand in the order of time"),
        ({"change": [{"time": 1.0, "dry": True}]},
         "ground.change[0].dry: found true where there is no film; allowed: it after a film, or no dry"),
        ({"change": [{"time": 1.0, "film": 9.0}, {"time": 2.0, "film": 8.0, "dry": True}]},
         "ground.change[1].film: found it together with dry = true; allowed: one of film and dry = true"),
        ({"change": [{"time": 4.0, "friction": 0.1}]},
         "ground.change[0].time: found 4 s, when the run is over; allowed: a number < 4 [s], the duration"),
    ],
)  # fmt: skip
def test_what_is_refused(ground, text):
    assert str(only(floor(**ground))) == text


def test_pushes_that_are_refused():
    late = changed(EIGHT, {**DRY, "disturbance": [PUSH, {**PUSH, "start": 5.0}]})
    assert str(only(late)) == (
        "disturbance[1].start: found 5 s, when the run is over; allowed: a number < 4 [s], the duration"
    )
    wrong = only(changed(EIGHT, {**DRY, "disturbance": [{**PUSH, "force": -1.0}]}))
    assert str(wrong) == "disturbance[0].force: found -1.0; allowed: a number > 0 [N]"
    missing = only(changed(EIGHT, {**DRY, "disturbance": [{k: v for k, v in PUSH.items() if k != "start"}]}))
    assert missing.key == "disturbance[0].start"
    ode = only(changed(PAPER, {"disturbance": [PUSH]}))
    assert ode.key == "disturbance"
    assert "kinematic_ode has no forces" in ode.allowed


def test_films_in_patches_do_not_go_with_a_moving_floor():
    slip = {"kind": "proportional", "lateral": 0.1}
    assert refused(changed(floor(patch=[DISC]), {"slip": slip})) == []
    wet = only(changed(floor(patch=[{**DISC, "film": 20.0}]), {"slip": slip}))
    assert "together with [slip], whose floor moves under the film" in wet.found


def test_terrain_is_read_swept_and_refused_where_it_does_not_fit():
    bumps = {"kind": "bumps", "amplitude": 0.01, "wavelength": 0.6, "seed": 5}
    assert read(floor(terrain=bumps)).ground.terrain == Bumps(**bumps)
    grid = worlds(read({**floor(terrain=bumps), "sweep": {"ground.terrain.seed": [1, 2]}}))
    assert [world.scenario.model_dump()["ground"]["terrain"]["seed"] for world in grid] == [1, 2]
    ignored = only(floor(terrain={**bumps, "heading_deg": 3.0}))
    assert str(ignored) == (
        "ground.terrain.heading_deg: found a key of waves, which bumps would ignore; "
        "allowed: kind, amplitude, wavelength, seed"
    )
    assert only(floor(terrain={**bumps, "kind": "steps"})).allowed == '"waves", "bumps"'
    assert only(floor(terrain=3.0)).allowed == "a table, kinds: waves, bumps"
    belt = only(changed(floor(terrain=bumps), {"slip": {"kind": "proportional", "lateral": 0.1}}))
    assert "[slip], whose moving floor is level" in belt.found
    wet = only(floor(terrain=bumps, patch=[{**DISC, "film": 20.0}]))
    assert "patches and a film" in wet.found
    assert refused(floor(terrain=bumps, patch=[DISC])) == []
    assert scenario_id(read(floor(terrain=bumps))) != scenario_id(read(floor(terrain={**bumps, "seed": 6})))


def test_entries_of_arrays_are_swept_by_their_index():
    document = floor(patch=[DISC, {**STRIPES, "count": 2}])
    document["disturbance"] = [PUSH]
    document["sweep"] = {
        "ground.patch.0.friction": [0.1, 0.3],
        "ground.patch.1.count": [1, 2],
        "disturbance.0.force": [5.0],
    }
    grid = worlds(read(document))
    assert [
        (w.scenario.ground.patch[0].friction, w.scenario.ground.patch[1].model_dump()["count"]) for w in grid
    ] == [
        (0.1, 1), (0.1, 2), (0.3, 1), (0.3, 2),
    ]  # fmt: skip
    assert {w.scenario.disturbance[0].force for w in grid} == {5.0}
    assert document["ground"]["patch"][0]["friction"] == 0.1
    for key in ("ground.patch.2.friction", "ground.patch.0.width", "disturbance.0.kind"):
        problem = only({**document, "sweep": {key: [1.0]}})
        assert problem.key == f"sweep.{key}"
        assert "ground.patch.0.friction" in problem.allowed
    bad = only({**document, "sweep": {"ground.patch.0.radius": [0.1, -0.1]}})
    assert (bad.key, bad.found) == ("sweep.ground.patch.0.radius", "-0.1")


def test_the_identity_counts_what_differs_and_only_that():
    plain = scenario_id(read(floor()))
    assert scenario_id(read(floor(patch=[], change=[]))) == plain
    ids = {
        scenario_id(read(floor(**ground)))
        for ground in (
            {"patch": [DISC]},
            {"patch": [DISC, STRIPES]},
            {"patch": [STRIPES, DISC]},
            {"change": [{"time": 1.0, "friction": 0.2}]},
        )
    }
    assert len(ids | {plain}) == 5
    assert scenario_id(read(floor(patch=[{**STRIPES, "x": 0.0}]))) == scenario_id(
        read(floor(patch=[STRIPES]))
    )


@pytest.mark.parametrize("name", ["ice-stripes", "puddle", "push", "sudden-rain", "bumpy-floor"])
def test_templates_of_such_scenarios_mean_the_same(name):
    assert scenario_id(read(tomllib.loads(template(name, "mine")))) == scenario_id(load(name))


def test_templates_name_the_arrays_where_they_could_stand():
    assert "# Pushes on the robot: [[disturbance]]" in template("wet-slope", "mine")
    assert "[[ground.patch]]" in template("wet-slope", "mine")
    assert "[[" + "disturbance" not in template("paper-kinematic", "mine")
    assert read(TORQUE).disturbance == ()
