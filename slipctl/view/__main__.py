"""A worker process: ``python -m slipctl.view JOB.json`` writes the recordings of one job and ends."""

from __future__ import annotations

import sys
from pathlib import Path

from slipctl.view.batch import run_job
from slipctl.view.content import RecordingError


def main() -> int:
    """Write the recordings that the job file names; say what went wrong on standard error."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        run_job(Path(sys.argv[1]))
    except RecordingError as error:
        print(error, file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
