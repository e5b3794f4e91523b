"""The same chunks on a cluster: two Dask workers on this machine."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from slipctl.experiment import executors, resume, run
from slipctl.experiment.chunk import simulate_chunk
from slipctl.experiment.errors import ClusterError, WorkerError
from slipctl.experiment.executors import dask_cluster
from slipctl.experiment.executors.dask_cluster import DaskCluster
from tests import deadly
from tests.sweeps import ON_MUJOCO, moment, parquet_bytes, swept

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Start a scheduler and two workers with a nanny each, which restarts them; return the address."""
    dask, distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    os.environ[deadly.MARK] = str(tmp_path_factory.mktemp("mark") / "mark")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    settings = {
        # given up after the second death of a worker, not the fourth: each takes seconds to be replaced
        "distributed.scheduler.allowed-failures": 1,
        # a cluster of this kind takes a worker for gone for good that has died again when it looks
        "distributed.deploy.lost-worker-timeout": "10 minutes",
    }
    with dask.config.set(settings), distributed.LocalCluster(**options) as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def on(cluster, monkeypatch):
    """Let the cluster do with chunks what the returned function is told."""

    def choose(simulate=None):
        executor = DaskCluster(cluster) if simulate is None else DaskCluster(cluster, simulate=simulate)
        monkeypatch.setattr("slipctl.experiment.runner.choose", lambda *_: executor)
        monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 3)

    return choose


@pytest.mark.parametrize("tables", [{}, ON_MUJOCO], ids=["ode", "mujoco"])
def test_a_cluster_gives_the_same_bytes(tables, tmp_path, on):
    scenario = moment(**tables)
    alone = parquet_bytes(swept(tmp_path, scenario))
    on()
    assert parquet_bytes(swept(tmp_path, scenario)) == alone


def test_a_worker_killed_in_the_middle_of_a_chunk_costs_nothing(tmp_path, on):
    alone = parquet_bytes(swept(tmp_path))
    on(deadly.die_once)
    assert parquet_bytes(swept(tmp_path)) == alone
    assert Path(os.environ[deadly.MARK]).exists()


def test_a_chunk_that_always_ends_its_worker_is_reported_and_the_rest_goes_on(tmp_path, on):
    whole = pq.read_table(swept(tmp_path) / "metrics.parquet").to_pylist()
    on(deadly.die_always)
    result = run(moment(), out=tmp_path, record="none")
    dead = range(deadly.DEADLY * 3, deadly.DEADLY * 3 + 3)
    assert [entry["world"] for entry in result.failures] == [world for world in dead for _ in range(2)]
    assert all("ended every Dask worker" in entry["failure"] for entry in result.failures)
    for before, now in zip(whole, result.metrics.to_pylist(), strict=True):
        assert now["status"] == "failed" if now["world"] in dead else now == before


def test_a_world_that_ends_its_worker_takes_no_other_with_it(tmp_path, on):
    whole = pq.read_table(swept(tmp_path) / "metrics.parquet").to_pylist()
    on(deadly.die_of_one_world)
    result = run(moment(), out=tmp_path, record="none")
    assert [entry["world"] for entry in result.failures] == [deadly.DEADLY_WORLD] * 2
    for before, now in zip(whole, result.metrics.to_pylist(), strict=True):
        assert now["status"] == "failed" if now["world"] == deadly.DEADLY_WORLD else now == before


def test_a_chunk_that_raises_ends_the_experiment_with_what_it_raised(on):
    on(raising)
    with pytest.raises(ValueError, match="planted in chunk"):
        run(moment())


def raising(setup, chunk, threads):
    raise ValueError(f"planted in chunk {chunk.index}")


def test_other_versions_on_a_worker_are_refused(cluster, monkeypatch, tmp_path):
    other = {"slipctl": "0.0.1", "mujoco": "3.0.0"}
    monkeypatch.setattr(dask_cluster, "exact_versions", lambda: other)
    with pytest.raises(ClusterError, match="the workers must have the versions of this machine") as said:
        run(moment(), out=tmp_path, dask=cluster)
    lines = str(said.value).splitlines()
    assert len(lines) > 1  # a worker that died in another test may be on its way back
    assert all("slipctl is " in line and "mujoco is " in line for line in lines[1:])
    assert all(line.endswith("needed is 3.0.0") for line in lines[1:])
    assert list(tmp_path.iterdir()) == []


def test_a_cluster_that_is_not_there_is_a_message_and_exit_2(monkeypatch, capsys, tmp_path):
    pytest.importorskip("distributed")
    from slipctl.cli import main

    monkeypatch.setattr(dask_cluster, "CONNECT_TIMEOUT", 0.5)
    arguments = ["sweep", "paper-kinematic", "--dask", "tcp://127.0.0.1:9", "--out", str(tmp_path)]
    assert main([*arguments, "--quiet"]) == 2
    assert capsys.readouterr().err.startswith("no Dask scheduler answers at tcp://127.0.0.1:9")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("address", ["nonsense", "carrier-pigeon://host:8786", "tcp://host.invalid:8786"])
def test_what_is_no_address_is_said_at_once(address, capsys, tmp_path):
    pytest.importorskip("distributed")
    from slipctl.cli import main

    assert main(["sweep", "paper-kinematic", "--dask", address, "--out", str(tmp_path / "runs")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"dask: found {address!r}, allowed is a scheduler's address such as tcp://")
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "runs").exists()


def test_a_cluster_is_asked_before_the_folder_is_made(cluster, monkeypatch, tmp_path):
    monkeypatch.setattr(dask_cluster, "exact_versions", lambda: {"slipctl": "0.0.1"})
    with pytest.raises(ClusterError, match=r"needed is 0\.0\.1"):
        run(moment(), out=tmp_path / "runs", dask=cluster)
    assert not (tmp_path / "runs").exists()


def last_one_dies(setup, chunk, threads):
    if chunk.index == 1:
        time.sleep(2.0)  # the chunk before it is fetched
        os._exit(9)
    return simulate_chunk(setup, chunk, threads)


def test_a_cluster_without_workers_is_said_and_given_up(tmp_path, monkeypatch, capsys):
    distributed = pytest.importorskip("distributed")
    whole = parquet_bytes(swept(tmp_path / "whole"))
    monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", 3)
    monkeypatch.setattr(dask_cluster, "LOOK", 0.2)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as alone:
        address = alone.scheduler_address
        arguments = ["-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1"]
        with subprocess.Popen([sys.executable, *arguments, "--no-dashboard"], env=environment) as worker:
            try:
                executor = DaskCluster(address, simulate=last_one_dies)
                executor.check()
                monkeypatch.setattr(dask_cluster, "WORKER_TIMEOUT", 1.0)
                monkeypatch.setattr("slipctl.experiment.runner.choose", lambda *_: executor)
                with pytest.raises(WorkerError, match="has had no worker for 1 s; start some") as said:
                    run(moment(), out=tmp_path, record="none")
            finally:
                worker.kill()
    left = tmp_path / "moment.unfinished"
    assert said.value.__notes__ == [f"what is finished is kept; go on: slipctl sweep --resume {left}"]
    assert f"no Dask worker is left at {address}: waiting 1 s for one\n" in capsys.readouterr().err
    monkeypatch.undo()
    finished = resume(left).folder
    assert finished is not None
    assert parquet_bytes(finished) == whole


def test_without_dask_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"pip install 'slipctl\[cluster\]'"):
        run(moment(), dask="tcp://host:8786")


def test_nothing_of_dask_is_imported_unless_asked_for():
    assert executors.choose(1, None, None)
    code = "import sys, slipctl.experiment; sys.exit('distributed' in sys.modules)"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    assert subprocess.run([sys.executable, "-c", code], env=environment, check=False).returncode == 0
