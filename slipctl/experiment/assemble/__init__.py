"""From the worlds of a scenario to the objects of one batch: plan, start, plant and laws.

The only place that knows both the file format and the implementations.
"""

from slipctl.experiment.assemble.beliefs import believed, radius_ratio
from slipctl.experiment.assemble.floor import terrain
from slipctl.experiment.assemble.laws import Law, known_inertia, law
from slipctl.experiment.assemble.plan import references, start
from slipctl.experiment.assemble.plants import plant
from slipctl.experiment.assemble.robot import RobotModel, read_robot
from slipctl.experiment.assemble.sensing import sees_the_truth, sensor
from slipctl.experiment.assemble.stack import World, batch_key, gather, tick_count

__all__ = [
    "Law",
    "RobotModel",
    "World",
    "batch_key",
    "believed",
    "gather",
    "known_inertia",
    "law",
    "plant",
    "radius_ratio",
    "read_robot",
    "references",
    "sees_the_truth",
    "sensor",
    "start",
    "terrain",
    "tick_count",
]
