"""Who is served while a callback blocks: as the executor of a program, and its groups, decide."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import rclpy.executors
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.node import Node
from std_srvs.srv import Trigger

from bt_mission.programs.stuck import DeadlockError
from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

LEAN: dict[str, Any] = {"start_parameter_services": False}


class Server(Node):
    """A Fibonacci server, as beginners write it."""

    def __init__(self, group: type | None = None, **options: Any) -> None:
        super().__init__("fib", **LEAN, **options)
        self.server = ActionServer(
            self,
            Fibonacci,
            "fib",
            self.execute,
            callback_group=group() if group else None,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def execute(self, goal: Any) -> Any:
        numbers = [0, 1]
        for _ in range(goal.request.order):
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=numbers)
            numbers.append(numbers[-1] + numbers[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
            time.sleep(1)
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)


def spun_by(executor: str, make: Callable[..., Node], *arguments: Any) -> Callable[..., Node]:
    """Return a factory that adds its node to an executor of this class."""

    def factory(**options: Any) -> Node:
        node = make(**options)
        chosen = getattr(rclpy.executors, executor)(*arguments, context=node.context)
        chosen.add_node(node)
        return node

    return factory


def client_of(programs: Any) -> list[Any]:
    """Send a goal from a node of ours, cancel at the fifth feedback; return what comes."""
    node = programs.rig.node("client")
    client = ActionClient(node, Fibonacci, "fib")
    got: list[Any] = []
    feedbacks: list[Any] = []

    def accepted(future: Any) -> None:
        goal = future.result()

        def fed() -> None:
            if len(feedbacks) == 5:
                feedbacks.append(None)
                goal.cancel_goal_async()

        node.create_timer(0.01, fed)
        goal.get_result_async().add_done_callback(
            lambda done: got.append(
                (programs.rig.now_s, done.result().status, len(done.result().result.sequence))
            )
        )

    programs.rig.clock.run_until_quiet()
    client.send_goal_async(Fibonacci.Goal(order=20), feedbacks.append).add_done_callback(accepted)
    programs.rig.clock.run_until_quiet()
    return got


@pytest.mark.parametrize(
    ("factory", "end"),
    [
        (Server, (5.0, 5, 7)),
        (spun_by("MultiThreadedExecutor", Server, 2), (5.0, 5, 7)),
        (spun_by("SingleThreadedExecutor", Server), (20.0, 4, 22)),
        (spun_by("MultiThreadedExecutor", Server, 1), (20.0, 4, 22)),
    ],
    ids=["free", "several threads", "one thread", "a pool of one"],
)
def test_a_cancel_request_waits_for_a_free_thread(
    programs: Any, capfd: pytest.CaptureFixture[str], factory: Any, end: Any
) -> None:
    """As on a robot. The log of the node says for how long, and what to do."""
    programs.add(factory)
    got = client_of(programs)
    programs.rig.run_for(22)
    assert got == [end]
    log = capfd.readouterr().err
    assert ("the cancel request waited" in log) == (end[1] == 4)
    if end[1] == 4:
        assert "the cancel request waited 16 s: Server.execute (test_executors.py:" in log
        assert "sleeps in the only thread of its executor; use a MultiThreadedExecutor" in log


def test_a_sleep_on_ros_time_would_hang_with_simulated_time(
    programs: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    """In the thread that takes `/clock`. Here it goes on, and the log says so."""
    ends: list[float] = []

    def sleep_once() -> None:
        node.get_clock().sleep_for(Duration(seconds=0.5))
        ends.append(programs.rig.now_s)

    make = spun_by("SingleThreadedExecutor", lambda **o: Node("sleeps", **LEAN, **o))
    node = programs.add(make)
    node.create_timer(1.0, sleep_once)
    programs.rig.run_for(1.5)
    assert ends == [1.5]
    assert "with use_sim_time, it would hang on a robot" in capfd.readouterr().err


class Calls(Node):
    """Calls its own service in a timer, and waits for the answer."""

    def __init__(self, group: type, **options: Any) -> None:
        super().__init__("calls", **LEAN, **options)
        self.answers: list[Any] = []
        self.groups = group(), MutuallyExclusiveCallbackGroup()
        self.create_service(
            Trigger, "ask", lambda _, response: response, callback_group=self.groups[1]
        )
        self.client = self.create_client(Trigger, "ask", callback_group=self.groups[0])
        self.timer = self.create_timer(1.0, self.ask, callback_group=self.groups[0])

    def ask(self) -> None:
        self.answers.append(self.client.call(Trigger.Request()))


def test_a_service_called_in_a_callback_needs_another_group(programs: Any) -> None:
    """In a reentrant group the answer is served while the callback waits for it."""
    node = programs.add(
        spun_by("MultiThreadedExecutor", lambda **o: Calls(ReentrantCallbackGroup, **o))
    )
    programs.rig.run_for(2)
    assert len(node.answers) == 2


@pytest.mark.parametrize("executor", ["SingleThreadedExecutor", "MultiThreadedExecutor"])
def test_a_service_called_in_a_callback_of_its_group_is_a_deadlock(
    programs: Any, executor: str
) -> None:
    """It is named at once, in place of the hang on a robot."""
    programs.add(spun_by(executor, lambda **o: Calls(MutuallyExclusiveCallbackGroup, **o)))
    expected = r"Calls.ask \(test_executors.py:\d+\) waits for the answer of ask"
    with pytest.raises(DeadlockError, match=expected):
        programs.rig.run_for(1.5)
    assert programs.rig.now_s == 1.0


@pytest.mark.parametrize(
    ("group", "ends"),
    [(MutuallyExclusiveCallbackGroup, [1.75, 2.5]), (ReentrantCallbackGroup, [1.75, 1.75])],
)
def test_callbacks_of_one_group_wait_for_each_other(programs: Any, group: Any, ends: Any) -> None:
    """In a mutually exclusive group, one at a time; in a reentrant one, side by side."""
    ended: list[float] = []
    node = programs.add(lambda **options: Node("sleepers", **LEAN, **options))

    def sleep_once() -> None:
        time.sleep(0.75)
        ended.append(programs.rig.now_s)

    shared = group()
    for _ in range(2):
        node.create_timer(1.0, sleep_once, callback_group=shared)
    while len(ended) < 2:
        programs.rig.step()
    assert ended == ends


MISSION = """\
mission: fib
world: empty_arena
nodes: ["fib.py:Server"]
tree:
  action: {name: fib, type: example_interfaces/action/Fibonacci, goal: {order: 20}}
  timeout: 60
  cancel_when: len(sequence) >= 5
  on_cancel: success
"""


def test_a_mission_uses_a_server_that_sleeps(tmp_path: Path) -> None:
    """It is cancelled by its condition; the same happens each time."""
    (tmp_path / "fib.py").write_text(Path(__file__).read_text(encoding="utf-8"), encoding="utf-8")
    path = tmp_path / "fib.yaml"
    path.write_text(MISSION, encoding="utf-8")
    reports: list[Any] = []
    for _ in range(2):
        with Stage(load(path), image_folder=tmp_path) as stage:
            reports += drive(stage)
    first, second = reports
    assert (first.status, first.virtual_s) == ("success", 3.05)
    assert (first.trace_sha256, second.reason) == (second.trace_sha256, first.reason)
