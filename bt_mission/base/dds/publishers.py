"""Topics with a single publisher in a robot's graph: two publishers would mean two robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from bt_mission.base.dds.endpoints import node_of
from bt_mission.base.diagnostics import listed

CLOCK, ODOMETRY = "/clock", "odom"

ADVICE = (
    "two robots, or a robot and a simulation, cannot be distinguished; stop one of them, give "
    "each its own namespace or ROS_DOMAIN_ID, or add --allow-duplicates"
)


class TopicGraph(Protocol):
    """The methods of a node that are used."""

    def resolve_topic_name(self, topic: str) -> str:
        """Return the full name of a topic."""

    def get_publishers_info_by_topic(self, topic_name: str) -> Sequence[Any]:
        """Return the publishers of a topic."""

    def get_parameter(self, name: str) -> Any:
        """Return a parameter."""


def single_publisher_topics(node: TopicGraph, odometry: str = ODOMETRY) -> tuple[str, ...]:
    """Return the topics that must have one publisher: the clock, if the node follows it.

    The node's parameter decides that, not the options of its process: ROS arguments override those.
    """
    follows_clock = bool(node.get_parameter("use_sim_time").value)
    return (odometry, CLOCK) if follows_clock else (odometry,)


def duplicate_publishers(node: TopicGraph, odometry: str = ODOMETRY) -> str | None:
    """Return which of its topics has several publishers, with their names and advice, or None."""
    for topic in single_publisher_topics(node, odometry):
        name = node.resolve_topic_name(topic)
        publishers = node.get_publishers_info_by_topic(name)
        if len(publishers) > 1:
            who = sorted(node_of(publisher) for publisher in publishers)
            return f"{name} has {len(publishers)} publishers ({listed(who)}): {ADVICE}"
    return None
