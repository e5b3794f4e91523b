"""`[[ground.patch]]`, `[[ground.change]]` and `[[disturbance]]`: what differs with place and with time."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from slipctl.scenario.base import Table, quantity


def _friction() -> float:
    return quantity("Coulomb friction coefficient of the patch", "1", ge=0)


def _film() -> float | None:
    return quantity(
        "Viscous film on the patch: friction force per slip velocity of each wheel (dry unless given)",
        "N·s/m",
        None,
        gt=0,
    )


def _whole(value: Any) -> Any:
    """Read 3.0, as a sweep gives it, as 3."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class Rectangle(Table):
    """`[[ground.patch]]`, a rectangle."""

    kind: Literal["rectangle"] = quantity("A rectangle of the floor")
    friction: float = _friction()
    film: float | None = _film()
    x: float = quantity("World x of its middle", "m")
    y: float = quantity("World y of its middle", "m")
    length: float = quantity("Extent along its heading", "m", gt=0)
    width: float = quantity("Extent across its heading", "m", gt=0)
    heading_deg: float = quantity("World direction of its length", "deg", 0.0, ge=-360, le=360)


class Disc(Table):
    """`[[ground.patch]]`, a disc."""

    kind: Literal["disc"] = quantity("A disc of the floor")
    friction: float = _friction()
    film: float | None = _film()
    x: float = quantity("World x of its middle", "m")
    y: float = quantity("World y of its middle", "m")
    radius: float = quantity("Radius", "m", gt=0)


class Stripes(Table):
    """`[[ground.patch]]`, parallel stripes without ends."""

    kind: Literal["stripes"] = quantity("Parallel stripes of the floor, endless along the stripe")
    friction: float = _friction()
    film: float | None = _film()
    x: float = quantity("World x of a point on the middle line of the first stripe", "m", 0.0)
    y: float = quantity("World y of that point", "m", 0.0)
    heading_deg: float = quantity(
        "World direction in which the stripes follow each other", "deg", 0.0, ge=-360, le=360
    )
    period: float = quantity("From one stripe's middle line to the next one's", "m", gt=0)
    width: float = quantity("Width of a stripe, less than the period", "m", gt=0)
    count: Annotated[int | None, BeforeValidator(_whole)] = quantity(
        "Number of stripes from the first on (all over the floor unless given)", "1", None, ge=1
    )


Patch = Annotated[Rectangle | Disc | Stripes, Field(discriminator="kind")]


class Waves(Table):
    """`[ground.terrain]`, straight waves."""

    kind: Literal["waves"] = quantity(
        "Straight waves, z = amplitude · sin(2π s/wavelength), s from the origin"
    )
    amplitude: float = quantity("Height of the crests above the middle", "m", gt=0)
    wavelength: float = quantity("From crest to crest", "m", gt=0)
    heading_deg: float = quantity(
        "World direction in which the waves follow each other", "deg", 0.0, ge=-360, le=360
    )


class Bumps(Table):
    """`[ground.terrain]`, bumps at random."""

    kind: Literal["bumps"] = quantity("Bumps without direction: seven waves at random phases, all around")
    amplitude: float = quantity("Largest possible height; the root mean square is 0.267 of it", "m", gt=0)
    wavelength: float = quantity("Wavelength of the waves", "m", gt=0)
    seed: Annotated[int, BeforeValidator(_whole)] = quantity("Seed of the phases", "", 0, ge=0, lt=2**63)


Terrain = Annotated[Waves | Bumps, Field(discriminator="kind")]


class Change(Table):
    """`[[ground.change]]`: from a time on the floor beside the patches is another one."""

    time: float = quantity("From then on", "s", ge=0)
    friction: float | None = quantity(
        "Coulomb friction coefficient under both wheels from then on (as before unless given)",
        "1",
        None,
        ge=0,
    )
    film: float | None = quantity("Viscous film from then on (as before unless given)", "N·s/m", None, gt=0)
    dry: bool = quantity("The film goes", "", False)


class Disturbance(Table):
    """`[[disturbance]]`: a push on the robot's centre of mass."""

    force: float = quantity("Size of the push", "N", gt=0)
    heading_deg: float = quantity("World direction of the push", "deg", ge=-360, le=360)
    start: float = quantity("When it begins", "s", ge=0)
    duration: float = quantity("How long it lasts", "s", gt=0)
