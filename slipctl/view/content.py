"""What a recording is made of, stated without Rerun: runs, worlds, names and identities."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


class RecordingError(RuntimeError):
    """A recording could not be written; the message says what to change."""


class ViewerError(RuntimeError):
    """The viewer could not be opened; the message says what to change."""


@dataclass(frozen=True)
class RunInfo:
    """One controller in one world.

    Attributes
    ----------
    run : int
        Value of the column ``run`` in the signals.
    label : str
        The controller's label, unique within the world; part of every entity path.
    kind : str
        The controller's kind; decides the colour.
    status : str
        ``completed`` or why the run ended early.
    end_time : float or None
        When it ended [s]; None = at its last row.
    metrics : mapping of str to float or None
        Shown side by side in the tab *Run info* and stored as properties of the recording.
    slip_bound : float or None
        α of ‖slip‖ ≤ α|v|, drawn beside the slip [1]; None = no bound.
    theorem : Theorem or None
        What the law's theorem assumes; None = it has none.
    guarantee : mapping of str to float, str or None
        As of `slipctl.guarantee.verdict`.
    """

    run: int
    label: str
    kind: str = ""
    status: str = "completed"
    end_time: float | None = None
    metrics: Mapping[str, float | None] = field(default_factory=dict)
    slip_bound: float | None = None
    theorem: Theorem | None = None
    guarantee: Mapping[str, float | str | None] = field(default_factory=dict)


@dataclass(frozen=True)
class Theorem:
    """What the theorem of a law assumes; all that pictures need of it.

    Attributes
    ----------
    uncertainty : str
        Name of the bound ρ.
    slip_bound, boundary_layer : float
        α and ε.
    yaw_slip_bound, lateral_slip_bound : float or None
        ξ₁ [rad/s] and ξ₂ [m/s] where they stand for α|v|.
    order : int
        2 for a kinematic law, 3 for a dynamic one.
    """

    uncertainty: str
    slip_bound: float
    boundary_layer: float
    yaw_slip_bound: float | None = None
    lateral_slip_bound: float | None = None
    order: int = 2


@dataclass(frozen=True)
class WorldRecording:
    """One file to be written by `slipctl.view.write_recordings`.

    Attributes
    ----------
    file : str
        File name relative to the folder, ending in ``.rrd``.
    runs : tuple of RunInfo
        The controllers of the world, in the order of the scenario.
    info : mapping
        As for `slipctl.view.write_recording`.
    """

    file: str
    runs: tuple[RunInfo, ...]
    info: Mapping[str, Any]


def part_of(path: Path) -> Path:
    """Return where a recording is written before it gets its name."""
    return path.with_name(f"{path.name}.part")


def short_labels(labels: Sequence[str]) -> dict[str, str]:
    """Return label → what legends and pictures say: an ending that all labels share is left out.

    ``nominal_kinematic`` and ``robust_kinematic`` become ``nominal`` and ``robust``; a single label stays.
    """
    endings = {label.rpartition("_")[2] for label in labels if label.rpartition("_")[0]}
    shared = len(labels) > 1 and len(endings) == 1 and all("_" in label.strip("_") for label in labels)
    return {label: label.rpartition("_")[0] if shared else label for label in labels}


def _slug(text: str) -> str:
    """Reduce to ``[a-z0-9_-]``; the point of a decimal number becomes an underscore."""
    return re.sub(r"[^a-z0-9_-]+", "-", text.lower().replace(".", "_")).strip("-") or "world"


def world_slug(varied: Mapping[str, Any], fallback: str = "world") -> str:
    """Return a short name of a world for files and identities: ``friction-0_1``.

    Parameters
    ----------
    varied : mapping
        Dotted key and value of everything that the sweep varies; only the key's last part is used.
    fallback : str
        Used where nothing varies.

    Returns
    -------
    str
        Of the characters ``[a-z0-9_-]``; beyond 80 characters the tail is replaced by a hash.
    """
    if not varied:
        return _slug(fallback)
    text = _slug("-".join(f"{key.rsplit('.', 1)[-1]}-{value}" for key, value in varied.items()))
    if len(text) <= 80:
        return text
    digest = hashlib.sha256(json.dumps(dict(varied), sort_keys=True, default=str).encode()).hexdigest()
    return f"{text[:67]}-{digest[:12]}"


def recording_id(info: Mapping[str, Any]) -> str:
    """Return the identity of a recording: the same scenario and world always give the same one.

    Parameters
    ----------
    info : mapping
        ``scenario``, ``scenario_id`` and ``varied`` are used.

    Returns
    -------
    str
        Of the characters ``[a-z0-9_-]``, for instance ``friction-sweep-0123456789ab-friction-0_1``.
    """
    scenario = _slug(str(info.get("scenario") or "scenario"))
    identity = str(info.get("scenario_id") or "").removeprefix("sha256:")[:12]
    varied = info.get("varied") or {}
    parts = [scenario, _slug(identity) if identity else "", world_slug(varied) if varied else ""]
    return "-".join(part for part in parts if part)


def application_id(info: Mapping[str, Any]) -> str:
    """Return the identity of a layout, the world's name first: the viewer shows only the beginning.

    One per world, because cameras, axes and the scales in the names of views fit this world and no other.
    """
    slug, identity = world_slug(info.get("varied") or {}, "slipctl"), recording_id(info)
    return f"{slug}-{identity.removesuffix(f'-{slug}')}"


def recording_name(info: Mapping[str, Any]) -> str:
    """Return the name in the viewer's list of recordings: ``friction 0.1``, or the scenario's name."""
    varied = info.get("varied") or {}
    words = ", ".join(f"{key.rsplit('.', 1)[-1]} {value}" for key, value in varied.items())
    return words or str(info.get("scenario") or "slipctl")


def world_title(info: Mapping[str, Any]) -> str:
    """Return a title a person reads: ``friction-sweep · ground.friction = 0.1``."""
    varied = ", ".join(f"{key} = {value}" for key, value in (info.get("varied") or {}).items())
    scenario = str(info.get("scenario") or "slipctl")
    return f"{scenario} · {varied}" if varied else scenario
