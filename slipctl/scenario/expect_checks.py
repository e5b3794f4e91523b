"""The rules between a claim and what it is about: the controllers and the sweep."""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl.scenario.axes import Axis, read_axes, swept_keys
from slipctl.scenario.controllers import KINDS_WITH_THEOREM
from slipctl.scenario.problems import Problem, nearest, quote
from slipctl.scenario.structure import Path, dotted
from slipctl.scenario.values import controllers, entries
from slipctl.scenario.where import Condition, read_where


def expect_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything wrong between the claims and the controllers and swept keys that they name."""
    for path, entry in entries(raw, "expect"):
        yield from _labels(raw, path, entry)
        yield from _theorems(raw, path, entry)
        if "where" in entry:
            yield from _where(raw, dotted((*path, "where"), raw), entry["where"])


def _labels(raw: Mapping[str, Any], path: Path, entry: Mapping[str, Any]) -> Iterator[Problem]:
    labels = [label for _, label, _ in controllers(raw) if label]
    for name in ("controller", "than"):
        label = entry.get(name)
        if isinstance(label, str) and label and labels and label not in labels:
            found = f"no controller labelled {quote(label)}"
            yield Problem(dotted((*path, name), raw), found, ", ".join(labels), nearest(label, labels))
    if entry.get("kind") == "better" and isinstance(entry.get("than"), str):
        own = entry.get("controller")
        if own == entry["than"]:
            others = ", ".join(label for label in labels if label != own) or "another controller"
            yield Problem(dotted((*path, "than"), raw), f"{quote(str(own))}, the same as controller", others)


def _theorems(raw: Mapping[str, Any], path: Path, entry: Mapping[str, Any]) -> Iterator[Problem]:
    kind, guaranteed = entry.get("kind"), entry.get("only_where_guaranteed") is True
    key = dotted((*path, "only_where_guaranteed"), raw)
    if guaranteed and kind == "guarantee":
        yield Problem(key, "true, with which the claim could not fail", "false, or a claim of another kind")
        return
    if guaranteed and "controller" not in entry:
        yield Problem(
            key, "true, but no controller whose guarantee is meant", "false, or a controller as well"
        )
    if not guaranteed and kind not in ("below_bound", "guarantee"):
        return
    laws = {label: law.get("kind") for _, label, law in controllers(raw)}
    label = entry.get("controller")
    if isinstance(label, str) and laws.get(label, "robust_kinematic") not in KINDS_WITH_THEOREM:
        able = [name for name, law in laws.items() if law in KINDS_WITH_THEOREM]
        found = f"{quote(label)}, a law without a theorem and so without a guarantee"
        allowed = ", ".join(able) or "a claim of another kind, as no controller here has a theorem"
        yield Problem(dotted((*path, "controller"), raw), found, allowed)


def _where(raw: Mapping[str, Any], place: str, table: Any) -> Iterator[Problem]:
    conditions, problems = read_where(table, place)
    yield from problems
    sweep = raw.get("sweep", {})
    swept = swept_keys(sweep)
    axes = {axis.key: axis for axis in read_axes(sweep)[0]}
    for condition in conditions:
        if condition.key not in swept:
            allowed = ", ".join(swept) or "no where, as nothing is swept"
            hint = nearest(condition.key, swept)
            yield Problem(f"{place}.{condition.key}", "a key that is not swept", allowed, hint)
        elif condition.key in axes:
            yield from _values(f"{place}.{condition.key}", condition, axes[condition.key])


def _values(key: str, condition: Condition, axis: Axis) -> Iterator[Problem]:
    """Tell of values that no world has: a claim about them would say nothing."""
    allowed = f"values of the sweep, {_listed(list(axis))}"
    if not isinstance(condition.values, tuple):
        if not any(map(condition.holds, axis)):
            yield Problem(key, f"{condition.values}, which no world has", allowed)
        return
    for value in condition.values:
        if not any(map(Condition(condition.key, (value,)).holds, axis)):
            close = min(axis, key=lambda swept: abs(swept - value))
            yield Problem(key, f"{value:g}, which no world has", allowed, f"{close:g}")


def _listed(values: list[float]) -> str:
    texts = [f"{value:g}" for value in values]
    return ", ".join(texts if len(texts) <= 20 else [*texts[:10], "…", *texts[-3:]])
