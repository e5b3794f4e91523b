"""``slipctl study``: the paper reproduced, and the rungs between real contacts and its equations."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from slipctl.cli.options import Json, Quiet, Source
from slipctl.cli.progress import interruptible, progress_bar

studies = typer.Typer(
    no_args_is_help=True,
    help="Compare several experiments and explain what differs.",
    epilog="Example: slipctl study rungs wet-slope",
)

NOTHING = "interrupted; nothing was written"


@studies.command(epilog="Example: slipctl study paper --page docs/reproduction.md")
def paper(
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for the folder with figures and numbers.")
    ] = Path("runs"),
    page: Annotated[
        Path | None,
        typer.Option("--page", metavar="FILE", help="Also write the page here, its pictures beside it."),
    ] = None,
    json_output: Json = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="Cut every run short: to see that it works, not what it says.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Reproduce Sections V and VI of the paper: figures, numbers beside targets, and what they depend on."""
    from slipctl.study import paper as study

    with interruptible(NOTHING), progress_bar(quiet) as progress:
        result = study.reproduce(out, page_file=page, quick=quick, progress=progress)
    if json_output:
        print(json.dumps(result.numbers, allow_nan=False, ensure_ascii=False))
    elif not quiet:
        from rich.console import Console

        console = Console(highlight=False)
        for line in study.text_table(result.numbers):
            console.print(line, markup=False, soft_wrap=True)
        console.print(f"\n{result.folder}", markup=False, soft_wrap=True)


@studies.command(epilog="Example: slipctl study rungs wet-slope")
def rungs(source: Source, json_output: Json = False, quiet: Quiet = False) -> None:
    """Compare real contacts, prescribed slip and the paper's equations, and take the gaps apart."""
    from slipctl.scenario import load
    from slipctl.study import rungs as study

    scenario = load(source)
    with interruptible(NOTHING), progress_bar(quiet) as progress:
        result = study.study(scenario, progress)
    if json_output:
        print(json.dumps(result, allow_nan=False, ensure_ascii=False))
    elif not quiet:
        from rich.console import Console

        from slipctl.study.rungs_table import table

        console = Console(highlight=False)
        for line in table(result):
            console.print(line, markup=False, soft_wrap=True)
