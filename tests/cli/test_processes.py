"""Real processes: signals; sim, servers, arbiter and executive apart; several robots."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, TypeAlias

import pytest
import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor

from bt_mission.base.interrupts import SAME_WISH_S
from bt_mission.recording.reader import read_run
from bt_mission.testing.live_graph import LOCAL
from bt_mission.views.web.report.page import write_report
from tests.support.processes import PATIENCE_S, ended, read_until, started
from tests.support.report_pages import data_of
from tests.support.thorough import sample

pytestmark = pytest.mark.process

Process: TypeAlias = subprocess.Popen[str]
Start: TypeAlias = Callable[..., Process]
Write: TypeAlias = Callable[[str, str], str]
SIM = ("sim", "--world", "empty_arena", "--no-camera")

# A goal is refused while the servers have not found the sensors yet: hence the attempts.
DRIVE = """\
mission: drive
world: empty_arena
tree:
  retry: {attempts: 20, pause: 1}
  do:
    explore_forward: {fwd_velocity: 0.1, stopping_distance: 0.3}
    name: drive
    timeout: 100
"""


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write a file; gives its path."""

    def write(name: str, text: str) -> str:
        (tmp_path / name).write_text(text, encoding="utf-8")
        return str(tmp_path / name)

    return write


@pytest.fixture
def drive(write: Write) -> str:
    """A mission that drives for a while."""
    return write("drive.yaml", DRIVE)


@pytest.fixture
def start() -> Iterator[Start]:
    """Start a process that finds others of this machine; it is killed at the end."""
    with ExitStack() as stack:
        yield lambda *words: stack.enter_context(started(*words, **LOCAL))


@pytest.mark.process(always=True)
@pytest.mark.parametrize(
    ("number", "name"),
    sample([(signal.SIGINT, "Ctrl-C"), (signal.SIGTERM, "SIGTERM"), (signal.SIGHUP, "SIGHUP")], 3),
)
def test_a_signal_ends_the_mission_with_no_goal_left_behind(
    drive: str, number: signal.Signals, name: str
) -> None:
    """Exit code 130, and the summary says so; no traceback."""
    with started("run", drive, "--speed", "1") as process:
        read_until(process, "drive")
        read_until(process, "▶ drive")
        rest = ended(process, 130, number)
    assert f"drive: interrupted by {name}" in rest
    assert "0 orphaned" in rest


STUCK = """\
import ctypes
from py_trees.behaviour import Behaviour

class Stuck(Behaviour):
    def update(self):
        lib, mutex = ctypes.CDLL(None), ctypes.create_string_buffer(64)
        lib.pthread_mutex_lock(mutex)
        lib.pthread_mutex_lock(mutex)
"""
LOOPS = """\
from py_trees.behaviour import Behaviour

class Stuck(Behaviour):
    def update(self):
        while True:
            pass
"""


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("code", "number", "left"),
    sample([(LOOPS, signal.SIGINT, False), (STUCK, signal.SIGTERM, True)], 2),
    ids=["loop", "C"],
)
def test_a_signal_ends_a_run_whose_thread_is_held(
    write: Write,
    code: str,
    number: signal.Signals,
    left: bool,  # noqa: FBT001 - of the table
) -> None:
    """By an exception in the callback; without the thread if that does not return from C."""
    write("leaf.py", code)
    path = write(
        "held.yaml",
        "mission: held\nworld: empty_arena\ntree:\n  sequence:\n    - wait: 0.1\n"
        '    - python: "leaf.py:Stuck"\n',
    )
    recording = Path(path).with_name("held.mcap")
    with started("run", path, "--plain", "--record", str(recording)) as process:
        read_until(process, "Stuck.update (leaf.py:")
        rest = ended(process, 143 if left else 130, number)
    assert ("does not return: leaving without it" in rest) == left
    name = "SIGTERM" if left else "Ctrl-C"
    assert f"held: interrupted by {name}" in rest
    assert "0 orphaned" in rest
    assert read_run(recording).summary["status"] == "interrupted"


@pytest.mark.parametrize(("count", "seconds"), sample([(1, 1), (2, 3600)], 2))
def test_a_signal_is_cleaned_up_after_and_a_second_one_skips_that(
    write: Write, count: int, seconds: int
) -> None:
    """The clean-up turns for some seconds, to its end or cut off; `--speed` does not hold it up."""
    path = write(
        "tidy.yaml",
        "mission: tidy\nworld: empty_arena\ntree:\n  finally: {timeout: 4000}\n"
        "  do: {move: {secs: 100, linear_velocity: 0.1}, name: drive, timeout: 200}\n"
        "  then:\n    sequence:\n      - name: tidy up\n        timeout: 4000\n"
        f"        move: {{secs: {seconds}, angular_velocity: 0.3}}\n"
        "      - log: all tidy\n",
    )
    with started("run", path, "--speed", "4") as process:
        read_until(process, "▶ drive")
        process.send_signal(signal.SIGINT)
        read_until(process, "▶ tidy up")
        if count == 2:
            with suppress(subprocess.TimeoutExpired):
                process.wait(SAME_WISH_S)  # one sooner after the first is the same wish
            process.send_signal(signal.SIGINT)
        rest = ended(process, 130)
    assert "tidy: interrupted by Ctrl-C" in rest
    assert ("all tidy" in rest, "0 orphaned" in rest) == (count == 1, count == 1)
    assert ("clean-up skipped: ended at once by a second Ctrl-C" in rest) == (count == 2)


@pytest.mark.thorough
def test_a_closed_pipe_is_no_traceback(drive: str) -> None:
    """``bt-mission run ... | head -1``."""
    with started("run", drive, "--speed", "20") as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.wait(timeout=PATIENCE_S) == 130


@pytest.mark.parametrize(
    "closed",
    [">&-", *(pytest.param(each, marks=pytest.mark.thorough) for each in ("2>&-", "<&- >&- 2>&-"))],
)
def test_closed_streams_are_no_traceback(write: Write, tmp_path: Path, closed: str) -> None:
    """Nothing that is opened later is taken for one of them."""
    mission = write("waits.yaml", "mission: waits\nworld: empty_arena\ntree: {wait: 0.2}\n")
    recording = tmp_path / "run.mcap"
    words = shlex.join([sys.executable, "-m", "bt_mission", "run", mission, "--record"])
    script = f"exec {words} {shlex.quote(str(recording))} {closed}"
    shell = subprocess.run(["/bin/sh", "-c", script], capture_output=True, check=False)
    assert (shell.returncode, b"Error" in shell.stdout + shell.stderr) == (0, False)
    assert read_run(recording).summary["status"] == "success"


def test_sim_servers_and_executive_as_three_processes(
    start: Start, drive: str, tmp_path: Path
) -> None:
    """The executive attaches to the graph, follows /clock, and succeeds."""
    sim, servers = start(*SIM, "--speed", "5"), start("servers", "--images", str(tmp_path))
    read_until(sim, "empty_arena")
    trace = tmp_path / "trace.jsonl"
    out = ended(start("run", drive, "--attach", "--json", "--trace", str(trace)), 0)
    report: dict[str, Any] = json.loads(out.splitlines()[-1])
    assert (report["status"], report["goals_left_behind"]) == ("success", 0), out
    assert report["collisions"] is None, "only a simulation of its own knows them"
    assert report["world"] is None, "that of the file need not be where the robot is"
    events = [json.loads(line) for line in trace.read_text().splitlines()]
    last_ns = max(event["t"] for event in events if "t" in event)
    assert last_ns < 3600 * 10**9, "it follows the clock of the simulation"
    ended(servers, 0, signal.SIGINT)
    ended(sim, 0, signal.SIGINT)


@pytest.mark.thorough
def test_servers_that_are_killed_are_missed(start: Start, write: Write) -> None:
    """Long before the goal's timeout; the goal that nobody confirms is named."""
    mission = write(
        "move.yaml",
        "mission: move\ntree:\n  retry: {attempts: 20, pause: 1}\n  do:\n"
        "    sequence: [{move: {secs: 100, linear_velocity: 0.01}, timeout: 900}]\n",
    )
    sim, servers = start(*SIM), start("servers")
    read_until(sim, "empty_arena")
    run = start("run", mission, "--attach", "--plain")
    read_until(servers, "goal accepted")
    servers.kill()
    seen = read_until(run, "server lost: /move has gone from the graph")
    assert "Traceback" not in seen
    assert "orphaned goals: /move goal" in ended(run, 130, signal.SIGINT)


@pytest.mark.thorough
def test_a_mission_runs_missions_until_their_executive_is_told_to_end(
    start: Start, write: Write
) -> None:
    """Ctrl-C at the executive that serves: its goals end, and the outer mission learns why."""
    mission = write(
        "outer.yaml",
        "mission: outer\ntree:\n  sequence:\n"
        "    - execute_mission: {text: $first}\n      timeout: 60\n"
        "    - execute_mission: {text: $second}\n      timeout: 300\n"
        "inputs:\n  first: '{mission: inner, tree: {log: hello}}'\n"
        "  second: '{mission: long, tree: {move: {secs: 100}, timeout: 200}}'\n",
    )
    sim, servers, serve = start(*SIM), start("servers"), start("serve", "--allow-text")
    read_until(sim, "empty_arena")
    read_until(serve, "waits for missions")
    run = start("run", mission, "--attach", "--plain")
    read_until(servers, "goal accepted")
    served = ended(serve, 0, signal.SIGINT)
    assert "interrupted by Ctrl-C (code 901)" in ended(run, 1)
    assert "inner: success" in served
    assert "long: interrupted by Ctrl-C" in served
    assert "1 goal sent, 0 orphaned" in served


@pytest.mark.thorough
def test_a_mission_goes_on_after_its_process_was_killed(
    start: Start, write: Write, tmp_path: Path
) -> None:
    """In the second of three drives: the first is not driven again, the journal tells the end."""
    mission = write(
        "three.yaml",
        "mission: three\ntree:\n  for_each: {n: [1, 2, 3]}\n  do:\n    sequence:\n"
        "      - move: {secs: 2, linear_velocity: 0.1}\n        timeout: 20\n"
        "      - log: leg $n\n",
    )
    command = ("run", mission, "--attach", "--plain", "--journal", str(tmp_path / "journal"))
    start(*SIM)
    servers = start("servers")
    read_until(servers, "ready: scan and odometry have come")
    run = start(*command)
    for _drive in (1, 2):
        read_until(servers, "goal accepted")
    run.kill()
    assert "continue it with --resume, or delete the file" in ended(start(*command), 2)
    seen = ended(start(*command, "--resume"), 0)
    assert "leg 1" not in seen
    assert [line.split()[-1] for line in seen.splitlines() if " leg " in line] == ["2", "3"]
    assert "three: success" in seen
    assert "0 orphaned" in seen
    end = ended(start(*command, "--resume"), 2)
    assert "this mission has ended: success; start it again" in end


@pytest.mark.thorough
def test_nobody_hears_a_simulated_run_unless_asked(drive: str) -> None:
    """A robot on the same network would otherwise drive along."""
    context = rclpy.Context()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    try:
        rclpy.init(context=context)
    finally:
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
    bystander = rclpy.create_node("bystander", context=context, enable_rosout=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(bystander)
    messages: list[TwistStamped] = []
    bystander.create_subscription(TwistStamped, "cmd_vel", messages.append, 10)
    results = []
    for options in ([], ["--visible"]):
        with started("run", drive, "--speed", "1", *options) as process:
            read_until(process, "▶ drive")
            for _ in range(60):
                executor.spin_once(timeout_sec=0.1)
                if messages:
                    break
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=PATIENCE_S)
        results.append(bool(messages))
    bystander.destroy_node()
    context.shutdown()
    assert results == [False, True]


@pytest.mark.thorough
def test_goals_are_compared_with_the_limits_of_servers_that_run(start: Start, write: Write) -> None:
    """Of another robot, and of a parameter file; without the option, the mission's robot counts."""
    mission = write(
        "turns.yaml",
        "mission: turns\ntree:\n  sequence:\n"
        "    - {turn: {angle: 10, angular_velocity: 2.5}, timeout: 9}\n"
        "    - {turn: {angle: 50}, timeout: 9}\n",
    )
    limits = write("limits.yaml", "/**:\n  ros__parameters: {turn_limit: 45.0}\n")
    servers = start("servers", "--robot", "burger", "--wall-clock", "--params", limits)
    read_until(servers, "waiting for scan")
    output = ended(start("check", mission, "--against"), 2)
    assert "1 of 1 are in the graph" in output
    assert f"{mission}:5:22: error: angle must be from -45 to 45 deg, got 50" in output
    assert "angular_velocity" not in output
    output = ended(start("check", mission), 2)
    assert "angular_velocity must be from 0.05 to 1.82 rad/s, got 2.5" in output


TURNS = """\
mission: turns
tree:
  retry: {attempts: 20, pause: 1}
  do:
    turn: {angle: 15}
    timeout: 30
"""


@pytest.mark.thorough
def test_second_servers_are_refused_unless_the_first_were_killed(start: Start, drive: str) -> None:
    """A mission is refused, too, as long as both are in the graph."""
    servers = ("servers", "--robot", "burger", "--wall-clock")
    both = "has 2 servers (/bt_mission_servers, /bt_mission_servers): each of them runs every goal"
    first = start(*servers)
    read_until(first, "waiting for scan")
    assert both in ended(start(*servers), 2)
    second = start(*servers, "--allow-duplicates")
    read_until(second, "waiting for scan")
    attach = ("run", drive, "--attach", "--wall-clock")
    assert both in ended(start(*attach), 2)
    recording = Path(drive).with_suffix(".mcap")
    more = ("--allow-duplicates", "--json", "--record", str(recording))
    report = ended(start(*attach, *more), 1)
    assert json.dumps(both)[1:-1] in report.partition('"warnings": ')[2]
    page = recording.with_suffix(".html")
    write_report(recording, page)
    (data,) = data_of(page).values()
    assert both in dict(data["details"]["facts"])["warning"]
    for process in (first, second):
        process.kill()
        process.wait()
    read_until(start(*servers), "waiting for scan")


@pytest.mark.thorough
def test_a_simulation_beside_another_is_not_driven_with_it(start: Start, drive: str) -> None:
    """Neither by the executive nor by the servers, unless that is asked for.

    On a busy machine the executive may not have found the second one yet: then the servers refuse.
    """
    attach = ("run", drive, "--attach", "--plain")
    for _ in range(2):
        read_until(start(*SIM), "empty_arena")
    read_until(start("servers"), "/odom has 2 publishers")
    run = start(*attach)
    seen, _ = run.communicate(timeout=PATIENCE_S)
    is_found = run.returncode == 2 and "/odom has 2 publishers (/bt_mission_sim, " in seen
    assert is_found or (run.returncode == 1 and "rejected" in seen)
    assert "rejected" in ended(start(*attach, "--allow-duplicates"), 1)


def test_processes_say_that_they_are_heard_on_this_machine_only(drive: str) -> None:
    """In their first line, where the environment does not decide it."""
    lines = []
    for arguments in (("sim", "--no-camera"), ("servers",), ("run", drive, "--visible")):
        with started(*arguments, ROS_AUTOMATIC_DISCOVERY_RANGE="") as process:
            assert process.stdout is not None
            lines.append(process.stdout.readline())
    words = ", this machine only; --network includes other machines"
    assert [words in line for line in lines] == [True] * 3


def test_other_machines_cannot_reach_a_process_of_this_machine() -> None:
    """Every socket that DDS listens on is bound to the loopback interface."""
    first = 7400 + 250 * int(os.environ["ROS_DOMAIN_ID"])
    with started("sim", "--no-camera", ROS_AUTOMATIC_DISCOVERY_RANGE="") as process:
        read_until(process, "speed 1")
        proc = Path(f"/proc/{process.pid}")
        links = [str(link.readlink()) for link in (proc / "fd").iterdir()]
        rows = [line.split() for line in (proc / "net/udp").read_text().splitlines()[1:]]
    mine = [row[1].split(":") for row in rows if f"socket:[{row[9]}]" in links]
    listening = [address for address, port in mine if first <= int(port, 16) < first + 250]
    assert set(listening) == {"0100007F"}


@pytest.mark.parametrize("command", sample(["servers", "arbiter"], 2))
def test_a_misspelt_parameter_ends_before_anything_starts(
    start: Start, write: Write, command: str
) -> None:
    """With its place, exit code 2, and no traceback."""
    path = write("mine.yaml", "/**:\n  ros__parameters:\n    topics: {cmd_val: x}\n")
    output = ended(start(command, "--wall-clock", "--params", path), 2)
    assert "mine.yaml:3:14: error: no such parameter 'topics.cmd_val'" in output
    assert "did you mean 'topics.cmd_vel'?" in output


@pytest.mark.parametrize(
    ("command", "topic"), sample([("servers", "/cmd_vel_mission"), ("arbiter", "/cmd_vel")], 2)
)
def test_a_node_of_a_real_robot_says_that_nobody_listens(
    start: Start, command: str, topic: str
) -> None:
    """As an error, within a second."""
    process = start(command, "--real", "--params", "waffle")
    output = read_until(process, "has no subscriber")
    assert f"{topic} has no subscriber; is the robot's bringup running?" in output
    ended(process, 0, signal.SIGINT)


@pytest.mark.thorough
def test_a_mission_for_one_robot_of_two(start: Start, write: Write, tmp_path: Path) -> None:
    """By its namespace: sim, servers and executive as three processes."""
    robots = ("--robots", "robot1=waffle@-1,0,0", "robot2=burger@1,0,90")
    sim = start("sim", "--no-camera", "--speed", "3", *robots, "--world", "dqn_stage1")
    servers = start("servers", "--namespace", "robot2", "--images", str(tmp_path))
    read_until(sim, "dqn_stage1")
    run = start("run", write("turns.yaml", TURNS), "--attach", "--namespace", "robot2", "--json")
    report = json.loads(ended(run, 0).splitlines()[-1])
    assert (report["status"], report["goals_left_behind"]) == ("success", 0)
    ended(servers, 0, signal.SIGINT)
    ended(sim, 0, signal.SIGINT)
