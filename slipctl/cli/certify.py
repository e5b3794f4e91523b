"""``slipctl certify``, and what other commands ask of a certificate."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from slipctl.cli.exits import BadInput, Exit
from slipctl.cli.options import Json, Quiet
from slipctl.cli.progress import interruptible, progress_bar

if TYPE_CHECKING:
    from slipctl.scenario import Scenario

RequireCertified = Annotated[
    bool,
    typer.Option(
        "--require-certified",
        help="Refuse, with exit 3, unless the model is certified against closed forms here.",
    ),
]


def certify(
    model: Annotated[
        str,
        typer.Argument(metavar="MODEL", help="Name of a shipped model, or an MJCF or URDF file."),
    ] = "magellan_pro",
    timestep: Annotated[
        float, typer.Option("--timestep", metavar="S", min=1e-6, max=0.1, help="Physics step, as in [plant].")
    ] = 0.001,
    left_wheel: Annotated[
        str | None,
        typer.Option("--left-wheel", metavar="JOINT", help="Joint that drives; guessed by default."),
    ] = None,
    right_wheel: Annotated[
        str | None,
        typer.Option("--right-wheel", metavar="JOINT", help="Joint that drives; guessed by default."),
    ] = None,
    keep_contacts: Annotated[
        bool, typer.Option("--keep-contacts", help="Judge the file's own wheel contacts, not slipctl's.")
    ] = False,
    caster_friction: Annotated[
        float | None,
        typer.Option("--caster-friction", metavar="MU", min=0.0, help="In place of the file's; 0 slides."),
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(
            "--against", metavar="FILE", help="Say what changed since this certificate (--json of then)."
        ),
    ] = None,
    json_output: Json = False,
    quiet: Quiet = False,
) -> None:
    """Try a compiled robot against closed forms: mass, friction, creep, limits, film, belt, timestep.

    The certificate is kept in the user's cache for `run` and `check`. A fixture that fails: exit 1.
    """
    from slipctl.certify import examine
    from slipctl.certify.certificate import CertificateError, read
    from slipctl.plants.errors import ModelError
    from slipctl.plants.model import find_model
    from slipctl.plants.own import OwnModel

    then = None
    try:
        if against is not None:
            then = read(against)
        source = find_model(model)
        if left_wheel or right_wheel or keep_contacts or caster_friction is not None:
            source = OwnModel(Path(source), left_wheel, right_wheel, keep_contacts, caster_friction)
        with (
            interruptible("interrupted; there is no new certificate"),
            progress_bar(quiet) as progress,
        ):
            content = examine.certify(source, timestep, progress)
    except (ModelError, CertificateError) as error:
        raise BadInput(str(error)) from error
    content["model"] = model
    changed = None if then is None else examine.changes(then | {"model": model}, content)
    if json_output:
        extra: dict[str, Any] = {} if changed is None else {"changes": changed}
        print(json.dumps(content | extra, allow_nan=False, ensure_ascii=False))
    elif not quiet:
        _show(content, changed)
    if not content["passed"]:
        if json_output or quiet:
            for check in content["checks"]:
                if not check["passed"]:
                    print(f"{check['name']}: {check['reason']}", file=sys.stderr)
        raise typer.Exit(Exit.GATE_FAILED)


def _show(content: dict[str, Any], changed: list[str] | None) -> None:
    from rich.console import Console

    from slipctl.report.certificate import table, verdict

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=140)  # in a pipe nothing is folded
    console.print(table(content, laws=console.width >= 120))
    for line in verdict(content):
        console.print(line, soft_wrap=True)
    if changed is not None:
        console.print("nothing changed since that certificate" if not changed else "changed:", markup=False)
        for line in changed:
            console.print(f"  {line}", markup=False, soft_wrap=True)


def require(scenarios: list[Scenario]) -> None:
    """End the command with exit 3 unless every model that the scenarios simulate is certified.

    A plant without an engine needs no certificate.
    """
    from slipctl.experiment.certified import missing

    said = dict.fromkeys(line for scenario in scenarios for line in missing(scenario))
    for line in said:
        print(line, file=sys.stderr)
    if said:
        raise typer.Exit(Exit.NOT_JUDGED)
