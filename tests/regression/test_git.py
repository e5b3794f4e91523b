"""Temporary checkouts: the right commit, nothing of the user's touched, nothing left behind."""

import os
import re
import shutil
import tempfile
from pathlib import Path

import pytest

from slipctl.regression import git
from slipctl.regression.baseline.file import CannotJudge
from tests.repository import Repository, needs_git

pytestmark = needs_git


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """Two commits, a tag, a changed file; temporary folders are where the test can see them."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    repository = Repository(tmp_path / "repository")
    repository.commit("first", {"a.txt": "one"})
    repository.git("tag", "release")
    repository.commit("second", {"a.txt": "two"})
    (repository.folder / "a.txt").write_text("changed")
    return repository


def test_the_root_is_found_from_below(repository):
    below = repository.folder / "deep" / "down"
    below.mkdir(parents=True)
    assert git.root_of(below) == repository.folder


def test_a_folder_outside_is_in_no_checkout(tmp_path):
    with pytest.raises(CannotJudge, match="in no git checkout: "):
        git.root_of(tmp_path)


@pytest.mark.skipif(os.name == "nt", reason="a shell script is no program there")
def test_what_git_says_is_passed_on_without_its_advice(tmp_path, monkeypatch):
    # as in a container, where the checkout belongs to somebody else
    git_program = tmp_path / "git"
    advice = "fatal: detected dubious ownership in repository\nTo add an exception, call:\n\tgit config"
    git_program.write_text(f"#!/bin/sh\nprintf '{advice}' >&2\nexit 128\n", newline="\n")
    git_program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CannotJudge, match=r"checkout: fatal: detected dubious ownership in repository$"):
        git.root_of(tmp_path)


@pytest.mark.parametrize(("file", "tracked"), [("a.txt", True), ("b.txt", False), ("missing.txt", False)])
def test_tracked_is_what_git_holds(repository, file, tracked):
    (repository.folder / "b.txt").write_text("new")
    assert git.is_tracked(repository.folder / file) is tracked


def test_names_mean_what_git_says(repository):
    first, second = repository.git("rev-list", "--reverse", "HEAD").split()
    for name, commit in {"release": first, "HEAD~1": first, "main": second, second[:10]: second}.items():
        assert git.commit_of(repository.folder, name) == commit
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", git.day(repository.folder, first))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("relaese", "did you mean release?"),
        ("mian", "did you mean main?"),
        ("HEAD~9", "branches and tags: main, release"),
        ("HEAD:a.txt", "branches and tags"),
        ("", "branches and tags"),
        ("--all", "branches and tags"),
    ],
)
def test_an_unknown_revision_names_its_neighbours(repository, name, said):
    with pytest.raises(git.UnknownRevision, match="git knows no revision") as error:
        git.commit_of(repository.folder, name)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_shallow_clone_says_so(repository, tmp_path):
    repository.git("clone", "--quiet", "--depth=1", repository.folder.as_uri(), str(tmp_path / "shallow"))
    with pytest.raises(git.UnknownRevision, match="shallow clone: fetch the history"):
        git.commit_of(tmp_path / "shallow", "HEAD~1")


def test_a_worktree_holds_the_commit_and_leaves_the_checkout_alone(repository):
    before = repository.git("status", "--porcelain=v2", "--branch")
    with git.worktree(repository.folder, git.commit_of(repository.folder, "release")) as place:
        assert (place / "a.txt").read_text() == "one"
        assert not place.is_relative_to(repository.folder)
        assert repository.git("status", "--porcelain=v2", "--branch") == before
    assert not place.exists()
    assert repository.git("status", "--porcelain=v2", "--branch") == before
    assert (repository.folder / "a.txt").read_text() == "changed"


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_worktree_is_gone_after_any_end(repository, error):
    def work():
        with git.worktree(repository.folder, "release") as place:
            (place / "left.txt").write_text("by the run")
            (place / "a.txt").write_text("by the run")
            assert len(repository.worktrees()) == 2
            raise error

    with pytest.raises(error):
        work()
    assert [Path(path) for path in repository.worktrees()] == [repository.folder]
    assert list(Path(tempfile.gettempdir()).iterdir()) == []


def test_a_worktree_whose_folder_was_taken_away_is_forgotten(repository):
    with git.worktree(repository.folder, "release") as place:
        shutil.rmtree(place)
    assert len(repository.worktrees()) == 1


def test_a_worktree_that_cannot_be_made_leaves_nothing(repository):
    with pytest.raises(CannotJudge, match="git cannot check out"), git.worktree(repository.folder, "f" * 40):
        pytest.fail("there is no such commit")
    assert len(repository.worktrees()) == 1
    assert list(Path(tempfile.gettempdir()).iterdir()) == []


def test_hooks_of_the_user_do_not_run(repository):
    hook = repository.folder / ".git" / "hooks" / "post-checkout"
    hook.parent.mkdir(exist_ok=True)
    hook.write_text(f"#!/bin/sh\ntouch '{repository.folder.as_posix()}/ran'\n")
    hook.chmod(0o755)
    with git.worktree(repository.folder, "release"):
        pass
    assert not (repository.folder / "ran").exists()


def test_within_a_hook_of_another_repository_the_right_one_is_meant(repository, tmp_path, monkeypatch):
    other = Repository(tmp_path / "other")
    monkeypatch.setenv("GIT_DIR", str(other.folder / ".git"))
    monkeypatch.setenv("GIT_INDEX_FILE", str(other.folder / ".git" / "index"))
    assert git.root_of(repository.folder) == repository.folder
    with git.worktree(repository.folder, git.commit_of(repository.folder, "release")) as place:
        assert (place / "a.txt").read_text() == "one"


def test_without_git_it_cannot_be_judged(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CannotJudge, match="git cannot be run"):
        git.root_of(tmp_path)
    assert not git.is_tracked(tmp_path / "a.txt")
