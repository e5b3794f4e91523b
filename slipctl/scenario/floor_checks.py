"""The rules between the keys of patches, changes of the floor, pushes and the rest of a file."""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl.scenario.base import lookup
from slipctl.scenario.problems import Problem
from slipctl.scenario.structure import dotted
from slipctl.scenario.values import entries, has, natural_duration, value_at


def floor_problems(raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything wrong between patches, changes, pushes and the rest."""
    yield from _patches(raw)
    yield from _changes(raw)
    yield from _too_late(raw)


def _patches(raw: Mapping[str, Any]) -> Iterator[Problem]:
    creeps = has(raw, "ground", "creep_stiffness")
    for path, entry in entries(raw, "ground", "patch"):
        period, width = value_at(raw, *path, "period"), value_at(raw, *path, "width")
        if entry.get("kind") == "stripes" and period is not None and width is not None and width >= period:
            found = f"{width:g} m, not less than the period"
            yield Problem(dotted((*path, "width"), raw), found, f"a number < {period:g} [m], the period")
        if creeps and "film" in entry:
            allowed = "one of ground.creep_stiffness and films"
            yield Problem(dotted((*path, "film"), raw), "it together with ground.creep_stiffness", allowed)
    if _film_somewhere(raw) and lookup(raw, "ground", "patch"):
        if lookup(raw, "slip") is not None:
            found = "it together with [slip], whose floor moves under the film"
            yield Problem("ground.patch", found, "films on a floor with patches, or [slip]")
        if lookup(raw, "ground", "terrain") is not None:
            found = "it together with patches and a film, whose force is that of level floor"
            yield Problem("ground.terrain", found, "ground.terrain, or films on a floor with patches")
    if lookup(raw, "ground", "terrain") is not None and lookup(raw, "slip") is not None:
        found = "it together with [slip], whose moving floor is level"
        yield Problem("ground.terrain", found, "one of ground.terrain and [slip]")


def _film_somewhere(raw: Mapping[str, Any]) -> bool:
    floors = [*entries(raw, "ground", "patch"), *entries(raw, "ground", "change")]
    return has(raw, "ground", "film") or any("film" in entry for _, entry in floors)


def _changes(raw: Mapping[str, Any]) -> Iterator[Problem]:
    before, wet = None, has(raw, "ground", "film")
    for path, entry in entries(raw, "ground", "change"):
        place = dotted(path, raw)
        time = value_at(raw, *path, "time")
        if time is not None and before is not None and time <= before:
            allowed = f"a number > {before:g} [s]: changes stand in the order of time"
            yield Problem(f"{place}.time", f"{time:g}", allowed)
        before = time if time is not None else before
        dries = entry.get("dry") is True
        if not dries and "friction" not in entry and "film" not in entry:
            yield Problem(place, "no change", "friction, film, or dry = true")
        if dries and "film" in entry:
            yield Problem(f"{place}.film", "it together with dry = true", "one of film and dry = true")
        if dries and not wet:
            yield Problem(f"{place}.dry", "true where there is no film", "it after a film, or no dry")
        if "film" in entry and has(raw, "ground", "creep_stiffness"):
            allowed = "one of ground.creep_stiffness and films"
            yield Problem(f"{place}.film", "it together with ground.creep_stiffness", allowed)
        wet = ("film" in entry or wet) and not dries


def _too_late(raw: Mapping[str, Any]) -> Iterator[Problem]:
    duration = value_at(raw, "duration") if "duration" in raw else natural_duration(raw)
    if duration is None:
        return
    for names, key in ((("ground", "change"), "time"), (("disturbance",), "start")):
        for path, _ in entries(raw, *names):
            time = value_at(raw, *path, key)
            if time is not None and time >= duration:
                found = f"{time:g} s, when the run is over"
                yield Problem(dotted((*path, key), raw), found, f"a number < {duration:g} [s], the duration")
