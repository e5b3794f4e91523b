"""Certificates: what they say, where they are kept, and whether a model has one."""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from slipctl.certify.fixtures import FIXTURES
from slipctl.plants.model import compile_model, find_model, model_id
from slipctl.plants.own import OwnModel

FORMAT = 1

CACHE = "SLIPCTL_CACHE"
"""Environment variable that names another cache folder."""

_CONTACT = ("dim", "solref", "solreffriction", "solimp", "margin", "gap")
_GEOM = ("condim", "contype", "conaffinity", "priority", "solmix", "solref", "solimp", "margin", "gap")
_OPTION = (
    "cone",
    "impratio",
    "integrator",
    "solver",
    "jacobian",
    "iterations",
    "tolerance",
    "noslip_iterations",
)


class CertificateError(Exception):
    """A certificate file that cannot be read; the message says why."""


@dataclass(frozen=True)
class Key:
    """What a certificate is for: a model before ground edits, as it is compiled and stepped.

    Attributes
    ----------
    model_id : str
        Of the compiled base model.
    timestep : float
        [s].
    contacts : str
        Hash of every contact parameter but friction, which is the ground's, and of the solver's options.
    engine : str
        Name and version.
    fixtures : str
        Hash of the questions asked and their tolerances.
    """

    model_id: str
    timestep: float
    contacts: str
    engine: str
    fixtures: str

    @property
    def file(self) -> Path:
        """Where its certificate lies."""
        parts = (self.model_id, repr(self.timestep), self.contacts, self.engine, self.fixtures)
        return cache_folder() / "certificates" / f"{_hash(*(part.encode() for part in parts))[7:39]}.json"


def cache_folder() -> Path:
    """Return slipctl's folder for what can be made again, as the platform has it; nothing is created.

    ``SLIPCTL_CACHE``, else ``~/Library/Caches`` on macOS, ``%LOCALAPPDATA%`` on Windows, and
    ``$XDG_CACHE_HOME`` or ``~/.cache`` elsewhere.
    """
    told = os.environ.get(CACHE)
    if told:
        return Path(told)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "slipctl"
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return (Path(local) if local else Path.home() / "AppData" / "Local") / "slipctl" / "Cache"
    # the specification: a relative path is to be ignored
    base = Path(os.environ.get("XDG_CACHE_HOME") or ".")
    return (base if base.is_absolute() else Path.home() / ".cache") / "slipctl"


def key_of(model: str | Path | OwnModel, timestep: float) -> Key:
    """Return what a certificate of a model must be for.

    Raises
    ------
    slipctl.plants.model.ModelError
        If the model cannot be read.
    """
    found = find_model(model)
    path = found.path if isinstance(found, OwnModel) else found
    return _key(found, timestep, path.stat().st_mtime_ns, path.stat().st_size)


@lru_cache(maxsize=16)
def _key(model: Path | OwnModel, timestep: float, written: int, size: int) -> Key:
    compiled = compile_model(model, timestep)
    return Key(
        model_id=model_id(model),
        timestep=timestep,
        contacts=contacts_id(compiled),
        engine=f"mujoco {version('mujoco')}",
        fixtures=_hash(*_questions()),
    )


def contacts_id(compiled: Any) -> str:
    """Return ``sha256:…`` of a compiled model's contact parameters, friction apart, and solver options."""
    arrays = [getattr(compiled, f"pair_{name}") for name in _CONTACT]
    arrays += [getattr(compiled, f"geom_{name}") for name in _GEOM]
    options = [repr(getattr(compiled.opt, name)).encode() for name in _OPTION]
    return _hash(*(array.tobytes() for array in arrays), *options)


def _questions() -> Iterator[bytes]:
    for fixture in FIXTURES:
        yield f"{fixture.name} {fixture.unit} {fixture.tolerance!r} {fixture.relative}".encode()


def _hash(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(len(part).to_bytes(8, "little") + part)
    return "sha256:" + digest.hexdigest()


def store(key: Key, content: Mapping[str, Any]) -> Path:
    """Write a certificate into the cache, whole or not at all.

    Returns
    -------
    Path

    Raises
    ------
    OSError
        If it cannot be written.
    """
    target = key.file
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, part = tempfile.mkstemp(prefix=".", suffix=".part", dir=target.parent)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
        os.replace(part, target)
    except BaseException:
        Path(part).unlink(missing_ok=True)
        raise
    return target


def read(path: Path) -> dict[str, Any]:
    """Return the content of a certificate.

    Raises
    ------
    CertificateError
        If it is none.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise CertificateError(f"no certificate at {path}") from error
    except (OSError, ValueError) as error:
        raise CertificateError(f"{path}: not a certificate that can be read ({error})") from error
    checks = content.get("checks") if isinstance(content, dict) else None
    if not isinstance(checks, list) or not all(
        isinstance(check, dict) and {"name", "measured", "error", "tolerance", "unit", "passed"} <= set(check)
        for check in checks
    ):
        raise CertificateError(f"{path}: not a certificate: it holds no list of checks")
    return content


class State(Enum):
    """Whether a model is certified against closed forms."""

    PASSED = "passed"
    FAILED = "failed"
    MISSING = "missing"


@dataclass(frozen=True)
class Standing:
    """What the cache says of a model.

    Attributes
    ----------
    state : State
    failed : tuple of str
        Names of the failed fixtures.
    """

    state: State
    failed: tuple[str, ...] = ()

    def json(self) -> dict[str, Any]:
        """Return what stands in a manifest."""
        return {"against": "closed forms", "state": self.state.value, "failed": list(self.failed)}


def standing(model: str | Path | OwnModel, timestep: float) -> Standing:
    """Look up whether a model is certified against closed forms, as it is compiled and stepped here.

    Raises
    ------
    slipctl.plants.model.ModelError
        If the model cannot be read.
    """
    try:
        content = read(key_of(model, timestep).file)
    except CertificateError:
        return Standing(State.MISSING)
    failed = tuple(check["name"] for check in content["checks"] if not check["passed"])
    return Standing(State.FAILED if failed or not content["checks"] else State.PASSED, failed)
