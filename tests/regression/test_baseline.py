"""The baseline file: written whole, read strictly."""

import json

import pytest

from slipctl import shipped
from slipctl.regression import CannotJudge, read, write
from tests.fakes import baseline_of, payload, run_entry


@pytest.fixture
def baseline():
    return baseline_of(payload([run_entry("a", 0.1), run_entry("b", 0.1, None), run_entry("a", 0.8)]))


def test_what_is_written_is_read_back(baseline, tmp_path):
    path = tmp_path / "new" / "x.json"
    write(baseline, path)
    assert read(path) == baseline
    assert [entry.name for entry in path.parent.iterdir()] == ["x.json"]


def test_every_number_has_a_line_of_its_own(baseline, tmp_path):
    write(baseline, tmp_path / "x.json")
    lines = (tmp_path / "x.json").read_text(encoding="utf-8").splitlines()
    assert sum('"tolerance"' in line for line in lines) == 9
    assert all(line.count('"tolerance"') <= 1 for line in lines)


def test_a_failed_write_leaves_the_old_file(baseline, tmp_path, monkeypatch):
    path = tmp_path / "x.json"
    path.write_text("old")
    monkeypatch.setattr("slipctl.regression.baseline._text", lambda _: "\ud800")  # cannot be encoded
    with pytest.raises(UnicodeEncodeError):
        write(baseline, path)
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_missing_baseline_says_how_to_record_one(tmp_path):
    with pytest.raises(CannotJudge, match="slipctl check ice --update --reason"):
        read(tmp_path / "ice.json")


def damage(change):
    def apply(text):
        content = json.loads(text)
        change(content)
        return json.dumps(content)

    return apply


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda text: text[: len(text) // 2], "damaged"),
        (lambda text: "", "damaged"),
        (lambda text: "[]", "damaged"),
        (damage(lambda c: c.pop("scenario_id")), "scenario_id"),
        (damage(lambda c: c.update(format=2)), "format"),
        (damage(lambda c: c.update(extra=1)), "extra"),
        (damage(lambda c: c["runs"][0]["metrics"]["rms_position_error"].update(tolerance="x")), "tolerance"),
        (damage(lambda c: c.update(runs=[])), "no runs"),
        (damage(lambda c: c["runs"].append(c["runs"][0])), "the same run twice"),
    ],
)
def test_a_damaged_baseline_is_named_in_one_line(baseline, tmp_path, spoil, said):
    path = tmp_path / "x.json"
    write(baseline, path)
    path.write_text(spoil(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(CannotJudge, match=said) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_bytes_that_are_no_text_cannot_be_judged(tmp_path):
    (tmp_path / "x.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CannotJudge, match="cannot be read"):
        read(tmp_path / "x.json")


@pytest.mark.parametrize(
    ("planted", "where"),
    [
        (lambda metrics: metrics.clear(), "metrics"),
        (lambda metrics: metrics.pop("max_position_error"), "metrics"),
        (lambda metrics: metrics["rms_position_error"].update(tolerance=float("inf")), "tolerance"),
        (lambda metrics: metrics["rms_position_error"].update(tolerance=-1e-3), "tolerance"),
        (lambda metrics: metrics["rms_position_error"].update(value=float("nan")), "value"),
    ],
)
def test_a_baseline_that_could_never_fail_is_damaged(tmp_path, planted, where):
    """Each of these would have let any result pass."""
    shipped_one = json.loads((shipped.baseline_folder() / "wet-slope.json").read_text(encoding="utf-8"))
    planted(shipped_one["runs"][0]["metrics"])
    path = tmp_path / "planted.json"
    path.write_text(json.dumps(shipped_one), encoding="utf-8")
    with pytest.raises(CannotJudge, match=where):
        read(path)
