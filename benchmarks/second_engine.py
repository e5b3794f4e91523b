"""The same robot and wheel commands in MuJoCo and PyBullet: prints the tables of docs/second-engine.md.

    pip install 'slipctl[engine]'
    python benchmarks/second_engine.py [--page docs/second-engine.md]

With --page it writes them into the page instead. Takes about ten seconds.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # the drives and the robot are the tests'

from tests.engine.page import renewed, replayed, tables
from tests.engine.robot import magellan_pro

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Compare MuJoCo with PyBullet.")
    parser.add_argument("--page", type=Path, help="page to write the tables into")
    page = parser.parse_args().page
    robot = magellan_pro()
    measured = tables(robot, replayed(robot))
    if page is None:
        print(measured)
    else:
        page.write_text(renewed(page.read_text(encoding="utf-8"), measured), encoding="utf-8")
