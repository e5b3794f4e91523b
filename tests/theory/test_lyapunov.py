"""The solver of the Lyapunov equation: the same bits as SciPy's, without importing all of `scipy.linalg`."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.machinery import PathFinder
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import linalg

from slipctl.theory import lyapunov
from slipctl.theory.lyapunov import solve_lyapunov
from slipctl.theory.robust import chain_gains

ROOT = Path(__file__).resolve().parents[2]

numbers = st.floats(-10.0, 10.0)


def chain(gains):
    """Return a chain of integrators under feedback."""
    matrix = np.eye(len(gains), k=1)
    matrix[-1] = -np.asarray(gains)
    return matrix


@given(st.floats(-20.0, -0.05), st.sampled_from([2, 3]))
def test_a_chain_is_solved_to_the_bits_of_scipy(pole, order):
    matrix = chain(chain_gains(np.array([pole]), order)[0])
    for a in (matrix, matrix.T):
        expected = linalg.solve_continuous_lyapunov(a, -np.eye(order))
        assert np.array_equal(solve_lyapunov(a, -np.eye(order)), expected)


@given(st.lists(numbers, min_size=9, max_size=9), st.lists(numbers, min_size=9, max_size=9))
def test_any_stable_system_is_solved_to_the_bits_of_scipy(entries, sides):
    a, q = np.reshape(entries, (3, 3)) - 31.0 * np.eye(3), np.reshape(sides, (3, 3))
    solution = solve_lyapunov(a, q)
    assert np.array_equal(solution, linalg.solve_continuous_lyapunov(a, q))
    assert np.allclose(a @ solution + solution @ a.T, q, atol=1e-12)


def test_the_closed_form_of_a_chain_of_two():
    k1, k2 = 0.25, 1.0
    found = solve_lyapunov(chain([k1, k2]).T, -np.eye(2))
    corner = 1.0 / (2.0 * k1)
    exact = [[k2 / (2 * k1) + (1 + k1) / (2 * k2), corner], [corner, (1 + k1) / (2 * k1 * k2)]]
    assert np.allclose(found, exact, rtol=1e-15, atol=0.0)


def test_eigenvalues_that_add_up_to_zero_are_refused():
    with pytest.raises(np.linalg.LinAlgError, match="add up to zero"):
        solve_lyapunov(np.array([[0.0, 1.0], [-1.0, 0.0]]), np.eye(2))


@pytest.mark.parametrize("broken", ["missing", "other"])
def test_where_scipy_is_built_otherwise_its_package_is_used(broken, monkeypatch, tmp_path):
    a = chain([0.25, 1.0])
    expected = solve_lyapunov(a, np.eye(2))
    spec = None
    if broken == "other":
        (tmp_path / "_flapack.py").write_text("raise ImportError('planted')", encoding="utf-8")
        spec = PathFinder.find_spec("_flapack", [str(tmp_path)])
    fresh = lyapunov._lapack.__wrapped__
    with monkeypatch.context() as patch:
        patch.setattr(lyapunov.PathFinder, "find_spec", lambda *_: spec)
        assert fresh() is linalg.lapack
        patch.setattr(lyapunov, "_lapack", fresh)
        assert np.array_equal(solve_lyapunov(a, np.eye(2)), expected)


def test_a_law_is_made_without_importing_scipy_linalg():
    code = (
        "import sys, numpy; from slipctl.theory.robust import lyapunov_matrix\n"
        "lyapunov_matrix(numpy.array([0.25, 1.0])); print('scipy.linalg' in sys.modules)"
    )
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    ended = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout == "False\n"
