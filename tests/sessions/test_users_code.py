"""Code of users on the stage: it may neither hold the clock nor end the process."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading  # noqa: TID251 - a worker's task is in another thread
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from rclpy import utilities

from bt_mission.base import clock_watch, interrupts
from bt_mission.base.clock_watch import ClockWatch, LeftError, callback_in, refuse_leaving, told_by
from bt_mission.base.diagnostics import InputError
from bt_mission.cli.recorded_scenario import recording_and_report
from bt_mission.executive.report import Report
from bt_mission.scenarios import run as scenario_run
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from tests.support.thorough import sample

NODE = """\
import rclpy, select, sys, threading, time
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

class Quit(BaseException):
    pass

class Server(Node):
    def __init__(self, **options):
        super().__init__("numbers", **options)
        self.server = ActionServer(self, Fibonacci, "fib", self.execute)
        self.create_timer(0.3, self.beat)
        self.client = self.create_client(Trigger, "nobody")

    def beat(self):
        {beat}

    def execute(self, goal):
        {execute}
        goal.succeed()
        return Fibonacci.Result()
"""
CALLS = """\
mission: calls
world: empty_arena
nodes: ["server.py:Server"]
tree:
  sequence:
    - action: {name: fib, type: example_interfaces/action/Fibonacci, goal: {order: 5}}
      timeout: 60
    - wait: 1
"""
LEAF = """\
import rclpy, sys, threading, time
from py_trees.behaviour import Behaviour
from py_trees.common import Status

class Leaf(Behaviour):
    def __init__(self, name):
        super().__init__(name)
        {init}

    def setup(self, **_):
        {setup}

    def update(self):
        {update}
        return Status.SUCCESS

    def terminate(self, status):
        {terminate}
"""
WITH_LEAF = """\
mission: calls
world: empty_arena
tree:
  sequence:
    - wait: 0.5
    - python: "leaf.py:Leaf"
"""


def written(folder: Path, part: str, code: str) -> Path:
    """Write a mission with this code in one part of its node or leaf."""
    parts = dict.fromkeys(("beat", "execute", "init", "setup", "update", "terminate"), "pass")
    is_node = part in ("beat", "execute")
    name, text, mission = ("server.py", NODE, CALLS) if is_node else ("leaf.py", LEAF, WITH_LEAF)
    (folder / name).write_text(text.format(**{**parts, part: code}), encoding="utf-8")
    path = folder / "calls.yaml"
    path.write_text(mission, encoding="utf-8")
    return path


def ran(path: Path, **options: Any) -> Report:
    """Run a mission on a stage, driven to its end."""
    chosen = StageOptions(**options)
    with Stage(load(path), image_folder=path.parent, options=chosen) as stage:
        (report,) = drive(stage)
        return report


# ---- the clock is held -----------------------------------------------------------------------


@pytest.fixture
def lines() -> Iterator[list[str]]:
    """What people are told about the clock."""
    printed: list[str] = []
    with told_by(printed.append):
        yield printed


@pytest.mark.parametrize(
    ("part", "code", "name", "line"),
    sample(
        [
            ("execute", "[select.select([], [], [], 0.1) for _ in range(5)]", "Server.execute", 22),
            ("beat", "select.select([], [], [], 0.3)", "Server.beat", 19),
            ("update", "threading.Event().wait(0.3)", "Leaf.update", 14),
        ],
        3,
    ),
)
def test_code_that_waits_makes_the_times_wrong(
    tmp_path: Path, lines: list[str], part: str, code: str, name: str, line: int
) -> None:
    """The mission goes on to its end, and has failed; a line says so while it runs."""
    report = ran(written(tmp_path, part, code))
    file = "leaf.py" if part == "update" else "server.py"
    place = f"{name} ({file}:{line})"
    assert (report.status, report.reason) == (
        "failure",
        f"the times are wrong: {place} held the clock [BT-918]",
    )
    assert lines == [f"{place} waits for the wall clock; virtual time stands still meanwhile"]


def test_code_that_computes_is_not_blamed(tmp_path: Path, lines: list[str]) -> None:
    """Processor time is no virtual time; nor are two seconds of a busy machine."""
    assert ran(written(tmp_path, "execute", "sum(range(10_000_000))")).status == "success"
    assert lines == []


@pytest.mark.parametrize(
    "code",
    [
        "for _ in iter(int, 1): pass",
        "select.select([], [], [])",
    ],
    ids=["loop", "input"],
)
def test_code_that_does_not_return_is_interrupted_at_its_limit(
    tmp_path: Path, code: str, lines: list[str]
) -> None:
    """Where nobody presses Ctrl-C. Its goal ends, and the result names the place."""
    report = ran(written(tmp_path, "execute", code), hold_limit_s=0.4)
    assert report.status == "failure"
    assert "Server.execute (server.py:2" in report.reason
    assert "did not return within 0.4 s of wall time [BT-918]" in report.reason
    assert report.goals_left_behind == 0


def test_a_leaf_that_does_not_return_is_named_while_it_blocks(
    tmp_path: Path, lines: list[str]
) -> None:
    """After two seconds of wall time."""
    ran(written(tmp_path, "update", "threading.Event().wait()"), hold_limit_s=2.5)
    held = "holds the clock; virtual time stands still while it runs"
    assert lines[-1] == f"Leaf.update (leaf.py:14) {held}"


def test_a_request_that_is_being_noted_is_not_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The code that holds the clock is interrupted after the handler of Ctrl-C, not within it."""

    def interrupted_name(_number: int) -> str:
        signal.raise_signal(clock_watch._KICK)
        return "Ctrl-C"

    monkeypatch.setattr(interrupts, "name_of", interrupted_name)
    report = ran(
        written(tmp_path, "update", "__import__('signal').raise_signal(2); return Status.RUNNING")
    )
    assert (report.status, report.reason) == ("interrupted", "interrupted by Ctrl-C")


def test_a_worker_reports_code_that_does_not_return(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A task of a worker is no main thread: a wait there cannot be interrupted."""
    monkeypatch.setattr(scenario_run, "UNATTENDED_S", 0.3)
    base = load_base(written(tmp_path, "execute", "select.select([], [], [])"), BaseChanges())
    rows: list[ScenarioRow] = []
    with ScenarioWorker(base.bundle) as worker:
        scenario = base.concrete({})
        task = threading.Thread(target=lambda: rows.append(worker.carry_out(scenario)))
        task.start()
        task.join()
    (row,) = rows
    assert (row.outcome, row.reason) == ("error", "Server.execute (server.py:22) does not return")
    assert traced(lambda: 42) == 42  # for ever, while that thread has an exception to raise


def test_a_recording_of_code_that_does_not_return_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lines: list[str]
) -> None:
    """The worst runs of a sweep are recorded, and nobody watches that either."""
    monkeypatch.setattr(scenario_run, "UNATTENDED_S", 0.3)
    base = load_base(written(tmp_path, "execute", "for _ in iter(int, 1): pass"), BaseChanges())
    with ScenarioWorker(base.bundle) as worker:
        recording, page = worker.run_again(base.concrete({}), recording_and_report)
    held = "Server.execute (server.py:22) did not return within 0.3 s of wall time"
    assert held in page.decode()
    assert recording.startswith(b"\x89MCAP")
    assert lines == []


def traced(function: Callable[[], int]) -> int:
    """Return what a function returns under a trace, as of debuggers and coverage."""
    before = sys.gettrace()
    sys.settrace(lambda *_: None)
    try:
        return function()
    finally:
        sys.settrace(before)


def test_a_watch_ends_with_the_thread_it_looks_at() -> None:
    """A thread that is given up takes its session with it."""
    watches: list[ClockWatch] = []
    begin = partial(ClockWatch, lambda: 0, is_virtual=True)
    task = threading.Thread(target=lambda: watches.append(begin()))
    task.start()
    task.join()
    watches[0]._watcher.join()  # an error of it would fail this test
    watches[0].close()


def test_a_test_that_waits_in_an_action_fails_its_run(stage: Any, lines: list[str]) -> None:
    """As a node that waits: nothing else happens meanwhile."""
    run = stage.run("mission: m\nworld: empty_arena\ntree: {wait: 2}\n")
    run.at(1, lambda _: threading.Event().wait(0.3))
    report = run.until_done()
    assert "held the clock [BT-918]" in report.reason
    assert report.status == "failure"


TWIST = """\
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node

class Server(Node):
    def __init__(self, **options):
        super().__init__("numbers", **options)
        self.publisher = self.create_publisher(Twist, "cmd_vel", 1)
        self.create_timer(0.1, self.drive)

    def drive(self):
        assert rclpy.ok()
        command = Twist()
        command.linear.x = 0.2
        self.publisher.publish(command)
"""


def test_a_node_drives_by_plain_twists_where_the_stage_takes_them(tmp_path: Path) -> None:
    """Otherwise the error says what to do. The context of the stage is rclpy's default one."""
    before = utilities.get_default_context()
    path = written(tmp_path, "beat", "pass")
    (tmp_path / "server.py").write_text(TWIST, encoding="utf-8")
    path.write_text(CALLS.partition("tree:")[0] + "tree: {wait: 2}\n", encoding="utf-8")
    report = ran(path, command_type="plain")
    assert report.status == "success", report.reason
    assert report.distance_travelled_m == pytest.approx(0.37, abs=0.05)
    with pytest.raises(InputError, match=r"takes TwistStamped; .* --cmd-vel-type plain"):
        ran(path)
    assert utilities.g_default_context is before


# ---- the process is to end -------------------------------------------------------------------


@pytest.mark.parametrize(
    "part", sample(["execute", "beat", "init", "setup", "update", "terminate"], 3)
)
@pytest.mark.parametrize(
    ("code", "what"),
    [
        ("sys.exit(0)", "SystemExit: 0"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("raise GeneratorExit", "GeneratorExit"),
    ],
)
def test_no_code_ends_the_process(tmp_path: Path, part: str, code: str, what: str) -> None:
    """The mission fails, with the place, and every goal has ended."""
    path = written(tmp_path, part, code)
    try:
        report = ran(path)
    except Exception as error:  # noqa: BLE001 - the mission cannot be set up
        assert part in ("init", "setup")
        reason = f"{error} [{getattr(error, 'code', '')}]"
    else:
        assert (report.status, report.goals_left_behind) == ("failure", 0)
        reason = report.reason
    assert f"code of a mission must not end the process: {what} (" in reason
    assert "[BT-913]" in reason
    if part in ("init", "setup", "update"):
        assert "calls.yaml:6:7: " in reason


@pytest.mark.parametrize("part", sample(["execute", "beat", "update", "terminate"], 2))
@pytest.mark.parametrize("call", ["rclpy.shutdown()", "rclpy.try_shutdown()"])
def test_no_code_ends_ros(tmp_path: Path, part: str, call: str) -> None:
    """It is the run's; one line says so, with the place."""
    report = ran(written(tmp_path, part, call))
    assert (report.status, report.goals_left_behind) == ("failure", 0)
    what = "ContextShutdown: rclpy.shutdown() ends ROS for every node of the run; leave it out ("
    assert f"code of a mission must not end the process: {what}" in report.reason
    assert "[BT-913]" in report.reason


def test_a_node_that_destroys_itself_is_named(tmp_path: Path) -> None:
    """Nothing answers for it any more; the reason says why, and where its class is."""
    path = written(tmp_path, "execute", "self.destroy_node()")
    path.write_text(CALLS.replace("timeout: 60", "timeout: 1"), encoding="utf-8")
    report = ran(path)
    assert report.status == "failure"
    words = "the node of server.py:Server was destroyed while it was needed (server.py:12): leave"
    assert words in report.reason


def test_a_node_that_is_never_made_is_named(tmp_path: Path) -> None:
    """Its class waits in a loop that does not end."""
    path = written(tmp_path, "execute", "pass")
    path.write_text(CALLS.replace("timeout: 60", "timeout: 1"), encoding="utf-8")
    server = tmp_path / "server.py"
    code = server.read_text(encoding="utf-8")
    loop = code.replace(
        "        super().__init__", "        while True: pass\n        super().__init__"
    )
    assert loop != code
    server.write_text(loop, encoding="utf-8")
    report = ran(path)
    assert report.status == "failure"
    assert "server.py:Server has not returned, so its node was not there" in report.reason


def test_a_callback_that_awaits_asyncio_is_told_of_rclpy(tmp_path: Path) -> None:
    """Which has no loop of it, on the stage as elsewhere."""
    path = written(tmp_path, "execute", "await asyncio.sleep(1)")
    code = (tmp_path / "server.py").read_text(encoding="utf-8")
    code = code.replace("def execute", "async def execute")
    code = code.replace("import rclpy", "import asyncio, rclpy")
    (tmp_path / "server.py").write_text(code, encoding="utf-8")
    reason = ran(path).reason
    assert "RuntimeError: no running event loop; rclpy has no loop of asyncio: await a " in reason
    assert "(server.py:22)" in reason


class Quit(BaseException):
    """Of a user."""


@pytest.mark.parametrize(
    ("error", "is_theirs"),
    [(SystemExit(0), True), (GeneratorExit(), True), (Quit(), True), (ValueError(), False)],
)
def test_what_counts_as_ending_the_process(error: BaseException, is_theirs: bool) -> None:  # noqa: FBT001 - a case
    """An ordinary exception does not; nor does what pytest raises to skip or fail a test."""
    refuse_leaving(pytest.skip.Exception("later"))
    with pytest.raises(LeftError) if is_theirs else nullcontext():
        refuse_leaving(error)


@pytest.mark.parametrize("method", ["at", "do"])
def test_actions_of_a_test_do_not_end_it(stage: Any, method: str) -> None:
    """A test that is left by sys.exit would have shown nothing."""
    run = stage.run("mission: m\nworld: empty_arena\ntree: {wait: 2}\n")
    leave: Callable[[Any], None] = lambda _: exit(0)  # noqa: E731, PLR1722 - as users write it

    def act() -> None:
        (run.at(1, leave) if method == "at" else run.do(leave))
        run.until_done()

    with pytest.raises(Exception, match="must not end the process: SystemExit: 0"):
        act()
    assert run.until_done().status == "success", "the fault is the test's, not the mission's"
    assert callback_in(None) is None


STACKS = """\
import sys, threading
from bt_mission.base import clock_watch

class Garbage:
    def __init__(self):
        self.cycle = self
    def __del__(self):
        sum(range(200))

def look():
    for _ in range(5000):
        clock_watch._callback_of(clock_watch._stack_of(main))

def deepen(levels):
    Garbage()
    return [deepen(levels - 1) for _ in range(levels > 0)]

main, watcher = threading.get_ident(), threading.Thread(target=look)
sys.setswitchinterval(1e-5)
watcher.start()
while watcher.is_alive():
    deepen(60)
"""


@pytest.mark.process
def test_a_stack_is_read_while_its_thread_stands_still() -> None:
    """CPython 3.11 crashes where it runs on, also for finalizers of garbage."""
    assert subprocess.run([sys.executable, "-c", STACKS], check=False).returncode == 0
