"""From what the user says to an executor."""

from __future__ import annotations

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
    ClusterError
        Where the cluster cannot be used: it is asked before anything is begun.
    """
    if dask is not None:
        from slipctl.experiment.executors.dask_cluster import DaskCluster

        cluster = DaskCluster(dask, threads)
        cluster.check()
        return cluster
    if workers > 1:
        from slipctl.experiment.executors.local_workers import LocalWorkers

        return LocalWorkers(workers, threads)
    return InProcess(threads)
