"""A sweep of any size fits into memory: its peak does not grow with the number of worlds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from slipctl import scenario as files
from tests.sweeps import moment

ROOT = Path(__file__).resolve().parents[2]

CODE = """
import json, resource, sys
from slipctl import scenario as files
from slipctl.experiment import run
scenario = files.reread(json.loads(sys.argv[1]))
run(scenario, out=sys.argv[2], record="none", signals="sampled")
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(peak / 1024 if sys.platform != "darwin" else peak / 2**20)
"""


def peak(worlds: int, out: Path) -> float:
    """Return the largest memory of a process that runs so many worlds [MiB]."""
    sweep = {"start.x_offset": {"from": 0.0, "to": 0.01, "count": 64}, "seed": list(range(worlds // 64))}
    scenario = moment(duration=0.1, sweep=sweep)
    assert len(files.worlds(scenario)) == worlds
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-c", CODE, json.dumps(files.given(scenario)), str(out)]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(ended.stdout)


@pytest.mark.skipif(os.name == "nt", reason="Windows does not tell the largest memory of a process so")
def test_the_peak_of_memory_does_not_grow_with_the_number_of_worlds(tmp_path, record_property):
    few, many = peak(1024, tmp_path), peak(8192, tmp_path)
    record_property("MiB", (few, many))
    # only the rows of metrics stay; the signals that are kept of 7168 worlds would be 80 MiB
    assert many - few < 45.0
    assert many < 700.0


def test_worlds_are_made_when_they_are_asked_for_and_not_before(monkeypatch):
    scenario = moment(
        sweep={"start.x_offset": {"from": 0.0, "to": 0.01, "count": 100}, "seed": list(range(500))}
    )
    made = []
    original = files.Scenario.model_validate

    def counted(*arguments, **options):
        made.append(1)
        return original(*arguments, **options)

    monkeypatch.setattr(files.Scenario, "model_validate", counted)
    grid = files.worlds(scenario)
    assert len(grid) == 50_000
    assert grid.varied(49_999) == {"start.x_offset": 0.01, "seed": 499}
    assert made == []
    assert grid[-1].seed == 499
    assert len(grid[10:14]) == 4
    assert len(made) == 5
    with pytest.raises(IndexError, match="no world 50000: there are 50000"):
        grid[50_000]
