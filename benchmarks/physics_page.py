"""Measure and draw what docs/physics.md shows.

    python benchmarks/physics_page.py [--only pictures|tables|certificate]

Writes docs/figures/trap-*.png and the tables between the markers of docs/physics.md. Takes about two minutes.
"""

from __future__ import annotations

import argparse
import math
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from slipctl import experiment, scenario
from slipctl.certify import grip, slide
from slipctl.certify.examine import examine
from slipctl.certify.fixture import Bench
from slipctl.certify.fixtures import FIXTURES
from slipctl.plants.model import find_model
from slipctl.report.certificate import amount, number

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = DOCS / "physics.md"
SHIPPED = find_model("magellan_pro")
NAIVE = find_model("naive_magellan")
WHEEL_LOAD = 0.4 * 18.2 * 9.81


def variant(folder: Path, name: str, *edits: tuple[str, str]) -> Path:
    """The shipped model with edits to its text."""
    text = SHIPPED.read_text(encoding="utf-8")
    for old, new in edits:
        text, count = re.subn(old, new, text)
        if not count:
            raise SystemExit(f"nothing to edit: {old}")
    path = folder / f"{name}.xml"
    path.write_text(text, encoding="utf-8")
    return path


def stiffness(folder: Path, value: float) -> Path:
    """The shipped model on tyres of another stiffness [N/m], standing and rolling as before."""
    ratio, depth = value / 1e5, WHEEL_LOAD / value
    axle = 0.0825 - depth / 2.0
    caster = (0.082142916 - 0.061606466) - axle
    return variant(
        folder,
        f"stiffness-{value:g}",
        ("-10807.6704 -83.167957", f"{-10807.6704 * ratio:.6f} {-83.167957 * math.sqrt(ratio):.8f}"),
        ('size="0.082857084"', f'size="{0.0825 + depth / 2.0:.9f}"'),
        ('name="base" pos="0 0 0.082142916"', f'name="base" pos="0 0 {axle:.9f}"'),
        ("-0.061606466", f"{caster:.9f}"),
    )


def rate(folder: Path, value: float) -> Path:
    """The shipped model with another b_t [1/s]."""
    return variant(folder, f"rate-{value:g}", ('"-1e-9 -1.6"', f'"-1e-9 {-value * 0.002:.6f}"'))


def save(figure: Any, name: str) -> None:
    path = DOCS / "figures" / f"{name}.png"
    figure.savefig(path, dpi=100, metadata={"Software": None})
    plt.close(figure)
    print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


def draw_hopping() -> None:
    figure, axes = plt.subplots(figsize=(7.2, 3.0), layout="constrained")
    for path, colour, label in ((NAIVE, "tab:red", "naive"), (SHIPPED, "tab:blue", "slipctl")):
        trace = slide._towed(Bench(path, 0.001), 0.2, False)
        part = slice(1000, 1200)
        axes.plot(trace.time[part] - trace.time[1000], trace.load[part, 0], color=colour, label=label, lw=1.2)
    axes.set(xlabel="time [s]", ylabel="load on the left wheel [N]", xlim=(0.0, 0.2))
    axes.set_title("Locked wheels towed at 1 m/s, μ = 0.2", fontsize=10)
    axes.legend(loc="upper right", framealpha=1.0)
    save(figure, "trap-hopping")


def draw_curves(folder: Path) -> None:
    figure, axes = plt.subplots(figsize=(7.2, 3.0), layout="constrained")
    speeds = np.array([0.2, 0.4, 0.6, 0.8, 1.0])
    radius = 0.65
    for path, colour, label in (
        (rate(folder, 105.3), "tab:red", "b_t = 105 / s (MuJoCo's default solref)"),
        (SHIPPED, "tab:blue", "b_t = 800 / s (slipctl)"),
    ):
        bench = Bench(path, 0.001)
        slips = []
        for speed in speeds:
            trace = grip._circle(bench, float(speed), radius, 1.0, 0.8)
            slips.append(-1e3 * trace.along(trace.velocity)[1][-100:].mean())
        axes.plot(speeds, slips, "o", color=colour, label=label)
        axes.plot(speeds, 1e3 * speeds**2 / radius / bench.specimen.slip_rate, color=colour, lw=1)
    axes.set(xlabel="forward speed [m/s]", ylabel="lateral slip [mm/s]")
    axes.set_title("Circle of 0.65 m in full grip: measured (dots) and v·w/b_t (lines)", fontsize=10)
    axes.legend()
    save(figure, "trap-curves")


def draw_cone() -> None:
    figure, axes = plt.subplots(figsize=(4.4, 3.8), layout="constrained", subplot_kw={"projection": "polar"})
    degrees = np.arange(0.0, 91.0, 5.0)
    for path, colour, label in ((NAIVE, "tab:red", "pyramidal (naive)"), (SHIPPED, "tab:blue", "elliptic")):
        bench = Bench(path, 0.001)
        ratios = [
            measured / expected for measured, expected in (slide._deceleration(bench, d) for d in degrees)
        ]
        around = np.concatenate([np.radians(degrees + turn) for turn in (0.0, 90.0, 180.0, 270.0)])
        ratios = np.concatenate([ratios, ratios[::-1], ratios, ratios[::-1]])
        axes.plot(around, ratios, color=colour, label=label)
        print(label, [round(float(r), 4) for r in ratios[: len(degrees)]])
    axes.set_title("Friction while sliding, in shares of μN", fontsize=10)
    axes.set_yticks([0.5, 1.0])
    axes.legend(loc="center", fontsize=8)
    save(figure, "trap-cone")


def markdown(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def certificate_table() -> str:
    good, bad = (examine(name) for name in ("magellan_pro", "naive_magellan"))
    rows = []
    for a, b in zip(good["checks"], bad["checks"], strict=True):
        naive = "cannot be laid" if b["measured"] is None else f"{number(b, b['measured'])}"
        off = amount(b, b["error"], "+") if b["relative"] and b["error"] is not None else ""
        rows.append(
            [
                a["name"].replace("_", " "),
                a["law"].replace("|", "\\|"),
                f"{number(a, a['measured'])} {a['unit']}".removesuffix(" 1"),
                number(a, a["expected"]),
                amount(a, a["error"], "+"),
                amount(a, a["tolerance"]),
                f"{naive} ({off})" if off else naive,
            ]
        )
    versions = ", ".join(f"{name} {version}" for name, version in good["versions"].items())
    head = ["fixture", "closed form", "measured", "expected", "error", "allowed", "naive (error)"]
    return f"{markdown(head, rows)}\n\nMeasured with {versions}, physics step 1 ms."


def tracking(name: str, path: Path, timestep: float, **ground: float) -> list[float]:
    """RMS position errors of a shipped scenario's controllers [mm]."""
    file = scenario.load(name)
    file = file.model_copy(
        update={
            "sweep": (),
            "robot": file.robot.model_copy(update={"model": str(path)}),
            "plant": file.plant.model_copy(update={"timestep": timestep}),
            "ground": file.ground.model_copy(update=ground),
        }
    )
    table = experiment.run(file).metrics
    return [1e3 * value for value in table["rms_position_error"].to_pylist()]


def failed(bench: Bench) -> list[str]:
    return [fixture.name.replace("_", " ") for fixture in FIXTURES if not fixture.check(bench).passed]


def sensitivity_table(folder: Path) -> str:
    cases: list[tuple[str, Path, float]] = [
        ("**as shipped**: 1 ms, K 100 kN/m, b_t 800 /s", SHIPPED, 0.001),
        ("timestep 2 ms", SHIPPED, 0.002),
        ("timestep 0.5 ms", SHIPPED, 0.0005),
        ("timestep 0.25 ms", SHIPPED, 0.00025),
        ("K 50 kN/m", stiffness(folder, 5e4), 0.001),
        ("K 200 kN/m", stiffness(folder, 2e5), 0.001),
        ("K 400 kN/m", stiffness(folder, 4e5), 0.001),
        ("b_t 200 /s", rate(folder, 200.0), 0.001),
        ("b_t 400 /s", rate(folder, 400.0), 0.001),
        ("b_t 1200 /s", rate(folder, 1200.0), 0.001),
    ]
    named = {fixture.name: fixture for fixture in FIXTURES}

    def told(name: str, show: Callable[[Any], str]) -> Callable[[Bench], str]:
        return lambda bench: show(named[name].check(bench))

    columns = {
        "failed fixtures": lambda bench: ", ".join(failed(bench)) or "none",
        "slip on the paper's path [mm/s]": told("slip_on_the_papers_path", lambda c: f"{c.measured:.3f}"),
        "break-away, lateral": told("break_away_lateral", lambda c: f"{100 * c.error:+.2f} %"),
        "traction at 2 × limit": told("traction_at_2_of_limit", lambda c: f"{100 * c.error:+.2f} %"),
        "wheel load sliding": told("wheel_load_sliding", lambda c: f"{100 * c.error:+.2f} %"),
    }
    rows = []
    for label, path, timestep in cases:
        bench = Bench(path, timestep)
        row = [label, *(measure(bench) for measure in columns.values())]
        for name, ground in (("friction-sweep", {"friction": 0.3}), ("wet-slope", {})):
            errors = tracking(name, path, timestep, **ground)
            row.append(" / ".join(f"{error:.2f}" for error in errors))
        rows.append(row)
        print(row)
    head = [
        "what",
        *columns,
        "figure-eight 1 m/s, μ 0.3: RMS nominal / robust [mm]",
        "wet slope: RMS nominal / robust [mm]",
    ]
    return markdown(head, rows)


def renew(name: str, text: str) -> None:
    page = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- {name}: written by benchmarks/physics_page.py -->", f"<!-- end of {name} -->"
    before, rest = page.split(begin)
    after = rest.split(end)[1]
    PAGE.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure and draw what docs/physics.md shows.")
    parser.add_argument("--only", choices=("pictures", "tables", "certificate"))
    only = parser.parse_args().only
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if only in (None, "pictures"):
            draw_hopping()
            draw_curves(folder)
            draw_cone()
        if only != "pictures":
            renew("certificate", certificate_table())
        if only in (None, "tables"):
            renew("sensitivity", sensitivity_table(folder))


if __name__ == "__main__":
    main()
