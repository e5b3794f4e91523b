"""What an experiment needs of whoever simulates its chunks."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Protocol

from slipctl.experiment.chunk import Output, Setup
from slipctl.experiment.chunkfiles import ChunkFiles
from slipctl.experiment.plan import Chunk

Progress = Callable[[Chunk, int], None]
"""Told a chunk and the number of its world-ticks done, from time to time."""


@dataclass(frozen=True)
class Finished:
    """A chunk that was simulated.

    Attributes
    ----------
    chunk : Chunk
    output : Output or None
        None where it is on the disk already. Runs of worlds that end every process which simulates them
        have the status ``failed`` in it.
    """

    chunk: Chunk
    output: Output | None


class Executor(Protocol):
    """Simulates chunks, in any order."""

    def run(
        self, setup: Setup, chunks: Iterable[Chunk], files: ChunkFiles | None, progress: Progress
    ) -> Generator[Finished, None, None]:
        """Yield every chunk once, as it ends. Closing the iterator ends all work.

        Parameters
        ----------
        setup : Setup
            What this process made; other processes make their own of its plan.
        chunks : iterable of Chunk
        files : ChunkFiles or None
            Where a process on the same disk may put a finished chunk itself.
        progress : callable
        """
        ...
