"""A testbed for one question: what does my tracking controller do when the wheels slip.

>>> import slipctl
>>> result = slipctl.run("friction-sweep")
>>> result.metrics.to_pandas()  # doctest: +SKIP
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from slipctl.experiment import Result, run

__all__ = ["Result", "run"]


def __getattr__(name: str) -> Any:
    # the engine, Arrow and the file format take a second to import: only for those who run something
    if name in __all__:
        from slipctl import experiment

        return getattr(experiment, name)
    raise AttributeError(f"module 'slipctl' has no attribute {name!r}")
