"""`slipctl study paper`: every run, the figures, the numbers, and the page that explains them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slipctl import scenario as files
from slipctl.experiment.folder import OutputError, publish, unfinished
from slipctl.study import choices, experiment, figures, page, sections
from slipctl.study.runs import StudyRun

NAME = "study-paper"
FIGURES = "figures"
PAGE = "reproduction.md"

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Reproduction:
    """What the study leaves behind.

    Attributes
    ----------
    folder : pathlib.Path
        With ``figures/``, ``numbers.json`` and ``reproduction.md``.
    numbers : dict
        What stands in ``numbers.json``.
    """

    folder: Path
    numbers: dict[str, Any]


def reproduce(
    out: Path, page_file: Path | None = None, quick: bool = False, progress: Progress | None = None
) -> Reproduction:
    """Run Sections V-A, V-B and VI and everything around them.

    Parameters
    ----------
    out : Path
        Folder in which a new folder ``study-paper`` is made.
    page_file : Path, optional
        Where the page is written as well, its pictures into ``figures`` beside it (PNG only).
    quick : bool
        Cut every run to a fraction of a second and take few seeds: the numbers then mean nothing.
    progress : callable, optional

    Raises
    ------
    slipctl.experiment.folder.OutputError
        Where `out` or the page's folder cannot be written.
    """
    with unfinished(out, NAME) as part:
        (part / FIGURES).mkdir()
        if page_file is not None:
            _check(page_file)
        runs, numbers = _run(quick, progress or (lambda done, total, text: None))
        pictures = figures.draw_all(runs, part / FIGURES)
        numbers["figures"] = [
            {"figure": picture.number, "section": picture.section, "file": f"{FIGURES}/{picture.name}"}
            for picture in pictures
        ]
        text = json.dumps(numbers, indent=1, ensure_ascii=False, allow_nan=False)
        (part / "numbers.json").write_text(text + "\n", encoding="utf-8", newline="\n")
        (part / PAGE).write_text(page.write(numbers, pictures), encoding="utf-8", newline="\n")
        folder = publish(part, out, NAME)
    if page_file is not None:
        _copy(folder, page_file, pictures)
    return Reproduction(folder, numbers)


def _run(quick: bool, tell: Progress) -> tuple[dict[str, sections.Section], dict[str, Any]]:
    runs: dict[str, sections.Section] = {}
    numbers: dict[str, Any] = {"quick": quick}
    tables: dict[str, tuple[str, Callable[[], Any]]] = {
        "targets": ("comparing", lambda: sections.compare(runs)),
        "facts": ("measuring", lambda: facts(runs)),
        "uncertainty": ("forms of the bound", lambda: _bounds(runs)),
        "start": ("starts", lambda: choices.starts(quick, runs)),
        "feedback": ("what the law sees", lambda: choices.feedback(quick, runs)),
        "tick": ("control periods", lambda: choices.tick_lengths(quick)),
        "dynamic_tick": ("control periods of the dynamic laws", lambda: choices.dynamic_ticks(quick)),
        "gains": ("higher gains", lambda: choices.higher_gains(quick)),
        "linear_bound": ("bounds of linear laws", lambda: _linear_bounds(runs)),
        "experiment": ("the experiment over seeds", lambda: _experiment(quick)),
    }
    parts = {"kinematic": sections.kinematic, "dynamic": sections.dynamic, "experiment": sections.experiment}
    total = len(parts) + len(tables)
    for done, (name, runner) in enumerate(parts.items()):
        tell(done, total, f"{name} section")
        runs[name] = runner(quick)
    for done, (name, (text, make)) in enumerate(tables.items()):
        tell(len(parts) + done, total, text)
        numbers[name] = make()
    return runs, numbers


def _bounds(runs: dict[str, sections.Section]) -> list[dict[str, Any]]:
    return [
        {"section": name, "law": label, **run.summary()}
        for name in ("kinematic", "dynamic")
        for label, run in runs[name].items()
    ]


def _linear_bounds(runs: dict[str, sections.Section]) -> list[dict[str, float]]:
    slip = files.load(sections.KINEMATIC).slip
    if slip is None or slip.kind != "proportional":
        raise ValueError("the paper's slip is proportional")
    ratio = complex(slip.longitudinal, -slip.lateral)
    return choices.linear_bounds(runs["kinematic"]["nominal"], ratio, slip.yaw)


def facts(runs: dict[str, sections.Section]) -> dict[str, Any]:
    """Return what the page says beside the tables: single numbers of single runs, by section and law."""
    shown = {
        section: {label: sections.measured(run) for label, run in laws.items()}
        for section, laws in runs.items()
    }
    return {"runs": shown, "late_y_mm": {label: late_y(run) for label, run in runs["experiment"].items()}}


def late_y(run: StudyRun) -> float:
    """Return the RMS error in y from 15 s on, where the paper saw its robust law do worse [mm].

    Of a shorter run, of its last quarter.
    """
    gap = run["motion.position.y"] - run["reference.position.y"]
    late = run["time"] >= min(15.0, 0.75 * float(run["time"][-1]))
    return 1e3 * float(np.sqrt(np.mean(gap[late] ** 2)))


def _experiment(quick: bool) -> dict[str, Any]:
    scenario = sections.shortened(files.load(sections.EXPERIMENT), quick)
    if quick:
        table = experiment.experiment_runs(seeds=(0, 1), ticks=(0.05,), gains=(1.0,), scenario=scenario)
    else:
        table = experiment.experiment_runs(scenario=scenario)
    rows = {"summary": experiment.summary(table), "comparison": experiment.comparison(table)}
    return {name: [_finite(row) for row in values] for name, values in rows.items()}


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    return {
        key: None if isinstance(value, float) and not np.isfinite(value) else value
        for key, value in row.items()
    }


def _check(page_file: Path) -> None:
    """Refuse a page that cannot be written before anything is run."""
    if page_file.is_dir():
        raise OutputError(f"{page_file} is a folder; name a file with --page")
    try:
        (page_file.parent / FIGURES).mkdir(parents=True, exist_ok=True)
        existed = page_file.exists()
        with page_file.open("a", encoding="utf-8"):
            pass
        if not existed:
            page_file.unlink()  # an interrupted study leaves no empty page
    except OSError as error:
        raise OutputError(
            f"cannot write the page {page_file}: {error.strerror or error}; name another with --page"
        ) from error


def _copy(folder: Path, page_file: Path, pictures: list[figures.Picture]) -> None:
    for picture in pictures:
        name = f"{picture.name}.png"
        shutil.copyfile(folder / FIGURES / name, page_file.parent / FIGURES / name)
    shutil.copyfile(folder / PAGE, page_file)


def text_table(numbers: dict[str, Any]) -> list[str]:
    """Return the numbers beside their targets as lines for a terminal."""
    rows = [("run", "number", "target", "measured", "")]
    rows += [page.target_cells(row) for row in numbers["targets"]]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    lines = [
        "  ".join(
            cell.rjust(width) if column in (2, 3) else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    lines.insert(1, "─" * (sum(widths) + 8))
    return lines
