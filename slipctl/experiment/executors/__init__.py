"""Who simulates the chunks: this process, worker processes of this machine, or a Dask cluster.

All of them call the same function, so that the results are the same to the last bit.
"""

from __future__ import annotations

from slipctl.experiment.executors.choice import check_processes, choose, sparing
from slipctl.experiment.executors.protocol import Executor, Finished

__all__ = ["Executor", "Finished", "check_processes", "choose", "sparing"]
