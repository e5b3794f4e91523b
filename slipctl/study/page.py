"""The page `docs/reproduction.md`: what the runs say, in words and tables made of their numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from slipctl.study.figures import Picture
from slipctl.study.markdown import prose, table
from slipctl.study.page_experiment import experiment_part
from slipctl.study.page_text import gains_part, open_part, wrong_part

QUANTITIES = {
    "max_x": "largest error in x",
    "max_y": "largest error in y",
    "max": "largest position error",
    "rms": "RMS position error",
    "final": "final position error",
    "min_speed": "least wheel speed v",
    "heading_offset": "final heading offset",
    "first_slip": "slip v_t at the start",
    "least_slip": "least slip v_t",
    "max_nominal_input": "largest ‖v̂‖",
    "max_robust_input": "largest ‖Δv‖",
    "late_robust_input": "largest ‖Δv‖ after 5 s",
    "max_torque": "largest wheel torque",
}
"""What the targets' quantities are called."""

SECTIONS = {
    "kinematic": "Section V-A: kinematic laws",
    "dynamic": "Section V-B: dynamic laws",
    "experiment": "Section VI: the experiment, simulated",
}


def write(numbers: dict[str, Any], pictures: Iterable[Picture]) -> str:
    """Return the page as Markdown.

    Parameters
    ----------
    numbers : dict
        As `slipctl study paper` collects them.
    pictures : iterable of Picture
        What was drawn.
    """
    parts: list[Callable[[dict[str, Any]], list[str]]] = [_head, _targets, open_part, gains_part]
    parts += [experiment_part, wrong_part]
    lines = [line for part in parts for line in part(numbers)]
    return "\n".join([*lines, *_pictures(list(pictures))]) + "\n"


def target_cells(row: dict[str, Any]) -> tuple[str, str, str, str, str]:
    """Return a target and what was measured as cells: run, number, target, measured, verdict."""
    digits = len(repr(row["target"]).partition(".")[2])
    sign = "≤ " if row["upper"] else ""
    found = "–" if row["measured"] is None else f"{row['measured']:.{digits + 1}f}"
    verdict = {None: "", True: "agrees", False: "differs"}[row["met"]]
    name = f"{QUANTITIES[row['quantity']]} [{row['unit']}]"
    return row["case"].replace("/", ", "), name, f"{sign}{row['target']:.{digits}f}", found, verdict


def _head(numbers: dict[str, Any]) -> list[str]:
    warning = "**This is a quick run: every simulation was cut short, and no number here means anything.**"
    return [
        "# The paper, reproduced",
        "",
        *prose("""J.-C. Ryu and S. K. Agrawal, *Differential flatness-based robust control of mobile robots
        in the presence of slip*: Sections V and VI, run again. This page and its pictures are written by"""),
        "```console",
        "$ slipctl study paper --page docs/reproduction.md",
        "```",
        "",
        *prose("""and every number on it comes from the runs of that command. Position errors are distances
        to the desired point at the same time. What the paper prints wrongly is listed in
        [errata.md](errata.md)."""),
        *(prose(warning) if numbers["quick"] else []),
    ]


def _targets(numbers: dict[str, Any]) -> list[str]:
    rows = numbers["targets"]
    judged = [row for row in rows if row["met"] is not None]
    met = sum(row["met"] for row in judged)
    cells = [target_cells(row) for row in rows]
    return [
        "## What agrees",
        "",
        *prose(f"""The paper prints curves and no table, so the targets below were {rows[0]["source"]}: its
        models, gains, slip and path, integrated once more under continuous control. The runs here hold
        their commands over a tick of 1 ms. {met} of {len(judged)} numbers agree, within 1 % or half of the
        target's last digit. What Section V says about its curves is seen: the robust laws track x and y
        better than the nominal ones, the error of the dynamic laws begins with the slip, and the heading
        keeps an offset under either law."""),
        *table(("run", "number", "target", "measured", ""), cells, right=(2, 3)),
        "",
    ]


def _pictures(pictures: list[Picture]) -> list[str]:
    lines = ["## Figures", "", "Numbered as in the paper; 1, 2 and 13 are sketches and a photograph.", ""]
    for section, title in SECTIONS.items():
        own = [picture for picture in pictures if picture.section == section]
        lines += [f"### {title}", ""] if own else []
        for picture in own:
            lines += [
                f"![Figure {picture.number}](figures/{picture.name}.png)",
                "",
                f"*Fig. {picture.number}.* {picture.caption}",
                "",
            ]
    return lines[:-1]
