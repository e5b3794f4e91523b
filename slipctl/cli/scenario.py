"""``slipctl scenario``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from slipctl.cli.exits import BadInput

scenarios = typer.Typer(
    no_args_is_help=True,
    help="List, start and describe scenario files.",
    epilog="Example: slipctl scenario new my-floor.toml",
)


@scenarios.command("list", epilog="Example: slipctl scenario list")
def list_scenarios(
    json_output: Annotated[
        bool, typer.Option("--json", help="Print one JSON object on standard output.")
    ] = False,
) -> None:
    """List the shipped scenarios."""
    from slipctl import shipped
    from slipctl.scenario import load

    descriptions = {name: load(name).description for name in shipped.scenario_names()}
    if json_output:
        listed = [{"name": name, "description": text} for name, text in descriptions.items()]
        print(json.dumps({"scenarios": listed}, ensure_ascii=False))
        return
    width = max(map(len, descriptions))
    for name, text in descriptions.items():
        print(f"{name.ljust(width)}  {text}")


@scenarios.command("new", epilog="Example: slipctl scenario new my-floor.toml --like wet-slope")
def new_scenario(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Where to write it.")],
    like: Annotated[
        str, typer.Option("--like", metavar="NAME", help="The shipped scenario to start from.")
    ] = "friction-sweep",
) -> None:
    """Write a new scenario file to start from."""
    from slipctl.scenario import template

    file = file if file.suffix else file.with_suffix(".toml")
    text = template(like, name=file.stem)
    try:
        with file.open("x", encoding="utf-8") as handle:
            handle.write(text)
    except FileExistsError:
        raise BadInput(f"{file} exists and is left as it is; name another file") from None
    except OSError as error:
        raise BadInput(f"{file} cannot be written: {error.strerror or error}") from None
    print(f"{file} written; run it: slipctl run {file}")


@scenarios.command("schema", epilog="Example: slipctl scenario schema > scenario.schema.json")
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors."""
    from slipctl.scenario import json_schema

    print(json.dumps(json_schema(), indent=2, ensure_ascii=False))
