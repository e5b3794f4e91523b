"""The command set and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from slipctl.cli.bench import bench
from slipctl.cli.certify import certify
from slipctl.cli.check import check
from slipctl.cli.inspect import inspect
from slipctl.cli.run import run, sweep
from slipctl.cli.scenario import scenarios
from slipctl.cli.study import studies
from slipctl.cli.view import view

app = typer.Typer(
    name="slipctl",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Example: slipctl run friction-sweep --view",
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"slipctl {version('slipctl')}")
        raise typer.Exit


@app.callback()
def slipctl(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Path following of two-wheeled robots that slip: run, look, and hold the numbers in CI.

    Exit status: 0 good, 1 a gate failed, 2 wrong input, 3 could not be judged, 130 interrupted.
    """


app.command(epilog="Example: slipctl run friction-sweep --view")(run)
app.command(epilog="Example: slipctl sweep paper-kinematic --over start.x_offset=0,0.05,0.1")(sweep)
app.command(epilog="Example: slipctl view runs/friction-sweep")(view)
app.command(epilog="Example: slipctl check friction-sweep wet-slope")(check)
app.command(epilog="Example: slipctl certify magellan_pro --json > certificate.json")(certify)
app.command(epilog="Example: slipctl inspect my-robot.urdf")(inspect)
app.command(epilog="Example: slipctl bench --worlds 512 --repeats 5 --json")(bench)
app.add_typer(scenarios, name="scenario")
app.add_typer(studies, name="study")
