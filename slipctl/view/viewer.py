"""Opening recordings in the viewer that is installed with Rerun."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from slipctl.view.content import ViewerError

GRACE = 1.5  # s, assumed: a viewer that cannot open a window ends within it


def open_paths(paths: Sequence[Path], wait: bool = False) -> None:
    """Start the Rerun viewer with recordings.

    Parameters
    ----------
    paths : sequence of Path
        Recordings, or folders whose ``.rrd`` files are opened in the order of their names.
    wait : bool
        Whether to return only when the viewer is closed; otherwise it lives on by itself.

    Raises
    ------
    ViewerError
        No recording, no screen, no viewer installed, or the viewer ended at once.
    """
    recordings = [
        file for path in paths for file in (sorted(path.glob("*.rrd")) if path.is_dir() else [path])
    ]
    missing = [str(file) for file in recordings if not file.is_file()]
    if missing:
        raise ViewerError(f"no such recording: {', '.join(missing)}")
    if not recordings:
        where = ", ".join(str(path) for path in paths) or "the run"
        raise ViewerError(f"no recording (.rrd) in {where}; make some with --record all")
    if not has_screen():
        raise ViewerError(
            "no screen to open the viewer on (neither DISPLAY nor WAYLAND_DISPLAY is set). "
            f"Copy the recording to a machine with a screen and open it there: rerun {recordings[0]}"
        )
    command = [str(viewer_program()), "--hide-welcome-screen", *(str(file.resolve()) for file in recordings)]
    # a file, not a pipe: the viewer outlives this process and would die of a pipe that nobody reads
    with tempfile.TemporaryFile() as complaint:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=complaint,
            start_new_session=True,
        )
        try:
            status = process.wait(None if wait else GRACE)
        except subprocess.TimeoutExpired:
            return
        if status != 0:
            complaint.seek(0)
            lines = complaint.read().decode(errors="replace").strip().splitlines()
            raise ViewerError(f"the viewer ended with status {status}" + (f": {lines[-1]}" if lines else ""))


def has_screen() -> bool:
    """Return whether a window can be opened; on Linux that takes an X or Wayland display."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def viewer_program() -> Path:
    """Return the viewer's own program: the `rerun` script on the path only wraps it.

    Raises
    ------
    ViewerError
        It is not installed.
    """
    found = importlib.util.find_spec("rerun_cli")
    if found is not None and found.origin is not None:
        for name in ("rerun", "rerun.exe"):
            program = Path(found.origin).parent / name
            if program.is_file():
                return program
    raise ViewerError("the Rerun viewer is not installed; pip install rerun-sdk brings it")
