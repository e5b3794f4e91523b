"""``slipctl bench``."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from slipctl.cli.exits import Exit
from slipctl.cli.options import Json, Quiet
from slipctl.cli.progress import interruptible, progress_bar


def bench(
    worlds: Annotated[int, typer.Option("--worlds", metavar="N", min=1, help="Worlds of the sweep.")] = 64,
    repeats: Annotated[
        int, typer.Option("--repeats", metavar="N", min=1, help="Pairs of replay and sweep.")
    ] = 3,
    threads: Annotated[int, typer.Option("--threads", metavar="N", min=1, help="Threads of MuJoCo.")] = 1,
    json_output: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure what a sweep costs on this machine, beside the physics engine alone.

    The floor is an open-loop replay of the same wheel commands, which must end in the same state to the last
    bit. Both are measured in turn, as processor time. Then every law decides for one robot, as wall time. The
    default takes less than a minute on an idle machine.
    """
    from slipctl.bench import ReplayError, bench_scenario, decision_times, measure_sweep

    try:
        with interruptible("interrupted; nothing was measured"), progress_bar(quiet) as progress:
            measured = measure_sweep(bench_scenario(worlds, 1), repeats, threads, progress=progress)
            decisions = decision_times()
    except ReplayError as error:
        typer.echo(f"{error}: the ratio would mean nothing", err=True)
        raise typer.Exit(Exit.NOT_JUDGED) from None
    if json_output:
        times = {name: round(value, 2) for name, value in decisions.items()}
        told = measured.json() | {"decisions_us": times}
        typer.echo(json.dumps(told, ensure_ascii=False, allow_nan=False))
        return
    for line in measured.lines():
        typer.echo(line)
    slowest = max(len(name) for name in decisions)
    typer.echo("decisions of one robot, median")
    for name, value in decisions.items():
        typer.echo(f"  {name:{slowest}}  {value:6.1f} µs")
