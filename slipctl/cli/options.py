"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Source = Annotated[
    str, typer.Argument(metavar="FILE|NAME", help="A scenario file, or the name of a shipped one.")
]
Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the run folders.")]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output instead of a table.")
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="No progress and no table; errors are still said.")
]
View = Annotated[bool, typer.Option("--view", help="Open the recordings in the Rerun viewer afterwards.")]
Record = Annotated[
    str,
    typer.Option(
        "--record", metavar="auto|all|failed|none|worst:N", help="Which worlds get a Rerun recording."
    ),
]
Signals = Annotated[
    str,
    typer.Option(
        "--signals",
        metavar="auto|all|sampled|none",
        help="Which rows of the signals are kept; auto is all unless that were very many.",
    ),
]
World = Annotated[
    int | None,
    typer.Option(
        "--world",
        metavar="N",
        min=0,
        help="Run this world of the grid alone, counted from 0; FILE may be a run folder.",
    ),
]
Workers = Annotated[
    int, typer.Option("--workers", metavar="N", min=1, help="Processes of this machine that simulate.")
]
Threads = Annotated[
    int | None, typer.Option("--threads", metavar="N", min=1, help="Threads of MuJoCo in each process.")
]
