"""A mission on somebody else's node, beside what that does, over real rclpy on a virtual clock."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.clock_type import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import String

from bt_mission import BtMissionError, MissionRunner, RunnerOptions, load
from bt_mission.base.dds.liveliness import TOPIC
from bt_mission.testing import ScriptedServer
from tests.support.graph import TURN as TYPE

TURN = "mission: turns\ntree:\n  turn: {angle: 90}\n  timeout: 60\n"
TALK = """\
mission: talks
tree:
  sequence:
    - wait_for: {topic: go, type: std_msgs/msg/String, until: data == "go"}
      timeout: 60
    - publish: {topic: said, type: std_msgs/msg/String, message: {data: gone}}
      readers: 0
    - turn: {angle: 90}
      timeout: 60
"""


@pytest.fixture
def node(ros: Any) -> Node:
    """The node of a program that does other things, too."""
    made: Node = ros.node("my_robot")
    return made


def counts(node: Node) -> dict[str, int]:
    """What a node has, by kind."""
    kinds = ("publishers", "subscriptions", "clients", "services", "timers", "waitables")
    return {kind: len(list(getattr(node, kind))) for kind in kinds}


def test_time_stands_still_during_a_tick(ros: Any) -> None:
    """Even where the node's clock is set forward within it, as a graph's ``/clock`` might."""
    runner = ros.mission("mission: m\ntree:\n  wait: 60\n")
    seen = []

    def move_on() -> None:
        later = Time(nanoseconds=runner.now_ns + 1, clock_type=ClockType.ROS_TIME)
        runner.node.get_clock().set_ros_time_override(later)
        seen.append(runner.now_ns)

    before_ns = runner.now_ns
    runner.executive.after_tick.append(move_on)
    runner.tick()
    assert (seen, runner.now_ns) == ([before_ns], before_ns + 1)


def test_a_mission_runs_beside_other_work_of_the_node(ros: Any, node: Node) -> None:
    """The program's own timer goes on; the report tells how the mission ended."""
    turn = ros.server()
    ticks: list[None] = []
    node.create_timer(0.1, lambda: ticks.append(None))
    runner = MissionRunner(node, load(TURN))
    while not runner.is_done:
        ros.clock.spin_once()
        if turn.goals and ros.now_s >= 2.0:
            turn.goal.succeed(angle_turned=90.0)
    assert len(ticks) == 20
    report = runner.report()
    assert (report.status, report.reason, report.goals_sent) == ("success", "", 1)
    assert report.virtual_s == 2.0
    assert str(report).startswith("turns: success\n  2.00 s in ")
    ros.run(1.0)
    assert runner.report() == report


def test_tools_find_it_below_the_name_of_the_node(ros: Any, node: Node) -> None:
    """And servers see that it lives."""
    with MissionRunner(node, load(TURN)):
        ros.run(0.1)
        topics = dict(ros.client.get_topic_names_and_types())
        assert "/my_robot/tree" in topics
        assert ros.client.count_publishers(TOPIC) == 1
        assert "/my_robot/pause" in dict(ros.client.get_service_names_and_types())


def test_closing_leaves_the_node_as_it_was(ros: Any, node: Node) -> None:
    """Clients, timer, topics and services go; what the program made stays."""
    server = ros.server(cancels=None)
    node.create_publisher(String, "go", 10)
    before = counts(node)
    runner = MissionRunner(node, load(TALK))
    node.create_timer(1.0, lambda: None)
    words = ros.client.create_publisher(String, "/go", 10)
    ros.run(0.1)
    words.publish(String(data="go"))
    ros.until(lambda: server.goals)
    runner.close()
    assert counts(node) == {**before, "timers": before["timers"] + 1}
    assert runner.is_done
    assert runner.report().reason.startswith("closed by its caller; orphaned goals: /turn goal ")
    ros.run(0.1)
    assert server.goal.cancels == 1
    runner.close()


def test_a_block_that_is_left_halts_the_mission_and_waits_for_its_goals(
    ros: Any, node: Node
) -> None:
    """The exception goes on; nobody is left behind."""
    turn = ros.server()
    runner = MissionRunner(node, load(TURN))

    def loop() -> None:
        with runner:
            ros.until(lambda: turn.goals)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        loop()
    report = runner.report()
    assert (report.status, report.goals_left_behind) == ("interrupted", 0)
    assert report.reason == "its caller has left: ZeroDivisionError"


def test_a_node_that_no_executor_holds_is_spun_until_the_end(ros: Any) -> None:
    """As after `rclpy.spin_once`; on the clock of this machine."""
    node = Node("alone", context=ros.context)
    turn = ScriptedServer(node, TYPE, "turn")
    executor = SingleThreadedExecutor(context=ros.context)
    with MissionRunner(node, load(TURN)) as runner:
        for _ in range(1000):
            executor.add_node(node)
            executor.spin_once(timeout_sec=0.1)
            executor.remove_node(node)
            if turn.goals and turn.goal.accepted:
                break
    executor.shutdown()
    report = runner.report()
    assert (report.reason, report.goals_left_behind) == ("its caller has left", 0)
    node.destroy_node()


def test_halting_cancels_goals(ros: Any, node: Node) -> None:
    """And the mission ends when its servers have confirmed that."""
    turn = ros.server(cancels=None)
    runner = MissionRunner(node, load(TURN))
    ros.until(lambda: turn.goals)
    runner.halt("enough")
    assert (str(runner.status), runner.is_done) == ("ending", False)
    ros.run(0.2)
    turn.goal.answer_cancel()
    turn.goal.cancel()
    ros.until(lambda: runner.is_done)
    assert (str(runner.status), runner.report().reason) == ("interrupted", "enough")


def test_a_type_that_is_not_installed_is_refused(ros: Any, node: Node) -> None:
    """With its place; the node is as before."""
    before = counts(node)
    text = "mission: m\ntree:\n  sequence:\n  - turn: {angle: 9}\n    timeout: 9\n"
    text += "  - action: {name: fly, type: birds/action/Fly}\n    timeout: 9\n"
    with pytest.raises(BtMissionError, match="the action type birds/action/Fly is not installed"):
        MissionRunner(node, load(text))
    assert counts(node) == before
    MissionRunner(node, load(TURN)).close()


def test_missions_run_one_after_another(ros: Any, node: Node) -> None:
    """The next takes the topics over; its goals have other UUIDs."""
    turn = ros.server()
    for count in (1, 2):
        runner = MissionRunner(node, load(TURN))
        ros.until(lambda count=count: len(turn.goals) == count)
        turn.goal.succeed(angle_turned=90.0)
        ros.until(lambda runner=runner: runner.is_done)
        assert str(runner.status) == "success"
    assert len({goal.id for goal in turn.goals}) == 2
    assert ros.client.count_publishers("/my_robot/tree") == 1


def test_a_second_mission_at_once_has_no_topics_for_tools(ros: Any, node: Node) -> None:
    """Two would share their names: it says what to do."""
    turn = ros.server()
    first = MissionRunner(node, load(TURN))
    with pytest.raises(BtMissionError, match="mission 'turns' runs on /my_robot and has its"):
        MissionRunner(node, load(TURN))
    text = "mission: waits\ntree: {wait: 0.5}\n"
    second = MissionRunner(node, load(text), RunnerOptions(has_controls=False))
    ros.until(lambda: second.is_done)
    turn.goal.succeed(angle_turned=90.0)
    ros.until(lambda: first.is_done)
    assert (str(first.status), str(second.status)) == ("success", "success")


def test_a_node_that_is_destroyed_ends_its_mission(ros: Any, node: Node) -> None:
    """As failed, with the goal that is left behind."""
    turn = ros.server(cancels=None)
    runner = MissionRunner(node, load(TURN))
    ros.until(lambda: turn.goals)
    ros.drop(node)
    assert runner.is_done
    assert str(runner.status) == "failure"
    assert str(runner.executive.status) == "running", "a look changes nothing"
    assert runner.report().reason.startswith("its node was destroyed; orphaned goals: /turn goal ")
    runner.close()
