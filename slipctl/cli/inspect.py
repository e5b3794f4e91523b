"""``slipctl inspect``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from slipctl.cli.exits import BadInput, Exit
from slipctl.cli.options import Json

if TYPE_CHECKING:
    from slipctl.plants.inspection import Inspection


def inspect(
    model: Annotated[
        str, typer.Argument(metavar="MODEL", help="An MJCF or URDF file, or the name of a shipped model.")
    ],
    left_wheel: Annotated[
        str | None,
        typer.Option("--left-wheel", metavar="JOINT", help="The joint that drives on the left."),
    ] = None,
    right_wheel: Annotated[
        str | None,
        typer.Option("--right-wheel", metavar="JOINT", help="The joint that drives on the right."),
    ] = None,
    keep_contacts: Annotated[
        bool, typer.Option("--keep-contacts", help="Keep the wheel contacts of the file.")
    ] = False,
    caster_friction: Annotated[
        float | None,
        typer.Option("--caster-friction", metavar="MU", min=0.0, help="In place of the file's; 0 slides."),
    ] = None,
    json_output: Json = False,
) -> None:
    """Show what slipctl finds in a robot's model file, and whether it can drive it.

    Usable: exit 0. Read, but not usable: exit 1. Not readable: exit 2.
    """
    from slipctl.plants.inspection import inspect as look
    from slipctl.plants.model import find_model
    from slipctl.plants.own import OwnModel

    source: str | OwnModel = model
    if keep_contacts and caster_friction is not None:
        raise BadInput("--keep-contacts keeps those of the casters, too: no --caster-friction with it")
    if left_wheel or right_wheel or keep_contacts or caster_friction is not None:
        source = OwnModel(Path(find_model(model)), left_wheel, right_wheel, keep_contacts, caster_friction)
    seen = look(source)
    if json_output:
        print(json.dumps(seen.json(), allow_nan=False, ensure_ascii=False))
    else:
        _show(seen)
    if not seen.usable:
        raise typer.Exit(Exit.GATE_FAILED)


def _show(seen: Inspection) -> None:
    from rich.console import Console

    from slipctl.report.robot import lines

    console = Console(highlight=False)
    for line in lines(seen.json()):
        console.print(line, soft_wrap=True)
