"""Seeded mistakes in theory, metrics and the gate, one at a time: ``python -m tests.mutation``.

Runs mutmut (the `mutation` extra; Linux and macOS), prints how many mistakes the tests see, module by module,
and every one that they do not see. Fails where a part is below 90 %, or where docs/mutation.md does not have
a survivor with its reason. With ``--report`` only the second half: of the run before.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections import Counter, defaultdict
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "mutation.md"
PROGRAM = str(Path(sys.executable).parent / "mutmut")
PARTS = ("slipctl.theory.", "slipctl.metrics.", "slipctl.regression.")
LEAST = 0.90
SEEN = ("killed", "timeout")


def mutmut(*arguments: str) -> str:
    return subprocess.run(
        [PROGRAM, *arguments], cwd=ROOT, check=True, capture_output=True, encoding="utf-8"
    ).stdout


def outcomes() -> dict[str, str]:
    """Return the status of every mutant by its name."""
    lines = (line.strip().rpartition(": ") for line in mutmut("results", "--all", "true").splitlines())
    return {name: status for name, _, status in lines if name.startswith("slipctl.")}


def module_of(mutant: str) -> str:
    return re.split(r"\.x[_ǁ]", mutant)[0]


def change(mutant: str) -> list[str]:
    """Return the lines of its diff that a mutant takes away and puts in, as ``mutmut show`` does."""
    shown = import_module("mutmut.mutation.diff_apply")
    path = Path(*module_of(mutant).split(".")).with_suffix(".py")
    lines = shown.get_diff_for_mutant(mutant, path=path).splitlines()
    return [line for line in lines if line[:1] in ("-", "+") and line[:3] not in ("---", "+++")]


def report() -> bool:
    """Print scores and survivors; tell whether all is well."""
    by_module: dict[str, Counter[str]] = defaultdict(Counter)
    statuses = outcomes()
    for mutant, status in statuses.items():
        by_module[module_of(mutant)][status] += 1
    good = bool(statuses)
    for part in PARTS:
        total = killed = 0
        for module, counts in sorted(by_module.items()):
            if f"{module}.".startswith(part):
                dead, every = sum(counts[status] for status in SEEN), sum(counts.values())
                total, killed = total + every, killed + dead
                print(f"{module:38} {dead:5} / {every:5}  {dead / every:7.1%}  {dict(counts)}")
        good &= total > 0 and killed >= LEAST * total
        print(f"{part.strip('.'):38} {killed:5} / {total:5}  {killed / max(total, 1):7.1%}\n")
    page = PAGE.read_text(encoding="utf-8").splitlines()
    for mutant, status in statuses.items():
        if status not in SEEN:
            lines = change(mutant)
            known = all(line in page for line in lines)
            good &= known
            print(f"{mutant}: {status}{'' if known else ', not in docs/mutation.md'}", *lines, sep="\n")
    return good


def main() -> int:
    os.chdir(ROOT)  # where mutmut looks for its files
    if "--report" not in sys.argv[1:]:
        # anew: what earlier tests saw or missed counts for nothing
        shutil.rmtree(ROOT / "mutants", ignore_errors=True)
        subprocess.run([PROGRAM, "run"], cwd=ROOT, check=True)
    return 0 if report() else 1


if __name__ == "__main__":
    sys.exit(main())
