"""The entities that can wake the nodes of an executor, and which of them are ready."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import Any

from rclpy.action import ActionClient, ActionServer, get_action_server_names_and_types_by_node
from rclpy.client import Client
from rclpy.context import Context
from rclpy.event_handler import EventHandler
from rclpy.exceptions import InvalidHandle
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from rclpy.waitable import Waitable

from bt_mission.ros.executors.arrivals import RANK, TELLING, Arrivals, Arrived

KINDS = ("subscriptions", "services", "clients", "guards", "waitables", "timers")
COUNTS = (
    "num_subscriptions",
    "num_guard_conditions",
    "num_timers",
    "num_clients",
    "num_services",
    "num_events",
)


TELLING_AGAIN = tuple(TELLING)
_ADDED: dict[type, str] = {
    Subscription: "subscription",
    Service: "service",
    Client: "client",
    GuardCondition: "guard_condition",
}
"""The names of the kinds in a wait set."""


class Entities:
    """A snapshot of the entities of some nodes, and the arrivals for them.

    A wait set is asked only for entities that the middleware does not report: guard conditions and
    waitables of other packages.

    Args:
        nodes: Nodes in the order in which they are served.
        context: The rclpy context of the nodes.
        arrivals: Counts the arrivals; it is set to watch these entities.
        with_events: Include the events of discovery. Discovery runs on a thread, and so has no
            virtual time.
    """

    def __init__(
        self,
        nodes: Sequence[Node],
        context: Context,
        arrivals: Arrivals,
        *,
        with_events: bool = False,
    ) -> None:
        self.subscriptions = [e for node in nodes for e in node.subscriptions]
        self.services = [e for node in nodes for e in node.services]
        self.clients = [e for node in nodes for e in node.clients]
        self.guards = [e for node in nodes for e in node.guards]
        self.waitables = [
            e
            for node in nodes
            for e in node.waitables
            if with_events or not isinstance(e, EventHandler)
        ]
        self.arrivals = arrivals
        messages = (*self.subscriptions, *self.services, *self.clients)
        in_order = (*messages, *self.guards, *self.waitables)
        self.asked = arrivals.watch(in_order)
        """The entities that the middleware does not report: they are asked at each look."""
        self.timers: list[Timer] = [e for node in nodes for e in node.timers]
        self.timer_handles = [timer.handle for timer in self.timers]
        self._nodes = tuple(nodes)
        self._context = context
        self._owners = {
            id(entity): node for node in nodes for kind in KINDS for entity in getattr(node, kind)
        }

    @cached_property
    def _awake(self) -> Any:
        # Always triggered, so that a wait never gives up the processor: even a wait of zero
        # sleeps for the kernel's timer slack, which took nine tenths of its time.
        with self._context.handle:
            return _rclpy.GuardCondition(self._context.handle)

    @cached_property
    def _wait_set(self) -> Any:
        sizes = dict.fromkeys(COUNTS, 0)
        sizes["num_guard_conditions"] = 1
        for asked in self.asked:
            for known, kind in _ADDED.items():
                sizes[f"num_{kind}s"] += isinstance(asked.entity, known)
            if isinstance(asked.entity, Waitable):
                numbers = asked.entity.get_num_entities()
                for name in COUNTS:
                    sizes[name] += getattr(numbers, name)
        with self._context.handle:
            return _rclpy.WaitSet(*sizes.values(), self._context.handle)

    def node_of(self, entity: Any) -> Node | None:
        """Return the node of an entity; None if it is gone, or its node is not served."""
        return self._owners.get(id(entity))

    @cached_property
    def _names(self) -> dict[int, str]:
        return {id(node): node.get_fully_qualified_name() for node in self._nodes}

    def owner_of(self, entity: Any) -> str:
        """Return the full name of the node of an entity; empty if it is gone."""
        return self._names.get(id(self.node_of(entity)), "")

    def actions_of(self, end: ActionClient | ActionServer) -> tuple[str, ...]:
        """Return the full names of the actions to which an end of an action may belong.

        A server of rclpy does not keep its name, so servers of one type on one node cannot be
        distinguished.
        """
        node = end._node
        if isinstance(end, ActionClient):
            return (node.resolve_topic_name(end._action_name),)
        return self._offered[node.get_fully_qualified_name(), end._action_type]

    def offers(self, action: str) -> bool:
        """Return whether a node serves the action of this full name."""
        return action in self._actions

    @cached_property
    def _actions(self) -> frozenset[str]:
        return frozenset(name for names in self._offered.values() for name in names)

    @cached_property
    def _offered(self) -> dict[tuple[str, Any], tuple[str, ...]]:
        offered: dict[tuple[str, Any], tuple[str, ...]] = {}
        for node in self._nodes:
            servers = [
                waitable for waitable in node.waitables if isinstance(waitable, ActionServer)
            ]
            if not servers:
                continue
            named = get_action_server_names_and_types_by_node(
                node, node.get_name(), node.get_namespace()
            )
            for kind in {server._action_type for server in servers}:
                names = tuple(name for name, types in named if _type_name(kind) in types)
                offered[node.get_fully_qualified_name(), kind] = names
        return offered

    def ready(self, owed: Sequence[Arrived], *, any_held: bool) -> Sequence[Arrived]:
        """Return the arrivals that can be served, by kind, then in the order of creation.

        Args:
            owed: What was ready earlier, was not served, and is not reported again.
            any_held: Whether a callback that awaits something may hold a callback group.
        """
        waiting = self.arrivals.waiting()
        ready = [
            *waiting,
            *self._with_work(self._askable(owed) if any_held or owed else self.asked),
        ]
        ready += [
            arrived for arrived in owed if arrived not in ready and self.node_of(arrived.entity)
        ]
        ready.sort(key=RANK)
        return ready

    def _with_work(self, asked: Sequence[Arrived]) -> list[Arrived]:
        """Ask entities through a wait set. Return those that are ready."""
        wait_set = self._wait_set
        wait_set.clear_entities()
        wait_set.add_guard_condition(self._awake)
        self._awake.trigger_guard_condition()
        for arrived in asked:
            entity = arrived.entity
            if isinstance(entity, Waitable):
                entity.add_to_wait_set(wait_set)
            else:
                kind = next(kind for known, kind in _ADDED.items() if isinstance(entity, known))
                getattr(wait_set, f"add_{kind}")(entity.handle)
        wait_set.wait(0)
        ready = {
            pointer for kind in _ADDED.values() for pointer in wait_set.get_ready_entities(kind)
        }
        return [
            arrived
            for arrived in asked
            if (
                _has_work(arrived.entity, wait_set)
                if isinstance(arrived.entity, Waitable)
                else arrived.entity.handle.pointer in ready
            )
        ]

    def _askable(self, owed: Sequence[Arrived]) -> list[Arrived]:
        """Return the entities to ask, without those that would be ready and cannot be served."""
        return [
            arrived
            for arrived in self.asked
            if not isinstance(arrived.entity, Waitable)
            or isinstance(arrived.entity, TELLING_AGAIN)
            or (arrived not in owed and arrived.entity.callback_group.can_execute(arrived.entity))
        ]

    def ns_until_next_timer(
        self,
        *,
        can_fire: Callable[[Timer], bool] | None,
        stopped: frozenset[Node] = frozenset(),
    ) -> int | None:
        """Return the nanoseconds until the next timer is due, or None without a timer.

        A timer that waits for the end of a suspended callback is not due before that. Time moves
        without it.

        Args:
            can_fire: Returns whether a timer waits for nothing; None if none does.
            stopped: Nodes whose clocks stand still.
        """
        if not stopped and can_fire is None:
            return ns_until_due(self.timer_handles)
        timers = self.timers
        if stopped:
            timers = [timer for timer in timers if self.node_of(timer) not in stopped]
        if can_fire is not None:
            timers = [timer for timer in timers if can_fire(timer)]
        return ns_until_due(timer.handle for timer in timers)


def _has_work(waitable: Waitable, wait_set: Any) -> bool:
    """Return whether a waitable has something to serve besides old results of goals to drop.

    Those stay due for a whole instant, during which virtual time would not move. They are dropped
    with the next request.
    """
    if isinstance(waitable, ActionServer) and True not in waitable._handle.is_ready(wait_set)[:3]:
        return False
    return bool(waitable.is_ready(wait_set))


def _type_name(action_type: Any) -> str:
    """Such as ``bt_mission_interfaces/action/Turn``."""
    return "/".join([*action_type.__module__.split(".")[:2], action_type.__name__])


def ns_until_due(handles: Iterable[Any]) -> int | None:
    """Return the nanoseconds until the first of some timers is due by its clock, or None."""
    nearest: int | None = None
    for handle in handles:
        try:
            with handle:
                wait_ns = handle.time_until_next_call()  # None if it is canceled
        except InvalidHandle:
            continue  # destroyed since the snapshot
        if wait_ns is not None and (nearest is None or wait_ns < nearest):
            nearest = wait_ns
    return nearest


def is_reported_once(entity: Any) -> bool:
    """Return whether an entity forgets that it is ready once that has been read.

    A message, a request or a response waits until it is taken. A guard condition and the parts of
    waitables of other packages do not.
    """
    return not isinstance(entity, TELLING_AGAIN)


def exists(node: Node) -> bool:
    """Return whether a node is not destroyed."""
    try:
        with node.handle:
            return True
    except InvalidHandle:
        return False


def describe_timer(timer: Timer, node_name: str) -> str:
    """A timer's owner and period, for people."""
    return f"timer of {node_name}, every {timer.timer_period_ns / 1e9:g} s"


def describe(entity: Any) -> str:
    """An entity's kind and name, for people."""
    for attribute in ("topic_name", "srv_name", "_action_name"):
        name = getattr(entity, attribute, None)
        if name:
            return f"{type(entity).__name__} {name}"
    return type(entity).__name__
