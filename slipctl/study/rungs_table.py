"""The table of `slipctl study rungs`, and what it says in words."""

from __future__ import annotations

from typing import Any

TITLES = ("law", "rung", "RMS", "max", "final", "gap", "servo", "contact", "tick", "rest")


def table(result: dict[str, Any]) -> list[str]:
    """Return the lines of the table, in millimetres, and a sentence per gap.

    Parameters
    ----------
    result : dict
        As `slipctl.study.rungs.study` returns it.
    """
    rows = [TITLES]
    for law in result["controllers"]:
        rows += [_row(law["controller"], rung) for rung in law["rungs"]]
    widths = [max(len(row[column]) for row in rows) for column in range(len(TITLES))]
    lines = [
        "  ".join(
            cell.ljust(width) if column < 2 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    lines.insert(1, "─" * (sum(widths) + 2 * (len(widths) - 1)))
    heading = f"{result['scenario']}, tick {1e3 * result['tick']:g} ms; everything in mm"
    notes = [
        "",
        "gap: RMS distance between the paths of this rung and of the analytic one.",
        "servo, contact, tick, rest: what each adds to the RMS error, from the analytic rung to this one"
        + ("." if _has_parts(result) else "; not told for a torque drive."),
        *(sentence for law in result["controllers"] for sentence in _sentences(result, law)),
    ]
    return [heading, *lines, *notes]


def _has_parts(result: dict[str, Any]) -> bool:
    return any(rung["parts"] for law in result["controllers"] for rung in law["rungs"])


def _row(label: str, rung: dict[str, Any]) -> tuple[str, ...]:
    errors = (
        _mm(rung[name]) for name in ("rms_position_error", "max_position_error", "final_position_error")
    )
    parts = rung["parts"]
    signed = (_signed(parts[name]) if parts else "" for name in ("servo", "contact", "tick", "rest"))
    status = "" if rung["status"] == "completed" else f" ({rung['status']})"
    return (label, rung["rung"] + status, *errors, _mm(rung["gap"]), *signed)


def _mm(value: float | None) -> str:
    return "" if value is None else f"{1e3 * value:.3f}"


def _signed(value: float) -> str:
    text = f"{1e3 * value:+.3f}"
    return "0.000" if text in ("+0.000", "-0.000") else text


def _sentences(result: dict[str, Any], law: dict[str, Any]) -> list[str]:
    lines = []
    for index, rung in enumerate(law["rungs"]):
        moved = {name: value for name, value in rung["moved"].items() if name != "rest"}
        if not moved:
            continue
        name = max(moved, key=moved.__getitem__)
        line = (
            f"{law['controller']}, {rung['rung']}: the {name} moves the path most, by {_mm(moved[name])} mm"
        )
        if law["rungs_at_half_the_tick"]:
            half = law["rungs_at_half_the_tick"][index]["moved"]["tick"]
            own = "" if name == "tick" else f"the tick by {_mm(moved['tick'])} mm, "
            line += f"; {own}at half of {1e3 * result['tick']:g} ms by {_mm(half)} mm"
        lines.append(line)
    return lines
