"""docs/errata.md names tests that exist, leaves none out, and quotes what the scan really says."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "errata.md"
SCAN = ROOT.parent / "shared" / "paper.txt"
NAMED = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE.read_text(encoding="utf-8"))


def names_of_tests(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {
        node.name for node in tree.body if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


@pytest.mark.parametrize(("path", "name"), NAMED, ids=lambda part: part.rsplit("/", 1)[-1])
def test_each_named_test_exists(path, name):
    assert name in names_of_tests(ROOT / path)


def test_each_erratum_is_held_by_a_test_and_each_test_of_an_erratum_is_named():
    text = PAGE.read_text(encoding="utf-8")
    held = text[: text.index("## References to the wrong place")]
    rows = [line for line in held.splitlines() if line.startswith("| ") and not line.startswith("| where")]
    assert len(rows) == 16
    for row in rows:
        assert re.search(r"`tests/theory/\w+\.py::test_\w+`", row), row
        assert re.search(r"\| (no|maybe) \|", row), row
    for module in ("test_errata.py", "test_errata_of_the_control.py"):
        named = {name for path, name in NAMED if path.endswith(f"/{module}")}
        assert names_of_tests(Path(__file__).parent / module) == named


# what the scan says where the page says "printed"; whitespace does not count
PRINTED = {
    "(9)": r"\theta = \tan^{-1} \left(\frac{\dot{F}_2}{\dot{F}_1}\right)",
    "(23)": r"\bar{\mu}_1 = \dot{\mu}_1, \ \bar{u}_2 = \mu_2",
    "(24)": r"\begin{pmatrix} \ddot{F}_1 \\ \ddot{F}_2 \end{pmatrix} = \mathbf{A} + \mathbf{B}",
    "(62)": r"\ddot{\mathbf{F}} = \mathbf{v} + \boldsymbol{\eta},\tag{62}",
    "(65)": r"\mathbf{J}(\mathbf{v} + \boldsymbol{\eta} - \ddot{\mathbf{F}}_{\mathbf{d}}), \tag{65}",
    "(68)": r"- \mathbf{K}_{3}\mathbf{e}_{3} \equiv \ddot{\mathbf{F}}_{\mathbf{d}}",
    "(27)": r"= \mathbf{B}^{-1} \mathbf{v} - \mathbf{A},\tag{27}",
    "C below (61), along t": r"(\dot{v}_s w - v_t w^2) \cos \theta",
    "C below (61), along n": r"(v_s w^2 + v \dot{w}_s + v_t \dot{w}_s + \ddot{v}_s) \sin \theta",
    "(45)": r"||v_t|| + ||v_s|| < 2\alpha ||v||",
    "Theorem 4.3": "is globally asymptotically stable using the control structure",
    "V-A, slip rates": r"$\|\dot{v}_t\| \leq \alpha \|\hat{v}_1\|$",
    "V-A, ε": "ϵ in Eq. (47) was chosen to be 0.02",
    "Fig. 7": r"corrective control term $\Delta \mathbf{v}$ in Eq. (47)",
    "(70)": r"||v_t|| \le \alpha ||v||$$, where $0 \le \alpha < 1$ (70)",
    "(99)": r"\underbrace{\sqrt{\frac{\epsilon}{2\lambda_{\min}(\mathbf{Q})}}}_{\equiv R} \rho",
    "V-A, gains": "one cannot guarantee the uniformly ultimate boundedness property",
    "V-B": r"the Lyapunov equation in Eq. (48) can be solved with \mathbf{Q} being a (6 × 6)",
    "Fig. 16": r"Fig. 16. The nominal control term $\hat{\mathbf{v}}$ given in Eq. (68)",
    "Fig. 12": "τ_r is the torque for the robot's right wheel and τ_r for the left wheel",
}


@pytest.mark.skipif(not SCAN.exists(), reason="the scan of the paper is not part of this repository")
@pytest.mark.parametrize("place", PRINTED)
def test_printed_forms_are_in_the_scan(place):
    text = SCAN.read_text(encoding="utf-8")
    assert "".join(PRINTED[place].split()) in "".join(text.split())
