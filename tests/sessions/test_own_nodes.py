"""The user's own nodes on the stage: `nodes` of missions, scenarios and fleets, and in Python."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission, Turn
from rclpy.action import ActionServer
from rclpy.node import Node
from std_msgs.msg import String

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.cli import main
from bt_mission.executive.report import Report
from bt_mission.language.plugins import find_factory
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.scenarios.fleets.loader import load_fleet
from bt_mission.scenarios.fleets.run import run_fleet
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load
from bt_mission.sessions.served_missions import ServedMissions
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from bt_mission.testing.run import Run
from tests.support.own_nodes import TURN_SERVER, written
from tests.support.project import ROOT

CODE = ROOT / "docs" / "tutorials" / "code"
WITH_NODES = "numbers_in_simulation.yaml"

WAITS = "mission: m\nworld: empty_arena\ntree: {wait: 1}\n"


def ran(mission: Any, folder: Path, **options: Any) -> Report:
    """Run a mission on a stage."""
    with Stage(mission, image_folder=folder, options=StageOptions(**options)) as stage:
        while not stage.is_done:
            stage.step()
        return stage.report()


def refused(call: Callable[[], Any]) -> str:
    """Gives the error, as people see it."""
    with pytest.raises(BtMissionError) as caught:
        call()
    return str(caught.value)


def test_the_example_calls_its_own_servers(tmp_path: Path) -> None:
    """The servers are those of the tutorial; each run has the same trace."""
    mission = load(CODE / WITH_NODES)
    first = ran(mission, tmp_path)
    assert (first.status, first.goals_left_behind) == ("success", 0)
    assert first.virtual_s == 6.35
    assert ran(mission, tmp_path).trace_sha256 == first.trace_sha256


def test_an_own_server_replaces_ours(tmp_path: Path) -> None:
    """There is one server of the action: the mission gets its result."""
    assert ran(load(written(tmp_path, "server.py:TurnServer")), tmp_path).status == "success"
    assert ran(load(written(tmp_path)), tmp_path).status == "failure"


TWO_SERVERS = """\
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

def make(name, options, **qos):
    node = Node(name, **options)
    node.server = ActionServer(node, Turn, "turn", lambda _: None, **qos)
    return node

def first(**options):
    return make("first", options)

def second(**options):
    return make("second", options)

def muffled(**options):
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    return make("muffled", options, feedback_pub_qos_profile=qos)
"""


@pytest.mark.parametrize(
    ("nodes", "words"),
    [
        ("server.py:first, server.py:second", "/turn has 2 servers (/first, /second): each of "),
        ("server.py:muffled", "/turn: its server /muffled publishes feedback with best effort "),
    ],
)
def test_own_servers_that_can_get_no_goal_are_named(tmp_path: Path, nodes: str, words: str) -> None:
    """At once, instead of a mission that waits."""
    mission = load(written(tmp_path, nodes, TWO_SERVERS))
    assert refused(lambda: ran(mission, tmp_path)).startswith(words)


REJECTS = (
    TURN_SERVER.replace(
        'ActionServer(self, Turn, "turn", self.turn)',
        'ActionServer(self, Turn, "turn", self.turn, goal_callback=self.refuse)',
    )
    + """
    def refuse(self, _):
        self.get_logger().{level}("battery at 7%")
        return 1
"""
)


@pytest.mark.parametrize(
    ("level", "words"), [("warning", "battery at 7%"), ("info", "logged 'battery at 7%'")]
)
def test_an_own_server_says_why_it_rejects(tmp_path: Path, level: str, words: str) -> None:
    """By its log; for its first goal, too."""
    mission = load(written(tmp_path, "server.py:TurnServer", REJECTS.replace("{level}", level)))
    report = ran(mission, tmp_path)
    assert report.reason == f"'turn' rejected: /turn: {words}"


def test_timers_of_an_own_node_are_on_the_clock_of_the_stage(tmp_path: Path) -> None:
    """Whatever its parameter `use_sim_time` says."""
    times = []

    class Clock(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("own_clock", **options)
            self.create_timer(0.5, lambda: times.append(self.get_clock().now().nanoseconds))

    assert ran(load(WAITS.replace("1", "2")), tmp_path, nodes=[Clock]).status == "success"
    assert times[:3] == [1_500_000_000, 2_000_000_000, 2_500_000_000]


def test_a_scenario_names_further_nodes(tmp_path: Path) -> None:
    """Beside the scenario, which need not lie beside the mission."""
    written(tmp_path)
    (tmp_path / "deep").mkdir()
    (tmp_path / "server.py").rename(tmp_path / "deep" / "server.py")
    path = tmp_path / "deep" / "it.scenario.yaml"
    text = "scenario: it\nmission: ../turns.yaml\nnodes: [server.py:TurnServer]\n"
    path.write_text(text, encoding="utf-8")
    assert run_scenario(load_scenario(path)).passed
    base = load_base(path, BaseChanges())
    with ScenarioWorker(base.bundle) as worker:
        row = worker.carry_out(base.concrete({}))
    assert row.outcome == "success", row.reason


def test_a_sweep_takes_the_files_of_nodes_along(tmp_path: Path) -> None:
    """Each worker has a folder of its own."""
    base = load_base(written(tmp_path, "server.py:TurnServer"), BaseChanges())
    with ScenarioWorker(base.bundle) as worker:
        row = worker.carry_out(base.concrete({}, seed=4))
    assert row.outcome == "success", row.reason


def test_each_robot_of_a_fleet_has_the_nodes_of_its_mission(tmp_path: Path) -> None:
    """In its namespace; those that the fleet names are there once."""
    written(tmp_path, "server.py:TurnServer")
    common = "\n\ndef common(**options):\n    node = Node('common', **options)\n"
    common += "    MADE.append(node.get_fully_qualified_name())\n    return node\n"
    (tmp_path / "server.py").write_text(TURN_SERVER + common, encoding="utf-8")
    path = tmp_path / "two.fleet.yaml"
    path.write_text(
        "fleet: two\nnodes: [server.py:common]\nrobots:\n"
        "  robot1: {mission: turns.yaml, start: {x: 1}}\n"
        "  robot2: {mission: turns.yaml, start: {x: -1}}\n",
        encoding="utf-8",
    )
    assert run_fleet(load_fleet(path)).status == "success"
    module = sys.modules[find_factory("server.py:common", str(path)).__module__]
    assert module.MADE == ["/common", "/robot1/own_turn", "/robot2/own_turn"]


# ---- trust -----------------------------------------------------------------------------------


def test_served_missions_need_leave_for_them(tmp_path: Path) -> None:
    """The same as for Python leaves, and never a file from elsewhere."""
    path = written(tmp_path, "server.py:TurnServer", "raise RuntimeError('was run')\n")
    goal = ExecuteMission.Goal(path=str(path), seed=-1)
    output = refused(lambda: ServedMissions((tmp_path,)).load(goal))
    assert "turns.yaml:3:9: error: the Python node 'server.py:TurnServer' is refused" in output
    assert "--allow-python" in output
    # Served missions run on a graph, which has its own servers: nothing is imported.
    assert ServedMissions((tmp_path,), allow_python=True).load(goal).name == "turns"
    outside = ExecuteMission.Goal(path=str(written(tmp_path, "os:getcwd")), seed=-1)
    output = refused(lambda: ServedMissions((tmp_path,), allow_python=True).load(outside))
    assert "the module 'os' must not be imported here" in output


def test_check_only_names_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Unless it is told to import them."""
    path = written(tmp_path, "server.py:TurnServer", "raise RuntimeError('was run')\n")
    assert main(["check", str(path)]) == 0
    assert "was not imported: 'server.py:TurnServer'" in capsys.readouterr().err
    assert main(["check", str(path), "--import-python"]) == 2
    assert "was run" in capsys.readouterr().err


OTHER_CONTEXT = """\
from rclpy.context import Context
from rclpy.node import Node

def make(**_):
    other = Context()
    other.init()
    return Node("x", context=other)
"""
OUR_NAME = """\
from rclpy.node import Node

def make(**options):
    return Node("bt_mission_sim", **options)
"""


# ---- factories that make no node -------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("server.py:Turnserver", "no 'Turnserver' in server.py (functions or classes: "),
        ("nowhere.py:make", "no such file: nowhere.py"),
        ("no_such_package.server:make", "the module no_such_package.server cannot be imported"),
        ("server.py:MADE", "server.py:MADE is neither a function nor a class"),
        (
            "countdown",
            "expected 'my_package.server:make', 'server.py:make' or a program, 'server.py'",
        ),
    ],
)
def test_factories_that_are_not_there(tmp_path: Path, target: str, words: str) -> None:
    """Found before anything moves, at their place."""
    mission, diagnostics = examine(written(tmp_path, f"{target}"))
    assert mission is None
    assert [(diagnostic.line, diagnostic.column) for diagnostic in diagnostics] == [(3, 9)]
    assert words in diagnostics[0].message


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("def make(**_):\n    return 1\n", "server.py:make returned int; expected an rclpy Node"),
        ("def make():\n    pass\n", "raised TypeError: make() got an unexpected keyword argument"),
        ("def make(**_):\n    {}['x']\n", "server.py:make raised KeyError: 'x' (server.py:2)"),
        ("def make(**_):\n    raise SystemExit(3)\n", "server.py:make raised SystemExit: 3"),
        (
            "import signal\ndef make(**_):\n    signal.raise_signal(signal.SIGALRM)\n",
            "server.py:make did not return within 10 s",
        ),
        (OTHER_CONTEXT, "server.py:make created its node in another rclpy context"),
        (OUR_NAME, "a node '/bt_mission_sim' already exists on the stage"),
    ],
)
def test_factories_that_make_no_node(tmp_path: Path, code: str, words: str) -> None:
    """An error at its place in the file, and no traceback."""
    mission = load(written(tmp_path, "server.py:make", code))
    with pytest.raises(InputError) as caught:
        ran(mission, tmp_path)
    (fault,) = caught.value.diagnostics
    assert (Path(fault.file).name, fault.line, fault.column) == ("turns.yaml", 3, 9)
    assert words in fault.message


def test_a_callable_that_makes_no_node(tmp_path: Path) -> None:
    """In Python it has no place, and the same words."""

    def make(**_: Any) -> Any:
        return None

    output = refused(lambda: ran(load(WAITS), tmp_path, nodes=[make]))
    assert output.endswith("make returned NoneType; expected an rclpy Node")


def test_a_callback_that_raises_ends_the_mission(tmp_path: Path) -> None:
    """As one of any other node on the stage."""

    class Broken(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("broken", **options)
            self.create_timer(0.2, self.fail)
            self.create_publisher(String, "said", 1)

        def fail(self) -> None:
            raise ValueError("worn out")

    report = ran(load(WAITS), tmp_path, nodes=[Broken])
    assert (report.status, report.virtual_s) == ("failure", 0.2)
    assert "worn out" in report.reason


RAISES = "raise ValueError('jammed')"
EXECUTES = """\
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer
from rclpy.node import Node

class Server(Node):
    def __init__(self, **options):
        super().__init__("numbers", **options)
        self.server = ActionServer(self, Fibonacci, "fib", self.compute)

    {prefix}def compute(self, goal):
        {body}
"""
FIB = "{name: fib, type: example_interfaces/action/Fibonacci, goal: {order: 3}}"


def executing(folder: Path, tree: str, body: str, prefix: str = "") -> Path:
    """Write a server whose execute callback has this body, and a mission; gives the mission."""
    (folder / "server.py").write_text(EXECUTES.format(body=body, prefix=prefix), encoding="utf-8")
    path = folder / "numbers.yaml"
    head = "mission: numbers\nworld: empty_arena\nnodes: [server.py:Server]\n"
    path.write_text(f"{head}tree:\n{tree}", encoding="utf-8")
    return path


@pytest.mark.parametrize("prefix", ["", "async "])
def test_an_execute_callback_that_raises_aborts_its_goal(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], prefix: str
) -> None:
    """As under rclpy; the reason and one line of the log name the exception and its place."""
    path = executing(tmp_path, f"  action: {FIB}\n", RAISES, prefix)
    report = ran(load(path), tmp_path)
    reason = "aborted: /fib: ValueError: jammed (server.py:11)"
    assert (report.status, report.reason) == ("failure", f"'fib' {reason}")
    assert report.failure is not None
    assert (report.failure.nodes, report.failure.message) == (("fib",), reason)
    assert report.goals_left_behind == 0
    logged = capfd.readouterr().err
    assert "Traceback" not in logged
    callback = "Server.compute() (server.py:10), for '/fib' of node '/numbers',"
    assert f"[numbers]: {callback} raised ValueError: jammed (server.py:11)" in logged
    assert "assuming aborted" not in logged


@pytest.mark.parametrize("prefix", ["", "async "])
def test_a_goal_that_no_callback_ends_is_aborted_with_the_reason(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], prefix: str
) -> None:
    """As under rclpy, which logs the UUID alone."""
    path = executing(tmp_path, f"  action: {FIB}\n", "return Fibonacci.Result()", prefix)
    report = ran(load(path), tmp_path)
    words = "returned without goal.succeed(), canceled() or abort()"
    assert (report.status, report.reason) == ("failure", f"'fib' aborted: /fib: {words}")
    callback = "Server.compute() (server.py:10), for '/fib' of node '/numbers',"
    logged = capfd.readouterr().err
    assert f"[numbers]: {callback} {words}; the goal is aborted" in logged
    assert "Goal state not set" not in logged


def test_an_exception_of_a_library_has_the_place_in_the_users_code(tmp_path: Path) -> None:
    """A place within the library would tell its user nothing."""
    path = executing(tmp_path, f"  action: {FIB}\n", "import json; json.loads('')")
    assert ran(load(path), tmp_path).reason.endswith("(char 0) (server.py:11)")


def test_a_mission_recovers_from_an_execute_callback_that_raises(tmp_path: Path) -> None:
    """The goal fails, not the mission."""
    tree = f"  fallback:\n    - action: {FIB}\n    - log: plan B\n"
    report = ran(load(executing(tmp_path, tree, RAISES)), tmp_path)
    assert (report.status, report.goals_left_behind) == ("success", 0)


def test_the_reason_of_an_abort_is_that_of_its_own_goal(tmp_path: Path) -> None:
    """A later goal that the same server aborts has none."""
    body = "self.goals = getattr(self, 'goals', 0) + 1\n        if self.goals == 1:\n"
    body += f"            {RAISES}\n        goal.abort()\n        return Fibonacci.Result()"
    tree = f"  fallback:\n    - action: {FIB}\n    - action: {FIB}\n"
    report = ran(load(executing(tmp_path, tree, body)), tmp_path)
    assert report.reason == "'fib' aborted: /fib"


@pytest.mark.parametrize(("returned", "words"), [("", "nothing"), ("5", "the number 5")])
def test_an_execute_callback_without_a_result_ends_the_mission(
    tmp_path: Path, returned: str, words: str
) -> None:
    """The reason names the callback, the action and the node."""
    body = f"goal.succeed()\n        return {returned}"
    report = ran(load(executing(tmp_path, f"  action: {FIB}\n", body)), tmp_path)
    assert (report.status, report.goals_left_behind) == ("failure", 0)
    assert report.reason == (
        "a callback failed: Server.compute() (server.py:10), for '/fib' of node '/numbers', "
        f"returned {words}, expected Fibonacci.Result [BT-903]"
    )


@pytest.mark.parametrize(
    ("body", "cause"),
    [
        ("return Fibonacci.Result(sequence=['one'])", "TypeError: 'str' object cannot be"),
        ("goal.succeed()", "RCLError: Failed to update goal state"),
        (RAISES, "ValueError: jammed"),
    ],
)
def test_an_exception_after_success_ends_the_mission(tmp_path: Path, body: str, cause: str) -> None:
    """The client would receive an empty result as a success. The place is the user's line."""
    path = executing(tmp_path, f"  action: {FIB}\n", f"goal.succeed()\n        {body}")
    report = ran(load(path), tmp_path)
    assert (report.status, report.goals_left_behind) == ("failure", 0)
    head, _, tail = report.reason.partition(cause)
    assert head == (
        "a callback failed: Server.compute() (server.py:10), for '/fib' of node '/numbers', raised "
    )
    assert tail.endswith(" (server.py:12), after goal.succeed(); the result is empty [BT-903]")


@pytest.mark.parametrize(
    ("body", "prefix"),
    [
        ("goal.canceled()", ""),  # not asked to cancel
        ("goal.publish_feedback(Fibonacci.Result())", ""),
        ("Fibonacci.Result().sequence = 5", ""),
        ("import asyncio; await asyncio.sleep(1)", "async "),
    ],
)
def test_the_place_of_an_error_that_a_library_raises_is_the_callers(
    tmp_path: Path, body: str, prefix: str
) -> None:
    """Of Python's library, of rclpy, and of generated interfaces."""
    report = ran(load(executing(tmp_path, f"  action: {FIB}\n", body, prefix)), tmp_path)
    assert report.reason.startswith("'fib' aborted: /fib: ")
    assert report.reason.endswith(" (server.py:11)")


def test_a_test_of_pytest_adds_nodes(tmp_path: Path) -> None:
    """An option of the run, which takes anything that makes a node."""

    def make(**options: Any) -> Node:
        node = Node("own_turn", **options)

        def turn(goal: Any) -> Any:
            goal.succeed()
            return Turn.Result(angle_turned=1234.0)

        ActionServer(node, Turn, "turn", turn)
        return node

    run = Run(load(written(tmp_path)), tmp_path, nodes=[make])
    run.until_done()
    assert run.report.status == "success"
    run.close()
