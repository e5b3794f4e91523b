"""``slipctl study paper``: figures, numbers, page."""

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from slipctl.cli import main
from slipctl.study import figures, page, style
from slipctl.study.runs import StudyRun
from slipctl.study.targets import TARGETS, Target

ROOT = Path(__file__).resolve().parents[2]
NUMBERED = (*range(3, 13), 14, 15, 16)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """A quick study, run once: its folder, its page and what it printed."""
    place = tmp_path_factory.mktemp("study")
    written = place / "docs" / "reproduction.md"
    with pytest.MonkeyPatch.context() as patch:
        lines = []
        patch.setattr("builtins.print", lambda *values, **_: lines.append(" ".join(map(str, values))))
        assert main(["study", "paper", "--quick", "--json", "--out", str(place), "--page", str(written)]) == 0
    (printed,) = lines
    return place / "study-paper", written, json.loads(printed)


def test_every_figure_is_there_as_png_and_svg(quick):
    folder, _, _ = quick
    names = {f"figure-{number:02d}.{kind}" for number in NUMBERED for kind in ("png", "svg")}
    assert {path.name for path in (folder / "figures").iterdir()} == names
    for name in names:
        path = folder / "figures" / name
        if path.suffix == ".png":
            with Image.open(path) as image:
                image.load()
                assert image.width == pytest.approx(style.WIDTH * 100, abs=2)
                assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 50
        else:
            assert ElementTree.parse(path).getroot().tag.endswith("svg")
            assert "<dc:date>" not in path.read_text(encoding="utf-8")


def test_what_is_printed_is_what_is_written(quick):
    folder, _, printed = quick
    assert json.loads((folder / "numbers.json").read_text(encoding="utf-8")) == printed
    assert [entry["figure"] for entry in printed["figures"]] == list(NUMBERED)
    assert printed["quick"] is True


def test_every_target_stands_in_the_page_with_its_measured_number(quick):
    folder, written, printed = quick
    text = written.read_text(encoding="utf-8")
    assert text == (folder / "reproduction.md").read_text(encoding="utf-8")
    rows = [
        line.strip("| ").split(" | ") for line in text.splitlines() if re.match(r"\| (kin|dyn)\w+, ", line)
    ]
    assert len(rows) == len(printed["targets"]) == len(TARGETS)
    for (case, name, target, found, *_), row in zip(rows, printed["targets"], strict=True):
        assert case == row["case"].replace("/", ", ")
        assert name == f"{page.QUANTITIES[row['quantity']]} [{row['unit']}]"
        assert float(target.removeprefix("≤ ")) == row["target"]
        if row["measured"] is None:
            assert found == "–"
        else:
            digits = len(found.partition(".")[2])
            assert float(found) == pytest.approx(row["measured"], abs=0.51 * 10**-digits)
    assert "no number here means anything" in text


def test_other_tables_hold_the_numbers_of_the_runs(quick):
    _, written, printed = quick
    text = written.read_text(encoding="utf-8")
    for row in printed["feedback"]:
        cells = [
            f"{row['signal']}: {row['source']}",
            row["law"],
            *map(page_number, (row["rms_mm"], row["max_mm"])),
        ]
        assert " | ".join(cells) in text


def page_number(value):
    return f"{value:.1f}" if value >= 9.995 else f"{value:.2f}"


def test_the_pictures_of_a_page_lie_beside_it(quick):
    _, written, _ = quick
    assert_pictures(written)


def assert_pictures(written):
    links = re.findall(r"!\[Figure (\d+)\]\((.*?)\)", written.read_text(encoding="utf-8"))
    assert [int(number) for number, _ in links] == list(NUMBERED)
    for _, link in links:
        assert (written.parent / link).stat().st_size <= 60_000
    assert {path.suffix for path in (written.parent / "figures").iterdir()} == {".png"}


def test_the_committed_page_is_that_of_a_whole_study():
    written = ROOT / "docs" / "reproduction.md"
    assert_pictures(written)
    text = written.read_text(encoding="utf-8")
    assert "quick run" not in text
    assert "| differs |" not in text
    for target in TARGETS:
        assert f"{page.QUANTITIES[target.quantity]} [{target.unit}]" in text


@pytest.mark.parametrize("option", ["--out", "--page"])
def test_what_cannot_be_written_is_said_before_anything_runs(option, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("slipctl.study.paper._run", lambda *_: pytest.fail("it ran"))
    blocked = tmp_path / "file"
    blocked.write_text("")
    other = {"--out": ["--page", str(tmp_path / "p.md")], "--page": ["--out", str(tmp_path)]}[option]
    assert main(["study", "paper", option, str(blocked / "inside"), *other]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert str(blocked) in err
    assert "name another with" in err
    assert not list(tmp_path.glob("study-paper*"))


def test_an_interrupted_study_leaves_nothing(tmp_path, capsys, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.study.paper._run", interrupt)
    page_file = tmp_path / "docs" / "page.md"
    assert main(["study", "paper", "--out", str(tmp_path / "runs"), "--page", str(page_file)]) == 130
    assert "nothing was written" in capsys.readouterr().err
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_page_that_is_a_folder_is_refused(tmp_path, capsys):
    assert main(["study", "paper", "--out", str(tmp_path), "--page", str(tmp_path)]) == 2
    assert "is a folder" in capsys.readouterr().err


def test_the_same_runs_give_the_same_bytes(tmp_path):
    runs = {"kinematic": {label: synthetic(shift) for label, shift in (("nominal", 0.05), ("paper", 0.0))}}
    written = []
    for name in ("one", "other"):
        folder = tmp_path / name
        folder.mkdir()
        drawn = figures.draw_all(runs, folder)
        assert [picture.number for picture in drawn] == [3, 4, 5, 6, 7]
        written.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert len(written[0]) == 10
    assert written[0] == written[1]


def test_laws_have_their_colours(tmp_path):
    """The desired path is grey, the nominal law orange, the robust one green, here and in recordings."""
    figure = figures.paths(False)(synthetic(0.05), synthetic(0.0))
    colours = {line.get_label(): line.get_color() for line in figure.axes[0].get_lines()}
    assert colours == {"desired": style.DESIRED, "nominal": "#E69F00", "robust": "#009E73"}
    nominal = next(line for line in figure.axes[0].get_lines() if line.get_label() == "nominal")
    np.testing.assert_allclose(np.asarray(nominal.get_xdata()), np.linspace(0.0, 1.0, 50) + 0.05)


def synthetic(shift):
    """A straight run of one second, `shift` off to the right."""
    time = np.linspace(0.0, 1.0, 50)
    zero = np.zeros_like(time)
    columns = {f"{name}.{axis}": time for name in ("reference.position", "motion.position") for axis in "xy"}
    columns |= {"motion.position.x": time + shift, "time": time, "slip.longitudinal": 0.4 * time}
    columns |= {"motion.forward_speed": time, "motion.heading": zero + shift, "reference.heading": zero}
    columns |= {f"decision.{term}_input.{axis}": time for term in ("nominal", "robust") for axis in "xy"}
    return StudyRun("", "completed", {}, columns)


def test_a_target_is_met_within_one_per_cent_or_half_its_last_digit():
    assert Target("a", "b", 17.3, "mm").met(17.3 * 1.0099)
    assert not Target("a", "b", 17.3, "mm").met(17.3 * 1.02)
    assert Target("a", "b", 0.09, "mm").met(0.0949)
    assert not Target("a", "b", 0.09, "mm").met(0.0951)
    assert Target("a", "b", 0.06, "N·m", upper=True).met(0.01)
    assert not Target("a", "b", 0.06, "N·m", upper=True).met(0.07)


def test_every_target_says_where_it_comes_from():
    assert {target.source for target in TARGETS} == {"derived independently"}
    assert len({(target.case, target.quantity) for target in TARGETS}) == len(TARGETS)
