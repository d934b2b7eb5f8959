"""Discovery within a process: whether all endpoints that belong together are matched.

Within one rclpy context (one DDS participant) matching is done when the call that creates an
endpoint returns. Between contexts it takes a moment of wall time, during which virtual time must
not move. :func:`wait_for_matching` checks, and waits if needed.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import chain

from rclpy.action import ActionClient, ActionServer, get_action_server_names_and_types_by_node
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription

from bt_mission.base.errors import BtMissionError
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.ros.executors.action_endpoints import qos_conflict

WAIT_S = 5.0
"""Wall time after which endpoints that belong together must be matched."""

PAUSE_NS = 1_000_000


class DiscoveryError(BtMissionError):
    """Endpoints of this process were not matched, or cannot be."""

    code = "BT-902"


def wait_for_matching(nodes: Sequence[Node]) -> None:
    """Return when all endpoints of ``nodes`` that belong together are matched.

    Raises:
        DiscoveryError: When some are not after five seconds of wall time; at once where the QoS of
            an action does not match.
    """
    if next(unmatched(nodes), None) is None:
        return
    why = next(chain.from_iterable(map(_conflicts, nodes)), None)
    if why is not None:
        raise DiscoveryError(why, code="BT-917")
    since = Stopwatch()
    while since.elapsed_s < WAIT_S:
        pause(nodes[0].context)
        if next(unmatched(nodes), None) is None:
            return
    missing = ", ".join(sorted(set(unmatched(nodes))))
    raise DiscoveryError(
        f"these did not discover each other within this process: {missing}; run `bt-mission "
        f"doctor` to check DDS on this machine"
    )


def pause(context: Context) -> None:
    """Leave the processor to the middleware's threads for a millisecond of wall time."""
    with context.handle:
        never = _rclpy.GuardCondition(context.handle)
        wait_set = _rclpy.WaitSet(0, 1, 0, 0, 0, 0, context.handle)
        wait_set.add_guard_condition(never)
        wait_set.wait(PAUSE_NS)


def unmatched(nodes: Sequence[Node]) -> Iterator[str]:
    """Names of what has a counterpart among ``nodes`` that it is not matched with yet."""
    yield from _unmatched_topics(nodes)
    yield from _unmatched_services(nodes)
    yield from _unmatched_actions(nodes)


def _unmatched_topics(nodes: Sequence[Node]) -> Iterator[str]:
    publishers = defaultdict(list)
    for node in nodes:
        for publisher in node.publishers:
            publishers[publisher.topic_name].append(publisher)
    subscriptions = defaultdict(list)
    for node in nodes:
        for subscription in node.subscriptions:
            subscriptions[subscription.topic_name].append(subscription)
    for topic in publishers.keys() & subscriptions.keys():
        writers, readers = publishers[topic], subscriptions[topic]
        for writer in writers:
            partners = sum(_compatible(writer, reader) for reader in readers)
            # The method of the class: a tapped one counts its tap, too.
            if Publisher.get_subscription_count(writer) < partners:
                yield f"publisher of {topic}"
        for reader in readers:
            partners = sum(_compatible(writer, reader) for writer in writers)
            if reader.get_publisher_count() < partners:
                yield f"subscription to {topic}"


def _compatible(writer: Publisher, reader: Subscription) -> bool:
    if writer.msg_type is not reader.msg_type:
        return False
    verdict, _ = qos_check_compatible(writer.qos_profile, reader.qos_profile)
    return verdict != QoSCompatibility.ERROR


def _unmatched_services(nodes: Sequence[Node]) -> Iterator[str]:
    names = {service.handle.name for node in nodes for service in node.services}
    for node in nodes:
        for client in node.clients:
            if client.handle.service_name in names and not client.service_is_ready():
                yield f"client of {client.handle.service_name}"


def _conflicts(node: Node) -> Iterator[str]:
    """Yield the actions whose server the clients of a node cannot hear."""
    for waitable in node.waitables:
        if isinstance(waitable, ActionClient):
            why = qos_conflict(node, waitable._action_name)
            if why is not None:
                yield why


def _unmatched_actions(nodes: Sequence[Node]) -> Iterator[str]:
    clients = [
        (node, waitable)
        for node in nodes
        for waitable in node.waitables
        if isinstance(waitable, ActionClient)
    ]
    if not clients:
        return
    names = set()
    for node in nodes:
        if any(isinstance(waitable, ActionServer) for waitable in node.waitables):
            actions = get_action_server_names_and_types_by_node(
                node, node.get_name(), node.get_namespace()
            )
            names |= {name for name, _ in actions}
    for node, client in clients:
        name = node.resolve_topic_name(client._action_name)
        if name in names and not client.server_is_ready():
            yield f"client of action {name}"
