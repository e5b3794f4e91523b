"""What the numbers of a run were made on."""

from __future__ import annotations

import hashlib
import os
import platform
import re
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

CPU_INFO = Path("/proc/cpuinfo")
"""Where Linux tells of the processor."""

ARCHITECTURES = {"amd64": "x86_64", "arm64": "aarch64"}
"""What systems call one architecture, by the name that is used here."""

SOURCE = "slipctl source"
"""Where the hash of the source stands among the versions."""

VENDORS = ("vendor_id", "CPU implementer")
FAMILIES = ("cpu family", "CPU architecture")
"""Keys of Linux's description of a processor, of x86 and of ARM."""


def versions() -> dict[str, str]:
    """Return the versions that decide the numbers."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    return {name: version(name) for name in ("slipctl", "mujoco", "numpy", "scipy", "rerun-sdk", "pyarrow")}


def exact_versions() -> dict[str, str]:
    """Return the versions, and a hash of this package's source under `SOURCE`.

    Parts of one experiment must agree in all of it: a version says nothing of a source that was edited.
    """
    return {**versions(), SOURCE: source()}


@cache
def source() -> str:
    """Return a hash of the names and text of all Python files of this package, as they are now."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py"), key=lambda path: path.relative_to(package).parts):
        # line ends depend on how it was installed, not on what it does
        text = path.read_bytes().replace(b"\r\n", b"\n")
        digest.update(path.relative_to(package).as_posix().encode() + b"\0" + text + b"\0")
    return f"sha256:{digest.hexdigest()[:16]}"


def machine() -> dict[str, Any]:
    """Return what the numbers are made on.

    Returns
    -------
    dict
        ``system``, ``architecture``, ``processor``, ``family`` (see `family`), ``cores`` and ``python``.
    """
    described = _described()
    return {
        "system": platform.system(),
        "architecture": platform.machine(),
        "processor": described.get("model name") or platform.processor(),
        "family": family(platform.machine(), described, platform.processor()),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
    }


def family(architecture: str, described: dict[str, str], processor: str) -> str:
    """Name the family of a processor: those of one family round alike.

    Mathematical libraries choose their code by the processor, so that the last digit of a sine may differ
    from family to family.

    Parameters
    ----------
    architecture : str
        As `platform.machine` gives it.
    described : dict
        What Linux tells of the processor; empty elsewhere.
    processor : str
        As `platform.processor` gives it.

    Returns
    -------
    str
        Architecture, vendor and family, such as ``x86_64 GenuineIntel 6``; what is not known is left out.
    """
    vendor = next((described[key] for key in VENDORS if key in described), "")
    number = next((described[key] for key in FAMILIES if key in described), "")
    if not vendor:
        # Windows: "Intel64 Family 6 Model 85 Stepping 7, GenuineIntel"
        said = re.search(r"Family (\d+).*, (\w+)$", processor)
        number, vendor = said.groups() if said else ("", processor)
    name = ARCHITECTURES.get(architecture.lower(), architecture.lower())
    parts = [name, "" if vendor == name else vendor, number]
    return " ".join(part for part in parts if part) or "unknown"


def _described() -> dict[str, str]:
    """Return what Linux tells of the first processor; nothing elsewhere."""
    try:
        lines = CPU_INFO.read_text(encoding="utf-8", errors="replace").split("\n\n")[0].splitlines()
    except OSError:
        return {}
    pairs = (line.partition(":") for line in lines)
    return {key.strip(): value.strip() for key, _, value in pairs}
