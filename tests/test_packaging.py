"""The wheel: what is in it, and that it works far from the checkout."""

import json
import os
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

from tests.fakes import SHORT_SCENARIO

ROOT = Path(__file__).resolve().parent.parent
DATA = (".toml", ".xml", ".json", ".parquet")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build a wheel with hatchling itself: no build isolation, so no network."""
    folder = tmp_path_factory.mktemp("dist")
    code = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
    subprocess.run([sys.executable, "-c", code, str(folder)], cwd=ROOT, check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Programs of a clean environment: the wheel, and a path file that leads to the dependencies."""
    place = tmp_path_factory.mktemp("clean")
    venv.create(place, with_pip=True, symlinks=os.name != "nt")
    programs = place / ("Scripts" if os.name == "nt" else "bin")
    (packages,) = place.glob("[Ll]ib/site-packages" if os.name == "nt" else "lib/python*/site-packages")
    install = [programs / "python", "-m", "pip", "install", "-q", "--no-deps", "--no-index", wheel]
    subprocess.run(install, check=True, capture_output=True)
    assert (packages / "slipctl").is_dir()
    # A path file adds these folders but does not read the path files in them: the dependencies come along,
    # the editable installation of the checkout does not.
    entries = [entry for entry in sys.path if entry.endswith(("site-packages", "dist-packages"))]
    (packages / "dependencies.pth").write_text("\n".join(entries) + "\n")
    return programs


def call(installed, folder, *arguments):
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"CI": "1"}
    command = [str(installed / "python"), "-m", "slipctl.cli", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, encoding="utf-8")


def shipped(kind):
    """Files of a data folder, as they stand in the checkout."""
    return {path.relative_to(ROOT).as_posix() for path in (ROOT / kind).rglob("*.*") if path.suffix in DATA}


def test_models_scenarios_and_baselines_are_inside(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    data = shipped("models") | shipped("scenarios")
    assert {"models/magellan_pro.xml", "scenarios/friction-sweep.toml"} <= data
    assert {f"slipctl/{name}" for name in data} <= names


def test_the_wheel_holds_every_module_and_nothing_else(wheel):
    names = {name for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".py")}
    assert names == {path.relative_to(ROOT).as_posix() for path in (ROOT / "slipctl").rglob("*.py")}
    tops = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert tops == {"slipctl", f"slipctl-{version()}.dist-info"}


def test_the_wheel_tells_pytest_of_the_plugin(wheel):
    archive = zipfile.ZipFile(wheel)
    (name,) = (name for name in archive.namelist() if name.endswith("entry_points.txt"))
    assert "[pytest11]\nslipctl = slipctl.pytest_plugin" in archive.read(name).decode()


def version():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]


def test_the_installed_code_is_that_of_the_wheel(installed, tmp_path):
    code = "import slipctl; print(slipctl.__file__)"
    where = subprocess.run(
        [installed / "python", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert Path(where.stdout.strip()).is_relative_to(installed.parent)


def test_shipped_scenarios_are_found_from_any_folder(installed, tmp_path):
    ended = call(installed, tmp_path, "scenario", "list")
    assert ended.returncode == 0, ended.stderr
    names = [line.split()[0] for line in ended.stdout.splitlines()]
    assert names == sorted(path.stem for path in (ROOT / "scenarios").glob("*.toml"))


def test_a_short_run_works_from_any_folder(installed, tmp_path):
    """The shipped friction sweep with its shipped model, cut to a tenth of a second."""
    made = call(installed, tmp_path, "scenario", "new", "short.toml", "--like", "friction-sweep")
    assert made.returncode == 0, made.stderr
    file = tmp_path / "short.toml"
    lines = file.read_text().splitlines()
    lines.insert(next(i for i, line in enumerate(lines) if line.startswith("tick")), "duration = 0.1")
    file.write_text("\n".join(lines))
    ended = call(installed, tmp_path, "run", "short.toml", "--json", "--record", "worst:1")
    assert ended.returncode == 0, ended.stderr
    runs = json.loads(ended.stdout)["runs"]
    assert {run["controller"] for run in runs} == {"nominal_kinematic", "robust_kinematic"}
    assert len(list((tmp_path / "runs" / "short").glob("*.rrd"))) == 1


def test_the_program_is_installed_under_its_name(installed, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT_SCENARIO)
    command = [str(installed / "slipctl"), "run", "short.toml", "--quiet", "--record", "none"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")
