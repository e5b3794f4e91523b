"""From a scenario to worlds, from worlds to recordings, tables and a run folder."""

from slipctl.experiment.result import Result
from slipctl.experiment.runner import run

__all__ = ["Result", "run"]
