"""A cluster of Dask workers: the same chunks on many machines."""

from __future__ import annotations

import importlib
import sys
import time
from collections import deque
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any
from uuid import uuid4

from slipctl.experiment.chunk import Output, Setup, simulate_chunk
from slipctl.experiment.errors import ClusterError, WorkerError
from slipctl.experiment.executors.order import Order, Simulate, order, setup_of, version_problem
from slipctl.experiment.executors.protocol import Finished, Progress
from slipctl.experiment.executors.suspects import Suspects
from slipctl.experiment.machine import SOURCE, exact_versions
from slipctl.experiment.plan import Chunk
from slipctl.experiment.store import ChunkFiles

CONNECT_TIMEOUT = 15.0
"""How long a scheduler may take to answer [s]."""

WORKER_TIMEOUT = 60.0
"""How long its first worker may take to appear: one that has died takes a while to be started again [s]."""

LOOK = 0.5
"""How often is looked whether there is still a worker, where nothing comes back [s]: often enough to see one
that a deadly chunk ends soon after its start."""

POLL = 0.02
"""How long is slept between two looks at what came back [s]."""

AHEAD = 2
"""Chunks for every thread of the cluster that are handed over at a time: enough that none is idle, few enough
that finished ones do not pile up in memory."""


@dataclass(frozen=True)
class DaskCluster:
    """Simulates on the workers of a Dask scheduler.

    A worker that dies is no loss: Dask does its chunks elsewhere. A chunk that Dask gives up, as it was on
    every worker that died, is tried once more alone, as a neighbour may have been the cause. Then it is
    taken apart, so that no world is lost with one that is deadly.

    Attributes
    ----------
    address : str
        Of the scheduler, such as ``tcp://host:8786``.
    threads : int or None
        For MuJoCo in each task; 1 unless told otherwise.
    simulate : callable
        What a worker does with a chunk; importable there.
    """

    address: str
    threads: int | None = None
    simulate: Simulate = simulate_chunk

    def check(self) -> None:
        """See whether the cluster can be used, before anything is begun.

        Raises
        ------
        ClusterError
            Where it cannot be reached, has no workers, or has other versions than this machine.
        """
        with _client(_distributed(), self.address) as client:
            _checked_threads(client, exact_versions(), self.address)

    def run(
        self, setup: Setup, chunks: Iterable[Chunk], files: ChunkFiles | None, progress: Progress
    ) -> Generator[Finished, None, None]:
        """Yield chunks as they end, with what they gave: the cluster need not share a disk.

        Raises
        ------
        ClusterError
            Where the cluster cannot be reached, or has other versions than this machine.
        WorkerError
            Where its scheduler is gone, or all of its workers are and none comes in `WORKER_TIMEOUT`.
        Exception
            What a chunk raised.
        """
        distributed = _distributed()
        what = order(setup, self.threads)
        with _client(distributed, self.address) as client:
            threads = _checked_threads(client, dict(what.versions), self.address)
            name = f"slipctl-{uuid4().hex}"
            waiting = iter(chunks)
            deadly: list[Chunk] = []
            ended = _Ended(distributed, client, self.address, what, self.simulate, name)
            yield from ended.all_of(waiting, max(2, AHEAD * threads), deadly)
            suspects = Suspects(setup.plan)
            for chunk in deadly:
                yield from ended.in_pieces(chunk, suspects)


class _Ended:
    """Hands chunks to a cluster and takes what comes back."""

    def __init__(
        self, distributed: Any, client: Any, address: str, what: Order, simulate: Simulate, name: str
    ) -> None:
        self.distributed, self.client, self.address = distributed, client, address
        self.what, self.simulate, self.name = what, simulate, name
        self.tries = 0
        self.reason = ""

    def all_of(self, waiting: Iterator[Chunk], ahead: int, suspects: list[Chunk]) -> Iterator[Finished]:
        """Yield what becomes of chunks, at most `ahead` of them handed over at a time."""
        self.tries += 1
        held = dict(map(self._submit, islice(waiting, ahead)))
        # with results, as fetching one waits for a worker to do it again where the one that had it has died
        ended = self.distributed.as_completed(
            list(held), loop=self.client.loop, with_results=True, raise_errors=False
        )
        while held:
            self._wait_for(ended)
            future, output = next(ended)
            chunk = held.pop(future)
            try:
                if future.status != "finished":
                    future.result()  # raises what happened
            except self.distributed.KilledWorker as error:
                self.reason = " ".join(str(error).split())
                suspects.append(chunk)
            except (self.distributed.CancelledError, self.distributed.comm.CommClosedError) as error:
                raise WorkerError(f"the Dask scheduler is gone: {error}") from error
            else:
                yield Finished(chunk, output)
            future.release()
            for new, more in map(self._submit, islice(waiting, 1)):
                held[new] = more
                ended.add(new)

    def in_pieces(self, chunk: Chunk, suspects: Suspects) -> Iterator[Finished]:
        """Do a chunk that has ended every worker which tried it, one piece after the other."""
        whole: Finished | None = None
        waiting = deque(suspects.ended(chunk, self.reason))
        while waiting:
            piece, again = waiting.popleft(), []
            for finished in self.all_of(iter([piece]), 1, again):
                assert finished.output is not None, "a cluster shares no disk"
                suspects.done(piece, finished.output)
            for deadly in again:
                waiting += suspects.ended(deadly, f"every Dask worker that tried it ({self.reason})")
            whole = suspects.finished(chunk.index)
        assert whole is not None, "every world is done or given up"
        yield whole

    def _wait_for(self, ended: Any) -> None:
        """Wait until something has come back, or until there has been no worker for too long."""
        looked = last_seen = time.monotonic()
        said = False
        while not ended.has_ready():
            time.sleep(POLL)
            now = time.monotonic()
            if now - looked < LOOK:
                continue
            if self._has_workers():
                last_seen, said = now, False
            elif now - last_seen >= WORKER_TIMEOUT:
                raise WorkerError(
                    f"the Dask scheduler at {self.address} has had no worker for {WORKER_TIMEOUT:.0f} s; "
                    f"start some: dask worker {self.address}"
                )
            elif not said:
                where = f"no Dask worker is left at {self.address}"
                print(f"{where}: waiting {WORKER_TIMEOUT:.0f} s for one", file=sys.stderr)
                said = True
            looked = time.monotonic()

    def _has_workers(self) -> bool:
        try:
            return bool(self.client.nthreads())
        except OSError:  # the scheduler does not answer, either
            return False

    def _submit(self, chunk: Chunk) -> tuple[Any, Chunk]:
        key = f"{self.name}-{chunk.index}-{self.tries}"
        return self.client.submit(_do, self.what, chunk, self.simulate, key=key, pure=False), chunk


def _do(order: Order, chunk: Chunk, simulate: Simulate) -> Output:
    """Do one chunk: what a Dask worker does."""
    return simulate(setup_of(order), chunk, order.threads)


def _distributed() -> Any:
    try:
        return importlib.import_module("distributed")
    except ImportError as error:
        raise ClusterError(
            "a cluster needs dask.distributed, which is not installed: pip install 'slipctl[cluster]'"
        ) from error


def _client(distributed: Any, address: str) -> Any:
    try:  # before there is a client: one that has no address takes long to be thrown away
        distributed.comm.resolve_address(address)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"dask: found {address!r}, allowed is a scheduler's address such as tcp://host:8786; {error}"
        ) from error
    try:
        return distributed.Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"no Dask scheduler answers at {address}: {error}; start one: dask scheduler"
        ) from error


def _checked_threads(client: Any, needed: dict[str, str], address: str) -> int:
    """Return how many threads the cluster has; refuse one whose workers would give other numbers."""
    try:
        client.wait_for_workers(1, timeout=WORKER_TIMEOUT)
    except TimeoutError as error:
        raise ClusterError(
            f"the scheduler at {address} has no worker; start some: dask worker {address}"
        ) from error

    def versions_there(names: list[str], source_name: str) -> dict[str, str | None]:
        # defined here so that it travels as code: a worker without slipctl can still tell that it has none
        from importlib.metadata import PackageNotFoundError, version

        found: dict[str, str | None] = {}
        for name in names:
            try:
                if name == source_name:
                    from slipctl.experiment.machine import source

                    found[name] = source()
                else:
                    found[name] = version(name)
            except (PackageNotFoundError, ImportError):
                found[name] = None
        return found

    answers = client.run(versions_there, list(needed), SOURCE)
    wrong = {place: version_problem(needed, found) for place, found in answers.items()}
    lines = [f"  {place}: {problem}" for place, problem in sorted(wrong.items()) if problem is not None]
    if lines:
        raise ClusterError(
            "the workers must have the versions of this machine, as others may give other numbers:\n"
            + "\n".join(lines)
        )
    return sum(client.nthreads().values())
