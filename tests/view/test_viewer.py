"""Opening the viewer: what cannot work is said; nothing here opens a window."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from slipctl.view import ViewerError, open_viewer, viewer
from slipctl.view.viewer import viewer_program

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "world.rrd"
    path.touch()
    return path


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":0")


def stand_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    if sys.platform == "win32":
        pytest.skip("the stand-in is a shell script")
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setattr(viewer, "viewer_program", lambda: program)


@on_linux
def test_without_a_screen_it_says_what_to_do(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(ViewerError, match=r"no screen.*world\.rrd"):
        open_viewer([recording])


def test_without_a_recording(tmp_path: Path) -> None:
    with pytest.raises(ViewerError, match="no recording"):
        open_viewer([tmp_path])
    with pytest.raises(ViewerError, match="no recording"):
        open_viewer([])
    with pytest.raises(ViewerError, match=r"no such recording.*gone\.rrd"):
        open_viewer([tmp_path / "gone.rrd"])


@pytest.mark.usefixtures("screen")
def test_a_viewer_that_fails_is_quoted(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(tmp_path, monkeypatch, "echo no adapter >&2; exit 3")
    for wait in (False, True):
        with pytest.raises(ViewerError, match="status 3: no adapter"):
            open_viewer([recording], wait=wait)


@pytest.mark.usefixtures("screen")
def test_all_recordings_of_a_folder_are_handed_over(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "another.rrd").touch()
    stand_in(tmp_path, monkeypatch, f'echo "$@" > {tmp_path}/arguments')
    open_viewer([tmp_path], wait=True)
    told = (tmp_path / "arguments").read_text().split()
    assert told[-2:] == [str(tmp_path / "another.rrd"), str(recording)]


def test_the_viewer_comes_with_rerun() -> None:
    answer = subprocess.run(
        [viewer_program(), "--version"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "CI": "1"},
    )
    assert " 0.41." in answer.stdout
