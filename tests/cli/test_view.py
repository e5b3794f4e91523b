"""``slipctl view``: which recordings are opened."""

import os

import pytest

from slipctl.cli import main
from slipctl.view import ViewerError


@pytest.fixture
def opened(monkeypatch):
    calls = []
    monkeypatch.setattr(
        "slipctl.view.open_viewer", lambda paths, **_: calls.append([path.as_posix() for path in paths])
    )
    return calls


@pytest.fixture
def runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for age, name in enumerate(["old", "new", "older"]):
        folder = tmp_path / "runs" / name
        folder.mkdir(parents=True)
        (folder / "manifest.json").write_text("{}")
        for recording in ("b.rrd", "a.rrd"):
            (folder / recording).write_bytes(b"")
        stamp = {"older": 1e9, "old": 1.1e9, "new": 1.2e9}[name] + age
        os.utime(folder / "manifest.json", (stamp, stamp))
    return tmp_path / "runs"


def test_without_a_name_the_newest_run_is_opened(opened, runs):
    assert main(["view"]) == 0
    assert opened == [["runs/new/a.rrd", "runs/new/b.rrd"]]


def test_a_run_or_a_recording_can_be_named(opened, runs):
    assert main(["view", "runs/old"]) == 0
    assert main(["view", "runs/old/b.rrd"]) == 0
    assert opened == [["runs/old/a.rrd", "runs/old/b.rrd"], ["runs/old/b.rrd"]]


def test_half_written_runs_are_not_the_newest(opened, runs):
    (runs / ".new-x.part").mkdir()
    (runs / "empty").mkdir()
    assert main(["view"]) == 0
    assert opened == [["runs/new/a.rrd", "runs/new/b.rrd"]]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [([], "no run folder"), (["nothing"], "no such run folder"), (["."], "holds no recording")],
)
def test_where_there_is_nothing_to_open_exit_2_says_what_to_do(
    opened, tmp_path, monkeypatch, capsys, arguments, said
):
    monkeypatch.chdir(tmp_path)
    assert main(["view", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert opened == []


def test_without_a_screen_the_message_is_all(runs, monkeypatch, capsys):
    def refuse(paths):
        raise ViewerError("no screen")

    monkeypatch.setattr("slipctl.view.open_viewer", refuse)
    assert main(["view"]) == 3
    assert capsys.readouterr() == ("", "no screen\n")


def test_a_run_with_view_stays_good_without_a_screen(runs, monkeypatch, capsys):
    from slipctl.cli.view import show_folder

    def refuse(paths):
        raise ViewerError("no screen")

    monkeypatch.setattr("slipctl.view.open_viewer", refuse)
    show_folder(runs / "old")
    show_folder(None)
    assert capsys.readouterr().err == "no screen\nnothing was written, so there is nothing to view\n"
