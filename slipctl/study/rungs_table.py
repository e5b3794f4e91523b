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
        "servo, contact, tick, rest: what each adds to the RMS error, from the analytic rung to this one.",
        *(sentence for law in result["controllers"] for sentence in _sentences(result, law)),
    ]
    return [heading, *lines, *notes]


def _row(label: str, rung: dict[str, Any]) -> tuple[str, ...]:
    errors = (
        _mm(rung[name]) for name in ("rms_position_error", "max_position_error", "final_position_error")
    )
    parts = rung["parts"]
    signed = (f"{1e3 * parts[name]:+.3f}" if parts else "" for name in ("servo", "contact", "tick", "rest"))
    status = "" if rung["status"] == "completed" else f" ({rung['status']})"
    return (label, rung["rung"] + status, *errors, _mm(rung["gap"]), *signed)


def _mm(value: float | None) -> str:
    return "" if value is None else f"{1e3 * value:.3f}"


def _sentences(result: dict[str, Any], law: dict[str, Any]) -> list[str]:
    lines = []
    for index, rung in enumerate(law["rungs"]):
        moved = {name: value for name, value in rung["moved"].items() if name != "rest"}
        if not moved:
            continue
        name = max(moved, key=moved.__getitem__)
        line = f"{law['controller']}, {rung['rung']}: the {name} moves the path most"
        line += f", by {1e3 * moved[name]:.3f} mm"
        if law["rungs_at_half_the_tick"]:
            half = law["rungs_at_half_the_tick"][index]["moved"]["tick"]
            line += (
                f"; the tick by {1e3 * moved['tick']:.3f} mm at {1e3 * result['tick']:g} ms"
                f" and by {1e3 * half:.3f} mm at half of it"
            )
        lines.append(line)
    return lines
