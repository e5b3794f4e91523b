"""The run folder: written beside, then renamed, so that what is there is whole."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SIGNALS = "signals.parquet"
METRICS = "metrics.parquet"
MANIFEST = "manifest.json"
"""Written last: a folder that has it has all the others."""


class OutputError(Exception):
    """The output folder cannot be written; the message says why."""


@contextmanager
def unfinished(out: Path, name: str, option: str = "--out") -> Iterator[Path]:
    """Give a hidden folder inside `out` to write into; removed again unless `publish` moved it.

    Messages name the `option` with which the user chose `out`.

    Raises
    ------
    OutputError
        Where `out` cannot be made or written.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=f".{name}-", suffix=".part", dir=out))
        part.chmod(0o755)  # mkdtemp makes it private; results are for everyone who may see `out`
    except OSError as error:
        raise OutputError(
            f"cannot write to the output folder {out}: {error.strerror or error}; name another with {option}"
        ) from error
    try:
        yield part
    finally:
        if part.exists():
            shutil.rmtree(part, ignore_errors=True)


def publish(part: Path, out: Path, name: str) -> Path:
    """Rename the finished folder to `out`/`name`, or `name`-2, -3 …: what exists is never overwritten.

    Returns
    -------
    pathlib.Path
    """
    number = 1
    while True:
        target = out / (name if number == 1 else f"{name}-{number}")
        number += 1
        if target.exists():
            continue
        try:
            os.rename(part, target)
        except OSError:
            # somebody else took the name between the question and the answer
            if target.exists():
                continue
            raise
        return target
