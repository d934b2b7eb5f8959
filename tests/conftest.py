"""Isolation of the test session (its own DDS domain), and a server that a test plays."""

import os
import signal
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from rclpy.logging import LoggingSeverity, set_logger_level

from bt_mission.executive.goals.goal import Goal, GoalTrigger
from bt_mission.testing.live_graph import own_domain
from tests.support.play import Play

pytest_plugins = [
    "pytester",
    "tests.support.checkout",
    "tests.support.command_line",
    "tests.support.forked",
    "tests.support.installed",
    "tests.support.no_skips",
    "tests.support.recorded_runs",
    "tests.support.thorough",
]

# Before any test module imports rclpy. The domain belongs to this process as long as it lives.
# Within a process DDS works with discovery off; a test with processes of its own hands them
# ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.
_DOMAIN = ExitStack()
os.environ["ROS_DOMAIN_ID"] = str(_DOMAIN.enter_context(own_domain()))
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
os.environ["ROS_LOG_DIR"] = str(Path(tempfile.gettempdir()) / "bt_mission_test_logs")

# Ctrl-C is ignored by what a shell starts in the background, and by the children of that, too.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The same sources give the same verdict: no examples at random, no limit on the wall clock.
settings.register_profile("bt_mission", derandomize=True, deadline=None)
settings.load_profile("bt_mission")


class ScriptedServer:
    """A goal client whose server answers when the test lets it."""

    def __init__(self, name: str = "/turn", *, ready: bool = True) -> None:
        self.name = name
        self.type_name = "test_msgs/action/Test"
        self.ready = ready
        self.goals: list[Goal] = []
        self.requests: list[Any] = []
        self.results_asked: list[Goal] = []
        self.cancels: list[Goal] = []

    def is_ready(self) -> bool:
        return self.ready

    def obstacle(self) -> str:
        return ""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return fields

    def send(self, goal: Goal, request: Any) -> None:
        self.goals.append(goal)
        self.requests.append(request)

    def recover_goal(self, goal: Goal) -> None:
        self.goals.append(goal)

    def ask_result(self, goal: Goal) -> None:
        self.results_asked.append(goal)

    def send_cancel(self, goal: Goal) -> None:
        self.cancels.append(goal)

    # the moves

    @property
    def goal(self) -> Goal:
        return self.goals[-1]

    def accept(self) -> None:
        self.goal.on(GoalTrigger.ACCEPTED)

    def reject(self) -> None:
        self.goal.on(GoalTrigger.REJECTED)

    def feed(self, feedback: Any) -> None:
        self.goal.on_feedback(feedback)

    def refuse_cancel(self) -> None:
        self.goal.on(GoalTrigger.CANCEL_REFUSED)

    def succeed(self, result: Any = "result") -> None:
        self.goal.on_result(4, result)

    def cancel(self, result: Any = "partial") -> None:
        self.goal.on_result(5, result)

    def abort(self, result: Any = None) -> None:
        self.goal.on_result(6, result)


@pytest.fixture(autouse=True)
def _log_level() -> Iterator[None]:
    """A command that silences the logs of ROS does so until its test ends."""
    yield
    set_logger_level("", LoggingSeverity.INFO)


@pytest.fixture
def server() -> ScriptedServer:
    """A server at ``/turn`` that the test plays."""
    return ScriptedServer()


@pytest.fixture
def play(server: ScriptedServer) -> Callable[[str], Play]:
    """Set a mission's tree up: ``play(yaml_of_the_tree)``."""

    def start(tree: str, head: str = "mission: test") -> Play:
        return Play(f"{head}\ntree:\n{tree}", type(server))

    return start


@pytest.fixture
def rig() -> Iterator[Any]:
    """Nodes on one virtual clock."""
    from tests.support.rig import Rig  # noqa: PLC0415 - after the environment is set

    made = Rig()
    yield made
    made.close()


@pytest.fixture(scope="session")
def chromium_of_all(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A browser for all tests of this process."""
    from tests.support.browser import browser  # noqa: PLC0415 - most tests need none

    with browser(tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture
def chromium(chromium_of_all: Any) -> Iterator[Any]:
    """The page of a browser, which shows nothing before and after."""
    chromium_of_all.problems.clear()
    yield chromium_of_all
    chromium_of_all.prefer("")
    chromium_of_all.visit("about:blank", width=800, height=600)


@pytest.fixture
def context() -> Iterator[Any]:
    """A context of rclpy's, for nodes that the test makes."""
    import rclpy  # noqa: PLC0415 - after the environment is set

    made = rclpy.Context()
    rclpy.init(context=made)
    yield made
    made.shutdown()


@pytest.fixture
def ros() -> Iterator[Any]:
    """Missions, and servers that the test plays, over real rclpy on one virtual clock."""
    from tests.support.graph import Graph  # noqa: PLC0415 - after the environment is set

    graph = Graph()
    yield graph
    graph.close()
