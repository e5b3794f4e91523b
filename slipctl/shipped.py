"""Where the models, scenarios and baselines that ship with slipctl lie on disk.

In an installed wheel they are folders inside the package; in a checkout they stand beside it.
Imports nothing of slipctl.
"""

from functools import lru_cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _folder(name: str) -> Path:
    inside = _PACKAGE / name
    return inside if inside.is_dir() else _PACKAGE.parent / name


def model_path(name: str) -> Path:
    """Path of the shipped MJCF model `name` (whether or not it exists; see `model_names`)."""
    return _folder("models") / f"{name}.xml"


def model_names() -> tuple[str, ...]:
    """Names of the shipped models, sorted."""
    folder = _folder("models")
    return _stems(folder, "*.xml", folder.stat().st_mtime_ns)


def scenario_path(name: str) -> Path:
    """Path of the shipped scenario `name` (whether or not it exists; see `scenario_names`)."""
    return _folder("scenarios") / f"{name}.toml"


def scenario_names() -> tuple[str, ...]:
    """Names of the shipped scenarios, sorted."""
    folder = _folder("scenarios")
    return _stems(folder, "*.toml", folder.stat().st_mtime_ns)


@lru_cache(maxsize=16)
def _stems(folder: Path, pattern: str, changed: int) -> tuple[str, ...]:
    """Read a folder only where it was `changed`: every world of a sweep asks for the names of models."""
    return tuple(sorted(path.stem for path in folder.glob(pattern)))


def baseline_folder() -> Path:
    """Folder of the committed baselines (`slipctl check` compares with these)."""
    return _folder("scenarios") / "baselines"
