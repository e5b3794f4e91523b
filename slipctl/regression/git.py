"""What git knows: which commit a name means, and a temporary checkout of it.

The user's own checkout is never touched: its files, its index and its branch stay as they are.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path

from slipctl.regression.baseline.file import CannotJudge

TIED = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX", "GIT_COMMON_DIR", "GIT_OBJECT_DIRECTORY")
"""What git sets where it runs something for a checkout, such as a hook."""

NAMES = 8
"""Branches and tags listed where none is like the name that was given."""


class UnknownRevision(Exception):
    """Git knows no such revision; the message says which names are near."""


def root_of(folder: Path) -> Path:
    """Return the top folder of the checkout that holds `folder`.

    Raises
    ------
    CannotJudge
        There is none, or git is not installed.
    """
    answer = _git(folder, "rev-parse", "--show-toplevel")
    top = answer.stdout.rstrip("\n")
    if answer.returncode or not top:
        raise CannotJudge(f"{folder} is in no git checkout: {_said(answer)}")
    return Path(top).resolve()


def is_tracked(path: Path) -> bool:
    """Say whether a file is under git's care in the checkout around it; False where there is no git."""
    try:
        return _git(path.parent, "ls-files", "--error-unmatch", "--", path.name).returncode == 0
    except CannotJudge:
        return False


def commit_of(root: Path, revision: str) -> str:
    """Return the hash of the commit that a revision means.

    Raises
    ------
    UnknownRevision
        Git does not know it.
    """
    # a name that begins with a dash would be read as an option
    if revision.strip() and not revision.startswith("-"):
        answer = _git(root, "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}")
        if answer.returncode == 0:
            return answer.stdout.strip()
    raise UnknownRevision(f"git knows no revision {revision!r} in {root}; {_what_there_is(root, revision)}")


def _what_there_is(root: Path, revision: str) -> str:
    names = _git(root, "for-each-ref", "--format=%(refname:short)", "refs/heads", "refs/tags", "refs/remotes")
    known = names.stdout.split()
    near = get_close_matches(revision, known, n=3)
    if near:
        text = f"did you mean {' or '.join(near)}?"
    elif known:
        text = f"branches and tags: {', '.join(known[:NAMES])}{', …' if len(known) > NAMES else ''}"
    else:
        text = "it has no branch or tag"
    if _git(root, "rev-parse", "--is-shallow-repository").stdout.strip() == "true":
        text += " (this is a shallow clone: fetch the history, in a workflow with fetch-depth: 0)"
    return text


def commit_around(folder: Path, besides: str) -> str | None:
    """Return the commit that is checked out around a folder, such as ``3f2a1b9c0d1e`` or ``…-dirty``.

    Parameters
    ----------
    folder
        It need not exist yet.
    besides
        Folders of this name do not count as changed. Nor do files that git does not track.

    Returns
    -------
    str or None
        Twelve digits of the hash, marked as dirty where a tracked file differs; None where there is no
        checkout, no commit yet or no git.
    """
    there = next(place for place in (folder, *folder.parents) if place.is_dir())
    try:
        head = _git(there, "rev-parse", "--verify", "--quiet", "--short=12", "HEAD")
        if head.returncode:
            return None
        but = f":(top,exclude,glob)**/{besides}/**"
        changed = _git(there, "status", "--porcelain", "--untracked-files=no", "--", ":(top)", but)
    except CannotJudge:
        return None
    # where git cannot say that nothing changed, nothing is promised
    return head.stdout.strip() + ("-dirty" if changed.returncode or changed.stdout else "")


def day(root: Path, commit: str) -> str:
    """Return the day of a commit, as 2026-01-31."""
    return _git(root, "show", "--no-patch", "--format=%cs", commit).stdout.strip()


@contextmanager
def worktree(root: Path, commit: str) -> Iterator[Path]:
    """Give a checkout of a commit in a temporary folder; it is gone afterwards, whatever happens.

    Hooks do not run: one that installs or builds something would be a surprise here.

    Raises
    ------
    CannotJudge
        Git cannot make it.
    """
    with tempfile.TemporaryDirectory(prefix="slipctl-against-", ignore_cleanup_errors=True) as folder:
        place = Path(folder).resolve() / "worktree"
        no_hooks = f"core.hooksPath={place.with_name('no-hooks')}"
        try:
            answer = _git(root, "-c", no_hooks, "worktree", "add", "--quiet", "--detach", str(place), commit)
            if answer.returncode:
                raise CannotJudge(f"git cannot check out {commit[:12]}: {_said(answer)}")
            yield place
        finally:
            try:
                _git(root, "worktree", "remove", "--force", str(place))
            finally:
                # what `remove` did not take, such as after a second Ctrl-C
                shutil.rmtree(place, ignore_errors=True)
                _git(root, "worktree", "prune")


def environment() -> dict[str, str]:
    """Return the environment without what ties git to another checkout, as within a hook or a bisection."""
    tied = (
        "GIT_DIR",
        "GIT_WORK_TREE",
        "GIT_INDEX_FILE",
        "GIT_PREFIX",
        "GIT_COMMON_DIR",
        "GIT_OBJECT_DIRECTORY",
    )
    return {name: value for name, value in os.environ.items() if name not in tied}


def _git(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            ["git", "-C", str(folder), *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            env=environment() | {"LC_ALL": "C", "GIT_TERMINAL_PROMPT": "0"},
            check=False,
        )
    except OSError as error:
        raise CannotJudge(
            f"git cannot be run ({error.strerror}); it is needed to go to another revision"
        ) from None


def _said(answer: subprocess.CompletedProcess[str]) -> str:
    """Return the line in which git says what is wrong: it may add advice below, and progress above."""
    lines = answer.stderr.strip().splitlines() or [f"git ended with {answer.returncode}"]
    return next((line for line in lines if line.startswith(("fatal:", "error:"))), lines[-1])
