"""What is wrong with a scenario, said so that a person can put it right."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from json import dumps
from typing import Any


@dataclass(frozen=True)
class Problem:
    """One thing wrong.

    Attributes
    ----------
    key
        Dotted path of the key, e.g. `controller[1:robust_kinematic].slip_bound`; "" for the file itself.
    found
        What stands there.
    allowed
        What may stand there: a range, the choices, or what to do instead.
    nearest
        The valid name nearest to a misspelt one, if there is one.
    later
        True where the thing is meant to exist but comes with a later release.
    """

    key: str
    found: str
    allowed: str
    nearest: str | None = None
    later: bool = False

    def __str__(self) -> str:
        text = f"{self.key}: found {self.found}" if self.key else self.found
        if self.allowed:
            text += f"; {'available now' if self.later else 'allowed'}: {self.allowed}"
        if self.nearest:
            text += f"; did you mean {quote(self.nearest)}?"
        return text


class ScenarioError(Exception):
    """A scenario is refused; `str` of it lists everything that is wrong.

    Attributes
    ----------
    source : str
        The file (or what else was read).
    problems : tuple of Problem
        All problems found, in one go.
    """

    def __init__(self, source: str, problems: Iterable[Problem]) -> None:
        self.source = source
        self.problems = tuple(dict.fromkeys(problems))
        super().__init__(source, self.problems)

    def __str__(self) -> str:
        return "\n".join(f"{self.source}: {problem}" for problem in self.problems)


def later(key: str, what: str, available: Iterable[str]) -> Problem:
    """Make a problem of something that the file format names but this release does not have yet."""
    return Problem(
        key, f"{what}, which comes with a later release of slipctl", ", ".join(available), later=True
    )


def quote(text: str) -> str:
    """Text in quotes, control characters escaped."""
    return dumps(text, ensure_ascii=False)


def show(value: Any) -> str:
    """Spell a value the way TOML does, shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return quote(value if len(value) <= 60 else value[:57] + "…")
    if isinstance(value, Mapping):
        return f"a table with {', '.join(map(str, list(value)[:6]))}" if value else "an empty table"
    if isinstance(value, list | tuple):
        return f"an array of {len(value)}" if value else "an empty array"
    if isinstance(value, int) and abs(value) >= 10**20:
        return f"a whole number of {value.bit_length()} bits"
    return str(value)


def nearest(name: str, valid: Iterable[str]) -> str | None:
    """Find the valid name most like `name`, or None where none is like it."""
    scored = [(SequenceMatcher(None, name.lower(), other.lower()).ratio(), other) for other in valid]
    best = max(scored, default=(0.0, ""), key=lambda pair: pair[0])
    return best[1] if best[0] >= 0.6 else None


def unknown_keys(place: str, table: Iterable[str], allowed: Sequence[str]) -> list[Problem]:
    """Say of every key of a table at `place` that is none of `allowed` what it may have meant."""
    return [
        Problem(f"{place}.{name}", "an unknown key", ", ".join(allowed), nearest(name, allowed))
        for name in table
        if name not in allowed
    ]
