"""How much a number may move: from how far it was seen to move, not guessed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from slipctl.metrics import UNITS
from slipctl.regression.baseline.file import Number
from slipctl.regression.baseline.gated import CHAOTIC, LARGER_IS_BETTER, NUDGE, allowances, is_chaotic


@dataclass(frozen=True)
class Seen:
    """What one metric of one run gave in the runs beside it; None where a number was not finite.

    Attributes
    ----------
    nudged
        From moved starts.
    threads
        On other numbers of threads: the same as the run itself, rounding aside.
    halved
        With half the timestep: one number, or none where the plant has no timestep.
    same_status
        Whether all those runs ended as the run itself did. If one did not, its numbers are other quantities.
    """

    nudged: Sequence[float | None]
    threads: Sequence[float | None]
    halved: Sequence[float | None] = ()
    same_status: bool = True


def number(metric: str, value: float | None, seen: Seen, ticks: int) -> Number:
    """Give a value its tolerances and its gate.

    Parameters
    ----------
    metric : str
        One of `slipctl.regression.baseline.gated.GATED`.
    value : float or None
        None where it was not finite, or where there is no guarantee to speak of.
    seen : Seen
    ticks : int
        Length of the run.
    """
    everything = [*seen.nudged, *seen.threads, *seen.halved]
    if value is None:
        why = "no theorem" if metric in LARGER_IS_BETTER else "not finite"
        if all(other is None for other in everything) and seen.same_status:
            return Number(value=None, tolerance=0.0, tolerance_elsewhere=0.0, why=why)
        why = f"chaotic: {why}, but otherwise nearby; {GATED_ON}"
        return Number(value=None, tolerance=0.0, tolerance_elsewhere=0.0, gate="verdict", why=why)
    nudged, threads = _largest(value, seen.nudged), _largest(value, seen.threads)
    halving = _largest(value, seen.halved) if seen.halved else None
    spread = max(nudged or 0.0, threads or 0.0)
    reason, tolerance = max(allowances(metric, value, spread, ticks).items(), key=lambda item: item[1])
    sizes = {
        "tolerance": tolerance,
        "tolerance_elsewhere": max(tolerance, halving or 0.0),
        "halving": halving,
    }
    moved = _moved(metric, nudged, threads, halving if seen.halved else None, bool(seen.halved))
    if not seen.same_status or any(other is None for other in everything):
        why = f"chaotic: a run beside this one ended otherwise; {GATED_ON}; {moved}"
        return Number(value=value, spread=None, gate="verdict", why=why, **sizes)
    if is_chaotic(metric, value, spread):
        why = f"chaotic: {reason} are more than {CHAOTIC:.0%} of the value; {GATED_ON}; {moved}"
        return Number(value=value, spread=spread, gate="verdict", why=why, **sizes)
    return Number(value=value, spread=spread, why=f"{reason}; {moved}", **sizes)


GATED_ON = "gated on its status and the scenario's claims only"


def _largest(value: float, others: Sequence[float | None]) -> float | None:
    """Return the largest difference; None where there is none to take."""
    if not others or any(other is None for other in others):
        return None
    return max(abs(other - value) for other in others if other is not None)


def _moved(
    metric: str, nudged: float | None, threads: float | None, halving: float | None, steps: bool
) -> str:
    unit = UNITS[metric].split()[0].replace("1", "").strip()
    parts = [
        f"moved by {_size(nudged, unit)} from starts moved by {NUDGE:g} m or rad",
        f"{_size(threads, unit)} on 1 to 3 threads",
    ]
    if steps:
        parts.append(f"{_size(halving, unit)} at half the timestep")
    return ", ".join(parts)


def _size(moved: float | None, unit: str) -> str:
    if moved is None:
        return "an unknown amount"
    return f"{moved:.1e} {unit}".strip() if moved else "nothing"
