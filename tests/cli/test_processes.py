"""Real processes: Ctrl-C, SIGTERM, and sim, servers and executive apart from each other."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor

from bt_mission.core.interrupts import SAME_WISH_S
from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import PATIENCE_S, read_until, started

pytestmark = pytest.mark.process

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
def drive(tmp_path: Path) -> str:
    """A mission that drives for a while."""
    path = tmp_path / "drive.yaml"
    path.write_text(DRIVE, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_mission_with_no_goal_left_behind(
    drive: str, number: signal.Signals
) -> None:
    """Exit code 130, and the summary says so; no traceback."""
    with started("run", drive, "--speed", "1") as process:
        read_until(process, "drive")
        read_until(process, "▶ drive")
        process.send_signal(number)
        rest, _ = process.communicate(timeout=PATIENCE_S)
    name = "Ctrl-C" if number == signal.SIGINT else "SIGTERM"
    assert f"drive: interrupted by {name}" in rest
    assert "0 orphaned" in rest
    assert "Traceback" not in rest
    assert process.returncode == 130


@pytest.mark.parametrize(("count", "seconds"), [(1, 1), (2, 3600)])
def test_a_signal_is_cleaned_up_after_and_a_second_one_skips_that(
    tmp_path: Path, count: int, seconds: int
) -> None:
    """The clean-up turns for some seconds, to its end or cut off; `--speed` does not hold it up."""
    path = tmp_path / "tidy.yaml"
    path.write_text(
        "mission: tidy\nworld: empty_arena\ntree:\n  finally: {timeout: 4000}\n"
        "  do: {move: {secs: 100, linear_velocity: 0.1}, name: drive, timeout: 200}\n"
        "  then:\n    sequence:\n      - name: tidy up\n        timeout: 4000\n"
        f"        move: {{secs: {seconds}, angular_velocity: 0.3}}\n"
        "      - log: all tidy\n",
        encoding="utf-8",
    )
    with started("run", str(path), "--speed", "4") as process:
        read_until(process, "▶ drive")
        process.send_signal(signal.SIGINT)
        read_until(process, "▶ tidy up")
        if count == 2:
            with suppress(subprocess.TimeoutExpired):
                process.wait(SAME_WISH_S)  # one sooner after the first is the same wish
            process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "tidy: interrupted by Ctrl-C" in rest
    assert ("all tidy" in rest, "0 orphaned" in rest) == (count == 1, count == 1)
    assert ("clean-up skipped: ended at once by a second Ctrl-C" in rest) == (count == 2)
    assert "Traceback" not in rest


def test_a_closed_pipe_is_no_traceback(drive: str) -> None:
    """``bt-mission run ... | head -1``."""
    with started("run", drive, "--speed", "20") as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.wait(timeout=PATIENCE_S) == 130


def test_sim_servers_and_executive_as_three_processes(drive: str, tmp_path: Path) -> None:
    """The executive attaches to the graph, follows /clock, and succeeds."""
    local = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with ExitStack() as stack:
        sim = stack.enter_context(
            started("sim", "--world", "empty_arena", "--speed", "5", "--no-camera", **local)
        )
        servers = stack.enter_context(started("servers", "--images", str(tmp_path), **local))
        read_until(sim, "empty_arena")
        trace = tmp_path / "trace.jsonl"
        run = stack.enter_context(
            started("run", drive, "--attach", "--json", "--trace", str(trace), **local)
        )
        out, _ = run.communicate(timeout=PATIENCE_S)
        report: dict[str, Any] = json.loads(out.splitlines()[-1])
        assert (report["status"], report["goals_left_behind"]) == ("success", 0), out
        assert report["collisions"] is None, "only a simulation of its own knows them"
        assert report["world"] is None, "that of the file need not be where the robot is"
        events = [json.loads(line) for line in trace.read_text().splitlines()]
        last_ns = max(event["t"] for event in events if "t" in event)
        assert last_ns < 3600 * 10**9, "it follows the clock of the simulation"
        for process in (servers, sim):
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=PATIENCE_S)
            assert "Traceback" not in rest


def test_servers_that_are_killed_are_missed(tmp_path: Path) -> None:
    """Long before the goal's timeout; the goal that nobody confirms is named."""
    mission = tmp_path / "move.yaml"
    mission.write_text(
        "mission: move\ntree:\n  retry: {attempts: 20, pause: 1}\n  do:\n"
        "    sequence: [{move: {secs: 100, linear_velocity: 0.01}, timeout: 900}]\n"
    )
    with ExitStack() as stack:
        options = ("--world", "empty_arena", "--no-camera")
        sim = stack.enter_context(started("sim", *options, **LOCAL))
        servers = stack.enter_context(started("servers", **LOCAL))
        read_until(sim, "empty_arena")
        run = stack.enter_context(started("run", str(mission), "--attach", "--plain", **LOCAL))
        read_until(servers, "goal accepted")
        servers.kill()
        seen = read_until(run, "server lost: /move has gone from the graph")
        run.send_signal(signal.SIGINT)
        rest, _ = run.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in seen + rest
    assert "orphaned goals: /move goal" in rest


@pytest.mark.thorough
def test_a_mission_runs_missions_until_their_executive_is_told_to_end(tmp_path: Path) -> None:
    """Ctrl-C at the executive that serves: its goals end, and the outer mission learns why."""
    mission = tmp_path / "outer.yaml"
    mission.write_text(
        "mission: outer\ntree:\n  sequence:\n"
        "    - execute_mission: {text: $first}\n      timeout: 60\n"
        "    - execute_mission: {text: $second}\n      timeout: 300\n"
        "inputs:\n  first: '{mission: inner, tree: {log: hello}}'\n"
        "  second: '{mission: long, tree: {move: {secs: 100}, timeout: 200}}'\n"
    )
    with ExitStack() as stack:
        options = ("--world", "empty_arena", "--no-camera")
        sim = stack.enter_context(started("sim", *options, **LOCAL))
        servers = stack.enter_context(started("servers", **LOCAL))
        serve = stack.enter_context(started("serve", "--allow-text", **LOCAL))
        read_until(sim, "empty_arena")
        read_until(serve, "waits for missions")
        run = stack.enter_context(started("run", str(mission), "--attach", "--plain", **LOCAL))
        read_until(servers, "goal accepted")
        serve.send_signal(signal.SIGINT)
        served, _ = serve.communicate(timeout=PATIENCE_S)
        seen, _ = run.communicate(timeout=PATIENCE_S)
    assert (serve.returncode, run.returncode) == (0, 1)
    assert "inner: success" in served
    assert "long: interrupted by Ctrl-C" in served
    assert "1 goal sent, 0 orphaned" in served
    assert "interrupted by Ctrl-C (code 901)" in seen
    assert "Traceback" not in served + seen


def test_a_mission_goes_on_after_its_process_was_killed(tmp_path: Path) -> None:
    """In the second of three drives: the first is not driven again, the journal tells the end."""
    mission = tmp_path / "three.yaml"
    mission.write_text(
        "mission: three\ntree:\n  for_each: {n: [1, 2, 3]}\n  do:\n    sequence:\n"
        "      - move: {secs: 2, linear_velocity: 0.1}\n        timeout: 20\n"
        "      - log: leg $n\n"
    )
    command = ("run", str(mission), "--attach", "--plain", "--journal", str(tmp_path / "journal"))
    with ExitStack() as stack:
        options = ("--world", "empty_arena", "--no-camera")
        stack.enter_context(started("sim", *options, **LOCAL))
        servers = stack.enter_context(started("servers", **LOCAL))
        read_until(servers, "ready: scan and odometry have come")
        run = stack.enter_context(started(*command, **LOCAL))
        for _drive in (1, 2):
            read_until(servers, "goal accepted")
        run.kill()
        again = stack.enter_context(started(*command, **LOCAL))
        refused, _ = again.communicate(timeout=PATIENCE_S)
        resumed = stack.enter_context(started(*command, "--resume", **LOCAL))
        seen, _ = resumed.communicate(timeout=PATIENCE_S)
        once_more = stack.enter_context(started(*command, "--resume", **LOCAL))
        ended, _ = once_more.communicate(timeout=PATIENCE_S)
    assert (again.returncode, resumed.returncode, once_more.returncode) == (2, 0, 2)
    assert "continue it with --resume, or delete the file" in refused
    assert "leg 1" not in seen
    assert [line.split()[-1] for line in seen.splitlines() if " leg " in line] == ["2", "3"]
    assert "three: success" in seen
    assert "0 orphaned" in seen
    assert "this mission has ended: success; start it again" in ended


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


def test_goals_are_compared_with_the_limits_of_servers_that_run(tmp_path: Path) -> None:
    """Of another robot, and of a parameter file; without the option, the mission's robot counts."""
    mission, limits = tmp_path / "turns.yaml", tmp_path / "limits.yaml"
    mission.write_text(
        "mission: turns\ntree:\n  sequence:\n"
        "    - {turn: {angle: 10, angular_velocity: 2.5}, timeout: 9}\n"
        "    - {turn: {angle: 50}, timeout: 9}\n",
        encoding="utf-8",
    )
    limits.write_text("/**:\n  ros__parameters: {turn_limit: 45.0}\n", encoding="utf-8")
    with ExitStack() as stack:
        options = ("--robot", "burger", "--wall-clock", "--params", str(limits))
        servers = stack.enter_context(started("servers", *options, **LOCAL))
        read_until(servers, "waiting for scan")
        checking = stack.enter_context(started("check", str(mission), "--against", **LOCAL))
        output, _ = checking.communicate(timeout=PATIENCE_S)
    assert checking.returncode == 2
    assert "1 of 1 are in the graph" in output
    assert f"{mission}:5:22: error: angle must be from -45 to 45 deg, got 50" in output
    assert "angular_velocity" not in output
    with started("check", str(mission), **LOCAL) as checking:
        output, _ = checking.communicate(timeout=PATIENCE_S)
    assert checking.returncode == 2
    assert "angular_velocity must be from 0.05 to 1.82 rad/s, got 2.5" in output


REMAPPED = """\
mission: remapped
tree:
  retry: {attempts: 20, pause: 1}
  do:
    turn: {angle: 5}
    timeout: 20
"""


@pytest.mark.thorough
def test_an_executive_that_serves_goes_by_other_names(tmp_path: Path) -> None:
    """As launch files give them: its namespace and its node, and actions offered and asked for."""
    (tmp_path / "remapped.yaml").write_text(REMAPPED, encoding="utf-8")
    there = ("--ros-args", "-r", "__ns:=/robot1", "-r", "turn:=rotate")
    mine = (*there, "-r", "__node:=executive", "-r", "execute_mission:=patrol")
    with ExitStack() as stack:
        sim = stack.enter_context(started("sim", "--no-camera", *there, **LOCAL))
        servers = stack.enter_context(started("servers", *there, **LOCAL))
        read_until(sim, "empty_arena")
        read_until(servers, "ready: scan and odometry have come")
        options = ("serve", "--missions", str(tmp_path))
        serve = stack.enter_context(started(*options, *mine, **LOCAL))
        read_until(serve, "/robot1/patrol waits for missions (/clock)")
        sent = stack.enter_context(
            started("actions", "send", "/robot1/patrol", "{path: remapped.yaml}", **LOCAL)
        )
        result, _ = sent.communicate(timeout=PATIENCE_S)
        listing = stack.enter_context(started("actions", "list", **LOCAL))
        offered, _ = listing.communicate(timeout=PATIENCE_S)
        serve.send_signal(signal.SIGINT)
        served, _ = serve.communicate(timeout=PATIENCE_S)
    assert sent.returncode == 0, result
    assert "remapped: success" in served
    who = {line.split()[0]: line.split()[-1] for line in offered.splitlines() if "/" in line}
    assert who["/robot1/patrol"] == "/robot1/executive"
    assert who["/robot1/rotate"] == "/robot1/bt_mission_servers"
    assert not {"/robot1/execute_mission", "/robot1/turn"} & set(who)


@pytest.mark.thorough
def test_a_simulation_beside_another_is_not_driven_with_it(tmp_path: Path, drive: str) -> None:
    """Neither by the executive nor by the servers, unless that is asked for.

    On a busy machine the executive may not have found the second one yet: then the servers refuse.
    """
    options = ("--world", "empty_arena", "--no-camera")
    attach = ("run", drive, "--attach", "--plain")
    with ExitStack() as stack:
        for _ in range(2):
            read_until(stack.enter_context(started("sim", *options, **LOCAL)), "empty_arena")
        servers = stack.enter_context(started("servers", **LOCAL))
        read_until(servers, "/odom has 2 publishers")
        run = stack.enter_context(started(*attach, **LOCAL))
        seen, _ = run.communicate(timeout=PATIENCE_S)
        leave = stack.enter_context(started(*attach, "--allow-duplicates", **LOCAL))
        rejected, _ = leave.communicate(timeout=PATIENCE_S)
    is_found = run.returncode == 2 and "/odom has 2 publishers (/bt_mission_sim, " in seen
    assert is_found or (run.returncode == 1 and "rejected" in seen)
    assert leave.returncode == 1
    assert "rejected" in rejected


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
