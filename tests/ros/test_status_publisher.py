"""Who listens to the tree of a mission, and from when on."""

from __future__ import annotations

from typing import Any

from bt_mission.ros.status_publisher import StatusPublisher

ONE = "mission: m\ntree: {wait: 1}\n"


def test_who_comes_late_is_told_the_tree_and_where_it_stands(ros: Any) -> None:
    """And from then on what changes; who has left is told nothing."""
    node = ros.mission(ONE)
    first: list[tuple[str, Any]] = []
    second: list[tuple[str, Any]] = []

    def take_first(what: str, message: Any) -> None:
        first.append((what, message))

    node.status_publisher.add(take_first)
    ros.run(0.5)
    assert [what for what, _ in first] == ["tree", "changes", "state"]
    node.status_publisher.add(lambda what, message: second.append((what, message)))
    assert [what for what, _ in second] == ["tree", "state"]
    assert second[0][1].nodes == first[0][1].nodes
    node.status_publisher.remove(take_first)
    ros.until(lambda: node.executive.is_done)
    assert len(first) == 3
    assert [what for what, _ in second[2:]] == ["changes", "state"]
    assert [state.status for what, state in second if what == "state"] == ["running", "success"]


def test_nothing_is_made_for_nobody(ros: Any) -> None:
    """Not even a sequence number."""
    node = ros.mission(ONE)
    assert isinstance(node.status_publisher, StatusPublisher)
    ros.until(lambda: node.executive.is_done)
    assert node.status_publisher.sequence == 0
