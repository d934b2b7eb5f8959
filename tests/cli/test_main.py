"""Ctrl-C while the program is loaded, and after a command has ended."""

from __future__ import annotations

import subprocess
import sys

import pytest

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
        [sys.executable, "-c", program], capture_output=True, check=False, text=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (code, "")
