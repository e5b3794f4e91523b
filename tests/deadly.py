"""What a worker process does with a chunk where it is to die of it: importable, as workers import it."""

from __future__ import annotations

import os
from pathlib import Path

from slipctl.experiment.chunk import Output, Setup, simulate_chunk
from slipctl.experiment.plan import Chunk

DEADLY = 1
"""Index of the chunk that ends its worker."""

DEADLY_WORLD = 4
"""Index of the world that ends its worker."""

MARK = "SLIPCTL_TEST_MARK"
"""Environment variable with a file that is there once a worker has died."""


def die_always(setup: Setup, chunk: Chunk, threads: int | None) -> Output:
    """End the process in the middle of one chunk, every time."""
    return _simulate(setup, chunk, threads, dies=chunk.index == DEADLY)


def die_of_one_world(setup: Setup, chunk: Chunk, threads: int | None) -> Output:
    """End the process wherever one world is simulated, whatever else is in the chunk."""
    return _simulate(setup, chunk, threads, dies=DEADLY_WORLD in chunk.worlds)


def die_while_ill(setup: Setup, chunk: Chunk, threads: int | None) -> Output:
    """End the process wherever one world is simulated, as long as the mark is there."""
    return _simulate(setup, chunk, threads, DEADLY_WORLD in chunk.worlds and Path(os.environ[MARK]).exists())


def die_once(setup: Setup, chunk: Chunk, threads: int | None) -> Output:
    """End the process in the middle of one chunk, the first time."""
    mark = Path(os.environ[MARK])
    dies = chunk.index == DEADLY and not mark.exists()
    if dies:
        mark.touch()
    return _simulate(setup, chunk, threads, dies)


def _simulate(setup: Setup, chunk: Chunk, threads: int | None, dies: bool) -> Output:
    def progress(ticks: int) -> None:
        if dies and ticks > 0:
            os._exit(9)

    return simulate_chunk(setup, chunk, threads, progress)
