"""Everything a change must pass, in one command: ``python -m tests``.

Each step is printed before it runs, a failed one does not keep the later ones from running, and the exit
status is that of the first that failed. The steps are the programs of the environment that runs this file,
so that no other version of a checker on the path can answer instead.
"""

import os
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAMS = Path(sysconfig.get_path("scripts"))  # on Windows not always where Python itself is


def program(name: str, *arguments: str) -> list[str]:
    return [str(PROGRAMS / name), *arguments]


STEPS: dict[str, list[str]] = {
    "ruff check": program("ruff", "check", "."),
    "ruff format": program("ruff", "format", "--check", "."),
    "pyright": program("pyright", "--pythonpath", sys.executable),
    "import-linter": program("lint-imports"),
    "slipctl certify": program("slipctl", "certify"),
    "slipctl check": program("slipctl", "check", "--require-certified"),
    "pytest": program("pytest", "-n", "auto", "--durations", "10"),
}


def main() -> int:
    environment = {**os.environ, "CI": os.environ.get("CI", "1")}
    codes: dict[str, int] = {}
    for name, command in STEPS.items():
        shown = " ".join([Path(command[0]).name, *command[1:]])
        print(f"\n--- {shown}", flush=True)
        begin = time.monotonic()
        codes[name] = subprocess.run(command, cwd=ROOT, env=environment, stdin=subprocess.DEVNULL).returncode
        print(f"--- {name}: exit {codes[name]} after {time.monotonic() - begin:.0f} s", flush=True)
    failed = [name for name, code in codes.items() if code]
    print(
        f"\n{len(codes) - len(failed)} of {len(codes)} steps good"
        + (f"; FAILED: {', '.join(failed)}" if failed else "")
    )
    return codes[failed[0]] if failed else 0


if __name__ == "__main__":
    sys.exit(main())
