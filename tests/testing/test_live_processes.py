from __future__ import annotations

import signal
import sys

import pytest

from bt_mission.faults.errors import ScenarioError
from bt_mission.testing.live_graph import Process

pytestmark = pytest.mark.process


@pytest.fixture
def python(tmp_path):
    """Run a line of Python as a process."""
    made = []

    def start(line: str) -> Process:
        arguments = [sys.executable, "-u", "-c", line]
        made.append(Process("one", arguments, {"GREETING": "hello"}, tmp_path / "one.log"))
        return made[-1]

    yield start
    for process in made:
        process.kill()


def test_words_are_waited_for_one_after_another(python):
    """Those that were waited for before do not count again."""
    process = python("import os; print(os.environ['GREETING'], 'hello'); input()")
    assert process.until("hello") == process.until("hello")
    with pytest.raises(ScenarioError, match="'one' ended with 1, without printing 'hello':\nhello"):
        process.until("hello")
    assert "EOFError" in process.output, "it has no keyboard"


def test_a_process_that_says_nothing_is_named(python):
    """With what it has said instead."""
    process = python("import signal; print('here'); signal.pause()")
    process.until("here")
    with pytest.raises(ScenarioError, match=r"has not said 'there' within 0\.1 s:\nhere"):
        process.until("there", within=0.1)
    with pytest.raises(ScenarioError, match=r"has not ended within 0\.1 s"):
        process.wait(within=0.1)
    assert process.code is None
    process.interrupt()
    assert process.wait() == -signal.SIGINT
    process.kill()


def test_a_process_that_is_killed_says_so_by_its_code(python):
    """Its output stays."""
    process = python("import signal; print('here', end=''); signal.pause()")
    process.until("here")
    process.kill()
    assert process.code == -signal.SIGKILL
    assert process.output == "here"
