"""From what the user says to an executor."""

from __future__ import annotations

import os
from numbers import Integral

from slipctl.experiment.executors.in_process import InProcess
from slipctl.experiment.executors.protocol import Executor


def choose(workers: int, dask: str | None, threads: int | None) -> Executor:
    """Return who simulates.

    Parameters
    ----------
    workers : int
        Processes of this machine; 1 is this process.
    dask : str or None
        Address of a Dask scheduler, which then does it.
    threads : int or None
        For MuJoCo, in each process.

    Raises
    ------
    ValueError
        As `check_processes`.
    ClusterError
        Where the cluster cannot be used: it is asked before anything is begun.
    """
    check_processes(workers, dask, threads)
    if dask is not None:
        from slipctl.experiment.executors.dask_cluster import DaskCluster

        cluster = DaskCluster(dask, threads)
        cluster.check()
        return cluster
    if workers > 1:
        from slipctl.experiment.executors.local_workers import LocalWorkers

        return LocalWorkers(workers, threads)
    return InProcess(threads)


def sparing(executor: Executor) -> Executor:
    """Return who simulates what may end its process, and is not this process.

    Parameters
    ----------
    executor : Executor
        Who simulates the rest.
    """
    if not isinstance(executor, InProcess):
        return executor
    from slipctl.experiment.executors.local_workers import LocalWorkers

    return LocalWorkers(1, executor.threads or os.cpu_count())


def check_processes(workers: int, dask: str | None, threads: int | None) -> None:
    """Refuse what says nothing of who simulates.

    Parameters
    ----------
    workers, dask, threads
        As for `choose`.

    Raises
    ------
    ValueError
        Where one of them cannot be, or both a cluster and several workers are asked for.
    """
    for name, value in (("workers", workers), ("threads", 1 if threads is None else threads)):
        if isinstance(value, bool) or not isinstance(value, Integral) or value < 1:
            raise ValueError(f"{name}: found {value!r}, allowed are whole numbers from 1")
    if dask is not None and not (isinstance(dask, str) and dask):
        raise ValueError(f"dask: found {dask!r}, allowed is a scheduler's address such as tcp://host:8786")
    if dask is not None and workers != 1:
        raise ValueError("workers and dask: give one of them; a cluster has workers of its own")
