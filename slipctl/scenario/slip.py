"""`[slip]`: prescribed slip, on the ODE plants or on MuJoCo's moving floor."""

from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from slipctl.scenario.base import Table, quantity
from slipctl.scenario.series import Series, SeriesError, read_series


class ProportionalSlip(Table):
    """Slip in proportion to the forward speed, the paper's (83)."""

    kind: Literal["proportional"] = quantity("Slip in proportion to the forward speed")
    longitudinal: float = quantity("Longitudinal slip per forward speed", "1", 0.0)
    lateral: float = quantity("Lateral slip per forward speed, positive to the right", "1", 0.0)
    yaw: float = quantity("Yaw slip per forward speed", "rad/m", 0.0)


class SinusoidalSlip(Table):
    """Slip in proportion to the forward speed whose proportions swing as sin(2π t / period)."""

    kind: Literal["sinusoidal"] = quantity("Slip in proportion to the forward speed, swinging with time")
    longitudinal: float = quantity("Amplitude of the longitudinal slip per forward speed", "1", 0.0)
    lateral: float = quantity(
        "Amplitude of the lateral slip per forward speed, positive to the right", "1", 0.0
    )
    yaw: float = quantity("Amplitude of the yaw slip per forward speed", "rad/m", 0.0)
    period: float = quantity("Period of the swing", "s", gt=0)


class SeriesSlip(Table):
    """Slip as a series of samples over time, straight lines between them and held beyond the ends.

    The file is read when the scenario is; its content, not its path, counts for the scenario's identity.
    """

    kind: Literal["series"] = quantity("Slip as a series over time")
    file: str = quantity(
        "Parquet file with the columns time [s], longitudinal, lateral [m/s] and yaw [rad/s]; relative to "
        "the scenario file",
        min_length=1,
    )
    _series: Series | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _read_the_file(self) -> Self:
        # A file that cannot be read is told, with all other problems, by the rules between keys.
        try:
            self._series = read_series(self.file)
        except SeriesError:
            self._series = None
        return self

    @property
    def series(self) -> Series:
        """The samples, as they were when the scenario was read.

        Raises
        ------
        SeriesError
            If there is no such file or it holds no series; `load` and `read` refuse such scenarios.
        """
        return read_series(self.file) if self._series is None else self._series


Slip = Annotated[ProportionalSlip | SinusoidalSlip | SeriesSlip, Field(discriminator="kind")]
