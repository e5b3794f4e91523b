"""`[slip]`: prescribed slip, on the ODE plant or on MuJoCo's moving floor."""

from typing import Annotated, Literal

from pydantic import Field

from slipctl.scenario.base import Table, quantity


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


Slip = Annotated[ProportionalSlip | SinusoidalSlip, Field(discriminator="kind")]
