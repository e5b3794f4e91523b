"""A worker process: ``python -m slipctl.view JOB.json`` writes the recordings of one job and ends.

Whoever starts it holds its standard input open: where that ends, so does the worker. A process that is killed
leaves none behind that go on writing into its folder.
"""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path

from slipctl.view.batch import run_job
from slipctl.view.content import RecordingError


def main() -> int:
    """Write the recordings that the job file names; say what went wrong on standard error."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    threading.Thread(target=_end_with_the_caller, daemon=True).start()
    try:
        run_job(Path(sys.argv[1]))
    except RecordingError as error:
        print(error, file=sys.stderr)
        return 3
    return 0


def _end_with_the_caller() -> None:
    while os.read(0, 1):  # not `sys.stdin`, which Python closes at its end and would wait for this thread
        pass
    os._exit(1)


if __name__ == "__main__":
    sys.exit(main())
