"""Run a scenario: worlds in chunks, each put on disk as it is done, then results and recordings from them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

from slipctl import scenario as files
from slipctl.experiment import assemble
from slipctl.experiment.chunk import Output, Setup
from slipctl.experiment.chunkfiles import ChunkFiles, resume_command
from slipctl.experiment.conclude import conclude, in_memory
from slipctl.experiment.errors import Interrupted, StillDeadly, StorageError
from slipctl.experiment.executors import Executor, Finished, check_processes, choose, sparing
from slipctl.experiment.finish import manifest
from slipctl.experiment.machine import exact_versions, machine
from slipctl.experiment.own import OwnLaws, check_labels
from slipctl.experiment.plan import Chunk, make_plan
from slipctl.experiment.record import check_choice
from slipctl.experiment.result import Result
from slipctl.experiment.resuming import taken_over
from slipctl.experiment.retry import put_in, set_aside
from slipctl.experiment.store import Store

CLUSTER = 4
"""Workers that are reckoned with where a cluster simulates: chunks are then small enough to be shared out."""

Progress = Callable[[int, int, str], None]
Begun = Callable[[Path, int], None]


def run(
    scenario: files.Scenario | str | Path,
    *,
    out: Path | str | None = None,
    record: str = "auto",
    signals: str = "auto",
    threads: int | None = None,
    workers: int = 1,
    dask: str | None = None,
    worlds: Sequence[int] | None = None,
    keep_going: bool = False,
    keep_failed_rows: bool = False,
    progress: Progress | None = None,
    begun: Begun | None = None,
    laws: OwnLaws | None = None,
) -> Result:
    """Run every world of a scenario under every listed controller.

    Parameters
    ----------
    scenario : Scenario, path, or name of a shipped scenario
    out : path, optional
        Folder in which a new run folder is made; nothing is written where it is None. Until it is finished
        it is called NAME.unfinished and holds every chunk of worlds that is done: see `resume`.
    record : str
        Which worlds get a Rerun recording: ``auto``, ``all``, ``failed`` (those that did not complete),
        ``none`` or ``worst:N``. Without `out`, none.
    signals : str
        Which rows of the signals are kept: ``all``, ``sampled`` (at most 51 of each run), ``none``, or
        ``auto``, which is ``all`` unless that were very many on a disk.
    threads : int, optional
        Threads for MuJoCo; by default chosen from the size of a batch. Results do not depend on it.
    workers : int
        Processes of this machine that simulate; 1 is this process alone. Results do not depend on it. A
        script that asks for more must be importable: guard its body by ``if __name__ == "__main__":``.
    dask : str, optional
        Address of a Dask scheduler whose workers simulate instead (extra ``cluster``).
    worlds : sequence of int, optional
        Indices, in grid order, of the worlds to run; all of them where it is None.
    keep_going : bool
        Whether a run whose simulation raises gets the status ``failed`` and the rest goes on.
    keep_failed_rows : bool
        Whether a run whose simulation raises after its first row keeps the rows before, to be looked at: it
        gets the status ``failed``, the rest goes on, and its traceback is shown on standard error.
    progress : callable, optional
        Called with steps done, steps in all and a text.
    begun : callable, optional
        Called once with the unfinished folder and the number of chunks.
    laws : mapping, optional
        Laws of one's own by label: they run beside the listed controllers, in the same worlds. Each is a
        `slipctl.simulate.Controller`, or what makes one from a `slipctl.experiment.own.KnownRobot`.

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        Where `workers`, `threads` or `dask` cannot be.
    slipctl.scenario.ScenarioError
        Where the scenario is wrong.
    slipctl.experiment.folder.OutputError
        Where `out` cannot be written.
    slipctl.experiment.checked.OwnLawError
        Where an own law has a label that cannot be, raises, or gives what does not fit or is not finite.
    slipctl.experiment.errors.Interrupted
        On Ctrl-C (it is a KeyboardInterrupt), where chunks are kept in a folder.
    slipctl.experiment.errors.StorageError
        Where something cannot be put on disk; what is there is kept.
    slipctl.experiment.errors.WorkerError, ClusterError
        Where the processes that simulate cannot.
    """
    began = time.monotonic()
    if not isinstance(scenario, files.Scenario):
        scenario = files.load(scenario)
    laws = dict(laws or {})
    check_labels(laws, [controller.label for controller in scenario.controller])
    check_choice(record)
    check_processes(workers, dask, threads)
    plan = make_plan(
        scenario,
        laws,
        record=record,
        signals="all" if out is None and signals == "auto" else signals,
        worlds=worlds,
        keep_going=keep_going,
        workers=workers if dask is None else CLUSTER,
        keep_failed_rows=keep_failed_rows,
    )
    executor = choose(workers, dask, threads)
    # the model is read before the first tick, so that a wrong one is refused before any work
    setup = Setup(plan, assemble.read_robot(scenario), laws)
    told = manifest(setup)
    if out is None:
        return _here(setup, told, executor, progress)
    identity = {key: told[key] for key in ("scenario", "scenario_id", "model_id")}
    kept = {
        **identity,
        "versions": exact_versions(),
        "machine": machine(),
        "own_laws": list(laws),
        **plan.json(),
    }
    store = Store.create(Path(out), scenario.name, kept)
    if begun is not None:
        begun(store.folder, -(-len(plan.worlds) // plan.chunk_worlds))
    return _on_disk(setup, told, executor, store, progress, began, new=True)


def resume(
    folder: Path | str,
    *,
    threads: int | None = None,
    workers: int = 1,
    dask: str | None = None,
    progress: Progress | None = None,
) -> Result:
    """Go on with an unfinished experiment, and finish it as if it had never stopped.

    Worlds that were set aside, as they had ended the processes that simulated them, are tried once more: in
    a process beside this one, also where `workers` is 1, so that a script guards its body as for `run`. What
    a run raised itself stands.

    Parameters
    ----------
    folder : path
        What `run` left: ``NAME.unfinished``. The run folder is made beside it. Or a run folder in which
        worlds were set aside: it stays as it is, and one that has them is made beside it.
    threads, workers, dask, progress
        As for `run`; they may differ from those before.

    Returns
    -------
    Result
        With the same bytes in ``metrics.parquet`` and ``signals.parquet`` as without the interruption.

    Raises
    ------
    slipctl.experiment.errors.ResumeError
        Where it is no such folder, is in use, or was begun with other versions, files or models.
    slipctl.experiment.errors.StillDeadly
        Where all worlds of a run folder that were tried once more ended their processes again.
    Exception
        As `run` does.
    """
    began = time.monotonic()
    setup, store, source = taken_over(Path(folder))
    try:
        executor = choose(workers, dask, threads)
        told = manifest(setup, resumed=True)
    except BaseException:
        store.close() if source is None else store.discard()
        raise
    return _on_disk(setup, told, executor, store, progress, began, source=source, new=False)


def _on_disk(
    setup: Setup,
    told: dict,
    executor: Executor,
    store: Store,
    progress: Progress | None,
    began: float,
    *,
    new: bool,
    source: Path | None = None,
) -> Result:
    plan = setup.plan
    try:
        todo, kept = [], []
        for chunk in plan.chunks():
            (kept if store.whole(chunk) else todo).append(chunk)
        again = list(set_aside(kept, store))
        for ended in _simulate(setup, executor, store.chunk_files(), todo, progress):
            if ended.output is not None:
                store.keep(ended.output)
        if again and not _retry(setup, executor, store, again, progress) and source is not None:
            store.discard()
            raise StillDeadly(
                f"worlds that had ended their worker processes ended them again; {source} is as it was"
            )
        return conclude(setup, told, store, began)
    except StillDeadly:
        raise
    except BaseException as error:
        if store.published is not None:  # all is done but for removing what is no longer needed
            count = len(plan.worlds)
            if isinstance(error, KeyboardInterrupt):
                raise Interrupted(store.published, count, count, finished=True) from None
            error.add_note(f"what is finished is all of it: the run folder is {store.published}")
            raise
        listed = _listed(store)  # on the disk: a chunk may be there of which nobody was told yet
        # what somebody else began is never removed, and neither is what could not be looked into
        if new and listed == set() and not isinstance(error, StorageError):
            store.discard()
            raise
        store.close()
        if isinstance(error, KeyboardInterrupt):
            done = sum(len(chunk.worlds) for chunk in plan.chunks() if chunk.index in (listed or ()))
            raise Interrupted(store.folder, done, len(plan.worlds)) from None
        error.add_note(f"what is finished is kept; go on: {resume_command(store.folder)}")
        raise


def _retry(
    setup: Setup, executor: Executor, store: Store, again: Sequence[Chunk], progress: Progress | None
) -> bool:
    """Try worlds that were set aside once more; return whether one of them no longer ended its process."""
    cured = False
    for ended in _simulate(setup, sparing(executor), None, again, progress):
        assert ended.output is not None, "a piece of a chunk is put in its place here"
        cured |= put_in(setup.plan, store, ended.output)
    return cured


def _listed(store: Store) -> set[int] | None:
    """Return which chunks there are; None where the disk does not say."""
    try:
        return store.listed()
    except (OSError, ValueError):
        return None


def _here(setup: Setup, told: dict, executor: Executor, progress: Progress | None) -> Result:
    """Run without a folder: everything stays in memory."""
    outputs: dict[int, Output] = {}
    interrupted = False
    try:
        for ended in _simulate(setup, executor, None, list(setup.plan.chunks()), progress):
            assert ended.output is not None, "nothing is on the disk"
            outputs[ended.chunk.index] = ended.output
    except KeyboardInterrupt:
        interrupted = True
        if not outputs:
            raise
    return in_memory(setup, told, [outputs[index] for index in sorted(outputs)], interrupted)


def _simulate(
    setup: Setup,
    executor: Executor,
    where: ChunkFiles | None,
    todo: Sequence[Chunk],
    progress: Progress | None,
) -> Iterator[Finished]:
    """Yield what becomes of every chunk that is left to do, and tell how far all of it is."""
    plan, tell = setup.plan, progress or (lambda done, total, text: None)
    total = int(plan.ticks.sum()) * len(plan.entrants)
    done = total - sum(plan.steps(chunk) for chunk in todo)

    def within(chunk: Chunk, ticks: int) -> None:
        first, last = chunk.worlds[0] + 1, chunk.worlds[-1] + 1
        tell(done + ticks, total, f"world {first} to {last} of {len(plan.grid)}")

    with closing(executor.run(setup, todo, where, within)) as ended_ones:
        for ended in ended_ones:
            yield ended
            done += plan.steps(ended.chunk)
            within(ended.chunk, 0)
