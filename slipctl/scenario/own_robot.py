"""`[robot]` with a model by its path: a robot of one's own."""

from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from slipctl import shipped
from slipctl.scenario.base import lookup
from slipctl.scenario.problems import Problem, nearest, quote, show

OWN_KEYS = ("left_wheel", "right_wheel", "keep_contacts", "caster_friction")
"""Keys of `[robot]` that only a model by its path has."""

_ENDINGS = (".xml", ".mjcf", ".urdf")


def is_path(model: Any) -> bool:
    """Whether `robot.model` names a file and not a shipped model."""
    if not isinstance(model, str) or model in shipped.model_names():
        return False
    return "/" in model or "\\" in model or model.lower().endswith(_ENDINGS)


def model_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Tell of a model that is neither shipped nor a file."""
    model, names = lookup(raw, "robot", "model"), shipped.model_names()
    if not isinstance(model, str) or not model or model in names:
        return
    if not is_path(model):
        allowed = f"{', '.join(map(quote, names))}, or the path of an MJCF or URDF file"
        yield Problem("robot.model", show(model), allowed, nearest(model, names))
    elif not Path(model).is_file():
        yield Problem("robot.model", f"{model}, where there is no file", "the path of an MJCF or URDF file")
    elif lookup(raw, "robot", "keep_contacts") is True:
        for key in ("film", "creep_stiffness"):
            if lookup(raw, "ground", key) is not None:
                allowed = "none with robot.keep_contacts = true: it holds on calibrated contacts only"
                yield Problem(f"ground.{key}", show(lookup(raw, "ground", key)), allowed)
        for table in ("patch", "change"):
            entries = lookup(raw, "ground", table)
            for index, entry in enumerate(entries if isinstance(entries, list | tuple) else ()):
                if lookup(entry, "film") is not None:
                    allowed = "no film with robot.keep_contacts = true: it holds on calibrated contacts only"
                    yield Problem(f"ground.{table}[{index}].film", show(lookup(entry, "film")), allowed)


def with_whole_path(raw: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Make the path of the model absolute, so that it holds for every reader."""
    model = lookup(raw, "robot", "model")
    if not is_path(model):
        return raw
    return {**raw, "robot": {**raw["robot"], "model": str((folder / model).absolute())}}


def ignored_keys(raw: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], str]]:
    """Paths of keys that would have no effect, each with the reason."""
    model = lookup(raw, "robot", "model")
    if not is_path(model):
        for key in OWN_KEYS:
            yield ("robot", key), "a shipped model says so itself"
    elif lookup(raw, "robot", "keep_contacts") is True:
        yield ("robot", "caster_friction"), "keep_contacts = true keeps those of the casters, too"


def content(model: str) -> str:
    """Return what identifies a model by its path: the hash of the file, wherever it lies."""
    try:
        # a checkout on Windows may end lines in its own way: the robot is the same
        return sha256(Path(model).read_bytes().replace(b"\r\n", b"\n")).hexdigest()
    except OSError:
        return model
