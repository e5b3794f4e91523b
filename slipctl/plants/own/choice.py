"""Which file, which of its joints drive, and whose contacts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class OwnModel:
    """A model by its path, with what the file itself does not tell.

    Attributes
    ----------
    path : Path
        Of an MJCF or URDF file.
    left_wheel, right_wheel : str or None
        Names of the joints that drive; guessed where None.
    keep_contacts : bool
        Keep the file's own contacts and contact options instead of the calibrated ones.
    caster_friction : float or None
        Friction of casters that have no joint, in place of what is compiled from the file, which is 1 for
        most URDFs and brakes; 0 lets them slide freely [1].
    """

    path: Path
    left_wheel: str | None = None
    right_wheel: str | None = None
    keep_contacts: bool = False
    caster_friction: float | None = None

    def __str__(self) -> str:
        """Name the file, as messages do."""
        return str(self.path)
