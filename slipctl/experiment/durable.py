"""Files that are whole or not there: written beside, flushed to the disk, then renamed."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Callable
from pathlib import Path
from typing import IO

PART = ".part"
"""Ending of a file that is being written; one that is left over is never read."""

FULL = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))
"""What systems say where there is no room: disk, file size, quota."""


def write(path: Path, fill: Callable[[IO[bytes]], None]) -> None:
    """Put a file in its place once all of it is on the disk; replaces what is there.

    Parameters
    ----------
    path : pathlib.Path
        In an existing folder.
    fill : callable
        Writes the content into an open binary file.

    Raises
    ------
    OSError
        Where it cannot be written; what was at `path` is still there.
    """
    # the name is its own, so that two processes that write the same file do not write into each other's
    part = path.with_name(f"{path.name}.{os.getpid()}-{secrets.token_hex(4)}{PART}")
    try:
        with part.open("xb") as file:
            fill(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    sync_folder(path.parent)


def write_bytes(path: Path, content: bytes) -> None:
    """Put a small file in its place; as `write`."""

    def fill(file: IO[bytes]) -> None:
        file.write(content)

    write(path, fill)


def sync_folder(folder: Path) -> None:
    """Flush the names in a folder to the disk, on systems that can."""
    flags = getattr(os, "O_DIRECTORY", None)
    if flags is None:  # Windows has no handle of a folder that could be flushed
        return
    descriptor = os.open(folder, os.O_RDONLY | flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
