"""What a scenario gave elsewhere: at another git revision, or in a run folder."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipctl import experiment, shipped
from slipctl.regression import git
from slipctl.regression.against.payload import payload_of, see_payload
from slipctl.regression.baseline.file import CannotJudge
from slipctl.scenario import ScenarioError, load

Progress = Callable[[int, int, str], None]

PACKAGE = Path(shipped.__file__).resolve().parent
"""Folder of the slipctl that runs."""


@dataclass(frozen=True)
class Reference:
    """Numbers to compare with.

    Attributes
    ----------
    label
        What they are called.
    payload
        As in the output of ``slipctl run --json``.
    machine
        Where they were made; None where that is here and now.
    notes
        What a reader should know of where they come from.
    commit, date
        Commit and day, where known.
    """

    label: str
    payload: Mapping[str, Any]
    machine: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()
    commit: str | None = None
    date: str | None = None


@dataclass(frozen=True)
class RunFolder:
    """A folder that ``slipctl run`` wrote.

    Attributes
    ----------
    path
        Where it is.
    notes
        How its name was understood.
    """

    path: Path
    notes: tuple[str, ...] = ()

    def reference(self, threads: int | None = None, progress: Progress | None = None) -> Reference:
        """Read the numbers.

        Raises
        ------
        CannotJudge
            The folder is damaged, or was written by another version of the format.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        label = f"run folder {self.path}"
        try:
            manifest = json.loads((self.path / "manifest.json").read_text(encoding="utf-8"))
            rows = pq.read_table(self.path / "metrics.parquet").to_pylist()
        except (OSError, ValueError, RecursionError, pa.ArrowException) as error:
            first = (str(error).splitlines() or [type(error).__name__])[0]
            raise CannotJudge(f"{label} cannot be read: {first}") from None
        payload = payload_of(manifest, rows, label)
        machine, date = manifest["machine"], manifest["finished"][:10]
        notes = self.notes
        if manifest.get("interrupted"):
            notes = (*notes, f"{self.path} was interrupted and does not hold every run")
        return Reference(f"run {self.path}", payload, machine, notes, date=date)


@dataclass(frozen=True)
class Revision:
    """A scenario file as it stood at a git revision.

    Attributes
    ----------
    label
        The name that was given, with hash and day.
    root
        Top folder of the checkout.
    commit
        Hash of the commit.
    file
        The scenario, relative to `root`.
    source
        Where the folder with slipctl's own package lies, relative to `root`, if it does.
    """

    label: str
    root: Path
    commit: str
    file: Path
    source: Path

    def reference(self, threads: int | None = None, progress: Progress | None = None) -> Reference:
        """Run the scenario in a temporary checkout, by the slipctl in it if that is slipctl's own source.

        Raises
        ------
        CannotJudge
            The revision does not have the scenario, cannot run it, or gives what are no numbers.
        KeyboardInterrupt
            It was interrupted; the checkout is gone.
        """
        if progress is not None:
            progress(0, 1, f"{self.file.stem} at {self.label}")
        with git.worktree(self.root, self.commit) as place:
            file, source = place / self.file, place / self.source
            if not file.is_file():
                raise CannotJudge(f"{self.label} has no {self.file.as_posix()}")
            if (source / "slipctl" / "__init__.py").is_file():
                payload, by = self._by_its_own(source, file, threads), "the slipctl of then"
            else:
                payload, by = self._by_this(file, threads, progress), "this slipctl"
        see_payload(payload, f"what {self.label} gave")
        date = git.day(self.root, self.commit)
        return Reference(self.label, payload, notes=(f"run by {by}",), commit=self.commit[:12], date=date)

    def _by_this(self, file: Path, threads: int | None, progress: Progress | None) -> Mapping[str, Any]:
        from slipctl.plants.errors import ModelError

        try:
            result = experiment.run(load(file), record="none", threads=threads, progress=progress)
        except (ScenarioError, ModelError) as error:
            raise self._cannot_run(file, str(error).splitlines()[0]) from None
        if result.interrupted:
            raise KeyboardInterrupt
        return result.json()

    def _by_its_own(self, source: Path, file: Path, threads: int | None) -> Mapping[str, Any]:
        with tempfile.TemporaryDirectory(prefix="slipctl-runs-", ignore_cleanup_errors=True) as out:
            command = [sys.executable, "-m", "slipctl.cli", "run", str(file), "--json", "--quiet"]
            command += ["--record", "none", "--out", out]
            command += [] if threads is None else ["--threads", str(threads)]
            # `-m` looks in the working folder first, whatever slipctl is installed
            answer = subprocess.run(
                command,
                cwd=source,
                env=_environment(source),
                stdin=subprocess.DEVNULL,
                capture_output=True,
                encoding="utf-8",
                errors="replace",
                check=False,
            )
        if answer.returncode == 130:
            raise KeyboardInterrupt
        try:
            if answer.returncode:
                raise ValueError
            return json.loads(answer.stdout)
        except ValueError:
            raise self._cannot_run(file, _reason(answer.stderr)) from None

    def _cannot_run(self, file: Path, why: str) -> CannotJudge:
        # the temporary path is gone when somebody reads this
        why = why.removeprefix(f"{file}: ")
        return CannotJudge(f"{self.label} cannot run {self.file.as_posix()}: {why}")


def find(source: str, name: str) -> RunFolder | Revision:
    """Find what to compare a scenario with.

    Parameters
    ----------
    source
        What the scenario is loaded from: the name of a shipped one, or a path.
    name
        A run folder, or a git revision of the checkout that holds the scenario file. A name that is both is
        the folder.

    Raises
    ------
    UnknownRevision
        It is neither.
    CannotJudge
        The scenario is in no git checkout.
    """
    folder = Path(name)
    is_run = all((folder / part).is_file() for part in ("manifest.json", "metrics.parquet"))
    try:
        revision = _revision(source, name)
    except (git.UnknownRevision, CannotJudge) as error:
        if is_run:
            return RunFolder(folder)
        if isinstance(error, git.UnknownRevision):
            what = "the folder holds no run" if folder.is_dir() else "there is no such folder"
            raise git.UnknownRevision(f"--against {name}: {what}, and {error}") from None
        raise
    if is_run:
        return RunFolder(folder, (f"{name} is a run folder and a git revision: the folder is taken",))
    return revision


def _revision(source: str, name: str) -> Revision:
    tracked = git.is_tracked(PACKAGE / "__init__.py")
    if source in shipped.scenario_names():
        if not tracked:
            raise CannotJudge(
                f"{source} comes with the installed slipctl, which is no git checkout; "
                "name a scenario file that is in one"
            )
        file = shipped.scenario_path(source)
    else:
        file = Path(source)
    file = file.resolve()
    root = git.root_of(file.parent)
    commit = git.commit_of(root, name)
    own = tracked and PACKAGE.is_relative_to(root)
    return Revision(
        label=f"{name} ({commit[:7]} of {git.day(root, commit)})",
        root=root,
        commit=commit,
        file=file.relative_to(root),
        source=PACKAGE.parent.relative_to(root) if own else Path(),
    )


def _environment(source: Path) -> dict[str, str]:
    environment = git.environment()
    paths = [str(source), *filter(None, [environment.get("PYTHONPATH")])]
    return environment | {
        "PYTHONPATH": os.pathsep.join(paths),
        "PYTHONIOENCODING": "utf-8",
        "PYTHONDONTWRITEBYTECODE": "1",
    }


def _reason(said: str) -> str:
    """Return the line that says why: the first, or the error at the end of a traceback."""
    lines = [line for line in said.splitlines() if line.strip()]
    if not lines:
        return "it said nothing"
    if not any(line.startswith("Traceback") for line in lines):
        return lines[0]
    errors = [line for line in lines if not line.startswith((" ", "Traceback", "this is a defect"))]
    return errors[-1] if errors else lines[-1]
