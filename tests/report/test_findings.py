"""What the terminal says of findings: counted, in columns, within 80 of them."""

import io

import pytest
from rich.console import Console

from slipctl.regression import Verdict
from slipctl.report.findings import ORDER, lines, sentence
from tests.report.findings import EVERY_VERDICT, EXTRA, NO_BASELINE, STATUS, claim, finding


def shown(findings, width=80, **options):
    out = io.StringIO()
    console = Console(file=out, width=width, highlight=False)
    for line in lines("ice", findings, **options):
        console.print(line)
    return "".join(f"{line.rstrip()}\n" for line in out.getvalue().splitlines())


def test_every_verdict_there_is_is_counted_in_a_fixed_order():
    assert sorted(ORDER) == sorted(Verdict)


def test_the_same_is_only_counted():
    same = finding(verdict="same", current=0.0123)
    assert shown([same, same, claim("claim_held")]) == "ice: 2 same, 1 claim held\n"
    assert shown([]) == "ice: recorded for the first time\n"


def test_a_number_stands_in_columns_below_its_run():
    out = shown(
        [finding(), finding(metric="rms_heading_error", unit="rad")], since="commit abc of 2026-11-20"
    )
    assert out.splitlines() == [
        "ice: 2 worse",
        "  compared with commit abc of 2026-11-20",
        "  robust, ground.friction 0.16, seed 1",
        "    metric             baseline → current change tolerance verdict",
        "    rms position error 12.3 → 14.5 mm      +18 %  0.010 mm worse",
        "    rms heading error  0.705 → 0.831°      +18 %  0.00057° worse",
    ]


def test_the_columns_of_all_runs_stand_below_each_other_and_have_one_heading():
    out = shown([finding(), finding(seed=2, metric="max_position_error"), finding(seed=3)]).splitlines()
    assert len([line for line in out if "tolerance" in line]) == 1
    assert len({line.index("mm") for line in out if " mm " in line and "→" in line}) == 1


@pytest.mark.parametrize("metric", ["rms_cross_track_error", "guarantee_fraction"])
def test_the_widest_numbers_fit_80_columns_on_one_line(metric):
    rows = shown([finding(metric=metric, baseline=0.01, current=0.0100000123, tolerance=1e-8)]).splitlines()
    assert max(map(len, rows)) <= 80
    assert "10.000000 → 10.000012 mm" in rows[-1]
    assert rows[-1].endswith("worse")


def test_what_has_no_number_is_a_sentence():
    out = shown([STATUS, EXTRA, NO_BASELINE], width=200)
    assert "robust, ground.friction 0.16, seed 1: status changed: completed → left the arena\n" in out
    assert "robust, ground.friction 0.16, seed 1: extra (not in the baseline)\n" in out
    assert "not judged: no baseline\n" in out


def test_a_claim_is_told_with_its_interval():
    out = shown([claim("claim_failed")], width=200)
    assert out.startswith("ice: 1 claim failed\n")
    assert "claim failed: robust better than nominal by a factor 3" in out
    assert "measured 2.10 (1.90 to 2.30), required 3.00" in out
    assert "compared with" not in shown([claim("claim_failed")], since="commit abc")


def test_many_numbers_that_share_a_note_say_it_once():
    out = shown([finding(verdict="chaotic", note="it says nothing", seed=seed) for seed in range(5)])
    assert out.count("it says nothing") == 1


def test_what_is_better_asks_to_be_recorded_unless_it_just_was():
    assert "record it with --update" in shown([finding(verdict="better")])
    assert "record it with" not in shown([finding(verdict="better")], updated=True)
    assert "record it with" not in shown([finding(verdict="better"), finding()])  # that would record the rest


def test_a_difference_has_its_interval_in_the_table():
    mean = finding(
        metric="rms_cross_track_error", baseline=0.01394, current=0.01405, tolerance=1.4e-8,
        interval=[0.075e-3, 0.168e-3],
    )  # fmt: skip
    (row,) = [line for line in shown([mean], width=80).splitlines() if "cross-track" in line]
    assert row.split("mm", 1)[1].split() == ["0.075", "to", "0.168", "mm", "1.4e-05", "mm", "worse"]


def test_a_sentence_says_everything_in_one_line():
    assert sentence(finding()) == (
        "ice: robust, ground.friction 0.16, seed 1: worse: "
        "rms_position_error 12.3 → 14.5 mm (+18 %), tolerance 0.010 mm"
    )
    assert sentence(NO_BASELINE) == "ice: not judged: no baseline"
    for entry in EVERY_VERDICT:
        said = sentence(entry)
        assert said.startswith("ice: ")
        assert "\n" not in said
        assert "None" not in said


def test_a_swept_seed_is_named_once():
    assert sentence(finding(varied={"seed": 4}, seed=4)).count("seed") == 1
