"""Recordings for the Rerun viewer: one file per world, all controllers side by side.

Importing this package costs nothing: Rerun itself (a second) is imported by the first call that needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from slipctl.shape import Shape
from slipctl.view.content import (
    RecordingError,
    RunInfo,
    Theorem,
    ViewerError,
    WorldRecording,
    recording_id,
    world_slug,
)

__all__ = [
    "RecordingError",
    "RunInfo",
    "Theorem",
    "ViewerError",
    "WorldRecording",
    "open_viewer",
    "recording_id",
    "world_slug",
    "write_against_baseline",
    "write_recording",
    "write_recordings",
]


def write_recording(
    path: Path | str,
    signals: pa.Table,
    runs: Sequence[RunInfo],
    info: Mapping[str, Any],
    shapes: Sequence[Shape] | None = None,
) -> Path:
    """Write one world with all its controllers as one ``.rrd``; see `slipctl.view.recording.write`."""
    from slipctl.view.recording import write

    return write(Path(path), signals, runs, info, shapes)


def write_against_baseline(
    path: Path | str,
    signals: pa.Table,
    runs: Sequence[RunInfo],
    baselines: Mapping[str, pa.Table],
    info: Mapping[str, Any],
    page: str,
    shapes: Sequence[Shape] | None = None,
) -> Path:
    """Write runs of one world beside their baselines; see `slipctl.view.side_by_side.write`."""
    from slipctl.view.side_by_side import write

    return write(Path(path), signals, runs, baselines, info, page, shapes)


def write_recordings(
    folder: Path | str,
    signals: pa.Table | Path,
    worlds: Sequence[WorldRecording],
    shapes: Sequence[Shape] | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Write many worlds, each to its own ``.rrd``; see `slipctl.view.batch.write_all`."""
    from slipctl.view.batch import write_all

    return write_all(Path(folder), signals, worlds, shapes, threads, progress)


def open_viewer(paths: Sequence[Path | str], *, wait: bool = False) -> None:
    """Open recordings in the Rerun viewer; see `slipctl.view.viewer.open_paths`."""
    from slipctl.view.viewer import open_paths

    open_paths([Path(path) for path in paths], wait=wait)
