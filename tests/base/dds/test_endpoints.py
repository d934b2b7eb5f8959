"""Facts about publishers and subscriptions whose types differ."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from bt_mission.base.dds.endpoints import node_of, type_conflict, unheard

PLAIN, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"


@dataclass(frozen=True)
class End:
    """An endpoint, as rclpy tells of it."""

    node_name: str
    topic_type: str
    node_namespace: str = "/"


def test_who_publishes_another_type_is_named_with_it():
    """By the full name of the node, in order of names."""
    ends = [End("teleop", PLAIN, "/r1"), End("patrol", PLAIN), End("servers", STAMPED)]
    result = unheard(ends, {STAMPED})
    assert list(result.items()) == [("/patrol", PLAIN), ("/r1/teleop", PLAIN)]


def test_a_node_that_the_graph_has_not_heard_of_is_said_to_have_no_name_yet():
    """What rmw says instead of a name is for programs."""
    end = End("_NODE_NAME_UNKNOWN_", PLAIN, "_NODE_NAMESPACE_UNKNOWN_")
    assert node_of(end) == "a node with unknown name"


def test_both_sides_of_a_conflict_are_named():
    """Who sends what, and who takes what."""
    text = type_conflict("/cmd_vel", [End("patrol", PLAIN)], [End("sim", STAMPED)])
    assert text == f"/cmd_vel: {PLAIN} by /patrol published, but {STAMPED} by /sim taken"


@pytest.mark.parametrize(
    ("published", "taken"),
    [([PLAIN], [PLAIN]), ([PLAIN], []), ([], [STAMPED]), ([PLAIN], [PLAIN, STAMPED])],
)
def test_what_somebody_takes_is_no_conflict(published, taken):
    """Nor is a topic that has one side only."""
    sides = ([End("a", name) for name in published], [End(f"b{i}", t) for i, t in enumerate(taken)])
    assert type_conflict("/cmd_vel", *sides) is None
