"""SciPy's Lyapunov solver, to the last bit, without what else `scipy.linalg` imports.

`import scipy.linalg` also imports NumPy's test tools and Fortran parser: 0.2 s, a fifth of a short run, for
a matrix of two rows. The two LAPACK routines behind the solver are in one extension module of SciPy, which
can be had alone. Where SciPy is built otherwise the whole package is imported: the same routines, later.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipctl.tick import Array


def solve_lyapunov(a: Array, q: Array) -> Array:
    """Solve aX + Xaᵀ = q by the Schur form of a, as `scipy.linalg.solve_continuous_lyapunov` does.

    Parameters
    ----------
    a, q : (n, n) arrays
        Finite; no two eigenvalues of a add up to zero.

    Returns
    -------
    (n, n) array

    Raises
    ------
    numpy.linalg.LinAlgError
        Where there is no such solution.
    """
    lapack = _lapack()
    # how much room the routine wants depends on the size alone, but it decides how it works
    room = int(lapack.dgees(_any, a, lwork=-1)[-2][0])
    form, _, _, _, basis, _, info = lapack.dgees(_any, a, lwork=room)
    if info != 0:
        raise np.linalg.LinAlgError(f"no Schur form found (LAPACK's dgees: {info})")
    solution, scale, info = lapack.dtrsyl(form, form, basis.T.dot(q.dot(basis)), tranb="T")
    if info != 0:
        raise np.linalg.LinAlgError(f"two eigenvalues add up to zero (LAPACK's dtrsyl: {info})")
    return basis.dot(scale * solution).dot(basis.T)


def _any(real: float, imaginary: float) -> None:
    """Choose no eigenvalue: LAPACK wants to be told, though nothing is sorted."""


@cache
def _lapack() -> Any:
    folder = Path(scipy.__file__).parent / "linalg"
    spec = PathFinder.find_spec("_flapack", [str(folder)])
    if spec is not None and spec.loader is not None:
        with suppress(ImportError):
            module = module_from_spec(spec)
            spec.loader.exec_module(module)
            return module
    from scipy.linalg import lapack

    return lapack
