"""Chunks that end the processes which simulate them, taken apart until the worlds that do it are alone."""

from __future__ import annotations

from collections import Counter

from slipctl.experiment.chunk import Output, lost, merged
from slipctl.experiment.executors.protocol import Finished
from slipctl.experiment.plan import Chunk, Plan

DEATHS = 2
"""A world that ends so many processes, alone in each, is given up; a whole chunk is taken apart then."""


class Suspects:
    """What is known of the chunks of a plan that have ended a process.

    A piece of a chunk is a chunk with the same index and some of its worlds.

    Parameters
    ----------
    plan : Plan
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._whole: dict[int, Chunk] = {}
        self._parts: dict[int, list[Output]] = {}
        self._deaths: Counter[tuple[int, int, int]] = Counter()

    def ended(self, piece: Chunk, processes: str) -> list[Chunk]:
        """Say what to try next where a piece, or a whole chunk, has ended its process.

        Parameters
        ----------
        piece : Chunk
        processes : str
            Which processes it ended, and how; said of a world that is given up.

        Returns
        -------
        list of Chunk
            The same once more, or its halves; none where it is a world alone that is given up. Whole chunks
            and worlds alone are tried `DEATHS` times, as a neighbour may have been the cause; what lies
            between is taken apart at once.
        """
        whole = self._whole.setdefault(piece.index, piece)
        key = piece.index, piece.worlds[0], len(piece.worlds)
        self._deaths[key] += 1
        alone = len(piece.worlds) == 1
        if self._deaths[key] < DEATHS and (alone or len(piece.worlds) == len(whole.worlds)):
            return [piece]
        if alone:
            self._parts.setdefault(piece.index, []).append(lost(self._plan, piece, processes))
            return []
        half = len(piece.worlds) // 2
        return [Chunk(piece.index, piece.worlds[:half]), Chunk(piece.index, piece.worlds[half:])]

    def is_piece(self, chunk: Chunk) -> bool:
        """Whether it is less than a whole chunk, so that it cannot be put on the disk alone."""
        return len(chunk.worlds) < len(self._whole.get(chunk.index, chunk).worlds)

    def done(self, piece: Chunk, output: Output) -> None:
        """Take what was simulated of a piece."""
        self._parts.setdefault(piece.index, []).append(output)

    def finished(self, index: int) -> Finished | None:
        """Return a chunk whose pieces are all done or given up, in one piece; None where some are left."""
        parts = self._parts.get(index, [])
        whole = self._whole[index]
        if sum(len(part.chunk.worlds) for part in parts) < len(whole.worlds):
            return None
        return Finished(whole, merged(whole, self._parts.pop(index)))
