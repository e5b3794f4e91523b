"""Finding, reading and refusing scenario files."""

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import prod
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from slipctl import shipped
from slipctl.scenario.axes import Axis, read_axes
from slipctl.scenario.base import lookup
from slipctl.scenario.checks import rule_problems
from slipctl.scenario.fields import field_problems
from slipctl.scenario.grid import Place, axis_problems, variations, with_values
from slipctl.scenario.model import Scenario
from slipctl.scenario.own_robot import with_whole_path
from slipctl.scenario.problems import Problem, ScenarioError, nearest

_PROBLEM_LIMIT = 50
"""Problems listed of one grid; more are the same again and again."""

TOLD = 256
"""Worlds of a grid that are judged between two reports of it."""

Progress = Callable[[int, int, str], None]


def load(source: str | Path, progress: Progress | None = None) -> Scenario:
    """Load a scenario by the name of a shipped one or by its path.

    Parameters
    ----------
    source
        A shipped scenario's name, such as "friction-sweep", or the path of a TOML file.
    progress
        As for `read`.

    Raises
    ------
    ScenarioError
        If there is no such file, it is not TOML, or anything in it is wrong; lists every problem.
    """
    path = _find(source)
    raw = _parse(path)
    return read(raw, str(path), path.stem, path.parent, progress)


def read(
    raw: Mapping[str, Any],
    source: str = "scenario",
    name: str = "scenario",
    folder: str | Path = ".",
    progress: Progress | None = None,
) -> Scenario:
    """Read a scenario from its tables, as TOML gives them.

    Parameters
    ----------
    raw
        The tables.
    source
        What messages call the file.
    name
        Name of the scenario where the tables give none.
    folder
        Where the files that the tables name are, unless by an absolute path.
    progress
        Called with worlds judged, worlds to judge and a text, where there is a grid: a large one takes long.

    Raises
    ------
    ScenarioError
        If anything is wrong, in the scenario itself or in any world of its grid; lists every problem.
    """
    tables = {"name": name, **_with_whole_paths(raw, Path(folder))}
    axes, problems = read_axes(raw.get("sweep", {}))
    scenario, base = _validate(tables)
    problems = [*base, *problems, *axis_problems(axes, raw)]
    if not problems:
        problems = _grid_problems(tables, axes, progress)
    if problems or scenario is None:
        raise ScenarioError(source, problems)
    return scenario


def _with_whole_paths(raw: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Make the paths of the files that the tables name absolute, so that they hold for every reader."""
    raw = with_whole_path(raw, folder)
    file = lookup(raw, "slip", "file")
    if not isinstance(file, str) or not file:
        return raw
    return {**raw, "slip": {**raw["slip"], "file": str((folder / file).absolute())}}


def _validate(tables: Mapping[str, Any], judge_rules: bool = True) -> tuple[Scenario | None, list[Problem]]:
    """Make the scenario of some tables, or tell everything that is wrong with them but for the sweep."""
    rules = rule_problems(tables) if judge_rules else []
    try:
        scenario = Scenario.model_validate(tables)
    except ValidationError as error:
        return None, [*field_problems(error, tables), *rules]
    return scenario, rules


def _grid_problems(
    tables: Mapping[str, Any], axes: Sequence[Axis], progress: Progress | None
) -> list[Problem]:
    problems: dict[Problem, None] = {}
    others, seeds = ([axis for axis in axes if (axis.key == "seed") == is_seed] for is_seed in (False, True))
    total = (prod(map(len, others)) if others else 0) + sum(map(len, seeds))
    for done, (values, rules) in enumerate(_judged(others, seeds)):
        if progress is not None and done % TOLD == 0:
            progress(done, total, "judging the grid")
        _, wrong = _validate(with_values(tables, values), rules)
        problems.update((Place(values).blame(problem), None) for problem in wrong)
        if len(problems) > _PROBLEM_LIMIT:
            return [*problems, Problem("sweep", "more of these", "a grid whose every world is valid")]
    return list(problems)


def _judged(others: Sequence[Axis], seeds: Sequence[Axis]) -> Iterator[tuple[dict[str, float | int], bool]]:
    """Yield the worlds to be looked at, and whether the rules between keys are to be judged.

    No rule looks at the seed: it is judged once per value and not in every combination with the others.
    """
    if others:
        yield from ((values, True) for values in variations(others))
    yield from ((values, False) for seed in seeds for values in variations([seed]))


def tables_of(scenario: Scenario) -> dict[str, Any]:
    """Give the keys that a scenario was given as tables, without its sweep and its claims."""
    return scenario.model_dump(exclude_unset=True, exclude={"sweep", "expect"})


def sweep_table(axes: Sequence[Axis]) -> dict[str, Any]:
    """Write axes as a `[sweep]` table."""
    return {
        axis.key: list(axis.values) if isinstance(axis.values, tuple) else axis.values.table()
        for axis in axes
    }


def _find(source: str | Path) -> Path:
    path, names = Path(source), shipped.scenario_names()
    is_name = isinstance(source, str) and path.suffix != ".toml" and path.name == source
    if is_name and source in names:
        return shipped.scenario_path(str(source))
    try:
        if path.is_dir():
            raise ScenarioError(
                str(source), [Problem("", "this is a folder", "a TOML file, or a shipped scenario")]
            )
        if path.exists():
            return path
    except (OSError, ValueError) as error:
        raise ScenarioError(
            str(source), [Problem("", f"this cannot be read ({error})", "a TOML file")]
        ) from error
    found = (
        "there is neither such a file nor a shipped scenario of this name"
        if is_name
        else "there is no such file"
    )
    allowed = f"a TOML file, or a shipped scenario: {', '.join(names)}"
    raise ScenarioError(str(source), [Problem("", found, allowed, nearest(path.stem or str(source), names))])


def _parse(path: Path) -> dict[str, Any]:
    try:
        text = path.read_bytes().decode("utf-8-sig")
        return tomllib.loads(text)
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        where = f"byte {error.start}, line {line}"
        problem = Problem("", f"this is not UTF-8 text ({where})", "a TOML file")
    except (ValueError, RecursionError) as error:
        problem = Problem("", f"this is not a TOML file: {error}", "")
    except OSError as error:
        problem = Problem("", f"this cannot be read ({error.strerror})", "a TOML file")
    raise ScenarioError(str(path), [problem])
