"""An uneven floor in MuJoCo: a tangent plane for every sphere that touches the floor."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch

from slipctl.plants.errors import ModelError
from slipctl.plants.rows import Columns
from slipctl.plants.terrain import MOST_CURVED, Terrain, levelled, upright_to
from slipctl.tick import WHEELS, Array

FLOOR = "floor"


def give_planes(spec: Any) -> None:
    """Edit a model: every sphere in a pair with the floor gets a plane of its own that can be moved.

    Raises
    ------
    ModelError
        If something else than a sphere touches the floor, or something does without a pair.
    """
    floor = spec.geom(FLOOR)
    if floor.contype or floor.conaffinity:
        raise ModelError(
            "ground.terrain needs a model whose floor touches through contact pairs only: a shipped one; "
            "a robot of your own keeps contacts of its own beside its wheels' (no terrain for it yet)"
        )
    for pair in spec.pairs:
        if FLOOR not in (pair.geomname1, pair.geomname2):
            continue
        other = pair.geomname2 if pair.geomname1 == FLOOR else pair.geomname1
        if spec.geom(other).type != mujoco.mjtGeom.mjGEOM_SPHERE:
            raise ModelError(f"an uneven floor needs spheres to touch it, and {other!r} is none")
        plane = _plane(other)
        body = spec.worldbody.add_body(name=plane, mocap=True)
        body.add_geom(
            name=plane, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], group=4, contype=0, conaffinity=0
        )
        pair.geomname1, pair.geomname2 = plane, other
        for sensor in spec.sensors:
            if sensor.objname == FLOOR and sensor.refname == other:
                sensor.objname = plane


def _plane(geom: str) -> str:
    return f"floor_under_{geom}"


@dataclass(frozen=True)
class Relief:
    """The uneven floor of every world of a batch.

    Attributes
    ----------
    terrain : Terrain
    columns : Columns
    arms : (M, 3) array
        Centres of the spheres in the base's frame, those of the left and right wheel first [m].
    planes : (M,) list of int
        Their planes among MuJoCo's mocap bodies.
    """

    terrain: Terrain
    columns: Columns
    arms: Array
    planes: list[int]

    @classmethod
    def of(cls, batch: Batch, terrain: Terrain, columns: Columns) -> Relief:
        """Return the relief of a batch whose model has planes.

        Raises
        ------
        ModelError
            If the floor is more curved than a sphere on it can follow.
        """
        model = batch.model
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        base = model.body("base").id
        frame = data.xmat[base].reshape(3, 3)
        found = {}
        for pair in range(model.npair):
            plane, sphere = int(model.pair_geom1[pair]), int(model.pair_geom2[pair])
            if not model.geom(plane).name.startswith(_plane("")):
                plane, sphere = sphere, plane
            mocap = int(model.body_mocapid[model.geom_bodyid[plane]])
            if mocap >= 0:
                found[model.pair(pair).name] = (sphere, mocap)
        tyres = [f"{side}_tyre" for side in WHEELS]
        order = [*tyres, *sorted(name for name in found if name not in tyres)]
        largest = max(float(model.geom_size[found[name][0], 0]) for name in order)
        curvature = float(terrain.curvature.max())
        if curvature * largest > MOST_CURVED:
            raise ModelError(
                f"the floor is curved with a radius of {1.0 / curvature:.3g} m, too sharply for a wheel "
                f"of {largest:.3g} m: at least {largest / MOST_CURVED:.3g} m, by a smaller "
                "ground.terrain.amplitude or a longer wavelength"
            )
        arms = [frame.T @ (data.geom_xpos[found[name][0]] - data.xpos[base]) for name in order]
        return cls(terrain, columns, np.array(arms), [found[name][1] for name in order])

    def under(self, rows: Array) -> tuple[Array, Array]:
        """Return the floor's nearest points and normals, (N, M, 3) each, under the spheres."""
        at = self.columns.position.start
        return self.terrain.nearest(
            rows[:, None, at : at + 3] + _turn(rows[:, self.columns.quaternion], self.arms)
        )

    def lay(self, batch: Batch, rows: Array) -> Array:
        """Put the planes under the spheres; return the normals (N, 2, 3) under the wheels."""
        point, normal = self.under(rows)
        batch.bind("mocap_pos")[:, self.planes] = point
        batch.bind("mocap_quat")[:, self.planes] = upright_to(normal)
        return normal[:, :2]

    def set_down(self, rows: Array, half_track: float) -> Array:
        """Return rows at rest height on level floor moved and tilted with the floor under the robot."""
        columns, rows = self.columns, rows.copy()
        at = rows[:, columns.position]
        w, x, y, z = (rows[:, columns.quaternion.start + i] for i in range(4))
        forward = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)], axis=-1)
        left = half_track * np.stack([-forward[:, 1], forward[:, 0]], axis=-1)
        points = np.stack([at[:, :2], at[:, :2] + left, at[:, :2] - left], axis=1)
        height, gradient = self.terrain.relief(points)
        normal = np.stack([-gradient[:, 0, 0], -gradient[:, 0, 1], np.ones(len(rows))], axis=-1)
        normal = normal / np.sqrt((normal * normal).sum(axis=-1))[:, None]
        turn = upright_to(normal)
        level = columns.position.stop - 1
        rows[:, level] = rows[:, level] / normal[:, 2] + 0.5 * (height[:, 1] + height[:, 2])
        speed = rows[:, columns.velocity]
        rows[:, columns.velocity.stop] = (gradient[:, 0] * speed).sum(axis=-1)
        rows[:, columns.quaternion] = _times(turn, rows[:, columns.quaternion])
        return rows

    def told(self, sensors: Array, normal: Array) -> Array:
        """Return readings with the wheels' forces turned as if the floor under each wheel were level."""
        sensors = sensors.copy()
        for wheel, part in enumerate(self.columns.force):
            sensors[:, part] = levelled(sensors[:, part], normal[:, wheel])
        return sensors


def _turn(quaternion: Array, arms: Array) -> Array:
    """Return arms (M, 3) turned by quaternions (N, 4): (N, M, 3)."""
    w, x, y, z = (quaternion[:, i, None] for i in range(4))
    a, b, c = (arms[None, :, i] for i in range(3))
    return np.stack(
        [
            a * (1.0 - 2.0 * (y * y + z * z)) + b * 2.0 * (x * y - w * z) + c * 2.0 * (x * z + w * y),
            a * 2.0 * (x * y + w * z) + b * (1.0 - 2.0 * (x * x + z * z)) + c * 2.0 * (y * z - w * x),
            a * 2.0 * (x * z - w * y) + b * 2.0 * (y * z + w * x) + c * (1.0 - 2.0 * (x * x + y * y)),
        ],
        axis=-1,
    )


def _times(first: Array, second: Array) -> Array:
    """Return the product of quaternions (N, 4): first after second."""
    w, x, y, z = (first[:, i] for i in range(4))
    a, b, c, d = (second[:, i] for i in range(4))
    return np.stack(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ],
        axis=-1,
    )
