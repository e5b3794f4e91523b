"""The hypotheses of the theorem behind the robust law, checked on a recording."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipctl.recording import Columns

SLACK = 1e-9
"""Relative: the paper's own slip meets its bounds with equality (83)."""


@dataclass(frozen=True)
class Hypotheses:
    """What the robust law assumes.

    Attributes
    ----------
    slip_bound : (N,) array
        α [1].
    speed_floor : (N,) array
        The speed below which v counts as zero [m/s].
    uncertainty : str
        Name of the bound; it decides how α limits the slip.
    """

    slip_bound: np.ndarray
    speed_floor: np.ndarray
    uncertainty: str


def with_guarantee(columns: Columns, hypotheses: Hypotheses | None, tick: float) -> Columns:
    """Add ‖η_k‖ and, for a law with a theorem, whether every hypothesis held over tick k.

    η_k = (Ḟ_{k+1} − Ḟ_k)/tick − v_k is what the closed loop really did beyond the flat input, whatever the
    reason: slip, servo, sampling or saturation. The hypotheses are Assumption 4.1 on the measured slip (with
    ≤, as the paper's own simulation needs), the bound on |w_s| of Assumption 4.2, ‖η‖ ≤ ρ, and v away from
    zero. The bounds on the slip *rates* of Assumption 4.2 enter the theorem through ‖η‖ only, where they are
    measured together with everything else.

    Parameters
    ----------
    columns : dict of (N, T) arrays
    hypotheses : Hypotheses or None
        None for a law without a theorem: then `guarantee.held` is left out.
    tick : float
        [s].

    Returns
    -------
    dict of (N, T) arrays
        With `guarantee.uncertainty` and `guarantee.held`; the last row has no tick and holds no value.
    """
    columns = dict(columns)
    eta = []
    for axis in ("x", "y"):
        velocity = columns[f"motion.velocity.{axis}"]
        flat_input = columns[f"decision.nominal_input.{axis}"] + columns[f"decision.robust_input.{axis}"]
        eta.append((velocity[:, 1:] - velocity[:, :-1]) / tick - flat_input[:, :-1])
    size = np.zeros_like(columns["motion.forward_speed"])
    size[:, :-1] = np.sqrt(eta[0] * eta[0] + eta[1] * eta[1])
    columns["guarantee.uncertainty"] = size
    if hypotheses is not None:
        columns["guarantee.held"] = _held(columns, hypotheses, size)
    return columns


def _held(columns: Columns, hypotheses: Hypotheses, uncertainty: np.ndarray) -> np.ndarray:
    alpha = hypotheses.slip_bound[:, None]
    speed = np.abs(columns["motion.forward_speed"])
    along, across = np.abs(columns["slip.longitudinal"]), np.abs(columns["slip.lateral"])
    allowed = alpha * speed * (1.0 + SLACK)
    if hypotheses.uncertainty == "paper":
        bounded = along + across <= 2.0 * allowed
    elif hypotheses.uncertainty == "slip_ratio":
        bounded = np.sqrt(along * along + across * across) <= math.sqrt(2.0) * allowed
    else:
        bounded = (along <= allowed) & (across <= allowed)
    yaw_bounded = np.abs(columns["slip.yaw"]) <= allowed
    away_from_zero = speed >= hypotheses.speed_floor[:, None] * (1.0 - SLACK)
    covered = uncertainty <= columns["decision.robust_gain"] * (1.0 + SLACK)
    return bounded & yaw_bounded & away_from_zero & covered
