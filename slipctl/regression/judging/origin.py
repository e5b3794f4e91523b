"""What two sets of numbers were made with, and which tolerance that calls for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

MACHINE = ("system", "architecture", "processor", "family")
"""What a baseline says of a machine."""

ENGINE = ("system", "family")
"""Of these, what may change the last digits: another build of the engine, other mathematical routines."""


class _Recorded(Protocol):
    @property
    def model_id(self) -> str | None: ...
    @property
    def versions(self) -> Mapping[str, str]: ...
    @property
    def machine(self) -> Mapping[str, str]: ...


@dataclass(frozen=True)
class Origin:
    """What some numbers were made with.

    Attributes
    ----------
    model_id, versions
        As in the output of ``slipctl run --json``.
    machine
        As of `slipctl.experiment.machine`.
    """

    model_id: str | None
    versions: Mapping[str, str]
    machine: Mapping[str, str]

    @classmethod
    def of_manifest(cls, manifest: Mapping[str, Any]) -> Origin:
        """Take it from the manifest of a run."""
        machine = {name: str(manifest["machine"].get(name, "unknown")) for name in MACHINE}
        return cls(manifest["model_id"], manifest["versions"], machine)


def is_elsewhere(then: _Recorded, now: _Recorded) -> bool:
    """Say whether the tolerances for another place are due.

    They are for another MuJoCo, another robot model, another operating system (its MuJoCo is another build)
    and another family of processor. Another numpy or scipy differs in the last digit at most, far below the
    nudge that tolerances are measured with; another slipctl is what is being judged.
    """
    return (
        then.model_id != now.model_id
        or then.versions.get("mujoco") != now.versions.get("mujoco")
        or any(then.machine.get(name) != now.machine.get(name) for name in ENGINE)
    )


def differences(then: _Recorded, now: _Recorded) -> list[str]:
    """Say in one sentence what else is not as it was, and what that means; nothing where all is as it was."""
    changed = []
    if then.model_id != now.model_id:
        changed.append(f"model {then.model_id} then, {now.model_id} now")
    for name in dict.fromkeys([*then.versions, *now.versions]):
        before, after = then.versions.get(name), now.versions.get(name)
        if before != after:
            changed.append(f"{name} {before or 'absent'} then, {after or 'absent'} now")
    for name, said in zip(ENGINE, ("operating system", "processor family"), strict=True):
        before, after = then.machine.get(name), now.machine.get(name)
        if before != after:
            changed.append(f"{said} {before or 'unknown'} then, {after or 'unknown'} now")
    if not changed:
        return []
    how = ", with the tolerances for elsewhere" if is_elsewhere(then, now) else ""
    return [f"{'; '.join(changed)}: judged all the same{how}"]
