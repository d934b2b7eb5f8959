"""How the program ends: Ctrl-C while it is loaded, its last word, an output that takes nothing."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest

from bt_mission.base.dds.discovery import MACHINE, PROCESS, RANGE
from tests.support.command_cases import cases
from tests.support.command_line import CommandLine
from tests.support.processes import PATIENCE_S

CTRL_C_WHILE_LOADED = """\
class CtrlC:
    def find_spec(self, name, *_):
        if name == "bt_mission.cli.main":
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, CtrlC())
"""
CTRL_C_WHILE_ROS_IS_LOADED = """\
class CtrlC:
    def find_spec(self, name, *_):
        if name == "rclpy":
            try:
                signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt as error:
                raise ImportError("initialization failed") from error
sys.argv = ["bt-mission", *WORDS]
sys.meta_path.insert(0, CtrlC())
"""
CTRL_C_AFTER_THE_END = "import atexit; atexit.register(signal.raise_signal, signal.SIGINT)\n"
SCHEMA = "sys.argv = ['bt-mission', 'schema']\n"


def ran(
    program: str, code: int, error: str, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run our main program behind some lines; it ends with this code and standard error."""
    done = subprocess.run(
        [sys.executable, "-c", f"{program}runpy.run_module('bt_mission', run_name='__main__')\n"],
        capture_output=True,
        check=False,
        text=True,
        timeout=PATIENCE_S,
        env=os.environ | environment,
    )
    assert (done.returncode, done.stderr) == (code, error)
    return done


@pytest.mark.process
@pytest.mark.parametrize(
    ("happens", "code"),
    [
        (CTRL_C_WHILE_LOADED, 130),
        (f"WORDS = ['arbiter']\n{CTRL_C_WHILE_ROS_IS_LOADED}", 130),
        (f"WORDS = ['watch']\n{CTRL_C_WHILE_ROS_IS_LOADED}", 130),
        (f"WORDS = ['play', 'x.py']\n{CTRL_C_WHILE_ROS_IS_LOADED}", 130),
        (CTRL_C_AFTER_THE_END, 0),
    ],
)
def test_ctrl_c_before_and_after_is_no_traceback(happens: str, code: int) -> None:
    """Both take seconds on a busy machine; what has ended keeps its exit code."""
    program = (
        "import runpy, signal, sys\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
    )
    ran(f"{program}{SCHEMA}{happens}", code, "")


@pytest.mark.process
@pytest.mark.parametrize(
    ("imported", "discovery", "output"),
    [
        ("json", MACHINE, "last\n"),
        ("rclpy", PROCESS, "last\n"),
        ("rclpy", MACHINE, "last\nfirst\n"),
    ],
)
def test_a_process_that_nobody_saw_leaves_at_its_last_word(
    imported: str, discovery: str, output: str
) -> None:
    """What was registered since its start is called; libraries are taken down only by others."""
    program = (
        f"import atexit, runpy, sys, {imported}\n"
        "atexit.register(print, 'first', file=sys.stderr)\n"
        "class Late:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'bt_mission.cli.main':\n"
        "            atexit.register(print, 'last', file=sys.stderr)\n"
        "sys.meta_path.insert(0, Late())\n"
    )
    worlds = "sys.argv = ['bt-mission', 'worlds']\n"
    assert "empty_arena" in ran(program + worlds, 0, output, **{RANGE: discovery}).stdout


def stream(file: int | str, *, is_buffered: bool = True) -> io.TextIOWrapper:
    """A standard output."""
    raw = io.FileIO(file, "w")
    if is_buffered:
        return io.TextIOWrapper(io.BufferedWriter(raw))
    return io.TextIOWrapper(raw, write_through=True)  # as with python -u


@pytest.mark.parametrize(
    ("line", "is_buffered"),
    [
        ("schema", True),
        ("schema", False),
        ("check rest.yaml", True),
        ("run rest.yaml --json", True),
        ("run rest.yaml --json", False),
        ("run rest.yaml --plain", True),
        ("run rest.yaml --plain", False),
        ("--help", True),
        ("--version", False),
    ],
)
def test_a_full_disk_is_named(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch, line: str, *, is_buffered: bool
) -> None:
    """/dev/full takes nothing; what is still buffered is dropped."""
    cli.write("rest.yaml", "mission: rest\ntree:\n  wait: 0.1\n")
    with stream("/dev/full", is_buffered=is_buffered) as full:
        monkeypatch.setattr(sys, "stdout", full)
        cli(line, 2)
    assert cli.err.splitlines()[-1] == "cannot write standard output: No space left on device"
    assert "doctor" not in cli.err


@pytest.mark.parametrize("line", ["schema", "--help"])
def test_a_closed_pipe_is_an_interruption(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch, line: str
) -> None:
    """Nothing is printed: its reader has left."""
    reader, writer = os.pipe()
    os.close(reader)
    with stream(writer) as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        cli(line, 130)
    assert cli.err == ""


@pytest.mark.parametrize(
    "line",
    [
        *("check pipe.yaml", "run pipe.yaml", "tree pipe.yaml", "run square --require pipe.yaml"),
        *("verify pipe.mcap", "report pipe.mcap", "replay pipe.mcap --once", "replay pipe.jsonl"),
        *("diff pipe.jsonl pipe.mcap", "servers --ros-args --params-file pipe.yaml"),
        *cases("PIPES"),
    ],
)
def test_a_pipe_in_place_of_a_file_is_refused_and_never_waited_for(
    cli: CommandLine, line: str
) -> None:
    """Nobody may ever write to it."""
    for suffix in ("yaml", "mcap", "jsonl", "xml"):
        os.mkfifo(f"pipe.{suffix}")
    assert cli.call(line) == 2
    assert "expected a file, got a device or pipe" in cli.out + cli.err
