"""`[reference]`: the path to follow, with its timing."""

from math import hypot, pi
from typing import Annotated, Literal

from pydantic import Field

from slipctl.scenario.base import Table, quantity


class PathStart(Table):
    """Planned pose and speed at the start of a point-to-point path."""

    x: float = quantity("World x of the start", "m", 0.0)
    y: float = quantity("World y of the start", "m", 0.0)
    heading_deg: float = quantity("Heading at the start", "deg", 0.0)
    speed: float = quantity("Forward speed at the start (at 0 the flat map is singular)", "m/s", gt=0)
    yaw_rate: float | None = quantity("Yaw rate at the start (quintic path)", "rad/s", None)
    acceleration: float | None = quantity("Forward acceleration at the start (quintic path)", "m/s²", None)


class PathGoal(Table):
    """Planned pose and speed at the end of a point-to-point path."""

    x: float = quantity("World x of the goal", "m")
    y: float = quantity("World y of the goal", "m")
    heading_deg: float = quantity("Heading at the goal", "deg", 0.0)
    speed: float = quantity("Forward speed at the goal (at 0 the flat map is singular)", "m/s", gt=0)
    yaw_rate: float | None = quantity("Yaw rate at the goal (quintic path)", "rad/s", None)
    acceleration: float | None = quantity("Forward acceleration at the goal (quintic path)", "m/s²", None)


class PointToPoint(Table):
    """Polynomials of time through the poses and speeds at both ends (Table I).

    Cubic, or quintic where both ends have a yaw rate and an acceleration.
    """

    kind: Literal["point_to_point"] = quantity(
        "Polynomials between two poses: cubic, or quintic where yaw_rate and acceleration are given"
    )
    start: PathStart = quantity("Pose and speed at the start")
    goal: PathGoal = quantity("Pose and speed at the goal")
    duration: float = quantity("Time from start to goal", "s", gt=0)
    time_scaling: bool = quantity(
        "Run the path from rest to rest: the speeds at its ends are then those in the path's own time",
        "",
        False,
    )

    @property
    def quintic(self) -> bool:
        """Whether both ends have a yaw rate and an acceleration."""
        ends = (self.start, self.goal)
        return all(end.yaw_rate is not None and end.acceleration is not None for end in ends)

    @property
    def natural_duration(self) -> float:
        """Time from start to goal [s]."""
        return self.duration


class _Placed(Table):
    x: float = quantity("World x of the start", "m", 0.0)
    y: float = quantity("World y of the start", "m", 0.0)
    heading_deg: float = quantity("Heading at the start", "deg", 0.0)


class Line(_Placed):
    """A straight line at constant speed."""

    kind: Literal["line"] = quantity("A straight line at constant speed")
    speed: float = quantity("Forward speed", "m/s", gt=0)
    distance: float = quantity("Length of the line", "m", gt=0)

    @property
    def natural_duration(self) -> float:
        """Time along the line [s]."""
        return self.distance / self.speed


class Circle(_Placed):
    """A circle at constant speed."""

    kind: Literal["circle"] = quantity("A circle at constant speed")
    speed: float = quantity("Forward speed", "m/s", gt=0)
    radius: float = quantity("Radius; positive turns left, negative right, not 0", "m")
    laps: float = quantity("Number of laps", "1", 1.0, gt=0)

    @property
    def natural_duration(self) -> float:
        """Time for all laps [s]."""
        return self.laps * 2 * pi * abs(self.radius) / self.speed


class FigureEight(_Placed):
    """x = (length/2) sin φ, y = (length/4) sin 2φ at constant φ̇, starting at the crossing.

    The start's heading is that of the eight's own x axis turned by `heading_deg`: the path leaves the
    crossing into the first quadrant of the turned frame.
    """

    kind: Literal["figure_eight"] = quantity("A lying figure-eight that starts at its crossing")
    length: float = quantity("Length of the eight, end to end", "m", gt=0)
    speed: float = quantity("Forward speed at the crossing", "m/s", gt=0)
    laps: float = quantity("Number of laps", "1", 1.0, gt=0)

    @property
    def natural_duration(self) -> float:
        """Time for all laps [s]: at the crossing the speed is φ̇ · hypot(length/2, length/2)."""
        return self.laps * 2 * pi * hypot(self.length / 2, self.length / 2) / self.speed


Reference = Annotated[PointToPoint | Line | Circle | FigureEight, Field(discriminator="kind")]
