"""The paper's models and matrices as symbols, once more and independent of the package.

Names with an equation's number are what is *printed* there; `rate` differentiates along a model. Equality of
expressions is decided by value at random points: `simplify` is slow, and a wrong sign never survives 50.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

Expression = Any  # sympy's stubs know little of matrices

x, y, h, v, w, mu1 = sympy.symbols("x y h v w mu1")  # h is θ
u1bar, u2bar, mu1bar, mu2bar = sympy.symbols("u1bar u2bar mu1bar mu2bar")
vt, dvt, ddvt = sympy.symbols("vt dvt ddvt")
vs, dvs, ddvs = sympy.symbols("vs dvs ddvs")
ws, dws, ddws = sympy.symbols("ws dws ddws")
m, iz, r, b, tau_r, tau_l = sympy.symbols("m iz r b tau_r tau_l", positive=True)
v1, v2 = sympy.symbols("v1 v2")  # components of the transformed input v

SYMBOLS = (
    *(x, y, h, v, w, mu1, u1bar, u2bar, mu1bar, mu2bar),
    *(vt, dvt, ddvt, vs, dvs, ddvs, ws, dws, ddws, v1, v2),
    *(m, iz, r, b, tau_r, tau_l),
)
SLIPPING = {vt: dvt, dvt: ddvt, vs: dvs, dvs: ddvs, ws: dws, dws: ddws}
NO_SLIP = dict.fromkeys((vt, dvt, ddvt, vs, dvs, ddvs, ws, dws, ddws), 0)

c, s = sympy.cos(h), sympy.sin(h)
FLAT: Expression = sympy.Matrix([x, y])
INPUT: Expression = sympy.Matrix([v1, v2])
FORWARD: Expression = sympy.Matrix([c, s])
LEFT: Expression = sympy.Matrix([-s, c])

KINEMATIC_NO_SLIP = {x: v * c, y: v * s, v: u1bar, h: u2bar}  # (7)
DYNAMIC_NO_SLIP = {x: v * c, y: v * s, h: w, v: mu1, mu1: mu1bar, w: mu2bar}  # (22)
KINEMATIC = {  # (29)
    x: (v + vt) * c + vs * s,
    y: (v + vt) * s - vs * c,
    v: u1bar,
    h: u2bar + ws,
} | SLIPPING
DYNAMIC = {  # (31)
    x: v * c + vt * c + vs * s,
    y: v * s + vt * s - vs * c,
    h: w + ws,
    v: mu1 - dvt - vs * (w + ws),
    mu1: mu1bar,
    w: mu2bar - dws,
} | SLIPPING

B_12: Expression = sympy.Matrix([[c, -v * s], [s, v * c]])
B_13_INVERSE: Expression = sympy.Matrix([[v * c, v * s], [-s, c]]) / v
A_25: Expression = sympy.Matrix([-v * w**2 * c - 2 * w * mu1 * s, -v * w**2 * s + 2 * w * mu1 * c])
C_33: Expression = sympy.Matrix(
    [
        (vs * ws + dvt) * c - (v * ws + vt * ws - dvs) * s,
        (vs * ws + dvt) * s + (v * ws + vt * ws - dvs) * c,
    ]
)
D_34: Expression = sympy.Matrix([[0, -vt * s + vs * c], [0, vt * c + vs * s]])
_ACROSS = vs * w**2 + v * dws + vt * dws + ddvs
C_BELOW_61: Expression = sympy.Matrix(
    [(dvs * w - vt * w**2) * c + _ACROSS * s, (dvs * w - vt * w**2) * s - _ACROSS * c]
)
D_BELOW_61: Expression = sympy.Matrix([[0, -vt * s], [0, vt * c]])
C_CORRECTED: Expression = (dvs * (w + ws) - vt * (w + ws) ** 2 - v * (2 * w * ws + ws**2)) * FORWARD - (
    ddvs + vs * (w + ws) ** 2 - 2 * mu1 * ws
) * LEFT


def rate(expression: Expression, model: dict[Expression, Expression]) -> Expression:
    """Return the derivative in time along a model: the chain rule over its states."""
    unknown = {u1bar, u2bar, mu1bar, mu2bar, ddvt, ddvs, ddws}
    assert not expression.free_symbols & unknown, "no model says how fast these change"
    return expression.applyfunc(lambda e: sum(sympy.diff(e, state) * to for state, to in model.items()))


def difference(left: Expression, right: Expression, seed: int = 0) -> float:
    """Return the largest difference of two expressions over 50 random points, relative to their size."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.3, 1.7, (len(SYMBOLS), 50)) * rng.choice([-1.0, 1.0], (len(SYMBOLS), 50))
    for index, symbol in enumerate(SYMBOLS):
        if symbol.is_positive:
            points[index] = np.abs(points[index])
    left, right = (sympy.Matrix(side) for side in (left, right))
    assert left.shape == right.shape
    value = sympy.lambdify(SYMBOLS, [list(left), list(right)], modules="numpy", cse=True)
    # entries without symbols come back as plain numbers
    sides = [np.array([np.broadcast_to(e, (50,)) for e in side]) for side in value(*points)]
    return float(np.abs(sides[0] - sides[1]).max() / (1.0 + np.abs(sides[0]).max()))


def same(left: Expression, right: Expression) -> bool:
    return difference(left, right) < 1e-12


def different(left: Expression, right: Expression) -> bool:
    """Tell whether two expressions differ visibly, not by rounding."""
    return difference(left, right) > 1e-3
