"""The page *Run info*: what was run, how it went, and what the pictures mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from slipctl.view.colours import Rgb
from slipctl.view.content import world_title
from slipctl.view.ground import floor_words
from slipctl.view.scene import NESTING, Scales
from slipctl.view.theorem import page
from slipctl.view.tracks import PLOT_RATE, SCENE_RATE, Track

HIGHER_IS_BETTER = ("guarantee_fraction", "min_forward_speed")


def markdown(
    tracks: Sequence[Track],
    info: Mapping[str, Any],
    scales: Scales,
    colours: Mapping[str, Rgb],
    strides: Mapping[str, int],
) -> str:
    """Return the page as Markdown.

    Parameters
    ----------
    tracks : sequence of Track
        The runs, side by side in the table; the best value of a row is bold.
    info : mapping
        As for `slipctl.view.write_recording`.
    scales : Scales
        Lengths of the arrows.
    colours : mapping
        Colour of each label.
    strides : mapping
        Stride of each label's plots.
    """
    lines = [f"# {world_title(info)}", ""]
    if info.get("description"):
        lines += [str(info["description"]), ""]
    lines += [*_metrics_table(tracks, info.get("units") or {}), ""]
    lines += page(tracks)
    lines += floor_words(info)
    lines += ["## Reading the pictures", ""]
    lines.append(
        "* Colours: "
        + ", ".join(f"{_colour_word(colours[track.info.label])}: {track.name}" for track in tracks)
    )
    lines.append("* Grey is the reference; the pole with a ball is where the robot should be now")
    lines += [f"* {text[0].upper()}{text[1:]}" for text in arrow_words(scales)]
    lines += ["* Lateral slip is positive to the right; the lateral force is positive to the left"]
    lines += ["* Wide pale lines are bounds; of the wheel rates the wide line is what happened, the thin one"]
    lines += ["  what was commanded"]
    if len(tracks) > 1:
        lines += [
            f"* Each further robot is drawn {NESTING:.0%} slimmer, so that robots in the same place all show"
        ]
    lines += [""]
    lines += ["## Rows kept", ""]
    for label, step in strides.items():
        share = (
            "every row"
            if step == 1
            else f"every {step}th row and the last (more than {PLOT_RATE:.0f} a second)"
        )
        lines.append(f"* {label}: {share}, values bit for bit")
    lines += [f"* 3D at {SCENE_RATE:.0f} rows a second at most, in single precision", ""]
    lines += ["## Identity", ""]
    for key in ("scenario_id", "model_id", "seed"):
        if info.get(key) is not None:
            lines.append(f"* {key}: `{info[key]}`")
    lines += [f"* {name} {version}" for name, version in (info.get("versions") or {}).items()]
    return "\n".join(lines) + "\n"


def arrow_words(scales: Scales) -> list[str]:
    """Return the scales of the arrows in words, for the page and for the names of views."""
    words = [f"slip arrow {scales.slip:g} m per m/s"]
    if scales.traction is not None:
        words.append(f"traction arrow 1 m per {scales.traction:g} N (yellow: slides)")
    return words


def _metrics_table(tracks: Sequence[Track], units: Mapping[str, str]) -> list[str]:
    labels = [track.info.label for track in tracks]
    rows = [
        "| | " + " | ".join(labels) + " |",
        "|---|" + "---:|" * len(labels),
        "| status | " + " | ".join(track.info.status.replace("_", " ") for track in tracks) + " |",
    ]
    names = list(dict.fromkeys(name for track in tracks for name in track.info.metrics))
    for name in names:
        values = [track.info.metrics.get(name) for track in tracks]
        unit = units.get(name, "")
        title = name.replace("_", " ") + (f" [{unit}]" if unit not in ("", "1") else "")
        rows.append(f"| {title} | " + " | ".join(_cells(name, values)) + " |")
    return rows


def _cells(name: str, values: Sequence[float | None]) -> list[str]:
    shown = ["–" if value is None else f"{value:.4g}" for value in values]
    present = [value for value in values if value is not None]
    if len(set(present)) < 2:
        return shown
    best = max(present) if name in HIGHER_IS_BETTER else min(present)
    return [f"**{text}**" if value == best else text for text, value in zip(shown, values, strict=True)]


def _colour_word(colour: Rgb) -> str:
    words = {
        (0xE6, 0x9F, 0x00): "orange", (0x00, 0x9E, 0x73): "green", (0x56, 0xB4, 0xE9): "sky blue",
        (0xCC, 0x79, 0xA7): "pink", (0xF0, 0xE4, 0x42): "yellow",
    }  # fmt: skip
    return words.get(colour, "#{:02X}{:02X}{:02X}".format(*colour))
