"""``slipctl run`` and ``slipctl sweep``."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from slipctl.cli.certify import RequireCertified, require
from slipctl.cli.exits import BadInput, Exit
from slipctl.cli.options import Json, Out, Quiet, Record, Signals, Source, Threads, View, Workers, World
from slipctl.cli.progress import Progress, interruptible, progress_bar

if TYPE_CHECKING:
    from slipctl.experiment import Result
    from slipctl.scenario import Scenario

RUNS = Path("runs")

NOTHING_BEGUN = "interrupted; nothing was begun"

NOTHING = "interrupted before any run was finished; nothing was written"


def run(
    source: Source,
    out: Out = RUNS,
    record: Record = "auto",
    signals: Signals = "auto",
    world: World = None,
    view: View = False,
    json_output: Json = False,
    quiet: Quiet = False,
    threads: Threads = None,
    workers: Workers = 1,
    require_certified: RequireCertified = False,
) -> None:
    """Run a scenario, the whole grid where it has one, and show its controllers side by side."""
    with interruptible(NOTHING_BEGUN), progress_bar(quiet) as judging:
        scenario = _load(source, world, judging)
    if require_certified:
        require([scenario])
    execute(
        scenario,
        out,
        view=view,
        json_output=json_output,
        quiet=quiet,
        record=record,
        signals=signals,
        threads=threads,
        workers=workers,
        worlds=None if world is None else [world],
    )


def sweep(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="FILE|NAME",
            help="A scenario file, or the name of a shipped one.",
            show_default=False,
        ),
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help="Key to vary and its values: 0.1,0.2 or FROM:TO:COUNT or FROM:TO:COUNT:log. Repeatable.",
        ),
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(
            "--resume",
            metavar="DIR",
            help="Go on with what a sweep left: its NAME.unfinished; or try worlds that ended their worker "
            "processes once more: a run folder, which stays, beside its complete one.",
        ),
    ] = None,
    out: Out = RUNS,
    record: Record = "auto",
    signals: Signals = "auto",
    world: World = None,
    view: View = False,
    json_output: Json = False,
    quiet: Quiet = False,
    threads: Threads = None,
    workers: Workers = 1,
    dask: Annotated[
        str | None,
        typer.Option(
            "--dask",
            metavar="ADDRESS",
            help="Simulate on the workers of a Dask scheduler, such as tcp://host:8786.",
        ),
    ] = None,
) -> None:
    """Run a scenario over grids given here; those of the file stay unless the same key is given."""
    how = {"threads": threads, "workers": workers, "dask": dask}
    if dask is not None and workers != 1:
        raise BadInput("--workers and --dask: give one of them; a cluster has workers of its own")
    if resume is not None:
        _only_with_a_source(source, over, out, record, signals, world)
        _resume(resume, view, json_output, quiet, how)
        return
    if source is None:
        raise BadInput("FILE|NAME is missing: name a scenario, or what to go on with by --resume DIR")
    from slipctl.scenario import sweep_over

    with interruptible(NOTHING_BEGUN), progress_bar(quiet) as judging:
        scenario = sweep_over(_load(source, world, judging), over or [], judging)
    execute(
        scenario,
        out,
        view=view,
        json_output=json_output,
        quiet=quiet,
        record=record,
        signals=signals,
        worlds=None if world is None else [world],
        **how,
    )


def execute(
    scenario: Scenario, out: Path, *, view: bool, json_output: bool, quiet: bool, **options: Any
) -> None:
    """Run a scenario and report it; ends the command with the exit status.

    Parameters
    ----------
    scenario : Scenario
    out : pathlib.Path
    view, json_output, quiet : bool
    **options
        As of `slipctl.experiment.run`.
    """
    from slipctl import experiment
    from slipctl.experiment.plan import check_signals
    from slipctl.experiment.record import check_choice

    check_choice(options["record"])
    check_signals(options["signals"])

    def begun(folder: Path, chunks: int) -> None:
        from slipctl.experiment.store import resume_command

        if chunks > 1 and not quiet:
            print(f"what is finished is kept; if this stops: {resume_command(folder)}", file=sys.stderr)

    # one world alone that cannot be simulated is shown as what it is: its traceback, and the rows before
    alone = not scenario.sweep or options["worlds"] is not None
    going = {"keep_going": not alone, "keep_failed_rows": alone}
    _finish(
        lambda progress: experiment.run(
            scenario, out=out, begun=begun, progress=progress, **going, **options
        ),
        view,
        json_output,
        quiet,
    )


def _resume(folder: Path, view: bool, json_output: bool, quiet: bool, how: dict[str, Any]) -> None:
    from slipctl import experiment
    from slipctl.experiment.replay import check_unfinished
    from slipctl.experiment.store import resume_command

    check_unfinished(folder)
    _finish(
        lambda progress: experiment.resume(folder, progress=progress, **how),
        view,
        json_output,
        quiet,
        f"interrupted; what is finished is kept; go on: {resume_command(folder)}",
    )


def _finish(
    work: Callable[[Any], Result],
    view: bool,
    json_output: bool,
    quiet: bool,
    stopped: str = NOTHING,
) -> None:
    from slipctl.cli.outcome import is_alone, report
    from slipctl.experiment.errors import Interrupted
    from slipctl.experiment.store import resume_command

    try:
        with interruptible(stopped), progress_bar(quiet) as progress:
            result = work(progress)
    except Interrupted as stop:
        if stop.finished:
            print(f"interrupted; {stop}", file=sys.stderr)
            raise typer.Exit(Exit.INTERRUPTED) from None
        print(f"interrupted; {stop.done} of {stop.total} worlds are kept in {stop.folder}", file=sys.stderr)
        print(f"go on: {resume_command(stop.folder)}", file=sys.stderr)
        raise typer.Exit(Exit.INTERRUPTED) from None
    status = report(result, json_output, quiet)
    if view and (status is Exit.GOOD or is_alone(result)):
        from slipctl.cli.view import show_folder

        show_folder(result.folder)
    if status is not Exit.GOOD:
        raise typer.Exit(status)


def _load(source: str, world: int | None, judging: Progress | None) -> Scenario:
    """Load a scenario; that of a run folder where one world of it is run again."""
    from slipctl.scenario import ScenarioError, load

    if world is not None and Path(source).is_dir():
        from slipctl.experiment.replay import scenario_of

        return scenario_of(Path(source))
    try:
        return load(source, judging)
    except ScenarioError as error:
        if not (Path(source) / "manifest.json").is_file():
            raise
        raise BadInput(f"{source} is a run folder: run one of its worlds again with --world N") from error


def _only_with_a_source(source: Any, over: Any, out: Path, record: str, signals: str, world: Any) -> None:
    """Refuse what an unfinished sweep has decided already."""
    given = {
        "FILE|NAME": source is not None,
        "--over": bool(over),
        "--out": out != RUNS,
        "--record": record != "auto",
        "--signals": signals != "auto",
        "--world": world is not None,
    }
    wrong = [name for name, is_given in given.items() if is_given]
    if wrong:
        raise BadInput(f"{', '.join(wrong)}: not with --resume, which goes on with what was begun")
