"""A robot that slipctl did not write: an MJCF or URDF file made into one that the MuJoCo plant can drive."""

from slipctl.plants.own.adopt import Adopted, adopt
from slipctl.plants.own.choice import OwnModel

__all__ = ["Adopted", "OwnModel", "adopt"]
