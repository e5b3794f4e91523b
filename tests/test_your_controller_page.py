"""The page about controllers of one's own is run as it stands."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from typing import Any

from slipctl.pytest_plugin import SlipctlCheck
from tests.test_pytest_plugin import run

pytest_plugins = "pytester"

PAGE = (Path(__file__).parents[1] / "docs" / "your-controller.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
FILE = "test_my_controller.py"


def code(text: str) -> list[str]:
    """Lines of code: neither blank, nor a docstring on one line."""
    return [line for line in text.splitlines() if line.strip() and not line.strip().startswith('"""')]


def test_the_law_is_of_fifteen_lines() -> None:
    law = BLOCKS[0][BLOCKS[0].index("class ") : BLOCKS[0].index("def test_")]
    assert len(code(law)) <= 15


def test_the_page_s_law_is_recorded_passes_and_fails_where_the_page_says_so(pytester, monkeypatch) -> None:
    assert f"`{FILE}`" in PAGE
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    pytester.path.joinpath(FILE).write_text(BLOCKS[0], encoding="utf-8")
    (reason,) = re.findall(r'^pytest --slipctl-record "(.*?)"', PAGE, re.MULTILINE)
    run(pytester, "--slipctl-record", reason).assert_outcomes(passed=1)
    (path,) = pytester.path.glob("baselines/*.json")
    assert f"writes baselines/{path.name}" in PAGE

    slower = re.findall(r"With `(\(motion.*?)`, a twentieth slower", PAGE)[0]
    assert BLOCKS[0].count("(motion.velocity - expected) / 0.2 ") == 1
    text = BLOCKS[0].replace("(motion.velocity - expected) / 0.2 ", slower + " ")
    pytester.path.joinpath(FILE).write_text(text, encoding="utf-8")
    failed = run(pytester)
    failed.assert_outcomes(failed=1)
    # as printed, but for the day, the measured tolerances and the width of columns that follows from them
    said = {anew(line) for line in failed.outlines}
    table = PAGE[PAGE.index("```text\n") + len("```text\n") :]
    for line in table[: table.index("\n```")].splitlines():
        assert anew(line) in said, line


def anew(line: str) -> str:
    line = re.sub(r"\d{4}-\d\d-\d\d", "DAY", line)
    line = re.sub(r"[\d.e-]+ mm (worse)", r"TOLERANCE \1", line)
    return " ".join(line.split())


def test_the_page_s_run_gives_the_page_s_numbers(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "page"}
    exec(BLOCKS[0], names)  # the page's own code
    exec(BLOCKS[1], names)
    runs = {row["controller"]: row for row in names["result"].metrics.to_pylist()}
    nominal, own = runs["nominal_kinematic"], runs["observer"]
    said = re.findall(r"RMS error of ([\d.]+) mm, this one ([\d.]+) mm", PAGE)[0]
    assert f"{1e3 * nominal['rms_position_error']:.1f}" == said[0]
    assert f"{1e3 * own['rms_position_error']:.1f}" == said[1]
    (times,) = re.findall(r"pays with ([\d.]+) times", PAGE)
    assert f"{own['command_variation'] / nominal['command_variation']:.1f}" == times
    assert len(list((tmp_path / "runs" / "wet-slope").glob("*.rrd"))) == 1


def test_the_page_s_arguments_are_the_fixture_s() -> None:
    parameters = inspect.signature(SlipctlCheck.__call__).parameters
    for name in re.findall(r"`([a-z_]+)=", PAGE):
        assert name in parameters, name
