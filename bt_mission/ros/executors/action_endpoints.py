"""Why no goal can be sent to an action: it has a second server, or QoS that does not match."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

from rclpy.qos import (
    QoSCompatibility,
    QoSProfile,
    qos_check_compatible,
    qos_profile_action_status_default,
)

from bt_mission.base.dds.endpoints import node_of
from bt_mission.base.diagnostics import listed
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.ros.executors.participants import Discovery, ParticipantGraph

GONE_S = 3.0
"""Wall time after which a bt-mission process that was killed has left the graph."""

CLIENT_QOS = {"feedback": QoSProfile(depth=10), "status": qos_profile_action_status_default}
"""The QoS of the subscriptions of an action client, by topic."""


class ActionGraph(Protocol):
    """The methods of a node that are used."""

    def resolve_topic_name(self, topic: str) -> str:
        """Return the full name of a topic or an action."""

    def get_publishers_info_by_topic(self, topic_name: str) -> Sequence[Any]:
        """Return the publishers of a topic."""


def duplicate_servers(node: ActionGraph, actions: Iterable[str]) -> str | None:
    """Return which action has several servers, with their nodes and advice, or None.

    A process that was killed is in the graph until its lease is over.
    """
    for action in dict.fromkeys(map(node.resolve_topic_name, actions)):
        servers = node.get_publishers_info_by_topic(f"{action}/_action/status")
        if len(servers) > 1:
            who = listed(sorted(map(node_of, servers)))
            return (
                f"{action} has {len(servers)} servers ({who}): each of them runs every goal; stop "
                "one, or give each its own namespace or ROS_DOMAIN_ID (a killed process is listed "
                "for up to 20 s)"
            )
    return None


def qos_conflict(node: ActionGraph, action: str) -> str | None:
    """Return which topic of an action its clients cannot receive, with both QoS, or None."""
    for topic, wanted in CLIENT_QOS.items():
        name = f"{node.resolve_topic_name(action)}/_action/{topic}"
        for server in node.get_publishers_info_by_topic(name):
            offered = server.qos_profile
            if qos_check_compatible(offered, wanted)[0] == QoSCompatibility.ERROR:
                return (
                    f"{node.resolve_topic_name(action)}: its server {node_of(server)} publishes "
                    f"{topic} with {_in_words(offered)}, an action client needs "
                    f"{_in_words(wanted)}; remove {topic}_pub_qos_profile from the server"
                )
    return None


def settled(
    node: ParticipantGraph, look: Callable[[], str | None], spin: Callable[[], object]
) -> str | None:
    """Return what is still wrong in a graph once its participants are discovered, or None.

    An entry of a process that was killed disappears after its lease.

    Args:
        node: The one that discovers them.
        look: Returns what is wrong now.
        spin: Serves the graph for at most a moment.
    """
    since, discovery = Stopwatch(), Discovery(node)
    while True:
        is_over, why = discovery.is_over(), look()
        if is_over if why is None else since.elapsed_s > GONE_S:
            return why
        spin()


def _in_words(profile: QoSProfile) -> str:
    reliability, durability = profile.reliability.name, profile.durability.name
    return f"{reliability.lower().replace('_', ' ')} and {durability.lower().replace('_', ' ')}"
