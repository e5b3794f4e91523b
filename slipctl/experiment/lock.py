"""A lock on a folder that ends with its process, however that ends."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import IO

from slipctl.experiment.errors import ResumeError

NAME = "lock"

HELD = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES)
"""What systems say where another process holds a lock."""


class FolderLock:
    """Held by one process at a time; the operating system lets go of it when the process dies.

    Some disks, as of a network, know no locks: that is said on standard error, and nothing is held.

    Parameters
    ----------
    folder : pathlib.Path
        An existing folder, in which the file `NAME` is made.

    Raises
    ------
    ResumeError
        Where another process holds it.
    """

    def __init__(self, folder: Path) -> None:
        self._file: IO[bytes] | None = (folder / NAME).open("ab")
        try:
            _take(self._file)
        except OSError as error:
            self.release()
            if error.errno not in HELD:
                print(
                    f"{folder} cannot be locked ({error.strerror or error}): "
                    "let no other process go on with it at the same time",
                    file=sys.stderr,
                )
                return
            raise ResumeError(
                f"{folder} is in use: another process is at work on it; wait for it, or end it first"
            ) from error

    def release(self) -> None:
        """Let go of it."""
        if self._file is not None:
            self._file.close()
            self._file = None


def _take(file: IO[bytes]) -> None:
    if os.name == "nt":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
