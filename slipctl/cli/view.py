"""``slipctl view``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from slipctl.cli.exits import BadInput

RUNS = Path("runs")


def view(
    run: Annotated[
        Path | None,
        typer.Argument(
            metavar="RUN",
            help="A run folder, what slipctl check recorded, or one recording; by default the newest run.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Open recordings in the Rerun viewer."""
    from slipctl.view import open_viewer

    open_viewer(recordings(newest_run(RUNS) if run is None else run))


def newest_run(runs: Path) -> Path:
    """Return the run folder that was written last.

    Raises
    ------
    BadInput
        There is none.
    """
    folders = [manifest.parent for manifest in runs.glob("*/manifest.json")]
    if not folders:
        raise BadInput(f"no run folder in {runs}; make one: slipctl run friction-sweep")
    return max(folders, key=lambda folder: (folder / "manifest.json").stat().st_mtime_ns)


def recordings(run: Path) -> list[Path]:
    """Return the recordings of a run folder, or the one recording that was named, by name.

    Raises
    ------
    BadInput
        There are none.
    """
    if run.suffix == ".rrd" and run.is_file():
        return [run]
    if not run.is_dir():
        raise BadInput(f"{run}: no such run folder or recording")
    found = sorted(run.glob("*.rrd"))
    if not found:
        raise BadInput(f"{run} holds no recording; write some: slipctl run FILE|NAME --record all")
    return found


def show_folder(folder: Path | None) -> None:
    """Open what a run has just written; a screen that is not there does not undo the run."""
    from slipctl.view import ViewerError, open_viewer

    try:
        if folder is None:
            raise BadInput("nothing was written, so there is nothing to view")
        open_viewer(recordings(folder))
    except (BadInput, ViewerError) as error:
        print(error, file=sys.stderr)
