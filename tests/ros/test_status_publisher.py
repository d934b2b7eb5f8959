"""Who listens to the tree of a mission, and from when on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from bt_mission.base.stamps import to_ns
from bt_mission.executive.events import reader
from bt_mission.executive.events.events import NodeChanged, NodesReset, RequirementChanged
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.ros import event_messages
from bt_mission.ros.status_publisher import StatusPublisher

READERS: dict[str, Callable[[Any], Any]] = {
    "tree": reader.tree,
    "requirements": reader.requirements,
    "changes": reader.changes,
    "state": reader.state,
}


def followed(node: Any) -> tuple[MissionState, list[Any], list[tuple[str, Any]]]:
    """What a viewer knows of a mission, with the events and the messages that it has got."""
    feed, events, messages = MissionFeed(MissionState()), [], []

    def take(what: str, message: Any) -> None:
        messages.append((what, message))
        events.extend(feed.take(READERS[what](message)))

    node.status_publisher.add(take)
    return feed.mission, events, messages


ONE = "mission: m\ntree: {wait: 1}\n"


def test_who_comes_late_is_told_the_tree_and_where_it_stands(ros: Any) -> None:
    """And then what changes, with the time of the tick; who has left is told nothing."""
    node = ros.mission(ONE)
    first: list[tuple[str, Any]] = []
    second: list[tuple[str, Any]] = []
    take_first = lambda what, message: first.append((what, message))  # noqa: E731
    node.status_publisher.add(take_first)
    ros.run(0.5)
    assert [what for what, _ in first] == ["tree", "changes", "state"]
    node.status_publisher.add(lambda what, message: second.append((what, message)))
    assert [what for what, _ in second] == ["tree", "state"]
    assert second[0][1].nodes == first[0][1].nodes
    node.status_publisher.remove(take_first)
    ros.until(lambda: node.executive.is_done)
    assert len(first) == 3
    assert to_ns(first[0][1].stamp) == node.executive.started_ns
    assert to_ns(second[-1][1].stamp) == node.executive.ended_ns
    assert [what for what, _ in second[2:]] == ["changes", "state"]
    assert [state.status for what, state in second if what == "state"] == ["running", "success"]


def test_nothing_is_made_for_nobody(ros: Any) -> None:
    """Not even a sequence number."""
    node = ros.mission(ONE)
    assert isinstance(node.status_publisher, StatusPublisher)
    ros.until(lambda: node.executive.is_done)
    assert node.status_publisher.sequence == 0


def test_nothing_is_told_before_there_is_a_time(ros: Any) -> None:
    """A node that joins a graph with a clock has it with its first message; times begin there."""
    runner = ros.mission(ONE)
    publisher = StatusPublisher(runner.node, has_topics=False)
    publisher.begin(runner, runner.requirements)
    reports: list[tuple[str, Any]] = []
    publisher.add(lambda what, message: reports.append((what, message)))
    publisher.publish_if_changed()
    assert not reports, "the first tick has not been"
    ros.run(0.1)
    publisher.publish_if_changed()
    assert reports[0][0] == "tree"
    assert to_ns(reports[0][1].stamp) == runner.executive.started_ns > 0


LOOP = """\
mission: m
tree:
  repeat: {count: 2}
  do:
    sequence:
      - {wait: 1, name: first}
      - {wait: 1, name: second}
      - {log: hello, name: said}
"""


def test_a_new_round_begins_anew(ros: Any) -> None:
    """What ended in the last round of a loop is to run again, as in the tree itself."""
    node = ros.mission(LOOP)
    mission, events, _ = followed(node)
    at: list[Any] = []
    while not node.executive.is_done:
        ros.run(0.05)
        assert mission.statuses == [behaviour.status for behaviour in node.executive.nodes]
        at.append(list(mission.statuses))
    assert [status.value for status in at[50][2:5]] == ["RUNNING", "INVALID", "INVALID"]
    lines = [event for event in events if isinstance(event, NodeChanged) and event.node == 4]
    assert [line.status.value for line in lines] == ["SUCCESS", "SUCCESS"], "once in each round"
    (reset,) = [event for event in events if isinstance(event, NodesReset)]
    assert reset.nodes == (3, 4), "the first of the new round runs already"


NESTED = """\
mission: m
inputs: {angle: 90}
trees:
  about:
    inputs: {by: 90}
    do:
      turn: {angle: $by}
      name: turn
      timeout: 30
      cancel_when: current_angle >= 45
      outputs: {angle_turned: turned}
tree:
  sequence:
    - log: hello
    - tree: {name: about, inputs: {by: $angle}}
"""


def test_nodes_are_told_with_what_they_are_asked_to_do(ros: Any) -> None:
    """In their author's words, also inside a tree that is used by name."""
    ros.server()
    node = ros.mission(NESTED)
    mission, _, _ = followed(node)
    ros.run(0.1)
    assert mission.tree is not None
    reported = {first.name: mission.details(at) for at, first in enumerate(mission.tree.nodes)}
    assert reported["about"] == ("by $angle",)
    limits = ("failure when current_angle >= 45", "within 30 s")
    assert reported["turn"][-4:] == ("angle $by", *limits, "turned := angle_turned")
    assert reported["m"] == ()


JUDGED = """\
mission: m
requirements:
  has time: always time < 5
  is quick: always time < 1.22
  ends: eventually succeeded("later")
  sees: always x > 0
tree:
  wait: 3
  name: later
"""


def test_a_violation_is_told_in_the_step_in_which_it_is_seen(ros: Any) -> None:
    """Margins once a second, verdicts at the end; each message has all requirements."""
    node = ros.mission(JUDGED)
    mission, _, messages = followed(node)
    ros.until(lambda: node.executive.is_done)
    reports = [message for what, message in messages if what == "requirements"]
    start_ns = node.executive.started_ns
    times = [(to_ns(report.stamp) - start_ns) / 1e9 for report in reports]
    assert times == pytest.approx([0.0, 1.0, 1.25, 2.25, 3.0], abs=1e-9)
    assert all([requirement.name for requirement in sent.requirements] == NAMES for sent in reports)
    verdicts = [mission.requirements[at].verdict for at in range(4)]
    assert verdicts == ["holds", "violated", "holds", "unknown"]
    (quick,) = mission.failing
    assert (quick.name, quick.requirement) == ("is quick", "always time < 1.22")
    assert (quick.violated_at, quick.unit, quick.on_violation) == (1.25, "s", "report")
    assert quick.at is not None
    assert quick.margin == pytest.approx(1.22 - quick.at)
    assert reports[-1].requirements[3].outcome == "unknown: x: only a simulation provides it"


NAMES = ["has time", "is quick", "ends", "sees"]


def test_who_comes_late_is_told_of_requirements(ros: Any) -> None:
    """All of them; where a mission has none, nothing is told."""
    node = ros.mission(JUDGED)
    node.status_publisher.add(lambda *_: None)
    ros.run(2)
    reported: dict[str, Any] = {}
    node.status_publisher.add(reported.__setitem__)
    assert [requirement.name for requirement in reported["requirements"].requirements] == NAMES


def test_a_requirement_reads_back_as_it_was_sent() -> None:
    """What is not known is no number."""
    sources = ("speed by odometry", "distance by odometry")
    sent = RequirementChanged(
        5, "slow", "always speed < 1", "open", None, "", None, None, "fail", sources, "", "open"
    )
    message = event_messages.requirements(5, "run", [sent])
    assert reader.requirements(message) == Batch("run", (sent,))
