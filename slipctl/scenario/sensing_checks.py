"""The rules between the keys of `[sensing]` and the tick."""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl.scenario.applies import ignored
from slipctl.scenario.base import lookup
from slipctl.scenario.problems import Problem
from slipctl.scenario.sensing import DELAYS
from slipctl.scenario.values import has, misses_multiple, value_at


def sensing_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything wrong between the sensors and the times of a run."""
    camera = lookup(raw, "sensing", "pose") == "odometry_camera"
    if camera and not has(raw, "sensing", "camera_rate"):
        found = 'nothing, though pose = "odometry_camera" needs it'
        yield Problem("sensing.camera_rate", found, "a number > 0 [Hz]")
    tick = value_at(raw, "tick")
    if tick is None or tick <= 0:
        return
    rate = value_at(raw, "sensing", "camera_rate")
    if camera and rate is not None and rate * tick > 1 + 1e-9:
        found = f"{rate:g} Hz, {rate * tick:.4g} fixes a tick"
        yield Problem("sensing.camera_rate", found, f"at most one fix a tick, {1 / tick:g} Hz")
    without = ignored(raw)
    for key in DELAYS:
        delay = value_at(raw, "sensing", key)
        if delay is None or delay < 0 or ("sensing", key) in without:
            continue
        if misses_multiple(delay, tick):
            lower = int(delay / tick)
            yield Problem(
                f"sensing.{key}",
                f"{delay:g} s, {delay / tick:.6g} times the tick",
                f"a multiple of tick ({tick:g} s), such as {lower * tick:.9g} or {(lower + 1) * tick:.9g} s",
            )
