"""Reading a recording back, as a user's own script would."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rerun.chunk import RrdReader

from slipctl.view.viewer import viewer_program


class Recording:
    """The chunks of one recording."""

    def __init__(self, path: Path) -> None:
        self.reader = RrdReader(path)
        self.chunks = self.reader.stream().to_chunks()

    @property
    def entities(self) -> set[str]:
        return {chunk.entity_path for chunk in self.chunks}

    def rows(self, entity: str, component: str) -> tuple[NDArray[np.int64], list[Any]]:
        """Times [ns] and values of a component that changes."""
        (chunk,) = [chunk for chunk in self.chunks if chunk.entity_path == entity and not chunk.is_static]
        batch = chunk.to_record_batch()
        times = batch.column("sim_time").cast("int64").to_numpy()
        return times, [value[0] for value in batch.column(component).to_pylist()]

    def static(self, entity: str, component: str) -> Any:
        """The first value of a component that does not change."""
        found = [
            chunk.to_record_batch()
            for chunk in self.chunks
            if chunk.entity_path == entity and chunk.is_static
        ]
        (batch,) = [batch for batch in found if component in batch.schema.names]
        return batch.column(component).to_pylist()[0][0]

    def timelines(self) -> set[str]:
        return {name for chunk in self.chunks for name in chunk.timeline_names}


def rrd(*arguments: str | Path) -> int:
    """Exit status of ``rerun rrd …``."""
    command = [str(viewer_program()), "rrd", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, check=False, timeout=60).returncode
