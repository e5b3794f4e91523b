"""The tables of docs/second-engine.md."""

from __future__ import annotations

import math

from slipctl.tick import Array
from tests.engine.compare import Statistics, Track, in_bullet, in_mujoco
from tests.engine.drives import DRIVES
from tests.engine.fixtures import fixtures, measured
from tests.engine.planar import planar
from tests.engine.robot import Robot

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"

LEAST = 5e-6
"""Slip below which nothing is compared [m/s], [rad/s]."""

SLIPS = {"longitudinal": "v_t", "lateral": "v_s", "yaw": "w_s"}

CURVE = {"longitudinal": "b", "lateral": "a", "yaw": "b"}
TURNED = dict.fromkeys(SLIPS, "d")
SAME = dict.fromkeys(SLIPS, "same")

REASONS = {
    "weave, a tenth of the grip": CURVE,
    "weave, up to 0.9 of the grip": CURVE,
    "circle, 0.97 of the grip": {**CURVE, "longitudinal": "b, c"},
    "weave, up to 1.1 of the grip": TURNED,
    "circle, 1.5 of the grip": TURNED,
    "dash, 0.9 of the grip": {"longitudinal": "same, c"},
    "dash, 2 times the grip": SAME,
    "locked wheels, straight": SAME,
    "locked wheels, sideways": SAME,
    "locked wheels, at 45°, heading along x": TURNED,
    "locked wheels, at 45°, heading 45° from x": {**SAME, "yaw": "same, d as it turns"},
}
"""Letters of the page's list of reasons; "same": both engines model the same contact."""


def _number(value: float) -> str:
    """Return three significant digits of a slip, in thousandths."""
    thousandths = 1e3 * value
    if thousandths < 1e3 * LEAST:
        return "0"
    digits = max(0, 2 - math.floor(math.log10(thousandths)))
    return f"{thousandths:.{digits}f}"


def _three(slip: Array) -> str:
    return " / ".join(_number(value) for value in Statistics.of(slip).each())


def _percent(ratio: float) -> str:
    return f"{100.0 * (ratio - 1.0):+.2f} %"


def accelerations(robot: Robot) -> list[str]:
    """Return the table of what friction alone decides."""
    lines = [
        "| acceleration [m/s²] | closed form | MuJoCo | PyBullet | PyBullet against MuJoCo |",
        "|---|---|---|---|---|",
    ]
    for fixture in fixtures():
        mujoco, bullet = measured(fixture, robot)
        exact = "–" if fixture.closed_form is None else f"{fixture.closed_form:.4f}"
        lines.append(
            f"| {fixture.name} | {exact} | {mujoco:.4f} | {bullet:.4f} | {_percent(bullet / mujoco)} |"
        )
    return lines


def slips(tracks: dict[str, tuple[Track, Track]]) -> list[str]:
    """Return the table of slip statistics of both engines' tracks by drive."""
    lines = [
        "| drive | slip | MuJoCo rms / median / max | PyBullet rms / median / max | rms | why |",
        "|---|---|---|---|---|---|",
    ]
    for name, (mujoco, bullet) in tracks.items():
        for slip, symbol in SLIPS.items():
            one, other = getattr(mujoco, slip), getattr(bullet, slip)
            rms = [Statistics.of(signal).rms for signal in (one, other)]
            if max(rms) < LEAST:
                continue
            change = _percent(rms[1] / rms[0]) if min(rms) >= LEAST else "–"
            why = REASONS[name][slip]
            lines.append(f"| {name} | {symbol} | {_three(one)} | {_three(other)} | {change} | {why} |")
    return lines


def endings(tracks: dict[str, tuple[Track, Track]]) -> list[str]:
    """Return the table of how far apart the robots end."""
    lines = ["| drive | driven [m] | apart at the end [mm] | [deg] |", "|---|---|---|---|"]
    for name, (mujoco, bullet) in tracks.items():
        apart = 1e3 * math.dist(mujoco.position[-1], bullet.position[-1])
        turned = abs(math.degrees(mujoco.heading[-1] - bullet.heading[-1]))
        lines.append(f"| {name} | {mujoco.length:.2f} | {apart:.1f} | {turned:.2f} |")
    return lines


def directions(robot: Robot, tracks: dict[str, tuple[Track, Track]]) -> list[str]:
    """Return the table that gives reason d its proof: rms slips of both engines beside the planar model's."""
    lines = [
        "| drive | slip | MuJoCo | friction against the slip | PyBullet | friction as in reason d |",
        "|---|---|---|---|---|---|",
    ]
    for drive in DRIVES:
        if REASONS[drive.name] is not TURNED:
            continue
        mujoco, bullet = tracks[drive.name]
        every = (mujoco, planar(robot, drive, False), bullet, planar(robot, drive, True))
        for slip, symbol in SLIPS.items():
            cells = [_number(Statistics.of(getattr(track, slip)).rms) for track in every]
            lines.append(f"| {drive.name} | {symbol} | " + " | ".join(cells) + " |")
    return lines


def replayed(robot: Robot) -> dict[str, tuple[Track, Track]]:
    """Return the tracks of every drive, MuJoCo's and Bullet's."""
    return {drive.name: (in_mujoco(drive), in_bullet(robot, drive)) for drive in DRIVES}


def tables(robot: Robot, tracks: dict[str, tuple[Track, Track]]) -> str:
    """Return everything measured, as Markdown."""
    parts = [
        ("## Where friction alone decides", accelerations(robot)),
        (
            "## Slip over the same wheel commands",
            ["[mm/s], yaw [mrad/s]; of magnitudes.", "", *slips(tracks)],
        ),
        ("## Where the robots end", endings(tracks)),
        (
            "## Reason d, reckoned",
            ["Root mean square slip [mm/s], [mrad/s].", "", *directions(robot, tracks)],
        ),
    ]
    return "\n\n".join(f"{title}\n\n" + "\n".join(lines) for title, lines in parts)


def renewed(page: str, measured: str) -> str:
    """Return a page with new tables between its marks.

    Raises
    ------
    ValueError
        If the page has no marks.
    """
    before, _, rest = page.partition(BEGIN)
    _, mark, after = rest.partition(END)
    if not mark:
        raise ValueError(f"the page lacks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n\n{measured}\n\n{END}{after}"
