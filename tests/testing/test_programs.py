"""``stage.program``: programs under test, alone and beside a mission."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

from bt_mission.base.errors import BtMissionError
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing import Stages
from tests.support.project import ROOT

CODE = ROOT / "docs" / "tutorials" / "code"
MISSION = """\
mission: numbers
world: empty_arena
tree:
  action: {name: fibonacci, type: example_interfaces/action/Fibonacci, goal: {order: 20}}
  cancel_when: len(sequence) >= 7
  on_cancel: success
"""


@pytest.mark.parametrize(
    ("arguments", "ended_s", "status", "numbers"),
    [((), 20.0, "succeeded", 22), (("--threads",), 5.0, "canceled", 7)],
)
def test_a_server_and_a_client_are_tested(
    stage: Stages, arguments: Any, ended_s: float, status: str, numbers: int
) -> None:
    """Exit code, output, and the goal as the server saw it, each with its virtual time."""
    stage.program(CODE / "sleepy_server.py", arguments=arguments)
    client = stage.program(CODE / "impatient_client.py")
    assert client.until_done(within=30) == 0
    code = {"canceled": 5, "succeeded": 4}[status]
    assert client.output[-1] == (ended_s, f"status {code}, {numbers} numbers")
    (goal,) = client.goals
    assert (goal.action, goal.client, goal.server) == (
        "/fibonacci",
        "impatient_client",
        "sleepy_server",
    )
    assert (goal.accepted_s, goal.ended_s, goal.status) == (0.0, ended_s, status)
    assert [time_s for time_s, _ in goal.feedback[:5]] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert goal.cancel_s == (4.0 if arguments else 20.0)
    assert len(goal.result.sequence) == numbers
    assert stage.runs[0].check("always clearance > 0.1")


def test_a_program_may_end_at_its_start(stage: Stages, tmp_path: Path) -> None:
    """The test has run it to its end, though nothing else moved."""
    program = tmp_path / "ends.py"
    program.write_text("import rclpy\nrclpy.init()\nprint('end')\n", encoding="utf-8")
    ended = stage.program(program)
    assert (ended.until_done(), ended.text) == (0, "end\n")
    assert list(ended.run.untested) == []


def test_the_lines_of_a_program_are_covered(stage: Stages, tmp_path: Path) -> None:
    """Also those that follow a wait, in callbacks and threads, as pytest-cov counts them."""
    program = tmp_path / "waits.py"
    program.write_text(
        "import threading, time, rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
        "def work():\n    time.sleep(0.5)\n    print('thread')\n"
        "def tick():\n    timer.cancel()\n    time.sleep(1)\n    rclpy.shutdown()\n"
        "thread = threading.Thread(target=work)\nthread.start()\n"
        "timer = node.create_timer(0.1, tick)\nrclpy.spin(node)\n"
        "if rclpy.ok():\n    print('never')\nprint('end')\n",
        encoding="utf-8",
    )
    coverage = Coverage(
        data_file=None, config_file=False, concurrency="greenlet", include=[str(program)]
    )
    with coverage.collect():
        assert stage.program(program).until_done() == 0
    assert coverage.analysis2(str(program))[3] == [16]


def test_copies_of_a_program_have_their_own_goals(stage: Stages) -> None:
    """The second one has another name."""
    stage.program(CODE / "sleepy_server.py", arguments=["--threads"])
    clients = [stage.program(CODE / "impatient_client.py") for _ in range(2)]
    assert [client.until_done(within=30) for client in clients] == [0, 0]
    assert [[goal.client for goal in client.goals] for client in clients] == [
        ["impatient_client"],
        ["impatient_client_2"],
    ]


def test_a_program_serves_a_mission(stage: Stages) -> None:
    """It starts beside the run, before its first step."""
    run = stage.run(MISSION)
    server = stage.program(CODE / "sleepy_server.py", arguments=["--threads"])
    assert run.until_done(within=30).status == "success"
    (goal,) = server.goals
    assert (goal.client, goal.status, goal.ended_s) == ("", "canceled", 5.05)


ENDS = {
    "spins": (
        (
            "import rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
            "try:\n    rclpy.spin(node)\n"
            "except KeyboardInterrupt:\n    print('stopped', rclpy.ok())\n"
        ),
        (0, "stopped False"),
    ),
    "sleeps in a callback": (
        (
            "import time, rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
            "node.create_timer(0.5, lambda: time.sleep(60))\n"
            "try:\n    rclpy.spin(node)\nfinally:\n    print('ended')\n"
        ),
        (130, "KeyboardInterrupt"),
    ),
    "executes": (
        (
            "import time, rclpy\nfrom rclpy.action import ActionServer, ActionClient\n"
            "from example_interfaces.action import Fibonacci\nrclpy.init()\n"
            "node = rclpy.create_node('n')\n"
            "server = ActionServer(node, Fibonacci, 'f', lambda goal: time.sleep(60))\n"
            "client = ActionClient(node, Fibonacci, 'f')\n"
            "client.send_goal_async(Fibonacci.Goal())\n"
            "try:\n    rclpy.spin(node)\nexcept KeyboardInterrupt:\n    print('during a goal')\n"
        ),
        (0, "during a goal"),
    ),
    "has a handler": (
        (
            "import signal, time, rclpy\nrclpy.init()\ndone = []\n"
            "before = signal.signal(signal.SIGINT, lambda *_: done.append(time.time()))\n"
            "assert before is signal.default_int_handler\n"
            "while not done:\n    time.sleep(0.75)\n"
            "print('stopped', done[0] - 1, time.time() - 1, rclpy.ok())\n"
        ),
        (0, "stopped 1.0 1.5 True"),
    ),
    "has a handler of its loop": (
        (
            "import asyncio, signal, rclpy\nrclpy.init()\n"
            "async def main():\n    loop, event = asyncio.get_running_loop(), asyncio.Event()\n"
            "    loop.add_signal_handler(signal.SIGINT, event.set)\n"
            "    await event.wait()\n    await asyncio.sleep(0.5)\n    print('stopped')\n"
            "asyncio.run(main())\n"
        ),
        (0, "stopped"),
    ),
    "ignores it": (
        (
            "import signal, time, rclpy\nrclpy.init()\n"
            "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
            "time.sleep(2)\nprint('to the end')\n"
        ),
        (0, "to the end"),
    ),
    "ends at once": (
        (
            "import signal, time, rclpy\nrclpy.init()\n"
            "signal.signal(signal.SIGINT, signal.SIG_DFL)\n"
            "print('sleeps')\ntime.sleep(2)\n"
        ),
        (130, "sleeps"),
    ),
}


@pytest.mark.parametrize("name", ENDS)
def test_an_interrupt_is_that_of_a_terminal(stage: Stages, tmp_path: Path, name: str) -> None:
    """KeyboardInterrupt where the main thread waits, or the handler of the program."""
    code, (exit_code, line) = ENDS[name]
    (tmp_path / "program.py").write_text(code, encoding="utf-8")
    program = stage.program(tmp_path / "program.py", world="empty_arena")
    program.run.at(1.0, lambda _: program.interrupt())
    assert program.until_done(within=5) == exit_code, program.text
    assert program.output[-1].text == line
    with pytest.raises(ScenarioError, match="program has ended"):
        program.interrupt()


def test_what_cannot_be_tested_is_refused(stage: Stages, tmp_path: Path) -> None:
    """No file, a second stage, and two servers of one action."""
    with pytest.raises(ScenarioError, match="nothing is on the stage"):
        stage.until(lambda _: True)
    with pytest.raises(BtMissionError, match="no such file"):
        stage.program(tmp_path / "none.py")
    stage.until(lambda s: s.t > 0)
    with pytest.raises(ScenarioError, match="world: there is a stage already"):
        stage.program(CODE / "impatient_client.py", world="empty_arena")
    (tmp_path / "turns.py").write_text(
        "import rclpy\nfrom bt_mission_interfaces.action import Turn\n"
        "from rclpy.action import ActionServer\nrclpy.init()\nnode = rclpy.create_node('turns')\n"
        "server = ActionServer(node, Turn, 'turn', print)\nrclpy.spin(node)\n",
        encoding="utf-8",
    )
    with pytest.raises(BtMissionError, match=r"without=\[name\]"):
        stage.program(tmp_path / "turns.py")


def test_a_program_may_serve_an_action_of_ours(stage: Stages, tmp_path: Path) -> None:
    """If it is alone, too: `without` leaves ours out."""
    (tmp_path / "turns.py").write_text(
        "import rclpy\nfrom bt_mission_interfaces.action import Turn\n"
        "from rclpy.action import ActionClient, ActionServer\nrclpy.init()\n"
        "node = rclpy.create_node('turns')\n"
        "def turn(goal):\n    goal.succeed()\n    return Turn.Result(angle_turned=7.0)\n"
        "server = ActionServer(node, Turn, 'turn', turn)\n"
        "client = ActionClient(node, Turn, 'turn')\n"
        "goal = client.send_goal_async(Turn.Goal())\nrclpy.spin_until_future_complete(node, goal)\n"
        "end = goal.result().get_result_async()\nrclpy.spin_until_future_complete(node, end)\n"
        "print(end.result().result.angle_turned)\nnode.create_timer(0.5, rclpy.shutdown)\n"
        "rclpy.spin(node)\n",
        encoding="utf-8",
    )
    program = stage.program(tmp_path / "turns.py", world="empty_arena", without=["turn"])
    assert program.until_done(within=1) == 0
    assert program.text == "7.0\n"


def test_faults_reach_programs(stage: Stages) -> None:
    """A requirement is checked of the run, and the program drives on without odometry."""
    driver = stage.program(ROOT / "campaigns" / "programs" / "driver.py", world="empty_arena")
    driver.run.at(1.0, stage.faults.drop("odom", lasting=3.0))
    assert driver.until_done(within=10) == 0
    assert driver.output[-1].text == "there"
    assert driver.output[-1].time_s >= 4.0
    assert driver.run.check("eventually x > 0.7")
    assert driver.run.check("always clearance > 0.1")
