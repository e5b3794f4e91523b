"""One colour per run: Okabe and Ito's palette, which colour-blind people can tell apart."""

from __future__ import annotations

from collections.abc import Sequence

from slipctl.view.content import RunInfo

Rgb = tuple[int, int, int]

REFERENCE: Rgb = (0xA0, 0xA0, 0xA0)
NOMINAL_INPUT: Rgb = (0x00, 0x72, 0xB2)
ROBUST_INPUT: Rgb = (0xD5, 0x5E, 0x00)
NOMINAL: Rgb = (0xE6, 0x9F, 0x00)
ROBUST: Rgb = (0x00, 0x9E, 0x73)
OTHERS: tuple[Rgb, ...] = ((0x56, 0xB4, 0xE9), (0xCC, 0x79, 0xA7), (0xF0, 0xE4, 0x42))


def lighter(colour: Rgb, share: float = 0.5) -> Rgb:
    """Return the colour mixed with white; `share` 1 is white."""
    red, green, blue = (round(part + (255 - part) * share) for part in colour)
    return red, green, blue


def darker(colour: Rgb, share: float = 0.5) -> Rgb:
    """Return the colour mixed with black; `share` 1 is black."""
    red, green, blue = (round(part * (1 - share)) for part in colour)
    return red, green, blue


def run_colours(runs: Sequence[RunInfo]) -> dict[str, Rgb]:
    """Return label → colour: the first nominal law orange, the first robust law green, then the rest.

    Where a world has more runs than the palette has colours they come again, lighter.
    """
    colours: dict[str, Rgb] = {}
    firsts = {"nominal": NOMINAL, "robust": ROBUST}
    for run in runs:
        family = next((name for name in firsts if (run.kind or run.label).startswith(name)), None)
        if family:
            colours[run.label] = firsts.pop(family)
    spare = [*OTHERS, *firsts.values()]
    for position, run in enumerate(run for run in runs if run.label not in colours):
        cycle, place = divmod(position, len(spare))
        colours[run.label] = lighter(spare[place], min(0.3 * cycle, 0.7))
    return colours
