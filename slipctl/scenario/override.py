"""Grids from the command line: swept keys added to a scenario or replaced."""

from collections.abc import Mapping, Sequence
from typing import Any

from slipctl.scenario.loading import Progress, read, sweep_table, tables_of
from slipctl.scenario.model import Scenario
from slipctl.scenario.problems import Problem, ScenarioError, quote

_FORMS = "0.1,0.2,0.4 or FROM:TO:COUNT or FROM:TO:COUNT:log"


def override(
    scenario: Scenario, over: Mapping[str, str | Sequence[float]], progress: Progress | None = None
) -> Scenario:
    """Add or replace swept keys, as by `--over KEY=VALUES`.

    Parameters
    ----------
    scenario
        Scenario to start from. A key that it sweeps already keeps its place in the grid; new ones come
        after, in the order given, so the last one varies fastest.
    over
        Values by dotted key: "0.1,0.2" lists them, "0.05:0.8:10" spaces 10 evenly, "0.01:1:10:log" evenly
        in the logarithm; a sequence of numbers lists them too.
    progress
        As for `read`.

    Raises
    ------
    ScenarioError
        If a text is none of these, or as `read` does.
    """
    problems: list[Problem] = []
    given: dict[str, Any] = {key: _values(key, text, problems) for key, text in over.items()}
    if problems:
        raise ScenarioError("--over", problems)
    sweep = {**sweep_table(scenario.sweep), **given}
    tables = {**tables_of(scenario), "sweep": sweep}
    if not given:  # every world was judged when it was read
        return Scenario.model_validate({"name": scenario.name, **tables})
    return read(tables, f"{scenario.name} with --over", scenario.name, progress=progress)


def sweep_over(scenario: Scenario, over: Sequence[str], progress: Progress | None = None) -> Scenario:
    """Add or replace swept keys given as texts "KEY=VALUES", as on the command line; see `override`.

    Raises
    ------
    ScenarioError
        If a text has no "=", a key comes twice, or as `override` does.
    """
    problems: list[Problem] = []
    given: dict[str, str] = {}
    for text in over:
        key, equals, values = (part.strip() for part in text.partition("="))
        if not equals or not key:
            problems.append(Problem("", f"{quote(text)} is no KEY=VALUES", f"a dotted key, =, and {_FORMS}"))
        elif key in given:
            problems.append(Problem(key, "the key twice", "each key once"))
        given[key] = values
    if problems:
        raise ScenarioError("--over", problems)
    return override(scenario, given, progress)


def _values(key: str, text: str | Sequence[float], problems: list[Problem]) -> Any:
    if not isinstance(text, str):
        return list(text)
    try:
        if ":" not in text:
            return [float(part) for part in text.split(",")]
        first, last, count, *scale = text.split(":")
        if len(scale) > 1:
            raise ValueError(text)
        span = {"from": float(first), "to": float(last), "count": int(count)}
    except ValueError:
        problems.append(Problem(key, quote(text), _FORMS))
        return []
    return {**span, "scale": scale[0]} if scale else span
