"""The theorem of a law in pictures: what is bounded beside its bound, lanes, events, and a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipctl.guarantee import HYPOTHESES
from slipctl.guarantee.words import millimetres, percent, sentence
from slipctl.view.content import Theorem
from slipctl.view.tracks import Array, Track

Lane = tuple[str, tuple[str, int], tuple[str, int]]
"""Entity below the run's `state`, word and colour while true, word and colour while false."""

GREEN, GREY, VERMILLION, PURPLE = 0x009E73FF, 0x3A3F44FF, 0xD55E00FF, 0xCC79A7FF

HELD: Lane = ("guarantee", ("held", GREEN), ("not held", 0x7A4B00FF))
LANES: dict[str, Lane] = {
    "guarantee.speed_above_floor": ("speed above its floor", ("held", GREEN), ("violated", VERMILLION)),
    "guarantee.slip_bounded": ("slip within its bound", ("held", GREEN), ("violated", VERMILLION)),
    "guarantee.yaw_slip_bounded": ("yaw slip within its bound", ("held", GREEN), ("violated", VERMILLION)),
    "guarantee.feedback_exact": ("feedback exact", ("held", GREEN), ("violated", VERMILLION)),
    "guarantee.uncertainty_covered": ("η covered by ρ", ("held", GREEN), ("violated", VERMILLION)),
    "guarantee.lyapunov_falls": ("V falls or layer holds", ("yes", GREEN), ("no", PURPLE)),
    "guarantee.calm": ("tick below chatter", ("calm", GREEN), ("chatters", PURPLE)),
    "guarantee.alarm": ("slip monitor", ("alarm", VERMILLION), ("quiet", GREY)),
}
"""Column to lane, in the order in which they are stacked."""


def slip_title(theorem: Theorem) -> str:
    """Name the plot of the slip that the theorem bounds."""
    if theorem.lateral_slip_bound is not None:
        return "Slip |v_t|, |v_s| [m/s] · wide: their bounds"
    wide = f"wide: {theorem.slip_bound:g}|v|"
    if theorem.uncertainty == "paper" and theorem.order == 2:
        return f"Slip, mean of |v_t|, |v_s| [m/s] · {wide}"
    if theorem.uncertainty == "slip_ratio":
        return f"Slip √((v_t² + v_s²)/2) [m/s] · {wide}"
    return f"Slip |v_t|, |v_s| [m/s] · {wide}"


def quantities(track: Track) -> list[tuple[str, str, Array]]:
    """Return path, unit and values (T,) of what only the pictures of the theorem show.

    What is promised counts from the end of the transient; before it there is NaN, and no series at all where
    hypotheses were violated after it.
    """
    theorem, told = track.info.theorem, track.info.guarantee
    if theorem is None or not track.has("guarantee.lyapunov"):
        return []
    speed = np.abs(track.values("motion.forward_speed"))
    along, across = (np.abs(track.values(f"slip.{name}")) for name in ("longitudinal", "lateral"))
    allowed = theorem.slip_bound * speed
    found: list[tuple[str, str, Array]] = []
    if theorem.lateral_slip_bound is not None:
        found.append(("guarantee.bound.v_s", "m/s", np.full_like(speed, theorem.lateral_slip_bound)))
        found += [("guarantee.bound.slip", "m/s", allowed)]
        found += [("guarantee.size.v_t", "m/s", along), ("guarantee.size.v_s", "m/s", across)]
    else:
        found.append(("guarantee.bound.slip", "m/s", allowed))
        if theorem.uncertainty == "paper" and theorem.order == 2:
            found.append(("guarantee.size.slip", "m/s", (along + across) / 2.0))
        elif theorem.uncertainty == "slip_ratio":
            found.append(("guarantee.size.slip", "m/s", np.sqrt((along * along + across * across) / 2.0)))
        else:
            found += [("guarantee.size.v_t", "m/s", along), ("guarantee.size.v_s", "m/s", across)]
    yaw = theorem.yaw_slip_bound
    found.append(("guarantee.bound.w_s", "rad/s", allowed if yaw is None else np.full_like(speed, yaw)))
    found.append(("guarantee.size.w_s", "rad/s", np.abs(track.values("slip.yaw"))))
    found.append(("guarantee.bound.layer", "1", np.full_like(speed, theorem.boundary_layer)))
    settled = told.get("settling_time")
    if isinstance(settled, float) and told.get("error_bound") is not None:
        later = track.time >= settled - 1e-9
        for path, unit, value in (
            ("guarantee.bound.level", "1", told.get("lyapunov_level")),
            ("guarantee.bound.error", "m", told["error_bound"]),
        ):
            if isinstance(value, float):
                found.append((path, unit, np.where(later, value, np.nan)))
    return found


def violations(track: Track, k: int) -> str:
    """Return the hypotheses that do not hold in row `k`, in words."""
    names = [
        words
        for name, words in HYPOTHESES.items()
        if track.has(f"guarantee.{name}") and track.values(f"guarantee.{name}")[k] == 0
    ]
    return ", ".join(names)


def page(tracks: Sequence[Track]) -> list[str]:
    """Return the part of the page *Run info* about the theorem, as lines of Markdown."""
    judged = [
        track
        for track in tracks
        if track.info.guarantee and track.info.metrics.get("guarantee_fraction") is not None
    ]
    if not judged:
        return []
    lines = ["## Guarantee", ""]
    for track in judged:
        fraction = track.info.metrics["guarantee_fraction"]
        assert fraction is not None
        lines.append(f"* {track.name}: {sentence(fraction, track.info.guarantee)}")
        lines += [f"  * {text}" for text in _details(track)]
    return [*lines, ""]


def _details(track: Track) -> list[str]:
    told, parts = track.info.guarantee, []
    shares = {
        words: track.values(f"guarantee.{name}")
        for name, words in HYPOTHESES.items()
        if track.has(f"guarantee.{name}")
    }
    broken = {words: np.nanmean(values) for words, values in shares.items() if np.nanmin(values) == 0}
    if broken:
        said = ", ".join(f"{words} {percent(float(share))}" for words, share in broken.items())
        parts.append(f"share of the ticks on which each one that was violated held: {said}")
    bounds = [
        f"{words} {millimetres(value)}"
        for name, words in (
            ("error_bound_small_gain", "small gain"),
            ("error_bound_tight_level_set", "tight level set"),
            ("error_bound_level_set", "level set of the appendix, corrected"),
        )
        if isinstance(value := told.get(name), float)
    ]
    if bounds and told.get("error_bound") is not None:
        parts.append(
            f"bounds on the position error from {told['settling_time']:.1f} s on: {', '.join(bounds)}; "
            f"reached {millimetres(float(told['settled_error'] or 0.0))}"
        )
    calm, share = told.get("calm_tick"), told.get("calm_fraction")
    if isinstance(share, float) and share < 1.0:
        parts.append(f"the tick is below the chatter threshold {percent(share)} of the time")
    elif isinstance(calm, float):
        parts.append(f"ticks up to {1e3 * calm:.3g} ms would have stayed below the chatter threshold")
    alarm = told.get("alarm_time")
    parts.append("the slip monitor stayed quiet" if alarm is None else f"slip alarm at {alarm:.2f} s")
    return parts
