"""The progress bar: there for a person who looks, not for a log."""

import pytest

from slipctl.cli import main
from slipctl.cli.progress import progress_bar


def test_a_terminal_shows_what_is_done_and_the_time_left(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich then takes the stream for a terminal
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar(quiet=False) as progress:
        assert progress is not None
        progress(30, 120, "world 1 to 14 of 14")
    out, err = capsys.readouterr()
    assert out == ""
    assert "world 1 to 14 of 14" in err
    assert "25%" in err
    assert "left" in err


def test_quiet_shows_none(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with progress_bar(quiet=True) as progress:
        assert progress is None
    assert capsys.readouterr() == ("", "")


def test_a_log_gets_none(monkeypatch, capsys):
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    with progress_bar(quiet=False) as progress:
        assert progress is None
    assert capsys.readouterr() == ("", "")


def test_it_is_there_while_a_grid_is_judged(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")

    def stop(*_, **__):
        raise KeyboardInterrupt  # what comes after it does not matter here

    monkeypatch.setattr("slipctl.experiment.run", stop)
    order = ["sweep", "paper-kinematic", "--over", "slip.yaw=0.1,0.2", "--out", str(tmp_path)]
    assert main(order) == 130
    assert "judging the grid" in capsys.readouterr().err
    assert main([*order, "--quiet"]) == 130
    assert "judging the grid" not in capsys.readouterr().err


@pytest.mark.parametrize("command", ["run", "sweep"])
def test_ctrl_c_while_a_grid_is_judged_is_said(command, monkeypatch, capsys):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.scenario.loading.axis_problems", stop)
    assert main([command, "friction-sweep"]) == 130
    assert capsys.readouterr() == ("", "interrupted; nothing was begun\n")
