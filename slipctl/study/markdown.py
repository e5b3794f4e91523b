"""Tables and numbers in Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence


def table(titles: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int] = ()) -> list[str]:
    """Return a Markdown table; columns in `right` are aligned to the right."""
    rule = ["--:" if column in right else "---" for column in range(len(titles))]
    return [f"| {' | '.join(row)} |" for row in (titles, rule, *rows)]


def mm(value: float) -> str:
    """Write millimetres: one place, two below ten."""
    return f"{value:.1f}" if abs(value) >= 9.995 else f"{value:.2f}"


def signed(value: float) -> str:
    """Write a difference in millimetres with its sign."""
    return f"{value:+.2f}".replace("-", "−")


def number(value: float) -> str:
    """Write a parameter as short as it is, with a true minus sign."""
    return f"{value:g}".replace("-", "−")


def amount(value: float) -> str:
    """Write a number that may be small or large with three digits that matter."""
    return f"{value:.0f}" if abs(value) >= 99.95 else f"{value:#.3g}"


def prose(text: str) -> list[str]:
    """Return a paragraph as lines of even length, with an empty one after it."""
    return [*textwrap.wrap(" ".join(text.split()), 110, break_long_words=False, break_on_hyphens=False), ""]


def bullets(*texts: str) -> list[str]:
    """Return a list of points, with an empty line after it."""
    lines = []
    for text in texts:
        lines += textwrap.wrap(
            " ".join(text.split()),
            110,
            initial_indent="- ",
            subsequent_indent="  ",
            break_on_hyphens=False,
            break_long_words=False,
        )
    return [*lines, ""]
