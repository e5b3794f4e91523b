"""`[sensing]`: what the controller gets to see of the motion, and how well."""

from typing import Annotated, Any, Literal

from pydantic import WithJsonSchema

from slipctl.scenario.base import AsTrue, Table, quantity


def _sources(*words: str) -> Any:
    """Write the schema of a source: TOML's `true` and "true" mean the same."""
    return WithJsonSchema({"enum": ["true", True, *words]})


PoseSource = Annotated[Literal["true", "odometry_camera"], AsTrue, _sources("odometry_camera")]
VelocitySource = Annotated[
    Literal["true", "odometry", "differentiated"], AsTrue, _sources("odometry", "differentiated")
]
AccelerationSource = Annotated[Literal["true", "imu", "model"], AsTrue, _sources("imu", "model")]


class Sensing(Table):
    """`[sensing]`: the source of each signal, its white noise and its delay. Default: the truth at once."""

    pose: PoseSource = quantity(
        "Source of position and heading: the truth, or wheel odometry corrected by an overhead camera",
        "",
        "true",
    )
    velocity: VelocitySource = quantity(
        "Source of the velocity: the truth, wheel odometry (blind to slip), or differences of the pose",
        "",
        "true",
    )
    acceleration: AccelerationSource = quantity(
        "Source of the acceleration, with torque drive: the truth, an accelerometer, or the slip-free model",
        "",
        "true",
    )
    camera_rate: float | None = quantity("Fixes of the overhead camera per second", "Hz", None, gt=0)
    camera_position_noise: float = quantity(
        "Standard deviation of a camera fix, in x and in y", "m", 0.0, ge=0
    )
    camera_heading_noise_deg: float = quantity(
        "Standard deviation of a camera fix's heading", "deg", 0.0, ge=0, le=180
    )
    camera_delay: float = quantity("A fix arrives this long after its picture", "s", 0.0, ge=0, le=10)
    camera_gain: float = quantity(
        "Share of the difference between fix and odometry that a fix corrects", "1", 1.0, gt=0, le=1
    )
    position_noise: float = quantity("Standard deviation of the white noise on x and on y", "m", 0.0, ge=0)
    heading_noise_deg: float = quantity(
        "Standard deviation of the white noise on the heading", "deg", 0.0, ge=0, le=180
    )
    velocity_noise: float = quantity(
        "Standard deviation of the white noise on each component of the velocity", "m/s", 0.0, ge=0
    )
    acceleration_noise: float = quantity(
        "Standard deviation of the white noise on each component of the acceleration", "m/s²", 0.0, ge=0
    )
    yaw_rate_noise: float = quantity(
        "Standard deviation of the white noise on the yaw rate", "rad/s", 0.0, ge=0
    )
    pose_delay: float = quantity(
        "Position and heading are this old; a multiple of the tick", "s", 0.0, ge=0, le=10
    )
    velocity_delay: float = quantity(
        "The velocity is this old; a multiple of the tick", "s", 0.0, ge=0, le=10
    )
    acceleration_delay: float = quantity(
        "The acceleration is this old; a multiple of the tick", "s", 0.0, ge=0, le=10
    )


CAMERA_KEYS = tuple(name for name in Sensing.model_fields if name.startswith("camera_"))
ACCELERATION_KEYS = tuple(name for name in Sensing.model_fields if name.startswith("acceleration"))
DELAYS = ("pose_delay", "velocity_delay", "acceleration_delay")
