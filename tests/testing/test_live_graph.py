"""The fixture ``live_graph``."""

from __future__ import annotations

import signal
import socket
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.live_graph import DOMAINS, Process, own_domain

TURN = """
mission: turn
tree:
  turn: {angle: 30}
  timeout: 30
"""
TURNS_ON = """
mission: turn on
tree:
  parallel:
    - turn: {angle: 3000}
      timeout: 300
    - sequence:
        - wait_for: {topic: odom, type: nav_msgs/msg/Odometry, until: twist.twist.angular.z > 0.5}
        - log: it turns
"""
FAILS = """
def test_it(live_graph):
    hello = live_graph.start_program("hello", "echo", "hello", "world")
    hello.wait()
    live_graph.start_program("hello", "echo", "again").wait()
    sleeper = live_graph.start_program("sleeper", "sleep", "100")
    print(f"domain {live_graph.domain_id}")
    raise ValueError

def test_after(live_graph):
    pass
"""


def test_each_has_a_domain_of_its_own(tmp_path):
    """Until it is given back; where none is left, that is said."""
    with own_domain(tmp_path) as first, own_domain(tmp_path) as other:
        assert first != other
        assert {first, other} <= set(DOMAINS)
    with own_domain(tmp_path) as again:
        assert again == first
    with ExitStack() as stack, pytest.raises(ScenarioError, match="all 101 DDS domains are taken"):
        claim_all(stack, tmp_path)


def claim_all(stack, folder):
    """Claim one domain after the other; no two are the same."""
    taken: set[int] = set()
    while True:
        domain_id = stack.enter_context(own_domain(folder))
        assert domain_id in set(DOMAINS) - taken
        taken.add(domain_id)


def test_a_domain_in_which_a_process_listens_is_skipped(tmp_path):
    """No test knows of the robot of another shell."""
    with own_domain(tmp_path) as first:
        pass
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 7400 + 250 * first + 10))
        with own_domain(tmp_path) as other:
            assert other != first
    with own_domain(tmp_path) as again:
        assert again == first


@pytest.mark.process
def test_a_test_that_fails_shows_what_the_processes_said(pytester):
    """And ends them."""
    pytester.makepyfile(FAILS)
    result = pytester.runpytest()
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        ["*- process hello -*", "hello world", "*- process hello 2 -*", "again"]
    )


@pytest.mark.process
def test_messages_do_not_come_through_shared_memory(live_graph):
    """Whose ports outlive a process that is killed: the next one would miss what is sent there."""
    sim, servers = live_graph.robot("empty_arena", "waffle", "--no-camera")
    for process in (sim, servers):
        mapped = Path(f"/proc/{process.pid}/maps").read_text(encoding="utf-8")
        assert "fastrtps_port" not in mapped


@pytest.mark.thorough
@pytest.mark.process
def test_a_mission_runs_over_processes(live_graph):
    """Sim, servers and executive; what is killed is missed."""
    _, servers = live_graph.robot("empty_arena", "waffle", "--no-camera")
    turn = live_graph.run(TURN)
    assert turn.wait() == 0
    assert "turn: success" in turn.output
    listing = live_graph.start("check", "square", "--against")
    assert listing.wait() == 0, listing.output
    again = live_graph.run(TURNS_ON)
    again.until("it turns")
    servers.kill()
    again.until("server lost: /turn has gone from the graph")
    assert again.wait() == 1


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


@pytest.mark.process
def test_words_are_waited_for_one_after_another(python):
    """Those that were waited for before do not count again."""
    process = python("import os; print(os.environ['GREETING'], 'hello'); input()")
    assert process.until("hello") == process.until("hello")
    with pytest.raises(ScenarioError, match="'one' ended with 1, without printing 'hello':\nhello"):
        process.until("hello")
    assert "EOFError" in process.output, "it has no keyboard"


@pytest.mark.process
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


@pytest.mark.process(always=True)
def test_a_process_that_is_killed_says_so_by_its_code(python):
    """Its output stays."""
    process = python("import signal; print('here', end=''); signal.pause()")
    process.until("here")
    process.kill()
    assert process.code == -signal.SIGKILL
    assert process.output == "here"
