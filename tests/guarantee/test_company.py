"""A world's verdict does not depend on the worlds beside it."""

from __future__ import annotations

import numpy as np
import pytest

from slipctl.guarantee import Hypotheses, verdict, verdicts, with_guarantee
from tests.guarantee.recordings import TICK, hypotheses, sound

ROWS = 900


def worlds(order: int) -> tuple[dict[str, np.ndarray], Hypotheses]:
    """Return worlds that hold and that break a hypothesis early or late, with poles of their own."""
    rng = np.random.default_rng(order)
    alone = sound(ROWS, order)
    columns = {name: np.repeat(values, 5, axis=0) for name, values in alone.items()}
    columns["slip.yaw"][1, 3] = 5.0
    columns["motion.forward_speed"][2, 700] = 0.0
    columns["decision.robust_gain"][3] = rng.uniform(0.05, 0.4, ROWS)
    columns["error.position"] = rng.uniform(0.0, 0.01, (5, ROWS))
    parts = [
        hypotheses(order=order, pole=pole, boundary_layer=np.array([layer]))
        for pole, layer in ((-0.5, 0.02), (-1.0, 0.02), (-1.0, 0.05), (-2.0, 0.01), (-0.5, 0.02))
    ]
    together = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("slip_bound", "speed_floor", "boundary_layer", "gains", "weights")
    }
    return columns, Hypotheses(uncertainty="independent", **together)


@pytest.mark.parametrize("order", [2, 3])
def test_a_verdict_is_the_same_alone_and_in_company(order):
    columns, wanted = worlds(order)
    columns = with_guarantee(columns, wanted, TICK)
    last_rows = [ROWS - 1, ROWS - 1, 800, 650, 0]
    together = verdicts(columns, wanted, last_rows, TICK)
    for world, last in enumerate(last_rows):
        assert together[world] == verdict(columns, wanted, world, last, TICK)
        own = {name: values[world : world + 1].copy() for name, values in columns.items()}
        again = with_guarantee(own, wanted.of(slice(world, world + 1)), TICK)
        assert all(again[name].tobytes() == own[name].tobytes() for name in own)
    assert together[1]["first_violation"] == "yaw_slip_bounded"
    assert together[1]["first_violation_time"] == pytest.approx(3 * TICK)
    assert together[2]["first_violation"] == "speed_above_floor"
    assert together[4]["calm_tick"] is None
    levels = [told["lyapunov_level"] for told in together]
    assert levels[0] is not None
    assert levels[0] != levels[1]
    assert levels[1] != levels[2]
