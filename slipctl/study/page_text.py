"""The parts of the page that explain: what is open, what higher gains do, the experiment, and what is wrong.

Every number comes from `numbers`; which law is called better is decided by them, too.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from slipctl.study.choices import NOISE, SEEDS, STIFF_POLE
from slipctl.study.markdown import amount, bullets, mm, number, prose, table
from slipctl.study.sections import DYNAMIC, KINEMATIC

Numbers = dict[str, Any]
Row = dict[str, Any]

ERRORS = ("RMS [mm]", "max [mm]", "final [mm]", "variation")
KINDS = {KINEMATIC: "kinematic", DYNAMIC: "dynamic"}


def find(rows: list[Row], **wanted: Any) -> Row:
    """Return the one row with these values."""
    (row,) = (row for row in rows if all(row[key] == value for key, value in wanted.items()))
    return row


def _errors(row: Row) -> tuple[str, str, str, str]:
    return mm(row["rms_mm"]), mm(row["max_mm"]), mm(row["final_mm"]), amount(row["variation"])


def _tabled(rows: list[Row], columns: dict[str, Callable[[Row], str]]) -> list[str]:
    cells = [(*(read(row) for read in columns.values()), *_errors(row)) for row in rows]
    first = len(columns)
    return table((*columns, *ERRORS), cells, right=range(first, first + len(ERRORS)))


def open_part(numbers: Numbers) -> list[str]:
    """Return what the paper leaves open and how the answer depends on it."""
    return [
        "## What the paper leaves open",
        "",
        *prose("""Four choices decide the numbers, and the paper makes none of them in print. *Variation*
        is the total variation of the commanded yaw rate [rad/s], for the dynamic laws of the right
        wheel's torque [N·m]."""),
        *_bound(numbers),
        *_start(numbers),
        *_tick(numbers),
        *_feedback(numbers),
    ]


def _bound(numbers: Numbers) -> list[str]:
    rows = numbers["uncertainty"]
    paper, tight = (find(rows, section="kinematic", law=law) for law in ("paper", "slip_ratio"))
    printed, rigorous = (find(rows, section="dynamic", law=law) for law in ("paper", "proportional"))
    verdict = "worse" if printed["rms_mm"] > rigorous["rms_mm"] else "better"
    return [
        "### Φ, and so ρ",
        "",
        *prose(f"""Φ of (58) and (81) is not printed. `paper` is our reading of it; the others are
        rigorous bounds, each tight for other knowledge of the slip. A larger ρ tracks better and asks for
        more: from the tightest kinematic bound to the paper's, the RMS error falls from
        {mm(tight["rms_mm"])} to {mm(paper["rms_mm"])} mm. The kinematic `paper` form holds through slack
        only. The dynamic one does not hold for every sign of the slip, and here it tracks {verdict} than
        the rigorous form ({mm(printed["rms_mm"])} against {mm(rigorous["rms_mm"])} mm)."""),
        *_tabled(rows, {"section": lambda row: row["section"], "law": lambda row: row["law"]}),
        "",
    ]


def _start(numbers: Numbers) -> list[str]:
    rows = numbers["start"]

    def rms(scenario: str, start: str, law: str) -> str:
        return mm(find(rows, scenario=scenario, start=start, law=law)["rms_mm"])

    columns = {
        "model": lambda row: KINDS[row["scenario"]],
        "start": lambda row: row["start"],
        "law": lambda row: row["law"],
    }
    return [
        "### The initial state",
        "",
        *prose(f"""*Planned*: the robot has the desired pose and speed and the slip already acts, so Ḟ(0)
        ≠ Ḟ_d(0); the text's "error at the beginning, which resulted from the slip" needs this one.
        *Matched*: speed and heading are such that the slipping motion is the planned one. The start makes
        most of what the dynamic section shows: matched, its RMS errors are
        {rms(DYNAMIC, "matched", "nominal")} mm nominal and {rms(DYNAMIC, "matched", "robust")} mm robust
        instead of {rms(DYNAMIC, "planned", "nominal")} and {rms(DYNAMIC, "planned", "robust")} mm. The
        nominal kinematic law hardly notices ({rms(KINEMATIC, "planned", "nominal")} and
        {rms(KINEMATIC, "matched", "nominal")} mm): its error is the slip that lasts."""),
        *_tabled(rows, columns),
        "",
    ]


def _tick(numbers: Numbers) -> list[str]:
    rows = [row for row in numbers["tick"] if row["law"] in ("nominal", "robust")]
    robust = [row for row in rows if row["law"] == "robust"]
    calm, late = robust[0]["calm_tick"], robust[0]["late_calm_tick"]
    steps = ", ".join(f"{amount(row['variation'])} at {1e3 * row['tick']:g} ms" for row in robust)
    columns = {
        "model": lambda row: row["model"],
        "tick": lambda row: f"{1e3 * row['tick']:g} ms",
        "law": lambda row: row["law"],
    }
    both = [{**row, "model": "kinematic"} for row in rows]
    both += [{**row, "model": "dynamic"} for row in numbers["dynamic_tick"]]
    return [
        "### The sample time",
        "",
        *prose(f"""The errors hardly depend on the tick; the command does. Under a zero-order hold the
        boundary layer chatters above a tick of 2 Re(1+σ)/|1+σ|² · ε/(P₂₂ρ): {1e3 * calm:.1f} ms at the
        worst instant of the kinematic run, the start, which passes, and {1e3 * late:.1f} ms in its second
        half. The robust law's yaw rate varies by {steps} (in rad/s)."""),
        *_tabled(both, columns),
        "",
    ]


def _feedback(numbers: Numbers) -> list[str]:
    rows = numbers["feedback"]

    def rms(source: str, law: str) -> str:
        return mm(find(rows, scenario=KINEMATIC, source=source, law=law)["rms_mm"])

    def final(source: str, law: str) -> str:
        return mm(find(rows, scenario=DYNAMIC, source=source, law=law)["final_mm"])

    columns = {
        "model": lambda row: KINDS[row["scenario"]],
        "signal": lambda row: f"{row['signal']}: {row['source']}",
        "law": lambda row: row["law"],
    }
    return [
        "### What the law gets to see",
        "",
        *prose(f"""e₂ needs Ḟ, and e₃ of the dynamic law needs F̈. With Ḟ from odometry, which is blind to
        slip, and the true position, the kinematic RMS errors grow from {rms("true", "nominal")} (nominal)
        and {rms("true", "robust")} mm (robust) to {rms("odometry", "nominal")} and
        {rms("odometry", "robust")} mm: this choice matters more than the choice of the law. With F̈ from
        the model without slip instead of an accelerometer the dynamic laws end
        {final("model", "nominal")} and {final("model", "robust")} mm off instead of
        {final("true", "nominal")} and {final("true", "robust")} mm."""),
        *_tabled(rows, columns),
        "",
    ]


def gains_part(numbers: Numbers) -> list[str]:
    """Return the chatter of (47) and the paper's remark on higher gains."""
    rows = numbers["tick"]
    names = {"robust": "(59)", "discontinuous": "(47)"}
    chatter = [row for row in rows if row["law"] in names]
    fine = find(rows, law="discontinuous", tick=min(row["tick"] for row in rows))
    smooth = find(rows, law="robust", tick=fine["tick"])
    columns = {"tick": lambda row: f"{1e3 * row['tick']:g} ms", "law": lambda row: names[row["law"]]}
    return [
        "## The discontinuous law (47)",
        "",
        *prose(f"""At {1e3 * fine["tick"]:g} ms the discontinuous law tracks to {mm(fine["rms_mm"])} mm
        RMS, the continuous one (59) to {mm(smooth["rms_mm"])} mm. The price is a yaw rate that changes by
        {amount(fine["variation"])} rad/s in all instead of {amount(smooth["variation"])} rad/s, between
        its limits from tick to tick: no motor does that, and a shorter tick makes it worse."""),
        *_tabled(chatter, columns),
        "",
        *_higher_gains(numbers),
    ]


def _higher_gains(numbers: Numbers) -> list[str]:
    rows, (low, high) = numbers["gains"], numbers["linear_bound"]
    groups = list(dict.fromkeys((row["tick"], row["start"], row["noise"]) for row in rows))

    def lower(quantity: str) -> int:
        """Count the comparisons in which the linear law has the smaller number."""
        count = 0
        for tick, start, noise in groups:
            same = {"tick": tick, "start": start, "noise": noise}
            count += find(rows, law="linear", **same)[quantity] < find(rows, law="robust", **same)[quantity]
        return count

    late = numbers["facts"]["runs"]["kinematic"]["nominal"].get("late_max")
    seen = "" if late is None else f" (measured: {mm(late)} mm after 5 s)"
    noise = (
        f"{1e3 * NOISE['sensing.position_noise']:g} mm, {NOISE['sensing.heading_noise_deg']:.2f}° and"
        f" {1e3 * NOISE['sensing.velocity_noise']:g} mm/s"
    )
    columns = {
        "tick": lambda row: f"{1e3 * row['tick']:g} ms",
        "start": lambda row: row["start"],
        "noise": lambda row: "yes" if row["noise"] else "no",
        "law": lambda row: row["law"],
    }
    return [
        "## The remark on higher gains",
        "",
        *prose(f""""Note that the use of higher gains for K_i in the nonrobust control could reduce the
        tracking error, however, one cannot guarantee the uniformly ultimate boundedness property"
        (Section V-A). For the kinematic model the second half is wrong: for constant |σ| < 0.787 a linear
        law is uniformly ultimately bounded at every pole, with a bound that falls as 1/p²:
        {mm(low["bound_mm"])} mm at pole {number(low["pole"])} 1/s{seen}, {mm(high["bound_mm"])} mm at
        pole {number(high["pole"])} 1/s."""),
        *prose(f"""So the robust law has to be held against a linear law with poles {number(STIFF_POLE)}
        1/s, at the same tick, start and noise ({noise}; medians over {SEEDS} seeds; `paper` ρ). Of
        {len(groups)} comparisons the linear law has the smaller RMS error in {lower("rms_mm")}, the
        smaller largest error in {lower("max_mm")} and the smaller command variation in
        {lower("variation")}. Inside its boundary layer the robust law *is* a linear law with gains
        scheduled by ρ. What it has beyond that is its answer to the large error at the start."""),
        *_tabled(rows, columns),
        "",
    ]


def wrong_part(numbers: Numbers) -> list[str]:
    """Return where the paper is wrong, or its law loses, on these runs."""
    runs = numbers["facts"]["runs"]
    kinematic, dynamic = runs["kinematic"]["paper"], runs["dynamic"]["proportional"]
    return [
        "## Where the paper is wrong, or its law loses",
        "",
        *bullets(
            f"""The bounds below (84), ‖v̇_t‖, ‖v̇_s‖ ≤ α‖v̂₁‖, do not hold: v̇_t = αū₁ contains Δv. At the
            start ‖Δv‖ is {kinematic["max_robust_input"]:.2f} m/s², while ‖v̂‖ never exceeds
            {kinematic["max_nominal_input"]:.4f} m/s².""",
            f"""The heading does not follow the desired one, and cannot: its offset is atan(α/(1+α)), at
            the end {kinematic["heading_offset"]:.3f} and {dynamic["heading_offset"]:.3f} rad. The paper says
            so in words, without the number.""",
            """The dynamic law with our reading of the printed (81) tracks in these runs, but that ρ is no
            bound for every sign of the slip.""",
            f""""The robust controller makes the robot more accurately track the desired trajectory" is true
            against the nominal law with poles −0.5 1/s. Against a linear law with poles
            {number(STIFF_POLE)} 1/s see the remark on higher gains.""",
        ),
    ]
