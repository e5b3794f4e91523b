"""Reading an MJCF or URDF file that slipctl did not write."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco

from slipctl.plants.errors import ModelError

_TEMPLATE = re.compile(r"\$\{[^}]*\}|\$\((?:find|arg|env|optenv|eval)\b[^)]*\)")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def read_spec(path: Path) -> tuple[mujoco.MjSpec, list[str]]:
    """Return the editable model of a file with every part named, and what had to be left out.

    A URDF keeps its first link as a body: MuJoCo would by default melt it into the world with its mass.

    Raises
    ------
    ModelError
        If the file cannot be read: no XML of either kind, a template that was never filled in, a mesh that a
        collision needs and that is not there.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise ModelError(f"{path}: it cannot be read ({error.strerror or error})") from error
    placeholder = _TEMPLATE.search(_COMMENT.sub("", text))
    if placeholder:
        raise ModelError(
            f"{path}: {placeholder.group(0)} is a placeholder that xacro or a launch file fills in; "
            "expand it first, such as by: xacro robot.urdf.xacro > robot.urdf"
        )
    try:
        with quiet():
            spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{path}: {error}") from error
    spec.compiler.fusestatic = False
    notes = _without_missing_meshes(spec, path)
    _name_all(spec)
    return spec, notes


def compiled(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """Compile, with the file named in what is said of it.

    Raises
    ------
    ModelError
        If MuJoCo cannot.
    """
    try:
        with quiet():
            return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{path}: {error}") from error


@contextmanager
def quiet() -> Iterator[None]:
    """Keep MuJoCo's warnings off the terminal and out of a log file in the user's folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _without_missing_meshes(spec: mujoco.MjSpec, path: Path) -> list[str]:
    """Drop meshes whose file is not there where they are only seen."""
    folder = path.parent / (spec.meshdir or "")
    gone = {}
    for mesh in list(spec.meshes):
        file = mesh.file
        if file and not (folder / file).is_file() and not (path.parent / Path(file).name).is_file():
            gone[mesh.name or Path(file).stem] = (mesh, file)
    if not gone:
        return []
    for geom in list(spec.geoms):
        if geom.meshname not in gone:
            continue
        if geom.contype or geom.conaffinity:
            raise ModelError(
                f"{path}: the mesh {gone[geom.meshname][1]} of a collision geom is not beside the file "
                "(package:// means nothing here: put the mesh there, or use a primitive)"
            )
        spec.delete(geom)
    for mesh, _ in gone.values():
        spec.delete(mesh)
    files = ", ".join(sorted(file for _, file in gone.values()))
    return [f"meshes that are only seen were left out, as their files are missing: {files}"]


def _name_all(spec: mujoco.MjSpec) -> None:
    for kind, elements in (("body", spec.bodies), ("joint", spec.joints), ("geom", spec.geoms)):
        taken = {element.name for element in elements}
        for number, element in enumerate(elements):
            if not element.name:
                name = f"{kind}_{number}"
                while name in taken:
                    name += "_"
                element.name = name
