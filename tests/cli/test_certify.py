"""``slipctl certify``, and ``--require-certified`` on the commands that run."""

import json

import pytest

from slipctl.certify import certificate, examine
from slipctl.certify.certificate import key_of, store
from slipctl.cli import main
from tests.fakes import SHORT_SCENARIO

QUICK = ("mass", "rolling_radius", "sliding_isotropy")


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SLIPCTL_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def quick(monkeypatch):
    """Ask only a few questions."""
    few = tuple(fixture for fixture in certificate.FIXTURES if fixture.name in QUICK)
    assert len(few) == len(QUICK)
    monkeypatch.setattr(examine, "FIXTURES", few)


@pytest.fixture
def on_mujoco(tmp_path):
    """A tenth of a second on MuJoCo."""
    path = tmp_path / "short.toml"
    text = SHORT_SCENARIO.replace('kind = "kinematic_ode"', 'kind = "mujoco"').replace(
        "tick = 0.01", "tick = 0.01\nduration = 0.1"
    )
    path.write_text(text)
    return str(path)


def test_a_good_model_is_certified_against_closed_forms(quick, capsys):
    assert main(["certify"]) == 0
    out = capsys.readouterr().out
    assert "magellan_pro at 0.001 s is certified against closed forms: 3 of 3 fixtures" in out
    (line,) = (line for line in out.splitlines() if "rolling radius" in line)
    assert line.split()[:5] == ["ok", "rolling", "radius", "82.5", "82.5"]
    assert line.split()[5:9] == ["0", "%", "0.05", "%"]


def test_a_naive_model_fails_and_says_why(quick, capsys):
    assert main(["certify", "naive_magellan"]) == 1
    out = capsys.readouterr().out
    assert "is not certified against closed forms: 1 of 3 fixtures failed" in out
    assert 'use cone="elliptic"' in out
    assert "FAIL" in out


def test_machine_output_is_that_of_the_contract(quick, capsys):
    assert main(["certify", "naive_magellan", "--json"]) == 1
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert {"model", "model_id", "versions", "passed", "checks"} <= set(content)
    assert content["model"] == "naive_magellan"
    assert content["passed"] is False
    wanted = {"name", "measured", "expected", "error", "tolerance", "unit", "passed"}
    assert all(wanted <= set(check) for check in content["checks"])
    assert [check["name"] for check in content["checks"]] == list(QUICK)
    assert err.startswith("sliding_isotropy: ")


def test_what_changed_since_a_certificate_is_said(quick, tmp_path, capsys):
    assert main(["certify", "--json"]) == 0
    then = json.loads(capsys.readouterr().out)
    file = tmp_path / "then.json"
    file.write_text(json.dumps(then))
    assert main(["certify", "--against", str(file)]) == 0
    assert "nothing changed since that certificate" in capsys.readouterr().out
    then["versions"]["mujoco"] = "3.9.0"
    then["checks"][1]["measured"] = 82.51
    file.write_text(json.dumps(then))
    assert main(["certify", "--against", str(file), "--json"]) == 0
    changes = json.loads(capsys.readouterr().out)["changes"]
    assert [change.split(" then")[0] for change in changes] == ["mujoco 3.9.0", "rolling_radius: 82.51 mm"]


def test_wrong_input_is_exit_2(tmp_path, capsys):
    assert main(["certify", "no_such_robot"]) == 2
    assert "no_such_robot" in capsys.readouterr().err
    assert main(["certify", "--against", str(tmp_path / "none.json")]) == 2
    assert "no certificate at" in capsys.readouterr().err


def test_a_run_without_a_certificate_says_so_and_how_to_get_one(on_mujoco, tmp_path, capsys):
    assert main(["run", on_mujoco, "--out", str(tmp_path / "runs"), "--record", "none"]) == 0
    out = capsys.readouterr().out
    assert "magellan_pro: not yet certified against closed forms; slipctl certify magellan_pro does it" in out
    manifest = json.loads((tmp_path / "runs" / "short" / "manifest.json").read_text())
    assert manifest["certified"] == {
        "against": "closed forms",
        "state": "missing",
        "failed": [],
        "command": "slipctl certify magellan_pro",
    }


def test_a_certified_run_says_against_what(quick, on_mujoco, tmp_path, capsys):
    assert main(["certify", "-q"]) == 0
    arguments = ["run", on_mujoco, "--out", str(tmp_path / "runs"), "--record", "none", "--require-certified"]
    assert main(arguments) == 0
    assert "magellan_pro: certified against closed forms\n" in capsys.readouterr().out
    manifest = json.loads((tmp_path / "runs" / "short" / "manifest.json").read_text())
    assert manifest["certified"]["state"] == "passed"


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_missing_certificate_is_exit_3_where_one_is_required(
    command, on_mujoco, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main([command, on_mujoco, "--require-certified"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert (
        err == "magellan_pro: not yet certified against closed forms; slipctl certify magellan_pro does it\n"
    )
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_failed_certificate_is_exit_3_where_one_is_required(
    command, on_mujoco, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    check = {
        "name": "film_constant",
        "measured": 90.0,
        "error": 0.1,
        "tolerance": 1e-3,
        "unit": "",
        "passed": False,
    }
    store(key_of("magellan_pro", 0.001), {"checks": [check]})
    assert main([command, on_mujoco, "--require-certified"]) == 3
    assert "NOT certified against closed forms: film constant failed" in capsys.readouterr().err


def test_every_timestep_of_a_sweep_needs_its_certificate(quick, on_mujoco, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with open(on_mujoco, "a") as file:
        file.write("[sweep]\n'plant.timestep' = [0.001, 0.0005]\n")
    assert main(["certify", "-q"]) == 0
    assert main(["run", on_mujoco, "--require-certified"]) == 3
    assert main(["certify", "-q", "--timestep", "0.0005"]) == 0
    assert main(["run", on_mujoco, "--require-certified", "-q", "--record", "none"]) == 0


def test_a_plant_without_an_engine_needs_no_certificate(tmp_path, capsys):
    file = tmp_path / "short.toml"
    file.write_text(SHORT_SCENARIO)
    arguments = ["run", str(file), "--out", str(tmp_path / "runs"), "--record", "none", "--require-certified"]
    assert main(arguments) == 0
    assert "certified" not in capsys.readouterr().out
    assert json.loads((tmp_path / "runs" / "short" / "manifest.json").read_text())["certified"] is None
