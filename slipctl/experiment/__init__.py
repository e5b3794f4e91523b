"""From a scenario to worlds, from worlds to recordings, tables and a run folder."""

from slipctl.experiment.errors import Interrupted
from slipctl.experiment.result import Result
from slipctl.experiment.runner import resume, run

__all__ = ["Interrupted", "Result", "resume", "run"]
