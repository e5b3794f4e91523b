"""Worker processes of this machine. One that dies is replaced; its chunk is done again, or taken apart."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from collections import deque
from collections.abc import Generator, Iterable
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from slipctl.experiment.chunk import Setup, simulate_chunk
from slipctl.experiment.chunkfiles import ChunkFiles
from slipctl.experiment.errors import WorkerError
from slipctl.experiment.executors.order import Order, Simulate, order, setup_of
from slipctl.experiment.executors.protocol import Finished, Progress
from slipctl.experiment.executors.suspects import DEATHS, Suspects
from slipctl.experiment.plan import Chunk

STARTS = 3
"""So many workers that die before their first chunk end the experiment."""


@dataclass(frozen=True)
class LocalWorkers:
    """Simulates in processes beside this one. They are spawned, not forked: alike on every system.

    Attributes
    ----------
    workers : int
    threads : int or None
        For MuJoCo in each of them; 1 unless told otherwise.
    simulate : callable
        What a worker does with a chunk; importable.
    """

    workers: int
    threads: int | None = None
    simulate: Simulate = simulate_chunk

    def run(
        self, setup: Setup, chunks: Iterable[Chunk], files: ChunkFiles | None, progress: Progress
    ) -> Generator[Finished, None, None]:
        """Yield chunks as they end.

        Raises
        ------
        WorkerError
            Where workers cannot be started.
        Exception
            What a chunk raised.
        """
        waiting = deque(chunks)
        what = (order(setup, self.threads), files, self.simulate)
        crew = [_Worker(what) for _ in range(min(self.workers, len(waiting)))]
        suspects = Suspects(setup.plan)
        stillborn = 0
        try:
            while any(not worker.idle for worker in crew) or waiting:
                for pipe in wait([worker.pipe for worker in crew if not worker.idle]):
                    worker = next(worker for worker in crew if worker.pipe is pipe)
                    answer = worker.answer()
                    ended: Finished | None = None
                    if isinstance(answer, Finished):
                        ended = answer
                        if answer.output is not None and suspects.is_piece(answer.chunk):
                            suspects.done(answer.chunk, answer.output)
                            ended = suspects.finished(answer.chunk.index)
                    elif answer is None:
                        chunk = worker.chunk
                        crew[crew.index(worker)] = _Worker(what)
                        how = worker.bury()
                        if chunk is None:
                            stillborn += 1
                            if stillborn >= STARTS:
                                raise WorkerError(f"worker processes die at their start ({how})")
                            continue
                        again = suspects.ended(chunk, f"{DEATHS} worker processes, alone in each ({how})")
                        waiting.extend(again)
                        if not again:
                            ended = suspects.finished(chunk.index)
                    if ended is not None:
                        yield ended
                for worker in crew:
                    if worker.idle and waiting:
                        chunk = waiting.popleft()
                        worker.give(chunk, piece=suspects.is_piece(chunk))
        finally:
            for worker in crew:
                worker.end()


class _Worker:
    """One process, and what it is at."""

    def __init__(self, what: tuple[Order, ChunkFiles | None, Simulate]) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other, *what), daemon=True)
        self.process.start()
        other.close()  # so that the end of the process is the end of the pipe
        self.chunk: Chunk | None = None
        self.idle = False  # not before it has said that it is ready

    def give(self, chunk: Chunk, piece: bool) -> None:
        self.chunk, self.idle = chunk, False
        with contextlib.suppress(OSError):  # it has died: the next look at the pipe says so
            self.pipe.send((chunk, piece))

    def answer(self) -> Any:
        """Return what the worker says, or None where it has died.

        Raises
        ------
        Exception
            What the chunk raised.
        """
        try:
            answer = self.pipe.recv()
        except (EOFError, OSError):
            return None
        if isinstance(answer, _Raised):
            answer.again()
        self.chunk, self.idle = None, True
        return answer

    def bury(self) -> str:
        """Say how the process ended."""
        self.pipe.close()
        self.process.join()
        code = self.process.exitcode
        if code is not None and code < 0:
            with contextlib.suppress(ValueError):
                return f"by {signal.Signals(-code).name}"
        return f"with exit status {code}"

    def end(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


@dataclass(frozen=True)
class _Raised:
    """What a worker raised, on its way to the process that asked."""

    error: bytes
    told: str

    def again(self) -> None:
        try:
            error = pickle.loads(self.error)
        except Exception:
            raise WorkerError(f"a worker process raised:\n{self.told}") from None
        error.add_note(f"in a worker process:\n{self.told}")
        raise error


def _serve(pipe: Connection, order: Order, files: ChunkFiles | None, simulate: Simulate) -> None:
    """Do chunks until the pipe ends: what a worker process does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asked
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        setup = setup_of(order)
        pipe.send("ready")
        while True:
            chunk, piece = pipe.recv()
            output = simulate(setup, chunk, order.threads)
            keeps = files is not None and not piece  # pieces are put together by who asked
            if files is not None and keeps:
                files.keep(output)
            pipe.send(Finished(chunk, None if keeps else output))
    except (EOFError, BrokenPipeError, ConnectionError):
        return  # nobody asks any more
    except Exception as error:
        try:
            packed = pickle.dumps(error)
        except Exception:
            packed = b""
        try:
            pipe.send(_Raised(packed, traceback.format_exc()))
        except OSError:
            return


def _end_with_parent() -> None:
    """End this process when the one that asked is no more: nothing is to go on behind a user's back."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
