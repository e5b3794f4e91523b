"""``slipctl check``: every exit status, with an engine that answers what the test says."""

import json
import shlex
from collections import Counter

import pytest

from slipctl import shipped
from slipctl.cli import main
from slipctl.regression import read, write
from slipctl.scenario import load, scenario_id, worlds
from tests.fakes import MACHINE, SHORT_SCENARIO, FakeResult, baseline_of, payload, run_entry


class Bench:
    """A folder of scenarios with baselines, and an engine that gives the runs stored for each."""

    def __init__(self, folder):
        self.folder = folder
        self.runs = {}
        self.asked = []

    def add(self, name, *runs, recorded=True):
        file = self.folder / f"{name}.toml"
        file.write_text(SHORT_SCENARIO)
        self.runs[name] = runs
        if recorded:
            write(baseline_of(self.content(name)), self.baseline(name))
        return str(file)

    def ship(self, monkeypatch):
        """Make this folder the one of the shipped scenarios."""
        real = shipped._folder
        monkeypatch.setattr(
            shipped, "_folder", lambda name: self.folder if name == "scenarios" else real(name)
        )

    def baseline(self, name):
        return self.folder / "baselines" / f"{name}.json"

    def content(self, name):
        return payload(self.runs[name], name, scenario_id(load(self.folder / f"{name}.toml")))

    def run(self, scenario, **options):
        """Give every world of the scenario the stored runs, whatever was moved in it."""
        assert options["out"] is None
        assert options["record"] == "none"
        self.asked.append(tuple(axis.key for axis in scenario.sweep))
        content = self.content(scenario.name)
        content["runs"] = [
            {**run, "varied": {**run["varied"], **world.varied}}
            for world in worlds(scenario)
            for run in self.runs[scenario.name]
        ]
        return FakeResult(content)


@pytest.fixture
def bench(tmp_path, monkeypatch):
    bench = Bench(tmp_path)
    monkeypatch.setattr("slipctl.experiment.run", bench.run)
    return bench


def test_the_same_numbers_are_good(bench, capsys):
    ice = bench.add("ice", run_entry("a"), run_entry("b"))
    assert main(["check", ice]) == 0
    assert capsys.readouterr().out == "ice: 16 same\n"


def test_a_worse_number_fails_and_is_named_with_everything(bench, capsys):
    ice = bench.add("ice", run_entry("a", 0.1), run_entry("b", 0.1))
    bench.runs["ice"] = (run_entry("a", 0.1), run_entry("b", 0.1, rms=0.002))
    assert main(["check", ice]) == 1
    out = capsys.readouterr().out
    assert "ice: 4 worse, 12 same" in out
    assert "b, ground.friction 0.1, seed 1" in out
    assert "1.00 → 2.00 mm" in out
    assert "0.10 mm worse" in out
    assert "a, ground.friction" not in out
    assert main(["check", ice, "--quiet"]) == 1
    said = capsys.readouterr().err
    assert "ice: b, ground.friction 0.1, seed 1: worse: " in said
    assert "a, ground.friction" not in said


def test_a_better_number_is_good_and_asks_to_be_recorded(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    bench.runs["ice"] = (run_entry("a", rms=0.0001),)
    assert main(["check", ice]) == 0
    (said,) = [line for line in capsys.readouterr().out.splitlines() if "record it with" in line]
    words = shlex.split(said.partition("record it with ")[2])
    assert words == ["slipctl", "check", ice, "--update", "--reason", "…"]


def test_another_status_fails(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    bench.runs["ice"] = (run_entry("a", rms=0.0001, status="tipped"),)
    assert main(["check", ice]) == 1
    assert "status changed: completed → tipped" in capsys.readouterr().out


def test_json_holds_every_finding(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    bench.runs["ice"] = (run_entry("a", rms=0.002),)
    assert main(["check", ice, "--json"]) == 1
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert answer["passed"] is False
    assert Counter(entry["verdict"] for entry in answer["results"]) == {"worse": 4, "same": 4}
    assert answer["results"][1]["baseline"] == 0.001
    assert "rms_position_error" in err


def unjudgeable(bench, how):
    ice = bench.add("ice", run_entry("a"), recorded=how != "missing")
    path = bench.baseline("ice")
    if how == "cut off":
        path.write_text(path.read_text()[:100])
    elif how == "newer":
        path.write_text(path.read_text().replace('"format": 2', '"format": 3'))
    elif how == "older":
        path.write_text(path.read_text().replace('"format": 2', '"format": 1'))
    elif how == "spread over tolerance":
        path.write_text(path.read_text().replace('"spread": 1e-05', '"spread": 2e-4', 1))
    elif how == "another scenario":
        write(read(path).model_copy(update={"scenario_id": "sha256:other"}), path)
    elif how == "missing run":
        bench.runs["ice"] = ()
    elif how == "extra run":
        bench.runs["ice"] = (run_entry("a"), run_entry("b"))
    return ice


WAYS = [
    "missing", "cut off", "newer", "older", "spread over tolerance", "another scenario", "missing run",
    "extra run",
]  # fmt: skip


@pytest.mark.parametrize("how", WAYS)
def test_what_cannot_be_judged_is_exit_3_with_one_line(bench, capsys, how):
    ice = unjudgeable(bench, how)
    assert main(["check", ice, "--json"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert "ice" in err
    assert "Traceback" not in err


@pytest.mark.parametrize("how", WAYS)
def test_a_failed_gate_outweighs_what_could_not_be_judged(bench, capsys, how):
    ice = unjudgeable(bench, how)
    wet = bench.add("wet", run_entry("a"))
    bench.runs["wet"] = (run_entry("a", rms=0.1),)
    assert main(["check", ice, wet, "--json"]) == 1
    verdicts = {entry["verdict"] for entry in json.loads(capsys.readouterr().out)["results"]}
    assert "worse" in verdicts
    assert verdicts & {"missing", "extra", "unjudged"}
    bench.runs["wet"] = (run_entry("a"),)
    assert main(["check", wet, ice]) == 3


def test_another_engine_or_model_is_said_and_still_judged(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    path = bench.baseline("ice")
    other = {"slipctl": "0.1.0", "mujoco": "4.9.9"}
    write(read(path).model_copy(update={"versions": other, "model_id": "sha256:old"}), path)
    assert main(["check", ice]) == 0
    err = capsys.readouterr().err
    assert "mujoco 4.9.9 then, 4.0.0 now" in err
    assert "sha256:old then" in err
    assert len(err.splitlines()) == 1
    bench.runs["ice"] = (run_entry("a", rms=0.1),)
    assert main(["check", ice]) == 1


def test_without_names_every_scenario_with_a_baseline_is_checked(bench, monkeypatch, capsys):
    bench.add("ice", run_entry("a"))
    bench.add("wet", run_entry("a"))
    bench.add("new", run_entry("a"), recorded=False)
    bench.ship(monkeypatch)
    assert main(["check"]) == 0
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == ["ice", "wet"]


def test_no_baseline_at_all_is_exit_3(bench, monkeypatch, capsys):
    bench.ship(monkeypatch)
    assert main(["check"]) == 3
    assert "no scenario has a baseline" in capsys.readouterr().err


def test_a_misspelt_name_costs_no_run(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    assert main(["check", ice, "friction-swep"]) == 2
    assert "friction-sweep" in capsys.readouterr().err
    assert bench.asked == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--update"], "--update needs --reason"),
        (["--update", "--reason", " "], "--update needs --reason"),
        (["--reason", "why"], "--reason goes with"),
        (["--record", "--update", "--reason", "why"], "give one of them"),
        (["--record"], "to replace it, say why: slipctl check"),
        (["--record", "--reason", "why"], "to replace it, say why: slipctl check"),
    ],
)
def test_a_baseline_is_replaced_only_with_a_reason(bench, capsys, arguments, said):
    ice = bench.add("ice", run_entry("a"))
    before = bench.baseline("ice").read_bytes()
    assert main(["check", ice, *arguments]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert len(err.splitlines()) == 1
    if "say why" in said:
        assert named(err, "--update") == ice
    assert bench.baseline("ice").read_bytes() == before
    assert bench.asked == []


@pytest.mark.parametrize("option", ["--record", "--update"])
def test_nobody_records_all_scenarios_by_leaving_out_the_name(bench, monkeypatch, capsys, option):
    for name in "abcdefgh":
        bench.add(name, run_entry("a"))
    bench.ship(monkeypatch)
    before = bench.baseline("a").read_bytes()
    assert main(["check", option, "--reason", "why"]) == 2
    err = capsys.readouterr().err
    assert f"slipctl check SCENARIO {option}" in err
    assert ("a, b, c, d, e, f, …" in err) == (option == "--update")
    assert len(err.splitlines()) == 1
    assert bench.asked == []
    assert bench.baseline("a").read_bytes() == before


def test_record_refuses_before_anything_is_run(bench, capsys):
    wet = bench.add("wet", run_entry("a"), recorded=False)
    ice = bench.add("ice", run_entry("a"))
    assert main(["check", wet, ice, "--record"]) == 2
    assert "ice.json exists" in capsys.readouterr().err
    assert bench.asked == []
    assert not bench.baseline("wet").exists()


def test_update_records_shows_the_difference_and_moves_the_start(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    bench.runs["ice"] = (run_entry("a", rms=0.002),)
    assert main(["check", ice, "--update", "--reason", " a softer tyre "]) == 0
    out, err = capsys.readouterr()
    (row,) = (line for line in out.splitlines() if "rms position error" in line)
    assert " ".join(row.split()) == "rms position error 1.00 → 2.00 mm +100 % 0.10 mm → 2e-06 mm"
    assert "ice.json written" in err
    assert bench.asked == [(), ("start.x_offset",), ("start.y_offset",), ("start.heading_offset_deg",)]
    new = read(bench.baseline("ice"))
    assert new.reason == "a softer tyre"
    assert new.machine == MACHINE
    assert new.runs[0].metrics["rms_position_error"].value == 0.002
    assert main(["check", ice]) == 0


def test_update_of_what_has_not_changed_shows_no_table(bench, capsys):
    ice = bench.add("ice", run_entry("a"), recorded=False)
    assert main(["check", ice, "--record"]) == 0
    assert main(["check", ice, "--update", "--reason", "again"]) == 0
    out = capsys.readouterr().out
    assert out == "ice: 7 numbers of 1 run recorded\n" * 2
    assert read(bench.baseline("ice")).reason == "again"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--record"], "first record"),
        (["--record", "--reason", "why"], "why"),
        (["--update", "--reason", "x"], "x"),
    ],
)
def test_the_first_baseline_is_made(bench, capsys, arguments, reason):
    ice = bench.add("ice", run_entry("a"), recorded=False)
    assert main(["check", ice, *arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == {"passed": True, "results": []}
    assert len(err.splitlines()) == 1
    assert "ice.json written" in err
    assert read(bench.baseline("ice")).reason == reason
    assert bench.baseline("ice").with_name("ice.tracks.parquet").exists()
    assert main(["check", ice]) == 0


def test_another_family_of_processor_alone_is_said_and_judged(bench, capsys):
    ice = bench.add("ice", run_entry("a", rms=0.001))
    path = bench.baseline("ice")
    write(read(path).model_copy(update={"machine": MACHINE | {"family": "x86_64 Another 9"}}), path)
    bench.runs["ice"] = (run_entry("a", rms=0.00105),)
    assert main(["check", ice]) == 0
    err = capsys.readouterr().err
    assert "processor family x86_64 Another 9 then, x86_64 AVendor 1 now" in err
    assert "with the tolerances for elsewhere" in err
    assert len(err.splitlines()) == 1
    bench.runs["ice"] = (run_entry("a", rms=0.0013),)
    assert main(["check", ice]) == 1


def test_an_interrupted_check_is_exit_130_and_leaves_the_baseline(bench, monkeypatch, capsys):
    ice = bench.add("ice", run_entry("a"))
    before = bench.baseline("ice").read_bytes()
    stopped = FakeResult(bench.content("ice"), interrupted=True)
    monkeypatch.setattr("slipctl.experiment.run", lambda *_, **__: stopped)
    assert main(["check", ice, "--json"]) == 130
    capsys.readouterr()
    assert main(["check", ice, "--update", "--reason", "x"]) == 130
    out, err = capsys.readouterr()
    assert out == ""
    assert err == f"interrupted; {ice} was not recorded; the old baseline stands\n"
    assert bench.baseline("ice").read_bytes() == before
    bench.baseline("ice").unlink()
    assert main(["check", ice, "--record"]) == 130
    assert capsys.readouterr().err == f"interrupted; {ice} was not recorded\n"


def named(line, what):
    """Read the command in a message as a shell does, up to what is left open in it."""
    words = shlex.split(line[line.index("slipctl check ") :])
    assert words[:2] == ["slipctl", "check"]
    assert words[3] == what
    return words[2]


@pytest.mark.parametrize(
    ("how", "said", "option"),
    [
        ("missing", "no baseline", "--record"),
        ("folder", "a folder is in place of the baseline", "--record"),
        ("not text", "is damaged: it is not UTF-8 text", "--update"),
        ("cut off", "is damaged at", "--update"),
        ("another scenario", "is another scenario", "--update"),
    ],
)
def test_what_cannot_be_judged_says_what_to_do_for_this_scenario(bench, capsys, how, said, option):
    bench.folder = bench.folder / "my floors"
    bench.folder.mkdir()
    ice = bench.add("ice", run_entry("a"), recorded=how != "missing")
    path = bench.baseline("ice")
    if how == "folder":
        path.unlink()
        path.mkdir()
    elif how == "not text":
        path.write_bytes(b"\xff\xfe\x00")
    elif how == "cut off":
        path.write_bytes(path.read_bytes()[:50])
    elif how == "another scenario":
        write(read(path).model_copy(update={"scenario_id": "sha256:other"}), path)
    assert main(["check", ice, "--quiet"]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert named(line, option) == ice


def test_update_replaces_a_damaged_baseline_and_says_so(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    bench.baseline("ice").write_text("{")
    assert main(["check", ice, "--update", "--reason", "mend"]) == 0
    (note,) = [line for line in capsys.readouterr().err.splitlines() if "nothing to compare with" in line]
    assert named(note, "--update") == ice
    assert main(["check", ice]) == 0


CLAIM = """
[[expect]]
kind = "below"
controller = "{}"
metric = "rms_position_error"
limit = {}
"""


def claim(scenario, controller, limit):
    with open(scenario, "a", encoding="utf-8") as file:
        file.write(CLAIM.format(controller, limit))


@pytest.mark.parametrize("option", [["--record"], ["--update", "--reason", "why"]])
def test_a_claim_that_fails_at_recording_is_said_and_the_baseline_written(bench, capsys, option):
    ice = bench.add("ice", run_entry("nominal_kinematic"), recorded=False)
    claim(ice, "nominal_kinematic", 1e-5)
    assert main(["check", ice, *option]) == 1
    out, err = capsys.readouterr()
    assert "7 numbers of 1 run recorded" in out
    assert "ice: claim failed: rms_position_error of nominal_kinematic is at most 1e-05" in err
    assert "the baseline is written all the same" in err
    assert read(bench.baseline("ice")).runs[0].metrics["rms_position_error"].value == 0.001
    assert main(["check", ice, "--update", "--reason", "again", "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["passed"] is False
    assert "claim_failed" in {entry["verdict"] for entry in answer["results"]}


def test_a_claim_that_is_open_at_recording_is_exit_3(bench, capsys):
    ice = bench.add("ice", run_entry("another"), recorded=False)
    claim(ice, "nominal_kinematic", 1e-5)  # a law that this engine does not run
    assert main(["check", ice, "--record", "--json"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "claim open" in err
    assert bench.baseline("ice").exists()


def test_worse_numbers_and_claims_that_hold_are_good_to_record(bench, capsys):
    ice = bench.add("ice", run_entry("nominal_kinematic"))
    claim(ice, "nominal_kinematic", 0.1)
    bench.runs["ice"] = (run_entry("nominal_kinematic", rms=0.05),)
    assert main(["check", ice, "--update", "--reason", "why", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["passed"] is True
    assert {entry["verdict"] for entry in answer["results"]} == {"worse", "same", "claim_held"}


def test_two_scenarios_that_share_a_baseline_are_refused(bench, tmp_path, capsys):
    ice = bench.add("ice", run_entry("a"), recorded=False)
    copy = tmp_path / "copy.toml"
    copy.write_text('name = "ice"\n' + SHORT_SCENARIO, encoding="utf-8")
    assert main(["check", ice, str(copy), "--record"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{ice} and {copy} share the baseline {bench.baseline('ice')}")
    assert main(["check", ice, ice, "--record"]) == 2
    assert f"{ice} is named twice" in capsys.readouterr().err
    assert bench.asked == []
    assert not bench.baseline("ice").exists()


def test_no_baseline_is_recorded_where_one_of_them_cannot_be_written(bench, capsys):
    ice = bench.add("ice", run_entry("a"), recorded=False)
    (bench.folder / "other").mkdir()
    (bench.folder / "other" / "baselines").write_text("a file", encoding="utf-8")
    wet = bench.folder / "other" / "wet.toml"
    wet.write_text(SHORT_SCENARIO, encoding="utf-8")
    assert main(["check", ice, str(wet), "--record"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("cannot write the baseline ")
    assert bench.asked == []
    assert not bench.baseline("ice").exists()


def drift(bench, monkeypatch, name):
    """Let each run of a scenario give other numbers than the one before."""

    def run(scenario, **options):
        if scenario.name == name:
            bench.runs[name] = (run_entry("a", rms=0.001 + 1e-5 * len(bench.asked)),)
        return bench.run(scenario, **options)

    monkeypatch.setattr("slipctl.experiment.run", run)


def test_a_law_that_gives_another_number_each_time_is_not_recorded(bench, monkeypatch, capsys):
    ice, wet = bench.add("ice", run_entry("a")), bench.add("wet", run_entry("a"))
    before = bench.baseline("ice").read_bytes()
    drift(bench, monkeypatch, "ice")
    assert main(["check", ice, wet, "--update", "--reason", "why", "--json"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    first, second = err.splitlines()
    assert first.startswith("ice: a is not repeatable, so that nothing can be recorded: from the very same")
    assert first.endswith("; the old baseline stands")
    assert second.endswith("wet.json written")
    assert bench.baseline("ice").read_bytes() == before
    assert read(bench.baseline("wet")).reason == "why"


def test_an_interruption_says_what_became_of_the_baseline(bench, monkeypatch, capsys):
    ice, wet = bench.add("ice", run_entry("a")), bench.add("wet", run_entry("a"), recorded=False)

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("slipctl.experiment.run", interrupted)
    assert main(["check", ice, "--update", "--reason", "why"]) == 130
    assert capsys.readouterr().err == f"interrupted; {ice} was not recorded; the old baseline stands\n"
    assert main(["check", wet, "--record"]) == 130
    assert capsys.readouterr().err == f"interrupted; {wet} was not recorded\n"


def test_a_baseline_under_the_name_of_another_scenario_is_damaged(bench, capsys):
    ice = bench.add("ice", run_entry("a"))
    write(read(bench.baseline("ice")).model_copy(update={"scenario": "snow"}), bench.baseline("ice"))
    assert main(["check", ice, "--json"]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert "is damaged at scenario: it says snow, not ice" in line


def test_a_run_with_chaotic_numbers_only_is_said_at_every_check(bench, capsys):
    ice = bench.add("ice", run_entry("nominal_kinematic"))
    baseline = read(bench.baseline("ice"))
    (run,) = baseline.runs
    chaotic = {
        name: number.model_copy(
            update={"gate": "verdict", "spread": abs(number.value), "value": number.value}
        )
        for name, number in run.metrics.items()
        if number.value is not None
    }
    run = run.model_copy(update={"metrics": run.metrics | chaotic})
    write(baseline.model_copy(update={"runs": [run]}), bench.baseline("ice"))
    said = "ice: only the status of nominal_kinematic is judged in 1 run: all numbers are chaotic"
    for _ in range(2):
        assert main(["check", ice]) == 0
        assert said in capsys.readouterr().err
    claim(ice, "nominal_kinematic", 0.1)
    assert main(["check", ice]) == 0
    assert said not in capsys.readouterr().err
