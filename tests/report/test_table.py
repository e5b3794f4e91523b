"""The terminal table: what it marks, how it aligns, and that it fits."""

import pytest

from slipctl.report.table import number_text, results
from tests.fakes import payload, run_entry


def laid_out(runs, end_times=None):
    return [line.plain for line in results(payload(runs), end_times)]


def row(lines, value):
    return next(line for line in lines if line.split() and line.split()[0] == value)


TWO = [
    run_entry("nominal_kinematic", 0.1, 0.9, "left_the_arena"),
    run_entry("robust_kinematic", 0.1, 1.4),
    run_entry("nominal_kinematic", 0.8, 0.00134),
    run_entry("robust_kinematic", 0.8, 0.00084),
]


def test_the_smallest_error_of_each_world_is_marked_and_only_that():
    dry = row(laid_out(TWO), "0.8").split()
    assert dry == ["0.8", "1.34", "4.02", "0.67", "1.23", "ok", "0.84*", "2.52*", "0.42*", "1.23", "ok"]


def test_a_run_that_ended_early_is_never_the_best_and_says_when():
    ice = row(laid_out(TWO, [3.21] * 4), "0.1")
    assert "900!" in ice
    assert "left at 3.2 s" in ice
    assert "1400*" in ice


def test_colour_says_nothing_that_signs_do_not():
    for line in results(payload(TWO)):
        for span in line.spans:
            if "red" in str(span.style) or "green" in str(span.style):
                assert line.plain[span.start : span.end].strip()[-1] in "*!–t"  # "left" ends in t


def test_two_controllers_that_lose_control_fit_a_terminal_of_100_columns():
    names = ("nominal_kinematic", "robust_kinematic")
    runs = [run_entry(name, mu, 3.3, "left_the_arena") for mu in (0.05, 0.8) for name in names]
    assert max(map(len, laid_out(runs, [12.34] * 4))) <= 100


def test_columns_stand_under_their_titles():
    lines = laid_out(TWO)
    title = next(line for line in lines if line.startswith("ground.friction"))
    dry = row(lines, "0.8")
    for name, value in (("RMS", "1.34"), ("max", "4.02"), ("final", "0.67"), ("slip", "1.23")):
        assert title.index(name) + len(name) == dry.index(value) + len(value)


def test_each_controller_is_told_where_it_keeps_to_its_path():
    frictions = (0.05, 0.1, 0.2, 0.4, 0.8)
    errors = {"a": (1.0, 0.001, 0.001, 1.0, 0.001), "b": (1.0, 1.0, 1.0, 1.0, 1.0)}
    runs = [run_entry(name, mu, errors[name][i]) for i, mu in enumerate(frictions) for name in errors]
    text = "\n".join(laid_out(runs))
    assert "a stays within 100 mm of the path in 3 of 5 worlds: ground.friction 0.1 to 0.2, 0.8" in text
    assert "b stays within 100 mm of the path in 0 of 5 worlds\n" in text + "\n"


def test_a_single_world_has_one_row_per_controller():
    lines = laid_out([run_entry(name, rms=rms, varied={}) for name, rms in (("a", 0.01), ("b", 0.02))])
    assert row(lines, "a").split()[1] == "10.0*"
    assert row(lines, "b").split()[1] == "20.0"


def test_worlds_that_differ_only_in_the_seed_show_it():
    lines = laid_out([run_entry("a", seed=seed) for seed in (4, 5)])
    assert "seed" in lines[1]
    assert [line.split()[1] for line in lines if line.split()[:1] == ["0.8"]] == ["4", "5"]


def test_more_than_two_controllers_go_on_below():
    lines = laid_out([run_entry(name, mu) for mu in (0.1, 0.8) for name in ("a", "b", "c")])
    assert sum(line.startswith("ground.friction") for line in lines) == 2
    assert sum(line.split()[:1] == ["0.8"] for line in lines) == 2


def test_a_number_that_is_not_finite_is_a_dash():
    lines = laid_out(
        [run_entry("a", 0.1, None, "diverged"), run_entry("b", 0.1), run_entry("a"), run_entry("b")]
    )
    assert row(lines, "0.1").split()[1:4] == ["–", "–", "–"]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (2205.4, "2205"),
        (99.96, "100"),
        (17.34, "17.3"),
        (9.996, "10.0"),
        (0.874, "0.87"),
        (0.0, "0.00"),
        (0.0004, "4e-04"),
    ],
)
def test_three_digits_that_matter(value, text):
    assert number_text(value) == text
