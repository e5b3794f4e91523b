"""What every plant and every law owes the loop: purity, determinism, worlds that do not feel each other."""

from __future__ import annotations

import copy
import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from slipctl.plants.ode import KinematicOde
from slipctl.theory.reference import FigureEight, Placement
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.robust import UNCERTAINTIES
from slipctl.theory.slip import SinusoidalSlip
from slipctl.tick import Motion, Reference
from tests.builders import leaves, robust_law, rows_of, track
from tests.dynamic import BOUNDS, dynamic_plant, robust_dynamic
from tests.lineup import (
    EVERY_LAW,
    EVERY_PLANT,
    LAWS,
    PLANTS,
    TICK,
    TICKS,
    TORQUE_LAWS,
    TORQUE_PLANTS,
    WORLDS,
    Loop,
    beginning,
    nominal_for,
    robust_for,
)


def assert_same(left: dict[str, Any], right: dict[str, Any]) -> None:
    assert left.keys() == right.keys()
    for name in left:
        np.testing.assert_array_equal(left[name], right[name], err_msg=name)


def one_world(seen: dict[str, Any], world: int) -> dict[str, Any]:
    return {name: leaf[world : world + 1] for name, leaf in seen.items()}


# every plant with one law of each kind, and every law on one plant of each kind
PAIRS = sorted(
    {*itertools.product(PLANTS, ("nominal_kinematic", "robust_independent"))}
    | {*itertools.product(("ode_proportional", "mujoco"), LAWS)}
    | {*itertools.product(TORQUE_PLANTS, ("nominal_dynamic", "robust_dynamic_proportional"))}
    | {*itertools.product(("dynamic_ode_sinusoidal", "mujoco_torque"), TORQUE_LAWS)}
)


@pytest.mark.parametrize(("plant", "law"), PAIRS)
def test_a_batch_of_one_is_its_row_in_a_batch_of_many_bit_for_bit(plant, law):
    loop = Loop(plant, law)
    _, _, many = loop.go(*loop.begin(), 0, TICKS)
    for world in WORLDS:
        alone = Loop(plant, law, [world])
        _, _, single = alone.go(*alone.begin(), 0, TICKS)
        for all_worlds, row in zip(many, single, strict=True):
            assert_same(one_world(all_worlds, world), row)
    paths = np.stack([seen["[0].position"] for seen in many])
    assert len({tuple(path.ravel()) for path in np.swapaxes(paths, 0, 1)}) == len(WORLDS)


@pytest.mark.parametrize(("plant", "law"), PAIRS)
def test_order_of_the_worlds_does_not_matter(plant, law):
    order = [3, 0, 4, 2, 1]
    loop, shuffled = Loop(plant, law), Loop(plant, law, order)
    _, _, seen = loop.go(*loop.begin(), 0, TICKS)
    _, _, mixed = shuffled.go(*shuffled.begin(), 0, TICKS)
    assert_same({name: leaf[order] for name, leaf in seen[-1].items()}, mixed[-1])


@pytest.mark.parametrize(("plant", "law"), PAIRS)
def test_the_same_run_gives_the_same_bits(plant, law):
    """Again on the same objects, dirty from the first run, and on new ones."""
    loop = Loop(plant, law)
    _, _, first = loop.go(*loop.begin(), 0, TICKS)
    _, _, again = loop.go(*loop.begin(), 0, TICKS)
    new = Loop(plant, law)
    _, _, anew = new.go(*new.begin(), 0, TICKS)
    for left, right, third in zip(first, again, anew, strict=True):
        assert_same(left, right)
        assert_same(left, third)


@pytest.mark.parametrize(("plant", "law"), PAIRS)
def test_a_run_goes_on_from_the_middle_with_the_same_bits(plant, law):
    """From a kept state and memory: on the same objects after they went on, and on new ones."""
    loop = Loop(plant, law)
    state, memory, _ = loop.go(*loop.begin(), 0, TICKS // 2)
    _, _, rest = loop.go(state, memory, TICKS // 2, TICKS)
    _, _, again = loop.go(state, memory, TICKS // 2, TICKS)
    kept = copy.deepcopy((state, memory))
    _, _, elsewhere = Loop(plant, law).go(*kept, TICKS // 2, TICKS)
    for left, right, third in zip(rest, again, elsewhere, strict=True):
        assert_same(left, right)
        assert_same(left, third)


@pytest.mark.parametrize("plant", EVERY_PLANT)
def test_plants_are_pure(plant):
    """`step`, `observe` and `details` change neither state nor command, and answer the same bits again."""
    loop = Loop(plant, robust_for(plant))
    state, memory, _ = loop.go(*loop.begin(), 0, 5)
    motion = loop.plant.observe(state)
    reference = loop.references.row(5)
    command = loop.law.update(memory, reference, motion, TICK).command
    inputs = copy.deepcopy((state, command, motion))
    stepped = copy.deepcopy(loop.plant.step(state, command, TICK))
    other = loop.plant.step(loop.plant.step(state, command, TICK), command, TICK)  # go elsewhere in between
    loop.plant.details(other)
    again = loop.plant.step(state, command, TICK)
    assert_same(leaves(inputs), leaves((state, command, motion)))
    assert_same(leaves(stepped), leaves(again))
    assert_same(leaves(inputs[2]), leaves(loop.plant.observe(state)))
    assert (again.status == 0).all()
    assert not np.array_equal(loop.plant.observe(again).position, motion.position)


@pytest.mark.parametrize("plant", EVERY_PLANT)
def test_starting_anew_leaves_old_states_valid(plant):
    loop = Loop(plant, nominal_for(plant))
    start = beginning(WORLDS)
    before = copy.deepcopy(start)
    state = loop.go(*loop.begin(), 0, 5)[0]
    kept = copy.deepcopy(leaves((state, loop.plant.observe(state))))
    loop.plant.start(start)
    assert_same(kept, leaves((state, loop.plant.observe(state))))
    assert_same(leaves(before), leaves(start))


@pytest.mark.parametrize("law", EVERY_LAW)
def test_laws_are_pure(law):
    controller = EVERY_LAW[law](WORLDS)
    rng = np.random.default_rng(3)
    worlds = len(WORLDS)
    heading = rng.uniform(-math.pi, math.pi, worlds)
    motion = Motion(
        rng.normal(size=(worlds, 2)),
        rng.normal(size=(worlds, 2)),
        np.stack([np.cos(heading), np.sin(heading)], axis=-1),
        *(
            rng.normal(size=shape)
            for shape in (worlds, (worlds, 2), (worlds, 2), worlds, worlds, (worlds, 2))
        ),
    )
    first, second, third, fourth = (rng.normal(size=(worlds, 2)) for _ in range(4))
    reference = Reference(first, second, third, fourth)
    memory = controller.start(replace(beginning(WORLDS), forward_speed=rng.uniform(0.1, 1.0, worlds)))
    inputs = copy.deepcopy((memory, reference, motion))
    decision = copy.deepcopy(controller.update(memory, reference, motion, TICK))
    controller.update(decision.memory, reference, motion, TICK)
    again = controller.update(memory, reference, motion, TICK)
    assert_same(leaves(inputs), leaves((memory, reference, motion)))
    left, right = leaves(decision), leaves(again)
    assert_same(
        {k: v for k, v in left.items() if v is not None}, {k: v for k, v in right.items() if v is not None}
    )


@pytest.mark.parametrize("plant", EVERY_PLANT)
def test_plants_start_as_asked(plant):
    """Planned pose and wheel rates, to rounding; the wheels' rates are those of v and w."""
    start = beginning(WORLDS)
    motion = EVERY_PLANT[plant](WORLDS)
    seen = motion.observe(motion.start(start))
    np.testing.assert_allclose(seen.position, start.position, rtol=0, atol=1e-12)
    facing = np.stack([np.cos(start.heading), np.sin(start.heading)], axis=-1)
    np.testing.assert_allclose(seen.heading_vector, facing, rtol=0, atol=1e-12)
    np.testing.assert_allclose(seen.forward_speed, start.forward_speed, rtol=0, atol=1e-12)
    np.testing.assert_allclose(seen.yaw_rate, start.yaw_rate, rtol=0, atol=1e-12)
    assert seen.forward_speed.any()


@pytest.mark.parametrize("plant", EVERY_PLANT)
def test_world_that_ends_is_frozen_and_the_others_do_not_notice(plant):
    """World 2 drives out of a small arena; without it the others do the same to the last bit."""
    small = np.array([50.0, 50.0, 0.1, 50.0, 50.0])
    loop = Loop(plant, nominal_for(plant))
    loop.plant = _with_arena(loop.plant, small)
    _, _, seen = loop.go(*loop.begin(), 0, TICKS)
    status = np.stack([row["[3]"] for row in seen])
    assert (status[-1] != 0).tolist() == [False, False, True, False, False]
    first = int(np.argmax(status[:, 2] != 0))
    assert 0 < first < TICKS // 2
    positions = np.stack([row["[0].position"] for row in seen])
    assert (positions[first:, 2] == positions[first, 2]).all()
    others = Loop(plant, nominal_for(plant), [0, 1, 3, 4])
    others.plant = _with_arena(others.plant, small[[0, 1, 3, 4]])
    _, _, rest = others.go(*others.begin(), 0, TICKS)
    for left, right in zip(seen, rest, strict=True):
        assert_same({name: leaf[[0, 1, 3, 4]] for name, leaf in left.items()}, right)


def _with_arena(plant: Any, arena: Any) -> Any:
    return type(plant)(
        **{**{name: getattr(plant, name) for name in plant.__dataclass_fields__}, "arena": arena}
    )


@pytest.mark.parametrize("drive", ["wheel_speed", "wheel_torque"])
def test_wide_batches_round_as_narrow_ones(drive):
    """Vector instructions take eight worlds at once and the rest otherwise; the bits must not tell."""
    worlds = 37
    rng = np.random.default_rng(11)
    values = {name: rng.uniform(-0.4, 0.4, worlds) for name in ("longitudinal", "lateral", "yaw")}
    period, speed = rng.uniform(0.5, 2.0, worlds), rng.uniform(0.2, 1.0, worlds)
    heading, pole = rng.uniform(-3.0, 3.0, worlds), rng.uniform(-3.0, -0.5, worlds)

    def final(rows: Any) -> dict[str, Any]:
        slip = SinusoidalSlip(**{name: value[rows] for name, value in values.items()}, period=period[rows])
        zero = np.zeros(len(rows))
        plan = FigureEight(zero + 2.0, speed[rows], Placement(zero, zero, heading[rows]))
        if drive == "wheel_torque":
            plant: Any = dynamic_plant(slip, len(rows))
            law: Any = robust_dynamic(pole[rows], zero + 0.05, BOUNDS["proportional"](zero + 0.3))
        else:
            plant = KinematicOde(MAGELLAN_PRO, slip, zero + 50.0)
            law = robust_law(pole[rows], zero + 0.4, zero + 0.05, UNCERTAINTIES["independent"].bound)
        return leaves(track(plant, law, rows_of(plan, TICK, 0.3), TICK).rows[-1].motion)

    together = final(np.arange(worlds))
    for world in range(worlds):
        assert_same(one_world(together, world), final(np.array([world])))


@pytest.mark.parametrize("plant", TORQUE_PLANTS)
def test_some_worlds_of_the_lineup_meet_their_torque_limit_and_others_do_not(plant):
    loop = Loop(plant, "nominal_dynamic")
    _, _, seen = loop.go(*loop.begin(), 0, TICKS)
    met = np.stack([row["[2].saturated"] for row in seen]).any(axis=0)
    assert met.any()
    assert not met.all()
