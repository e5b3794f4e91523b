"""The sentence about a law's theorem."""

from __future__ import annotations

from typing import Any

from slipctl.guarantee import METRIC_UNITS
from slipctl.report import guarantee

KEPT = {
    "settling_time": 5.0,
    "settled_error": 0.00085,
    "error_bound": 0.01,
    "error_bound_share": 0.085,
    "calm_fraction": 1.0,
    "calm_tick": 0.0135,
}
BROKEN = {
    "first_violation": "yaw_slip_bounded",
    "first_violation_time": 0.97,
    "first_violation_excess": 0.275,
    "calm_fraction": 0.4,
    "calm_tick": 0.001,
    "alarm_time": 1.18,
}


def run(fraction: float | None, **told: Any) -> dict[str, Any]:
    nothing = {"first_violation": None} | dict.fromkeys(METRIC_UNITS)
    return {"metrics": {"guarantee_fraction": fraction}, "guarantee": nothing | told}


def test_a_promise_stands_beside_what_was_achieved():
    assert guarantee.sentence("robust", [run(1.0, **KEPT)]) == (
        "robust: every hypothesis of its theorem holds, from 5.0 s on the error stays below 0.85 mm, "
        "promised are 10 mm"
    )


def test_a_violation_has_a_name_a_time_and_a_size():
    assert guarantee.sentence("robust", [run(0.109, **BROKEN)]) == (
        "robust: the hypotheses of its theorem hold on 11 % of the ticks; violated first: yaw slip within "
        "its bound, at 0.97 s, by 28 %; slip alarm at 1.18 s"
    )


def test_an_excess_of_many_limits_is_counted_in_limits():
    said = guarantee.sentence("robust", [run(0.9, **(BROKEN | {"first_violation_excess": 63.88}))])
    assert said is not None
    assert "at 0.97 s, by 64 times its limit" in said


def test_almost_all_is_not_all():
    said = guarantee.sentence("robust", [run(0.9999, **BROKEN)])
    assert said is not None
    assert "99.9 % of the ticks" in said


def test_many_worlds_are_counted():
    runs = [run(0.1, **BROKEN), run(1.0, **KEPT), run(1.0, **(KEPT | {"error_bound_share": 0.2}))]
    assert guarantee.sentence("robust", runs, "ground.friction 0.2 to 0.8") == (
        "robust: every hypothesis of its theorem holds in 2 of 3 worlds: ground.friction 0.2 to 0.8; errors "
        "reach 20 % of their bound; violated first: yaw slip within its bound (1); slip alarm in 1 of them"
    )


def test_a_tick_that_chatters_is_said():
    said = guarantee.sentence("robust", [run(1.0, **(KEPT | {"calm_fraction": 0.9}))])
    assert said is not None
    assert said.endswith("the tick is above its chatter threshold on 10 % of the ticks (13.5 ms at worst)")


def test_a_consequence_that_does_not_follow_is_said():
    said = guarantee.sentence("robust", [run(1.0, **(KEPT | {"lyapunov_fraction": 0.55}))])
    assert said is not None
    assert said.endswith("V = eᵀPe all the same grew on up to 45 % of the ticks on which it should fall")
    broken = guarantee.sentence("robust", [run(0.5, **(BROKEN | {"lyapunov_fraction": 0.55}))])
    assert broken is not None
    assert "grew" not in broken


def test_laws_without_a_theorem_get_no_sentence():
    assert guarantee.sentence("nominal", [run(None)]) is None
    assert guarantee.sentence("robust", [{"metrics": {"guarantee_fraction": 1.0}}]) is None
