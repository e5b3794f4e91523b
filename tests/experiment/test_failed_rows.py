"""A run that raises, alone: its rows before are there to look at, and what it raised is said."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from slipctl.cli import main
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.experiment import Interrupted, run
from slipctl.experiment.checked import OwnLawError
from slipctl.experiment.own import KnownRobot
from slipctl.metrics import UNITS
from slipctl.plants.ode import KinematicOde
from slipctl.theory.robust import chain_gains
from slipctl.tick import Decision
from tests.fakes import SHORT_SCENARIO
from tests.sweeps import ON_MUJOCO, moment
from tests.view.reading import Recording

TICK = 20
"""The tick at which something raises."""


def raise_at_call(monkeypatch: pytest.MonkeyPatch, owner: type, name: str, number: int) -> None:
    """Let one call of a method, counted from 0, divide by zero where that is an error."""
    original: Callable[..., Any] = getattr(owner, name)
    calls: list[int] = []

    def raising(*arguments):
        calls.append(1)
        if len(calls) == number + 1:
            with np.errstate(divide="raise"):
                np.divide(1.0, 0.0)
        return original(*arguments)

    monkeypatch.setattr(owner, name, raising)


def last_times(recording: Path) -> dict[str, float]:
    """Return the last time of every controller in a recording [s]."""
    read = Recording(recording)
    ends: dict[str, float] = {}
    for label in ("nominal_kinematic", "robust_kinematic"):
        times, _ = read.rows(f"/runs/{label}/error/position", "Scalars:scalars")
        ends[label] = times[-1] * 1e-9
    return ends


def same_but_for_the_guarantee(kept: pa.Table, before: pa.Table) -> bool:
    """Whether rows are the same, but for what is judged with the row that comes next."""
    names = [name for name in kept.column_names if not name.startswith("guarantee.")]
    assert len(names) > 20
    return kept.select(names).equals(before.select(names))


@pytest.mark.parametrize("tables", [{}, ON_MUJOCO], ids=["ode", "mujoco"])
@pytest.mark.parametrize("signals", ["all", "sampled", "none"])
def test_a_law_that_raises_leaves_the_rows_before_its_tick(signals, tables, tmp_path, capsys, monkeypatch):
    scenario = moment(**tables)
    whole = run(scenario)
    with monkeypatch.context() as patch:
        raise_at_call(patch, NominalKinematic, "update", TICK)
        if signals != "all":  # what is to be recorded is simulated again, and raises again
            patch.setattr("slipctl.experiment.conclude._replay", replay_that_raises(patch))
        result = run(scenario, out=tmp_path, worlds=[3], signals=signals, keep_failed_rows=True)
    assert result.folder is not None
    failed, other = result.metrics.to_pylist()
    assert (failed["status"], other["status"]) == ("failed", "completed")
    assert failed["end_time"] == (TICK - 1) * scenario.tick
    assert {failed[name] for name in (*UNITS, "first_violation")} == {None}
    assert other | {"recording": None} == whole.metrics.to_pylist()[7]
    (entry,) = result.failures
    assert entry["failure"].startswith("FloatingPointError: divide by zero encountered in divide (test_fail")
    assert (entry["world"], entry["controller"]) == (3, "nominal_kinematic")
    told = json.loads((result.folder / "manifest.json").read_text(encoding="utf-8"))
    assert told["failures"] == [entry]
    said = capsys.readouterr().err
    assert said.startswith("Traceback")
    assert said.count("Traceback") == 1
    assert "FloatingPointError: divide by zero" in said
    if signals == "all":
        assert same_but_for_the_guarantee(result.run_signals(6), whole.run_signals(6).slice(0, TICK))
        assert result.run_signals(7).equals(whole.run_signals(7))
    ends = last_times(result.folder / failed["recording"])
    assert ends == pytest.approx(
        {"nominal_kinematic": failed["end_time"], "robust_kinematic": scenario.duration}
    )


def replay_that_raises(patch: pytest.MonkeyPatch) -> Callable[..., None]:
    from slipctl.experiment import conclude

    original = conclude._replay

    def replay(*arguments):
        raise_at_call(patch, NominalKinematic, "update", TICK)
        original(*arguments)

    return replay


def test_a_plant_that_raises_leaves_the_row_of_its_tick(tmp_path, monkeypatch):
    scenario = moment()
    whole = run(scenario)
    raise_at_call(monkeypatch, KinematicOde, "step", TICK)
    result = run(scenario, out=tmp_path, worlds=[3], keep_failed_rows=True)
    ends = [row["end_time"] for row in result.metrics.to_pylist()]
    assert ends == [TICK * scenario.tick, whole.metrics["end_time"][7].as_py()]
    assert same_but_for_the_guarantee(result.run_signals(6), whole.run_signals(6).slice(0, TICK + 1))


@dataclass(frozen=True)
class Stumbling:
    """Raises in the one world that starts a millimetre off, whatever worlds are beside it."""

    law: NominalKinematic

    def start(self, start):
        return 0, np.isclose(start.position[:, 1], 0.001), self.law.start(start)

    def update(self, memory, reference, motion, tick):
        k, there, inner = memory
        if k == TICK and there.any():
            raise ValueError("planted")
        decision = self.law.update(inner, reference, motion, tick)
        return Decision(decision.command, (k + 1, there, decision.memory), decision.trace)


def sound(known: KnownRobot) -> NominalKinematic:
    return NominalKinematic(known.speed_drive(), chain_gains(np.full(known.worlds, -2.0), 2))


def test_one_of_many_that_raises_is_found_and_keeps_its_rows(tmp_path, capsys):
    scenario = moment(sweep={"start.y_offset": [0.0, 0.001, 0.002, 0.003, 0.004]})
    stumbling = {"mine": lambda known: Stumbling(sound(known))}
    whole = run(scenario, out=tmp_path, record="none", laws={"mine": sound})
    result = run(scenario, out=tmp_path, record="none", laws=stumbling, keep_failed_rows=True)
    for before, now in zip(whole.metrics.to_pylist(), result.metrics.to_pylist(), strict=True):
        if (now["world"], now["controller"]) == (1, "mine"):
            assert (now["status"], now["end_time"]) == ("failed", (TICK - 1) * scenario.tick)
            assert result.run_signals(now["run"]).num_rows == TICK
        else:
            assert now == before
            assert result.run_signals(now["run"]).equals(whole.run_signals(now["run"]))
    (entry,) = result.failures
    assert f"law 'mine' at tick {TICK} (0.2 s) failed: ValueError: planted" in entry["failure"]
    assert "ValueError: planted" in capsys.readouterr().err
    with pytest.raises(OwnLawError, match="planted"):
        run(scenario, laws=stumbling)


def test_what_raises_before_its_first_row_leaves_nothing(tmp_path, monkeypatch):
    raise_at_call(monkeypatch, NominalKinematic, "update", 0)
    with pytest.raises(FloatingPointError):
        run(moment(), out=tmp_path, worlds=[3], keep_failed_rows=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("lacking", [MemoryError("planted"), OSError(24, "Too many open files")])
def test_what_the_machine_lacks_in_the_middle_is_not_said_of_the_world(lacking, tmp_path, monkeypatch):
    from slipctl.experiment.errors import WorkerError

    def short_of(*arguments):
        raise lacking

    monkeypatch.setattr(KinematicOde, "step", short_of)
    with pytest.raises(WorkerError, match="could not be simulated on this machine"):
        run(moment(), out=tmp_path, worlds=[3], keep_failed_rows=True)
    assert list(tmp_path.iterdir()) == []


def test_gone_on_with_it_ends_with_3_as_well(tmp_path, capsys, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    for only in (True, False):
        scenario = moment() if only else moment(sweep=None)
        out = tmp_path / str(only)
        chosen = [3] if only else None
        with monkeypatch.context() as patch:
            patch.setattr("slipctl.experiment.runner.conclude", stop)
            raise_at_call(patch, NominalKinematic, "update", TICK)
            with pytest.raises(Interrupted) as stopped:
                run(scenario, out=out, worlds=chosen, record="none", keep_failed_rows=True)
        capsys.readouterr()
        assert main(["sweep", "--resume", str(stopped.value.folder), "--json"]) == 3
        said = capsys.readouterr()
        assert said.out == ""
        assert f"the rows before are in {out / 'moment'}: no recordings" in said.err
        assert "run it alone" not in said.err


@pytest.mark.parametrize("sweep", [False, True])
def test_the_command_ends_with_3_and_says_where_the_rows_are(sweep, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("short.toml").write_text(SHORT_SCENARIO, encoding="utf-8")
    command, name = ["run", "short.toml", "--json"], "short"
    if sweep:
        assert main(["sweep", "short.toml", "--over", "seed=1,2,3", "--record", "none", "--json"]) == 0
        command, name = ["run", "runs/short", "--world", "1", "--json"], "short-2"
    capsys.readouterr()
    raise_at_call(monkeypatch, NominalKinematic, "update", TICK)
    assert main(command) == 3
    said = capsys.readouterr()
    assert said.out == ""
    lines = said.err.splitlines()
    assert lines[0].startswith("Traceback")
    assert lines[-4] == "1 of 1 runs ended early: 1 failed"
    assert lines[-3].startswith(f"world {int(sweep)} (nominal_kinematic) failed: FloatingPointError: divide")
    assert lines[-2] == f"the rows before are in {Path('runs', name)}: 1 recording: one per world"
    assert lines[-1] == "this is a defect of slipctl, not of your input"
    assert len(list(Path("runs", name).glob("*.rrd"))) == 1
