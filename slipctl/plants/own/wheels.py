"""Which joints of a robot are its two driven wheels."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from slipctl.plants.errors import UnusableModel
from slipctl.tick import Array

PARALLEL = 1e-3
"""Sine of the angle up to which two axles are parallel, and an axle level [1]."""

_SIDES = {
    "left": re.compile(r"left|(?<![a-z])l(?![a-z])"),
    "right": re.compile(r"right|(?<![a-z])r(?![a-z])"),
}


@dataclass(frozen=True)
class Axles:
    """The driven wheels where the file puts them.

    Attributes
    ----------
    joints : tuple of int
        Left, right.
    anchors : (2, 3) array
        [m], in the world of the file.
    signs : (2,) array
        1 where a positive joint speed drives ahead, −1 where it drives back.
    frame : (3, 3) array
        Rows: ahead, left and up in the world of the file.
    """

    joints: tuple[int, int]
    anchors: Array
    signs: Array
    frame: Array


def find_axles(model: mujoco.MjModel, path: Path, left: str | None, right: str | None) -> Axles:
    """Return the driven wheels of a compiled model.

    Raises
    ------
    UnusableModel
        If they are not named and not obvious, are not hinges that turn freely about one level line, or are
        more than two.
    """
    hinges = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE]
    driven = sorted(driven_joints(model) & set(hinges))
    names = {model.joint(j).name: j for j in hinges}
    if left is None or right is None:
        guess = _guessed(model, path, hinges, driven)
        chosen = [names_of(names, left, path) if left else guess[0]]
        chosen.append(names_of(names, right, path) if right else guess[1])
    else:
        chosen = [names_of(names, left, path), names_of(names, right, path)]
    if chosen[0] == chosen[1]:
        raise UnusableModel(
            f"{path}: left_wheel and right_wheel are the same joint, {model.joint(chosen[0]).name!r}"
        )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    axes, anchors = data.xaxis[chosen].copy(), data.xanchor[chosen].copy()
    if np.linalg.norm(np.cross(axes[0], axes[1])) > PARALLEL or np.abs(axes[:, 2]).max() > PARALLEL:
        raise UnusableModel(
            f"{path}: the axles {_listed(model, chosen)} are not parallel and level as the file has them"
        )
    across = anchors[0] - anchors[1]
    apart = float(np.linalg.norm(across))
    if apart < 1e-6 or np.linalg.norm(np.cross(across / apart, axes[0])) > 0.02:
        raise UnusableModel(
            f"{path}: the wheels {_listed(model, chosen)} are not side by side on one axle line"
        )
    for joint in chosen:
        if model.jnt_limited[joint]:
            raise UnusableModel(
                f"{path}: joint {model.joint(joint).name!r} is limited to "
                f"{np.array2string(model.jnt_range[joint], precision=3)} rad; a wheel turns on and on "
                "(in a URDF: type continuous)"
            )
    others = [j for j in driven if j not in chosen and abs(float(data.xaxis[j] @ axes[0])) > 1.0 - PARALLEL]
    others = [j for j in others if _is_wheel(model, j)]
    if others:
        raise UnusableModel(
            f"{path}: {len(others) + 2} wheels are driven ({_listed(model, [*chosen, *others])}); a robot "
            "that steers by skidding does not turn as its wheels say, which is not the paper's model"
        )
    sideways = np.array([across[0], across[1], 0.0]) / np.hypot(across[0], across[1])
    frame = np.stack([np.cross(sideways, [0.0, 0.0, 1.0]), sideways, [0.0, 0.0, 1.0]])
    return Axles((chosen[0], chosen[1]), anchors, np.sign(axes @ sideways), frame)


def names_of(names: dict[str, int], name: str, path: Path) -> int:
    """Return the hinge of a name.

    Raises
    ------
    UnusableModel
        If there is none.
    """
    if name not in names:
        raise UnusableModel(
            f"{path}: no hinge joint {name!r} (there are: {', '.join(sorted(names)) or 'none'})"
        )
    return names[name]


def driven_joints(model: mujoco.MjModel) -> set[int]:
    """Return the joints that actuators of the file push, tendons included."""
    pushed = set()
    for actuator in range(model.nu):
        target = int(model.actuator_trnid[actuator, 0])
        kind = mujoco.mjtTrn(model.actuator_trntype[actuator])
        if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
            pushed.add(target)
        elif kind == mujoco.mjtTrn.mjTRN_TENDON:
            first = int(model.tendon_adr[target])
            for wrap in range(first, first + int(model.tendon_num[target])):
                if mujoco.mjtWrap(model.wrap_type[wrap]) == mujoco.mjtWrap.mjWRAP_JOINT:
                    pushed.add(int(model.wrap_objid[wrap]))
    return pushed


def _words(model: mujoco.MjModel, joint: int) -> str:
    text = f"{model.joint(joint).name} {model.body(int(model.jnt_bodyid[joint])).name}"
    return re.sub(r"([a-z])([A-Z])", r"\1 \2", text).lower()


def _is_wheel(model: mujoco.MjModel, joint: int) -> bool:
    words = _words(model, joint)
    return (
        ("wheel" in words or "tire" in words or "tyre" in words)
        and "caster" not in words
        and "castor" not in words
    )


def _guessed(model: mujoco.MjModel, path: Path, hinges: list[int], driven: list[int]) -> tuple[int, int]:
    wheels = [j for j in hinges if _is_wheel(model, j)]
    sides = {side: [j for j in wheels if word.search(_words(model, j))] for side, word in _SIDES.items()}
    pushed = {side: [j for j in found if j in driven] for side, found in sides.items()}
    if all(len(found) == 1 for found in pushed.values()):
        sides = pushed
    if all(len(found) == 1 for found in sides.values()) and sides["left"] != sides["right"]:
        return sides["left"][0], sides["right"][0]
    if all(len(found) > 1 for found in sides.values()):
        raise UnusableModel(
            f"{path}: more than one wheel on a side ({_listed(model, wheels)}); a robot that steers by "
            "skidding cannot be used; where some only roll, left_wheel and right_wheel name those that drive"
        )
    raise UnusableModel(
        f"{path}: which joints drive is not obvious from the names; name them by left_wheel and right_wheel "
        f"(hinge joints: {_listed(model, hinges) or 'none'})"
    )


def _listed(model: mujoco.MjModel, joints: list[int]) -> str:
    return ", ".join(repr(model.joint(j).name) for j in joints)
