"""`[[controller]]`: the control laws to compare. Every listed one meets the same worlds."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from slipctl.scenario.base import Table, quantity

LABEL_PATTERN = r"^[a-z0-9_-]+$"

SLIP_BOUND_LIMIT = {"paper": 0.5, "independent": 0.5, "slip_ratio": 0.5**0.5}
"""slip_bound stays below this for each form of ρ: at it the bound's denominator reaches 0."""


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

    @model_validator(mode="after")
    def _label_defaults_to_kind(self) -> Self:
        if not self.label:
            object.__setattr__(self, "label", getattr(self, "kind", ""))
        return self


class NominalKinematic(_Law):
    """Flatness-based law without the robust term, (43)."""

    kind: Literal["nominal_kinematic"] = quantity("Nominal flatness-based law, kinematic model")
    pole: float = quantity("Double real pole of the error dynamics, negative", "1/s", lt=0)


class RobustKinematic(_Law):
    """Nominal law plus the robust term of Lyapunov redesign: (59), or (47) at `boundary_layer` 0."""

    kind: Literal["robust_kinematic"] = quantity("Robust flatness-based law, kinematic model")
    pole: float = quantity("Double real pole of the error dynamics, negative", "1/s", lt=0)
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


Controller = Annotated[NominalKinematic | RobustKinematic, Field(discriminator="kind")]
