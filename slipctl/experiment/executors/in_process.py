"""The process itself, one chunk after the other."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass

from slipctl.experiment.chunk import Setup, simulate_chunk
from slipctl.experiment.chunkfiles import ChunkFiles
from slipctl.experiment.executors.protocol import Finished, Progress
from slipctl.experiment.plan import Chunk


@dataclass(frozen=True)
class InProcess:
    """Simulates here.

    Attributes
    ----------
    threads : int or None
        For MuJoCo; by default chosen from the size of a batch.
    """

    threads: int | None = None

    def run(
        self, setup: Setup, chunks: Iterable[Chunk], files: ChunkFiles | None, progress: Progress
    ) -> Generator[Finished, None, None]:
        """Yield every chunk in order."""
        for chunk in chunks:

            def within(ticks: int, chunk: Chunk = chunk) -> None:
                progress(chunk, ticks)

            yield Finished(chunk, simulate_chunk(setup, chunk, self.threads, within))
