"""The tables `[robot]`, `[plant]`, `[ground]` and `[start]`."""

from typing import Annotated, Literal

from pydantic import Field

from slipctl.scenario.base import AsTuple, Table, quantity
from slipctl.scenario.floor import Change, Patch, Terrain


class Robot(Table):
    """`[robot]`: the model, how it is driven, and the limits of what it is commanded."""

    model: str = quantity(
        "Robot model: the name of a shipped one, or the path of an MJCF or URDF file, seen from this file",
        min_length=1,
    )
    left_wheel: str | None = quantity(
        "Name of the joint that drives on the left, in a model by its path; guessed where it is obvious",
        "",
        None,
        min_length=1,
    )
    right_wheel: str | None = quantity(
        "Name of the joint that drives on the right, likewise", "", None, min_length=1
    )
    keep_contacts: bool = quantity(
        "Keep the contacts of a model by its path in place of the calibrated ones", "", False
    )
    caster_friction: float | None = quantity(
        "Friction of the casters of a model by its path, in place of the file's; 0 lets them slide freely",
        "1",
        None,
        ge=0,
    )
    drive: Literal["wheel_speed", "wheel_torque"] = quantity("What the controller commands at the wheels")
    speed_limit: float = quantity("Largest commanded forward speed", "m/s", 2.5, gt=0)
    yaw_rate_limit: float = quantity("Largest commanded yaw rate, either way", "rad/s", 6.0, gt=0)
    torque_limit: float = quantity("Largest torque of each wheel motor", "N·m", 4.0, gt=0)
    compensate_wheels: bool = quantity(
        "Torque drive adds what the wheels' own inertia and the friction of their joints take", "", True
    )
    wheel_inertia: float | None = quantity(
        "Inertia of a wheel with its motor about the axle that is compensated; default: the model's",
        "kg·m²",
        None,
        ge=0,
    )
    joint_friction: float | None = quantity(
        "Dry friction of a wheel joint that is compensated; default: the model's", "N·m", None, ge=0
    )


class KinematicOde(Table):
    """`[plant]`, the kinematic model with slip as an ordinary differential equation, (29)."""

    kind: Literal["kinematic_ode"] = quantity("Kinematic model with prescribed slip; no floor, no forces")
    arena: float = quantity("The run ends beyond this distance from the origin", "m", 50.0, gt=0)

    @property
    def timestep(self) -> None:
        """None: the ODE has no physics time step of its own."""
        return


class DynamicOde(Table):
    """`[plant]`, the dynamic model with slip as an ordinary differential equation, (31)."""

    kind: Literal["dynamic_ode"] = quantity("Dynamic model with prescribed slip; no floor, no contacts")
    arena: float = quantity("The run ends beyond this distance from the origin", "m", 50.0, gt=0)

    @property
    def timestep(self) -> None:
        """None: the ODE has no physics time step of its own."""
        return


class Mujoco(Table):
    """`[plant]`, the robot in MuJoCo: real wheel-ground contacts."""

    kind: Literal["mujoco"] = quantity("Rigid-body simulation with wheel-ground contacts")
    timestep: float = quantity("Physics time step; the tick is a multiple of it", "s", 0.001, gt=0, lt=0.0025)
    arena: float = quantity("The run ends beyond this distance from the origin", "m", 50.0, gt=0)


Plant = Annotated[KinematicOde | DynamicOde | Mujoco, Field(discriminator="kind")]


class Ground(Table):
    """`[ground]`: the floor under the wheels (MuJoCo)."""

    friction: float = quantity("Coulomb friction coefficient under both wheels", "1", 0.8, ge=0)
    friction_left: float | None = quantity(
        "Friction coefficient under the left wheel, in place of `friction`", "1", None, ge=0
    )
    friction_right: float | None = quantity(
        "Friction coefficient under the right wheel, in place of `friction`", "1", None, ge=0
    )
    film: float | None = quantity(
        "Viscous film: friction force per slip velocity of each wheel (none unless given)",
        "N·s/m",
        None,
        gt=0,
    )
    creep_stiffness: float | None = quantity(
        "Tyre creep: force per unit slip ratio of each wheel, up to friction (none unless given)",
        "N",
        None,
        gt=0,
    )
    slope_deg: float = quantity("Slope of the floor (gravity is tilted)", "deg", 0.0, ge=0, le=45)
    downhill_deg: float = quantity("World direction in which the slope descends", "deg", 0.0, ge=-360, le=360)
    terrain: Terrain | None = quantity("Uneven floor (level unless given)", "", None)
    patch: Annotated[tuple[Patch, ...], AsTuple] = quantity(
        "Parts of the floor with a friction of their own; later ones lie on top", "", ()
    )
    change: Annotated[tuple[Change, ...], AsTuple] = quantity(
        "What changes of the floor beside the patches, in the order of time", "", ()
    )

    @property
    def wheel_friction(self) -> tuple[float, float]:
        """Friction coefficients under the left and the right wheel."""
        left, right = self.friction_left, self.friction_right
        return (self.friction, self.friction) if left is None or right is None else (left, right)


class Start(Table):
    """`[start]`: how the robot's start differs from the planned one."""

    at_rest: bool = quantity(
        "Start at standstill, the controller's speed memory at its speed floor", "", False
    )
    x_offset: float = quantity("Start this far from the planned x", "m", 0.0)
    y_offset: float = quantity("Start this far from the planned y", "m", 0.0)
    heading_offset_deg: float = quantity("Start turned from the planned heading", "deg", 0.0, ge=-360, le=360)
