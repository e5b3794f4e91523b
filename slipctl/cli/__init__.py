"""The commands: what the user types, and the exit status that a shell or a CI job reads.

0 done and good, 1 done and a gate failed, 2 the input is wrong, 3 it could not be judged, 130 interrupted.
Nothing but the command line itself is imported until a command needs it, so that help is there at once.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from io import TextIOWrapper

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
    for stream in (sys.stdout, sys.stderr):
        can_say_everything(stream)
    try:
        from slipctl.cli.app import app

        app(args=None if arguments is None else list(arguments), prog_name="slipctl")
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or Exit.GOOD
        raise
    except KeyboardInterrupt:  # while the commands were read
        print("interrupted; nothing was begun", file=sys.stderr)
        return Exit.INTERRUPTED
    except Exception as error:
        return explain(error)
    return Exit.GOOD


def can_say_everything(stream: object) -> None:
    """Let a stream take every character: an arrow in a message must not end a check.

    Where nobody looks (a pipe or a file, as in CI on Windows) text is UTF-8, as it is elsewhere. A terminal
    keeps its encoding, and shows a question mark for what it does not have.
    """
    if not isinstance(stream, TextIOWrapper) or stream.encoding.lower().startswith("utf"):
        return
    if stream.isatty():
        stream.reconfigure(errors="replace")
    else:
        stream.reconfigure(encoding="utf-8")
