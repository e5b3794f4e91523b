"""A file of measurements, one line each, so that a slow change is seen."""

from __future__ import annotations

import json
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from typing import Any


def append(path: Path, measured: dict[str, Any]) -> None:
    """Add one measurement to a file of JSON lines, with the time and the commit of the current folder.

    Parameters
    ----------
    path : pathlib.Path
        Made where it is not there.
    measured : dict
        What JSON can hold.
    """
    line = {"date": datetime.now(UTC).isoformat(timespec="seconds"), "commit": _commit(), **measured}
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8", newline="\n") as file:
        file.write(json.dumps(line, ensure_ascii=False, allow_nan=False) + "\n")


def _commit() -> str | None:
    """Return the commit of the current folder, with a plus where its files differ; None outside of git.

    Histories are files that measuring itself changes.
    """
    try:
        commit = _git("rev-parse", "--short=12", "HEAD")
        return commit + (
            "+"
            if _git("status", "--porcelain", "--untracked-files=no", "--", ":(exclude,top)*.jsonl")
            else ""
        )
    except (OSError, subprocess.CalledProcessError):
        return None


def _git(*arguments: str) -> str:
    done = subprocess.run(["git", *arguments], capture_output=True, check=True, encoding="utf-8")
    return done.stdout.strip()
