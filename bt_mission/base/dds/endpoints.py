"""Endpoints of a topic with different types: DDS connects none of them, and reports nothing."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Protocol

UNNAMED = "a node with unknown name"
"""Replaces a missing name: the graph may know an endpoint before its node."""

_UNKNOWN = "_NODE_NAME_UNKNOWN_"
"""The name of a node that rmw does not know."""


class Endpoint(Protocol):
    """A publisher or a subscription as in rclpy (`TopicEndpointInfo`)."""

    @property
    def node_name(self) -> str:
        """Name of its node."""

    @property
    def node_namespace(self) -> str:
        """Namespace of its node."""

    @property
    def topic_type(self) -> str:
        """Full name of the type, such as `geometry_msgs/msg/Twist`."""


def node_of(endpoint: Endpoint) -> str:
    """Return the full name of an endpoint's node, or UNNAMED."""
    if endpoint.node_name == _UNKNOWN:
        return UNNAMED
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def unheard(publishers: Iterable[Endpoint], types: Collection[str]) -> Mapping[str, str]:
    """Return the types, by the names of their nodes, of publishers whose type is not in `types`."""
    unread = {
        node_of(publisher): publisher.topic_type
        for publisher in publishers
        if publisher.topic_type not in types
    }
    return dict(sorted(unread.items()))


def type_conflict(
    topic: str, publishers: Iterable[Endpoint], subscriptions: Iterable[Endpoint]
) -> str | None:
    """Return the publishers without a matching subscription, and the types taken, or None."""
    taken = {node_of(subscription): subscription.topic_type for subscription in subscriptions}
    lost = unheard(publishers, set(taken.values()))
    if not lost or not taken:
        return None
    return f"{topic}: {_listed(lost)} published, but {_listed(taken)} taken"


def _listed(types: Mapping[str, str]) -> str:
    return ", ".join(f"{type_name} by {node}" for node, type_name in sorted(types.items()))
