"""`[[expect]]`: what a scenario claims of its runs. Claims change no run and are no part of its identity."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, InstanceOf, PlainSerializer, WithJsonSchema

from slipctl.scenario.base import Table, quantity
from slipctl.scenario.where import WHERE_SCHEMA, Condition, read_where, where_table

ErrorMetric = Literal[
    "rms_position_error",
    "max_position_error",
    "final_position_error",
    "rms_cross_track_error",
    "rms_heading_error",
    "rms_robust_input",
    "command_variation",
    "max_slip_ratio",
    "median_slip_ratio",
    "saturation_fraction",
]
"""The metrics of which less is better."""


def _conditions(value: Any) -> Any:
    """Read a `where` table; its problems are reported, with all others, by the rules between keys."""
    if isinstance(value, tuple):
        return value
    conditions, problems = read_where(value)
    if problems:
        raise ValueError("; ".join(str(problem) for problem in problems))
    return conditions


Where = Annotated[
    tuple[InstanceOf[Condition], ...],
    BeforeValidator(_conditions),
    PlainSerializer(where_table),
    WithJsonSchema(WHERE_SCHEMA),
]


class _Claim(Table):
    where: Where = quantity(
        "Only the worlds with these values: swept key = number, array or { from, to }; default: all", "", ()
    )
    only_where_guaranteed: bool = quantity(
        "Only the worlds in which the controller's guarantee holds on every tick", "", False
    )

    def _with_worlds(self, text: str) -> str:
        if self.where:
            text += f", where {' and '.join(map(str, self.where))}"
        return f"{text}, where its guarantee holds" if self.only_where_guaranteed else text


class Better(_Claim):
    """One law beats another in the same worlds."""

    kind: Literal["better"] = quantity("One law beats another in the same worlds")
    controller: str = quantity("Label of the law that is better", min_length=1)
    than: str = quantity("Label of the law that it beats", min_length=1)
    metric: ErrorMetric = quantity("In which metric", "", "rms_position_error")
    factor: float = quantity("By at least this factor: other / own", "1", 1.0, ge=1)
    command_variation_factor: float | None = quantity(
        "With at most this multiple of the other's command_variation; default: at any price",
        "1",
        None,
        gt=0,
    )

    def __str__(self) -> str:
        text = f"{self.controller} beats {self.than} in {self.metric} by a factor of {self.factor:g} or more"
        if self.command_variation_factor is not None:
            text += f" with at most {self.command_variation_factor:g} times its command_variation"
        return self._with_worlds(text)


class BelowBound(_Claim):
    """A law's position error stays below the bound of its theorem."""

    kind: Literal["below_bound"] = quantity("The error stays below the theorem's bound, where there is one")
    controller: str = quantity("Label of the law", min_length=1)

    def __str__(self) -> str:
        return self._with_worlds(f"{self.controller} stays below its guaranteed error bound")


class Guarantee(_Claim):
    """The hypotheses of a law's theorem hold."""

    kind: Literal["guarantee"] = quantity("The hypotheses of the law's theorem hold")
    controller: str = quantity("Label of the law", min_length=1)
    fraction: float = quantity("On at least this share of the ticks of every run", "1", 1.0, gt=0, le=1)

    def __str__(self) -> str:
        share = "every tick" if self.fraction == 1 else f"{100 * self.fraction:g} % of the ticks or more"
        return self._with_worlds(f"the guarantee of {self.controller} holds on {share}")


class StatusIs(_Claim):
    """Runs end as stated."""

    kind: Literal["status"] = quantity("Runs end as stated")
    controller: str | None = quantity("Label of the law; default: every one", "", None, min_length=1)
    status: Literal["completed", "diverged", "tipped", "left_the_arena"] = quantity(
        "How they end", "", "completed"
    )

    def __str__(self) -> str:
        return self._with_worlds(f"every run of {self.controller or 'every law'} ends as {self.status}")


class Below(_Claim):
    """A metric of one law stays below a limit."""

    kind: Literal["below"] = quantity("A metric of one law stays below a limit")
    controller: str = quantity("Label of the law", min_length=1)
    metric: ErrorMetric = quantity("Which metric", "", "rms_position_error")
    limit: float = quantity("At most this much, in the metric's own unit", ge=0)

    def __str__(self) -> str:
        return self._with_worlds(f"{self.metric} of {self.controller} is at most {self.limit:g}")


Claim = Annotated[Better | BelowBound | Guarantee | StatusIs | Below, Field(discriminator="kind")]
