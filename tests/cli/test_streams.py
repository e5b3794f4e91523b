"""What is said reaches every stream, whatever the system thinks of arrows."""

import io
import os
import subprocess
import sys

import pytest

from slipctl.cli import can_say_everything, main


class Terminal(io.TextIOWrapper):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("kind", "encoding", "written"),
    [
        (io.TextIOWrapper, "cp1252", "1 → 2 µ".encode()),
        (io.TextIOWrapper, "ascii", "1 → 2 µ".encode()),
        (io.TextIOWrapper, "utf-8", "1 → 2 µ".encode()),
        (io.TextIOWrapper, "utf-16-le", "1 → 2 µ".encode("utf-16-le")),
        (Terminal, "cp1252", "1 ? 2 µ".encode("cp1252")),
    ],
)
def test_an_arrow_is_written(kind, encoding, written):
    raw = io.BytesIO()
    stream = kind(raw, encoding=encoding)
    can_say_everything(stream)
    stream.write("1 → 2 µ")
    stream.flush()
    assert raw.getvalue() == written


def test_streams_of_other_kinds_are_left_alone():
    can_say_everything(io.StringIO())
    can_say_everything(None)
    assert main(["--version"]) == 0


def test_a_command_in_a_pipe_speaks_utf_8_on_every_system(tmp_path):
    name = "gr\N{GREEK SMALL LETTER MU}n.toml"
    environment = {**os.environ, "PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "slipctl.cli", "check", name]
    said = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, timeout=60)
    assert said.returncode == 2
    assert name in said.stderr.decode("utf-8")
