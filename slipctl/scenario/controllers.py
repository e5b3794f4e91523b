"""`[[controller]]`: the control laws to compare. Every listed one meets the same worlds."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from slipctl.scenario.base import Table, quantity

LABEL_PATTERN = r"^[a-z0-9_-]+$"

SLIP_BOUND_LIMIT = {"paper": 0.5, "independent": 0.5, "slip_ratio": 0.5**0.5, "proportional": 0.5}
"""slip_bound stays below this for each form of ρ: at it the bound's denominator reaches 0."""

GENERAL_REQUIRED = (
    "yaw_slip_bound",
    "lateral_slip_bound",
    "lateral_slip_rate_bound",
    "lateral_slip_acceleration_bound",
)
"""What the `general` form of ρ must be given besides slip_bound."""

GENERAL_KEYS = (*GENERAL_REQUIRED, "coupling_bound")
"""What only the `general` form of ρ uses."""


class Believes(Table):
    """What a law takes the robot to be, where it is wrong about it; what is left out it knows."""

    wheel_radius: float | None = quantity("Wheel radius that the law believes in", "m", None, gt=0)
    half_track: float | None = quantity(
        "Half the distance between the wheels that the law believes in", "m", None, gt=0
    )
    mass: float | None = quantity("Mass of the robot that a dynamic law believes in", "kg", None, gt=0)
    yaw_inertia: float | None = quantity(
        "Yaw inertia of the robot that a dynamic law believes in", "kg·m²", None, gt=0
    )


class _Law(Table):
    label: str = quantity(
        "Name of this controller in tables, recordings and sweeps; default: its kind",
        "",
        "",
        pattern=LABEL_PATTERN,
    )
    speed_floor: float = quantity(
        "Commanded speed stays above this, and so does the law's denominator; 0: no floor", "m/s", 0.05, ge=0
    )
    believes: Believes = quantity(
        "Where the law is wrong about the robot (it knows it unless given)", "", Believes()
    )

    @model_validator(mode="after")
    def _label_defaults_to_kind(self) -> Self:
        if not self.label:
            object.__setattr__(self, "label", getattr(self, "kind", ""))
        return self


class _KinematicLaw(_Law):
    time_scaled: bool | None = quantity(
        "Control in the path's own time, which needs no speed floor at rest; default: where "
        "the reference has time_scaling",
        "",
        None,
    )


class _DynamicLaw(_Law):
    speed_floor: float = quantity(
        "The law divides by the forward speed, or by this where the speed is smaller; 0: no floor",
        "m/s",
        0.05,
        ge=0,
    )


class NominalKinematic(_KinematicLaw):
    """Flatness-based law without the robust term, (43)."""

    kind: Literal["nominal_kinematic"] = quantity("Nominal flatness-based law, kinematic model")
    pole: float = quantity("Double real pole of the error dynamics, negative", "1/s", lt=0, ge=-1000)


class RobustKinematic(_KinematicLaw):
    """Nominal law plus the robust term of Lyapunov redesign: (59), or (47) at `boundary_layer` 0."""

    kind: Literal["robust_kinematic"] = quantity("Robust flatness-based law, kinematic model")
    pole: float = quantity("Double real pole of the error dynamics, negative", "1/s", lt=0, ge=-1000)
    slip_bound: float = quantity(
        "Bound on slip per forward speed; below 0.5 for paper and independent, 0.7071 for slip_ratio",
        "1",
        ge=0,
    )
    boundary_layer: float = quantity(
        "Width of the boundary layer, in the unit of the weighted error JᵀPe; 0: the discontinuous law",
        "m",
        ge=0,
    )
    uncertainty: Literal["paper", "independent", "slip_ratio"] = quantity(
        "Which bound ρ on the uncertainty to use"
    )


class NominalDynamic(_DynamicLaw):
    """Flatness-based law of the dynamic model without the robust term, (68)."""

    kind: Literal["nominal_dynamic"] = quantity("Nominal flatness-based law, dynamic model")
    pole: float = quantity("Triple real pole of the error dynamics, negative", "1/s", lt=0, ge=-1000)


class RobustDynamic(_DynamicLaw):
    """Nominal dynamic law plus the robust term of Lyapunov redesign, (73)."""

    kind: Literal["robust_dynamic"] = quantity("Robust flatness-based law, dynamic model")
    pole: float = quantity("Triple real pole of the error dynamics, negative", "1/s", lt=0, ge=-1000)
    slip_bound: float = quantity(
        "Bound on slip per forward speed; below 0.5 for paper and proportional, below 1 for general",
        "1",
        ge=0,
    )
    boundary_layer: float = quantity(
        "Width of the boundary layer, in the unit of the weighted error JᵀPe; 0: the discontinuous law",
        "m",
        ge=0,
    )
    uncertainty: Literal["paper", "proportional", "general"] = quantity(
        "Which bound ρ on the uncertainty to use (paper is not rigorous)"
    )
    yaw_slip_bound: float | None = quantity("general: bound ξ₁ on the yaw slip", "rad/s", None, ge=0)
    lateral_slip_bound: float | None = quantity("general: bound ξ₂ on the lateral slip", "m/s", None, ge=0)
    lateral_slip_rate_bound: float | None = quantity(
        "general: bound ξ₃ on the rate of the lateral slip", "m/s²", None, ge=0
    )
    lateral_slip_acceleration_bound: float | None = quantity(
        "general: bound ξ₄ on the second derivative of the lateral slip, less what the control adds",
        "m/s³",
        None,
        ge=0,
    )
    coupling_bound: float = quantity(
        "general: bound k₄ on what the control adds to that second derivative; 0 is (81)", "1", 0.0, ge=0
    )


Controller = Annotated[
    NominalKinematic | RobustKinematic | NominalDynamic | RobustDynamic, Field(discriminator="kind")
]
KINDS_WITH_THEOREM = ("robust_kinematic", "robust_dynamic")
"""The laws with a guarantee."""

KINEMATIC_KINDS = ("nominal_kinematic", "robust_kinematic")
DYNAMIC_KINDS = ("nominal_dynamic", "robust_dynamic")
