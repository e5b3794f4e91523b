"""Writing one recording: beside its name first, then renamed, so that no half-written file is ever found."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
from rerun.error_utils import catch_and_log_exceptions
from rerun.recording_stream import is_enabled as is_recording_enabled

from slipctl.shape import Shape
from slipctl.view.colours import run_colours
from slipctl.view.content import (
    RecordingError,
    RunInfo,
    application_id,
    part_of,
    recording_id,
    recording_name,
)
from slipctl.view.events import events
from slipctl.view.ground import floor_events
from slipctl.view.layout import blueprint
from slipctl.view.plots import log_series
from slipctl.view.scene import choose_scales, log_run, log_world
from slipctl.view.summary import markdown
from slipctl.view.tracks import Track, nanoseconds, read_tracks

LEVEL_COLOURS = {"INFO": 0xB0B0B0FF, "WARN": 0xF0E442FF, "ERROR": 0xD55E00FF}


def write(
    path: Path,
    signals: pa.Table,
    runs: Sequence[RunInfo],
    info: Mapping[str, Any],
    shapes: Sequence[Shape] | None = None,
) -> Path:
    """Write one world with all its controllers.

    Parameters
    ----------
    path : Path
        The ``.rrd`` to write; replaced if it exists.
    signals : pyarrow.Table
        One row per run and tick; columns as in ``signals.parquet``. Columns that are null throughout are
        left out. Unit of a column in its field's metadata under ``unit``.
    runs : sequence of RunInfo
        The controllers of this world.
    info : mapping
        All keys optional: ``scenario`` (name), ``description``, ``scenario_id``, ``model_id``, ``seed``,
        ``varied`` (dotted key → value), ``versions`` (program → version), ``units`` (metric → unit),
        ``wheel_radius``, ``half_track`` [m], ``slope_deg`` and ``downhill_deg`` [°]; ``friction`` and
        ``film`` of the floor, ``patches``, ``changes`` of it and ``pushes`` as tables of the scenario file.
    shapes : sequence of Shape or None
        The robot's shapes; None = a plain disc robot.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    RecordingError
        The signals do not fit the runs, the file cannot be written, or Rerun is switched off by the
        environment variable ``RERUN``.

    Notes
    -----
    Everything that decides the file comes from the arguments: two calls with the same arguments give files
    that ``rerun rrd compare`` calls equal.
    """
    tracks = read_tracks(signals, runs)
    with strict():
        content = _encode(tracks, info, shapes)
    return put(path, content)


def put(path: Path, content: bytes) -> Path:
    """Write the bytes of a recording beside their place and rename.

    Raises
    ------
    RecordingError
        There are none, because Rerun is switched off, or the file cannot be written.
    """
    if not content:
        switch = f" (the environment says RERUN={os.environ['RERUN']})" if "RERUN" in os.environ else ""
        raise RecordingError(f"Rerun wrote nothing for {path}{switch}; unset RERUN or run without recordings")
    part = part_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        raise RecordingError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    return path


def _encode(tracks: list[Track], info: Mapping[str, Any], shapes: Sequence[Shape] | None) -> bytes:
    """Return the file as bytes, none where Rerun is switched off.

    Rerun's own file writer is not used: on a full disk it may wait for ever for its thread that has ended.
    """
    colours = run_colours([track.info for track in tracks])
    roots = {track.info.label: f"/runs/{rr.escape_entity_path_part(track.info.label)}" for track in tracks}
    scales = choose_scales(tracks)
    identity = recording_id(info)
    with new_stream(application_id(info), identity) as rec:
        if not is_recording_enabled(rec):
            return b""
        memory = rec.memory_recording()
        layout = blueprint(tracks, scales, roots, sweep=bool(info.get("varied")))
        rec.send_blueprint(layout, make_active=False, make_default=True)
        rec.send_recording_name(recording_name(info))
        rec.send_property("run", rr.AnyValues(drop_untyped_nones=True, **_properties(tracks, info)))
        log_world(rec, tracks, info)
        strides = {}
        for order, track in enumerate(tracks):
            label = track.info.label
            log_run(rec, roots[label], track, colours[label], shapes, info, scales, order)
            strides[label] = log_series(rec, roots[label], track, colours[label], order)
            _log_events(rec, roots[label], track, info)
        page = markdown(tracks, info, scales, colours, strides)
        rec.log("/info/summary", rr.TextDocument(page, media_type="text/markdown"), static=True, strict=True)
        return memory.drain_as_bytes()


@contextmanager
def new_stream(application: str, identity: str) -> Iterator[rr.RecordingStream]:
    """Open a stream into memory whose chunks do not depend on how fast it is written."""
    # otherwise what is logged is put together by the clock, and a busy machine gives another file
    batches = rr.ChunkBatcherConfig.NEVER()
    stream = rr.RecordingStream(
        application, recording_id=identity, send_properties=False, batcher_config=batches
    )
    try:
        yield stream
    finally:
        stream.disconnect()  # or else `end_threads` does not end its two threads; those of its layout stay


def end_threads() -> None:
    """End the threads of recordings that are done; Rerun does so only when it is initialised again.

    For a process that does nothing else with Rerun: a global recording of the caller's own would end, too.
    """
    rr.init("slipctl", init_logging=False)


def _log_events(rec: rr.RecordingStream, root: str, track: Track, info: Mapping[str, Any]) -> None:
    found = sorted([*events(track), *floor_events(info)], key=lambda event: event.time)
    times = rr.TimeColumn("sim_time", duration=nanoseconds(np.array([event.time for event in found])))
    columns = rr.TextLog.columns(
        text=[event.text for event in found],
        level=[event.level for event in found],
        color=np.array([LEVEL_COLOURS[event.level] for event in found], dtype=np.uint32),
    )
    rec.send_columns(f"{root}/events", [times], columns, strict=True)


def _properties(tracks: Sequence[Track], info: Mapping[str, Any]) -> dict[str, Any]:
    """Return what `rerun server -d sweep=FOLDER` shows as columns: the world, then each run's metrics."""
    properties: dict[str, Any] = {"scenario": str(info.get("scenario") or "")}
    for key in ("scenario_id", "model_id", "seed"):
        if info.get(key) is not None:
            properties[key] = info[key]
    properties.update({f"varied.{key}": value for key, value in (info.get("varied") or {}).items()})
    for track in tracks:
        label = track.info.label
        properties[f"{label}.status"] = track.info.status
        values = {name: value for name, value in track.info.metrics.items() if value is not None}
        properties.update({f"{label}.{name}": float(value) for name, value in values.items()})
        told = {name: value for name, value in track.info.guarantee.items() if value is not None}
        properties.update({f"{label}.{name}": value for name, value in told.items()})
    return properties


def strict() -> AbstractContextManager[Any]:
    """Wrong lengths and types raise instead of going missing, in this thread alone."""
    # not `set_strict_mode`: that is for all threads, and those of the caller may be logging
    return catch_and_log_exceptions(strict=True)
