"""How much error of each parameter the laws take: prints the tables of docs/wrong-beliefs.md.

    python benchmarks/wrong_beliefs.py

Takes about a minute.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Sequence
from typing import Any

from slipctl import scenario as files
from slipctl import shipped
from slipctl.experiment import run
from slipctl.experiment.assemble import read_robot

Row = dict[str, Any]

SHARES = (0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5, 2.0)
FAR = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.25, 2.0, 3.0, 5.0)
NEAR = (0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.25)
LENGTHS = ("wheel_radius", "half_track")
ALL = (*LENGTHS, "mass", "yaw_inertia")


def truth(scenario: files.Scenario, name: str) -> float:
    """Return the true value of a parameter."""
    inertia = read_robot(scenario).inertia
    return float(getattr(inertia.geometry if name in LENGTHS else inertia, name))


def sweep(
    name: str, parameter: str, shares: Sequence[float], change: Callable[[Row], None] = lambda raw: None
) -> dict[str, list[Row]]:
    """Run a shipped scenario whose laws believe shares of a true value; rows of every kind of law."""
    raw = tomllib.loads(shipped.scenario_path(name).read_text(encoding="utf-8"))
    raw.pop("sweep", None)
    change(raw)
    true = truth(files.read(raw), parameter)
    raw["sweep"] = {f"controller.*.believes.{parameter}": [share * true for share in shares]}
    rows = run(files.read(raw), record="none").metrics.to_pylist()
    kinds = {row["kind"]: [] for row in rows}
    for row in rows:
        kinds[row["kind"]].append(row)
    return kinds


def millimetres(row: Row, metric: str) -> str:
    """Return an error in mm, or what ended the run."""
    value = row[metric]
    if row["status"] != "completed" or value is None:
        return row["status"]
    return f"{1e3 * value:.2f}" if value < 0.01 else f"{1e3 * value:.0f}"


def table(title: str, shares: Sequence[float], lines: list[tuple[str, list[str]]]) -> None:
    """Print a Markdown table, one column per share."""
    print(f"\n{title}\n")
    print("| believed / true | " + " | ".join(f"{share:g}" for share in shares) + " |")
    print("|---" * (len(shares) + 1) + "|")
    for label, cells in lines:
        print(f"| {label} | " + " | ".join(cells) + " |", flush=True)


def _words(parameter: str, kind: str) -> str:
    return f"{parameter.replace('_', ' ')}, {kind.split('_')[0]}"


def without_slip() -> None:
    """Shipped scenarios and their like: MuJoCo with grip."""
    for title, name, parameters in (
        ("Wheel speeds, grip: largest position error [mm]", "wrong-beliefs", LENGTHS),
        ("Wheel torques, grip: largest position error [mm]", "wrong-beliefs-torque", ALL),
    ):
        lines = []
        for parameter in parameters:
            for kind, rows in sweep(name, parameter, SHARES).items():
                cells = [millimetres(row, "max_position_error") for row in rows]
                lines.append((_words(parameter, kind), cells))
        table(title, SHARES, lines)


def _only_robust(raw: Row) -> None:
    raw["tick"] = 0.005
    raw["controller"] = [law for law in raw["controller"] if law["kind"].startswith("robust")]


def _with_share(rows: list[Row]) -> list[str]:
    """Return errors, and the share of ticks with all hypotheses, never rounded up to 100."""
    return [
        f"{millimetres(row, 'max_position_error')} ({math.floor(100 * row['guarantee_fraction'])})"
        for row in rows
    ]


def _robust(change: Callable[[Row], None], shares: Sequence[float]) -> list[tuple[str, list[str]]]:
    return [
        (f"{parameter.replace('_', ' ')}, {kind.split('_')[1]}", _with_share(rows))
        for name, parameters in (("paper-kinematic", LENGTHS), ("paper-dynamic", ALL))
        for parameter in parameters
        for kind, rows in sweep(name, parameter, shares, change).items()
    ]


def at_the_bound() -> None:
    """The robust laws with the slip at its bound besides, on the paper's equations."""

    def lower_floor(raw: Row) -> None:
        _only_robust(raw)
        raw["controller"][0]["speed_floor"] = 0.01

    lines = _robust(_only_robust, FAR)
    lower = sweep("paper-kinematic", "wheel_radius", FAR, lower_floor)["robust_kinematic"]
    lines.insert(1, ("wheel radius, kinematic, floor 0.01 m/s", _with_share(lower)))
    table("Robust laws, slip at its bound: largest error [mm] (ticks with all hypotheses [%])", FAR, lines)


def little_expected() -> None:
    """Robust laws that expect hardly any slip, where there is none."""

    def cautious(raw: Row) -> None:
        _only_robust(raw)
        raw.pop("slip", None)
        law = raw["controller"][0]
        law["slip_bound"] = 0.05
        if law["kind"] == "robust_kinematic":
            law["uncertainty"] = "independent"

    lines = _robust(cautious, NEAR)
    table("α = 0.05, no slip: largest error [mm] (ticks with all hypotheses [%])", NEAR, lines)


def by_odometry() -> None:
    """The experiment of Section VI, where the odometry reckons with the belief, too."""
    lines = []
    for parameter in LENGTHS:
        for kind, rows in sweep("paper-experiment", parameter, NEAR).items():
            cells = [millimetres(row, "rms_position_error") for row in rows]
            lines.append((_words(parameter, kind), cells))
    table("Odometry and 3 Hz camera fixes (Section VI): RMS position error [mm]", NEAR, lines)


if __name__ == "__main__":
    without_slip()
    at_the_bound()
    little_expected()
    by_odometry()
