"""The floor: the same wheel commands again, by the engine alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl.experiment import assemble
from slipctl.simulate import Row, simulate
from slipctl.tick import Array, Start

if TYPE_CHECKING:
    from slipctl.scenario import World


class ReplayError(Exception):
    """The replay does not end where the closed loop did, so comparing their cost would mean nothing."""


@dataclass(frozen=True)
class Replay:
    """The wheel commands of a closed loop on MuJoCo, ready to be run open-loop.

    Attributes
    ----------
    plant : MujocoPlant
        Its batch is what runs.
    start : Start
    commands : list of (N, steps, 2) arrays
        Wheel rates of every physics step, one array per law [rad/s].
    ends : list of (N, nstate) arrays
        The engine's states at the end of the closed loop, one array per law.
    """

    plant: Any
    start: Start
    commands: list[Array]
    ends: list[Array]

    @classmethod
    def of(cls, worlds: Sequence[World], threads: int = 1, tell: Callable[[], None] = lambda: None) -> Replay:
        """Run the closed loop of every listed controller once and keep what the wheels were told.

        Parameters
        ----------
        worlds : sequence of World
            On MuJoCo, with wheel speed servos, and alike: they share a batch.
        threads : int
        tell : callable
            Called after every law.
        """
        first = worlds[0].scenario
        robot = assemble.read_robot(first)
        planned = assemble.references(worlds)
        start = assemble.start(worlds, planned)
        plant: Any = assemble.plant(worlds, robot, threads)
        ticks = len(planned.position) - 1
        steps = round(first.tick / float(plant.batch.model.opt.timestep))
        commands, ends = [], []
        for index in range(len(first.controller)):
            told = np.zeros((len(worlds), ticks, 2))

            def write(k: int, row: Row, told: Array = told) -> None:
                if k < ticks:
                    told[:, k] = row.decision.command.wheel_rate

            simulate(plant, assemble.law(worlds, index, robot).controller, planned, start, first.tick, write)
            commands.append(np.repeat(told, steps, axis=1))
            ends.append(plant.batch.state.copy())
            tell()
        return cls(plant, start, commands, ends)

    @property
    def steps(self) -> int:
        """Physics steps of all worlds and laws together."""
        return sum(len(command) * command.shape[1] for command in self.commands)

    def run(self) -> None:
        """Run all commands open-loop, recording nothing.

        Raises
        ------
        ReplayError
            If any state at the end differs in a single bit from the closed loop's.
        """
        batch = self.plant.batch
        begin = self.plant.start(self.start).rows
        for command, end in zip(self.commands, self.ends, strict=True):
            batch.state[...] = begin
            batch.rollout(command.shape[1], command, record=())
            if not np.array_equal(batch.state, end):
                raise ReplayError("the replay does not end where the closed loop did")
