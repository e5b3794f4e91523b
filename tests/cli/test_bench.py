"""``slipctl bench``."""

from __future__ import annotations

import json

import pytest

from slipctl import bench as benchmarks
from slipctl.bench import Measurement, ReplayError
from slipctl.cli import main


@pytest.fixture
def asked(monkeypatch):
    asked = []

    def measure(scenario, repeats, threads, progress):
        asked.append((len(scenario.sweep[0].values), len(scenario.controller), repeats, threads))
        return Measurement(2, 1, 30, 10, threads, "all", (1.0,) * repeats, (1.25,) * repeats, (0.1, 0.2))

    monkeypatch.setattr(benchmarks, "measure_sweep", measure)
    monkeypatch.setattr(benchmarks, "decision_times", lambda: {"some_law": 12.345})
    return asked


def test_options_arrive_and_the_numbers_are_printed(asked, capsys):
    assert main(["bench", "--worlds", "5", "--repeats", "2", "--threads", "2"]) == 0
    assert asked == [(5, 1, 2, 2)]
    printed = capsys.readouterr().out
    assert "ratio     1.250, 1.250 to 1.250 in 2 pairs" in printed
    assert "some_law    12.3 µs" in printed


def test_json_is_one_object(asked, capsys):
    assert main(["bench", "--json"]) == 0
    assert asked == [(64, 1, 3, 1)]
    told = json.loads(capsys.readouterr().out)
    assert told["ratio"] == 1.25
    assert told["decisions_us"] == {"some_law": 12.35}
    assert {"machine", "versions", "load", "floor_us", "cost_us"} <= set(told)


def test_a_replay_that_ends_elsewhere_is_not_judged(monkeypatch, capsys):
    def differs(*arguments, **named):
        raise ReplayError("the replay does not end where the closed loop did")

    monkeypatch.setattr(benchmarks, "measure_sweep", differs)
    assert main(["bench", "--worlds", "2"]) == 3
    assert "would mean nothing" in capsys.readouterr().err


def test_nonsense_is_refused(capsys):
    assert main(["bench", "--worlds", "0"]) == 2
    assert "--worlds" in capsys.readouterr().err
