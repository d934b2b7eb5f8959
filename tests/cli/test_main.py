"""Ctrl-C while the program is loaded, and how it ends."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from bt_mission.core.dds.discovery import MACHINE, PROCESS, RANGE
from tests.support.processes import PATIENCE_S

pytestmark = pytest.mark.process

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
sys.argv = ["bt-mission", "arbiter"]
sys.meta_path.insert(0, CtrlC())
"""
CTRL_C_AFTER_THE_END = "import atexit; atexit.register(signal.raise_signal, signal.SIGINT)\n"


@pytest.mark.parametrize(
    ("happens", "code"),
    [(CTRL_C_WHILE_LOADED, 130), (CTRL_C_WHILE_ROS_IS_LOADED, 130), (CTRL_C_AFTER_THE_END, 0)],
)
def test_ctrl_c_before_and_after_is_no_traceback(happens: str, code: int) -> None:
    """Both take seconds on a busy machine; what has ended keeps its exit code."""
    program = (
        "import runpy, signal, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "sys.argv = ['bt-mission', 'schema']\n"
        f"{happens}"
        "runpy.run_module('bt_mission', run_name='__main__')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        check=False,
        text=True,
        timeout=PATIENCE_S,
    )
    assert (done.returncode, done.stderr) == (code, "")


@pytest.mark.parametrize(("discovery", "output"), [(PROCESS, "last\n"), (MACHINE, "last\nfirst\n")])
def test_a_process_that_nobody_saw_leaves_at_its_last_word(discovery: str, output: str) -> None:
    """What was registered since its start is called; libraries are taken down only by others."""
    program = (
        "import atexit, runpy, sys\n"
        "atexit.register(print, 'first', file=sys.stderr)\n"
        "sys.argv = ['bt-mission', 'schema']\n"
        "class Late:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'bt_mission.cli.main':\n"
        "            atexit.register(print, 'last', file=sys.stderr)\n"
        "sys.meta_path.insert(0, Late())\n"
        "runpy.run_module('bt_mission', run_name='__main__')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        check=False,
        text=True,
        timeout=PATIENCE_S,
        env=os.environ | {RANGE: discovery},
    )
    assert (done.returncode, done.stderr) == (0, output)
    assert done.stdout.endswith("}\n")
