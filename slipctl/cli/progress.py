"""What the user sees while work is done, and what Ctrl-C does then."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from slipctl.cli.exits import Exit

Progress = Callable[[int, int, str], None]


@contextmanager
def interruptible(message: str) -> Iterator[None]:
    """Turn Ctrl-C within the block into a sentence and the exit status for it."""
    import typer

    from slipctl.experiment.errors import Interrupted

    try:
        yield
    except Interrupted:
        raise  # something is kept, which its own sentence says
    except KeyboardInterrupt:
        print(message, file=sys.stderr)
        raise typer.Exit(Exit.INTERRUPTED) from None


@contextmanager
def progress_bar(quiet: bool) -> Iterator[Progress | None]:
    """Show a bar with the remaining time while the block runs, and take it away afterwards.

    Yields
    ------
    callable or None
        ``progress(done, total, text)``; None where nobody looks: quiet, or standard error is no terminal (a
        log would fill with thousands of bars).
    """
    from rich.console import Console

    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def progress(done: int, total: int, text: str) -> None:
            bar.update(task, completed=done, total=total, description=text)

        yield progress
