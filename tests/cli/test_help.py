"""The command set and its help."""

import subprocess
import sys

import pytest

from slipctl.cli import main

COMMANDS = (
    ["run"],
    ["sweep"],
    ["view"],
    ["check"],
    ["certify"],
    ["inspect"],
    ["scenario", "list"],
    ["scenario", "new"],
    ["scenario", "schema"],
    ["study", "paper"],
    ["study", "rungs"],
)


@pytest.mark.parametrize("command", [[], *COMMANDS], ids=" ".join)
def test_every_command_has_help_with_an_example(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    assert main([*command, "--help"]) == 0
    out = capsys.readouterr().out
    assert "Example: slipctl " + " ".join(command) in out


def test_the_version_is_that_of_the_package(capsys):
    from importlib.metadata import version

    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"slipctl {version('slipctl')}\n"


def test_help_imports_none_of_the_heavy_packages():
    code = (
        "import sys; from slipctl.cli import main; main(['--help']); "
        "heavy = {'numpy', 'scipy', 'mujoco', 'rerun', 'pyarrow', 'matplotlib', 'slipctl.scenario'}; "
        "heavy &= set(sys.modules); "
        "sys.exit(', '.join(sorted(heavy)) or 0)"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize(("arguments", "nearest"), [(["chek"], "check"), (["scenario", "lst"], "list")])
def test_an_unknown_command_names_the_nearest(arguments, nearest, capsys):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert nearest in err
