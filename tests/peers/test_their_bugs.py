"""What went wrong elsewhere, by project and issue, over real rclpy on a virtual clock.

Each test names the threads in which users of another behaviour-tree library for ROS 2 met the
fault. The statuses of composites, tick by tick, are in tests/executive/behaviours/test_statuses.py.
"""

from __future__ import annotations

from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.ros.goal_client import RosGoalClient
from tests.support.graph import outcome

TURN = "mission: m\ntree:\n  turn: {angle: 90}\n  timeout: 60\n"


def test_a_goal_does_not_outlive_its_halted_leaf(ros: Any) -> None:
    """navigation2#6426, navigation2#4659: cancelled, and the mission ends when it has ended."""
    turn, node = ros.turning(TURN, cancels=None)
    ros.run(1.0)
    node.executive.interrupt("enough")
    ros.until(lambda: turn.goal.cancels)
    turn.goal.answer_cancel()
    ros.run(0.5)
    assert not node.executive.is_done
    turn.goal.cancel()
    ros.until(lambda: node.executive.is_done)
    assert node.executive.goals_left_behind == ()


def test_a_halt_before_the_answer_does_not_orphan_the_goal(ros: Any) -> None:
    """BehaviorTree.ROS2#57, BehaviorTree.ROS2#75: cancelled as soon as it is accepted."""
    turn, node = ros.turning(TURN, accepts=None)
    node.executive.interrupt("enough")
    ros.run(1.0)
    assert (turn.goal.cancels, node.executive.is_done) == (0, False)
    turn.goal.accept()
    ros.until(lambda: node.executive.is_done)
    assert (turn.goal.cancels, node.executive.goals_left_behind) == (1, ())


@pytest.mark.parametrize("first", ["result", "cancel"])
def test_cancel_and_result_may_cross(ros: Any, first: str) -> None:
    """BehaviorTree.ROS2#18, BehaviorTree.ROS2#110: whichever is first, nothing is raised."""
    turn, node = ros.turning(TURN, cancels=None)
    ros.run(0.2)
    node.executive.interrupt("enough")
    ros.until(lambda: turn.goal.cancels)
    if first == "result":
        turn.goal.succeed()
        turn.goal.answer_cancel(3, taken=False)
    else:
        turn.goal.answer_cancel()
        turn.goal.succeed()
    ros.until(lambda: node.executive.is_done)
    assert node.executive.goals_left_behind == ()


def test_a_result_that_never_follows_the_end(ros: Any) -> None:
    """Servers of courses succeed first, then work: the reason is not an unconfirmed cancel."""
    turn, node = ros.turning("mission: m\ntree:\n  turn: {angle: 90}\n  timeout: 1\n", cancels=None)
    ros.until(lambda: turn.goal.cancels)
    turn.goal.answer_cancel(3, taken=False)
    ros.until(lambda: node.executive.is_done)
    assert outcome(node.executive, "turn") == (
        "unconfirmed: not done within 1 s, but /turn sent no result of the ended goal in 3 s"
    )
    assert len(node.executive.goals_left_behind) == 1


def test_a_server_that_no_longer_knows_the_goal(ros: Any) -> None:
    """BehaviorTree.ROS2#129, BehaviorTree.ROS2#134: an outcome, not a crash."""
    turn, node = ros.turning(TURN, accepts=None)
    turn.forget()
    turn.goal.accept()
    ros.until(lambda: node.executive.is_done)
    assert outcome(node.executive, "turn") == (
        "server lost: /turn no longer knows the goal (it has restarted, or its result_timeout is 0)"
    )


def test_a_late_result_reaches_nobody_else(ros: Any) -> None:
    """BehaviorTree.ROS2#115, and py_trees_ros' action client: not the leaf's next goal either."""
    turn, node = ros.turning(
        "mission: m\ntree:\n  retry: {attempts: 2}\n  do:\n    turn: {angle: 90}\n"
        "    timeout: 1\n    cancel_timeout: 0.5\n    server_timeout: 9\n"
        "    outputs: {angle_turned: way}\n",
        cancels=None,
    )
    first = turn.goal
    ros.run(1.7)  # timed out, its cancel not confirmed; the leaf waits for the server to be free
    first.feed(current_angle=5.0)
    first.answer_cancel()
    first.succeed(angle_turned=5.0)
    ros.until(lambda: len(turn.goals) == 2)
    assert "way" not in node.scope.values
    first.feed(current_angle=99.0)
    ros.run(0.3)
    assert outcome(node.executive, "turn") == "active"
    turn.goal.succeed(angle_turned=90.0)
    ros.until(lambda: node.executive.is_done)
    assert node.scope.values["way"] == 90.0


def test_a_server_that_dies_is_noticed(ros: Any) -> None:
    """py_trees_ros#234, py_trees_ros#213: not RUNNING for ever, without any timeout."""
    _, node = ros.turning("mission: m\ntree:\n  turn: {angle: 90}\n")
    ros.run(0.2)
    died_s = ros.now_s
    ros.drop(next(node for node in ros.clock.get_nodes() if node.get_name() == "turn_server"))
    ros.until(lambda: node.executive.root.status is Status.FAILURE)
    assert ros.now_s - died_s <= 0.3
    assert outcome(node.executive, "turn") == "server lost: /turn has gone from the graph"


def test_a_goal_that_ends_at_once_is_seen(ros: Any) -> None:
    """rclpy#1123: the result is there before anybody has asked for it."""
    turn, node = ros.turning(TURN, accepts=None)
    turn.goal.succeed()
    turn.goal.accept()
    ros.run(0.1)
    assert node.executive.mission_state.status == "success"


def test_each_leaf_has_its_own_time_for_an_answer(ros: Any) -> None:
    """navigation2#3355, navigation2#4278, BehaviorTree.ROS2#76: seconds, not 20 ms for all."""
    ros.server(accepts=None)
    ros.server("slow", accepts=None)
    node = ros.mission(
        "mission: m\ntree:\n  parallel:\n    - turn: {angle: 9}\n      timeout: 60\n"
        "    - action: {name: slow, type: bt_mission_interfaces/action/Turn}\n"
        "      acceptance_timeout: 4.5\n      timeout: 60\n  fail_when: impossible\n"
        "  succeed_when: any\n"
    )
    ends: dict[str, float] = {}
    while node.executive.root.status is not Status.FAILURE:
        ros.step()
        for change in ros.changes:
            leaf = node.executive.nodes[change.node]
            if change.status is Status.FAILURE and not leaf.children:
                ends.setdefault(leaf.name, (change.time_ns - ros.start_ns) / 1e9)
    assert ends["slow"] - ends["turn"] == pytest.approx(2.5)
    assert outcome(node.executive, "slow") == (
        "no answer to the goal: /slow did not answer the goal within 4.5 s"
    )


def test_halting_never_blocks_a_tick(ros: Any) -> None:
    """navigation2#2436, navigation2#3848, SMACC2#540: the cancel goes out in the halting tick.

    Another leaf is ticked on time while the server keeps the cancel waiting.
    """
    turn, node = ros.turning(
        "mission: m\ntree:\n  sequence:\n    - parallel:\n        - turn: {angle: 90}\n"
        "          timeout: 60\n        - wait: 1\n      succeed_when: any\n    - wait: 2\n",
        cancels=None,
    )
    ros.run(0.2)
    halts = []
    cancel = RosGoalClient.send_cancel

    def noted(goal_client: RosGoalClient, goal: Any) -> None:
        halts.append((ros.now_s, node.executive.ticks))
        cancel(goal_client, goal)

    node.goal_client("turn", turn.type_name).send_cancel = noted.__get__(
        node.goal_client("turn", turn.type_name)
    )
    ros.until(lambda: halts)
    nodes = node.executive.nodes
    first_wait = next(
        c for c in ros.changes if nodes[c.node].name == "wait" and c.status is Status.SUCCESS
    )
    assert (first_wait.time_ns - ros.start_ns) / 1e9 == halts[0][0]
    before = node.executive.ticks
    ros.run(1.0)
    assert node.executive.ticks == before + 20
    turn.goal.answer_cancel()
    turn.goal.cancel()
    ros.until(lambda: node.executive.is_done)
    assert node.executive.mission_state.status == "success"


def test_an_aborted_goal_is_no_success(ros: Any) -> None:
    """ros_bt_py's action node did not look at the status: every other final one is a failure."""
    turn = ros.server()
    endings = {}
    for status in (0, 4, 5, 6, 77):
        node = ros.mission(TURN)
        goals = len(turn.goals)
        ros.until(lambda goals=goals: len(turn.goals) > goals)
        turn.goal.end(status)
        ros.until(lambda node=node: node.executive.is_done)
        endings[status] = node.executive.mission_state.status
        ros.drop(node.node)
    assert endings == {0: "failure", 4: "success", 5: "failure", 6: "failure", 77: "failure"}


def test_an_exception_in_one_leaf_ends_the_others(ros: Any) -> None:
    """py_trees 2.6: siblings ran on; here each is halted, each goal cancelled."""
    turn = ros.server()
    node = ros.mission(
        "mission: m\ntree:\n  parallel:\n    - turn: {angle: 90}\n      timeout: 60\n"
        "    - sequence: [{wait: 1}, {log: x}]\n"
    )
    (log,) = (behaviour for behaviour in node.executive.nodes if behaviour.name == "log")

    def broken() -> Status:
        raise ZeroDivisionError("oh")

    log.update = broken
    ros.until(lambda: node.executive.is_done)
    assert node.executive.reason.startswith("ZeroDivisionError: oh (test_their_bugs.py:")
    assert (turn.goal.cancels, node.executive.goals_left_behind) == (1, ())
    assert all(behaviour.status is not Status.RUNNING for behaviour in node.executive.nodes)


def test_a_stopped_mission_terminates_its_leaves(ros: Any) -> None:
    """py_trees 2.6: shutdown left running leaves as they were."""
    _, node = ros.turning(
        "mission: m\ntree:\n  parallel:\n    - turn: {angle: 90}\n      timeout: 60\n"
        "    - wait: 100\n    - sequence: [{wait: 100}]\n"
    )
    node.executive.interrupt("enough")
    assert {behaviour.status for behaviour in node.executive.nodes} == {Status.INVALID}


@pytest.mark.thorough
def test_timeouts_are_of_ros_time(ros: Any) -> None:
    """BehaviorTree.CPP#781, py_trees_ros#147: an hour of it passes in a blink of the wall."""
    _, node = ros.turning("mission: m\ntree:\n  turn: {angle: 90}\n  timeout: 3600\n")
    sent_s = ros.now_s
    ros.until(lambda: node.executive.is_done, limit_s=4000)
    assert ros.now_s - sent_s == pytest.approx(3600, abs=0.2)
    assert outcome(node.executive, "turn") == "canceled by timeout: not done within 3600 s"


def test_an_interrupted_mission_neither_hangs_nor_leaves_a_goal(ros: Any) -> None:
    """py_trees_ros#119, yasmin#73: bounded also where a server is deaf; that goal is named.

    Ctrl-C itself, with processes: tests/cli/test_processes.py.
    """
    _, node = ros.turning(TURN, cancels=None)
    ros.run(0.2)
    node.executive.interrupt("interrupted by Ctrl-C")
    asked_s = ros.now_s
    ros.until(lambda: node.executive.is_done)
    assert ros.now_s - asked_s == pytest.approx(3.0, abs=0.1)
    (left,) = node.executive.goals_left_behind
    assert left.startswith("/turn goal ")
    assert left in node.executive.reason


def test_a_reactive_fallback_cancels_what_it_interrupts(ros: Any) -> None:
    """py_trees#329, py_trees#439, py_trees_ros#237: and what ran before starts anew later."""
    turn = ros.server()
    node = ros.mission(
        "mission: m\ntree:\n  fallback:\n"
        "    - sequence:\n        - wait_for: {topic: go, type: std_msgs/msg/Bool, until: data}\n"
        "          timeout: 1\n        - wait: 0.5\n"
        "    - turn: {angle: 90}\n      timeout: 60\n  memory: false\n"
    )
    ros.run(1.5)
    assert len(turn.goals) == 1, "the wait has timed out, so the turn has its turn"
    ros.run(0.2)
    halted = [change for change in ros.changes if change.status is Status.INVALID]
    started = [event for event in halted if node.executive.nodes[event.node].name == "turn"]
    assert started, "the fallback looked at its first child again, which runs: the turn is halted"
    assert turn.goal.cancels == 1
    ros.run(1.2)
    assert len(turn.goals) == 2
    node.executive.interrupt("enough")
    ros.until(lambda: node.executive.is_done)
    assert node.executive.goals_left_behind == ()


def test_a_sequence_goes_through_many_children_in_one_tick(ros: Any) -> None:
    """BehaviorTree.CPP#488: what is done at once takes no tick each."""
    node = ros.mission(
        "mission: m\ntree:\n  sequence:\n" + "    - sequence: [{log: a}, {log: b}]\n" * 50
    )
    ros.until(lambda: node.executive.is_done)
    assert (node.executive.ticks, len(ros.logged)) == (1, 100)


def test_a_parallel_says_what_becomes_of_the_rest(ros: Any) -> None:
    """BehaviorTree.CPP#573, BehaviorTree.CPP#954: halted children are cancelled, done ones rest."""
    turn = ros.server()
    node = ros.mission(
        "mission: m\ntree:\n  parallel:\n    - log: once\n    - turn: {angle: 90}\n"
        "      timeout: 60\n    - wait: 1\n      name: long enough\n"
        "  succeed_when: [long enough]\n"
    )
    ros.until(lambda: node.executive.is_done)
    assert (ros.logged, turn.goal.cancels) == (["once"], 1)
    assert node.executive.mission_state.status == "success"


@pytest.mark.thorough
def test_big_trees_cost_what_runs(ros: Any) -> None:
    """BehaviorTree.CPP#550, ros2_planning_system#293: 10,000 nodes, of which a tick visits three.

    How long loading and ticking take is in docs/explanation/performance.md; what tools hear while
    nothing changes, in tests/ros/test_control_services.py.
    """
    block = "    - sequence:\n" + "        - log: x\n" * 99
    node = ros.mission(f"mission: m\ntree:\n  sequence:\n    - wait: 60\n{block * 100}")
    assert len(node.executive.nodes) == 10_002
    ros.run(1.0)
    assert len(list(node.executive.root.tick())) == 2
