"""The commands: what the user types, and the exit status that a shell or a CI job reads.

0 done and good, 1 done and a gate failed, 2 the input is wrong, 3 it could not be judged, 130 interrupted.
Nothing but the command line itself is imported until a command needs it, so that help is there at once.
"""

from __future__ import annotations

from collections.abc import Sequence

from slipctl.cli.exits import Exit, explain


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments
        What stands after ``slipctl`` on the command line; by default that of this process.

    Returns
    -------
    int
        The exit status.
    """
    try:
        from slipctl.cli.app import app

        app(args=None if arguments is None else list(arguments), prog_name="slipctl")
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or Exit.GOOD
        raise
    except Exception as error:
        return explain(error)
    return Exit.GOOD
