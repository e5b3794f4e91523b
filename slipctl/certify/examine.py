"""Try every fixture on a model, keep the certificate, and compare two of them."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from slipctl.certify.certificate import FORMAT, key_of, store
from slipctl.certify.fixture import Bench
from slipctl.certify.fixtures import FIXTURES
from slipctl.plants.model import find_model
from slipctl.plants.own import OwnModel

Progress = Callable[[int, int, str], None]

SAME = 1e-9
"""Relative difference up to which two measurements are the same: what rounding in another library may do."""


def examine(
    model: str | Path | OwnModel, timestep: float = 0.001, progress: Progress | None = None
) -> dict[str, Any]:
    """Return the certificate of a model, passed or failed; nothing is written.

    Parameters
    ----------
    model : str, Path or OwnModel
        A shipped model's name, a path, or a path with what the file does not tell.
    timestep : float
        Physics step [s].
    progress : callable, optional
        Called with the fixtures done, all fixtures, and the name of the next.

    Returns
    -------
    dict
        ``model``, ``model_id``, ``versions``, ``passed`` and ``checks``, and what else it was made for.

    Raises
    ------
    slipctl.plants.model.ModelError
        If the model cannot be read.
    """
    key, bench = key_of(model, timestep), Bench(find_model(model), timestep)
    checks = []
    for done, fixture in enumerate(FIXTURES):
        if progress is not None:
            progress(done, len(FIXTURES), fixture.name.replace("_", " "))
        checks.append(fixture.check(bench))
    return {
        "format": FORMAT,
        "model": str(model),
        "model_id": key.model_id,
        "timestep": timestep,
        "contacts": key.contacts,
        "versions": {name: version(name) for name in ("slipctl", "mujoco", "numpy")},
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "passed": all(check.passed for check in checks),
        "checks": [check.json() for check in checks],
    }


def certify(
    model: str | Path | OwnModel, timestep: float = 0.001, progress: Progress | None = None
) -> dict[str, Any]:
    """Examine a model and keep the certificate in the user's cache, passed or failed.

    Parameters and errors are those of `examine`.

    Raises
    ------
    OSError
        If the cache cannot be written.
    """
    content = examine(model, timestep, progress)
    store(key_of(model, timestep), content)
    return content


def changes(then: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Say what is different between two certificates: versions, model, and every measurement that moved.

    Parameters
    ----------
    then, now : mapping
        Contents of certificates.
    """
    said = [
        f"{name}: {then.get(name)} then, {now.get(name)} now"
        for name in ("model", "model_id", "timestep", "contacts")
        if then.get(name) != now.get(name)
    ]
    old, new = then.get("versions", {}), now.get("versions", {})
    said += [
        f"{name} {old.get(name, 'absent')} then, {new.get(name, 'absent')} now"
        for name in dict.fromkeys([*old, *new])
        if old.get(name) != new.get(name)
    ]
    before = {check["name"]: check for check in then["checks"]}
    for check in now["checks"]:
        was = before.pop(check["name"], None)
        if was is None:
            said.append(f"{check['name']}: not asked then")
        else:
            said += _moved(was, check)
    said += [f"{name}: not asked now" for name in before]
    return said


def _moved(was: Mapping[str, Any], check: Mapping[str, Any]) -> list[str]:
    name, unit = check["name"], check["unit"]
    a, b = was["measured"], check["measured"]
    verdicts = {True: "passed", False: "failed"}
    flip = ""
    if was["passed"] != check["passed"]:
        flip = f"; {verdicts[was['passed']]} then, {verdicts[check['passed']]} now"
    still = a == b if a is None or b is None else abs(a - b) <= SAME * max(abs(a), abs(b), check["tolerance"])
    if still and not flip:
        return []
    shown = ["not measured" if value is None else f"{value:.6g} {unit}" for value in (a, b)]
    return [f"{name}: {shown[0]} then, {shown[1]} now{flip}"]
