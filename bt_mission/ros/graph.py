"""A ROS graph that other processes make up, its time, and the care for a mission on it."""

from __future__ import annotations

import secrets
from collections.abc import Collection, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import rclpy
from rclpy import utilities
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.type_hash import TypeHash

from bt_mission.base.clock_watch import ClockWatch, Interrupted, LeftError, refuse_leaving
from bt_mission.base.dds.publishers import CLOCK, duplicate_publishers
from bt_mission.base.errors import BtMissionError, callback_failure
from bt_mission.base.goal_rate import MOST_WAITING
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.status import MissionStatus
from bt_mission.ros.executors.action_endpoints import duplicate_servers, qos_conflict, settled
from bt_mission.ros.executors.live import LiveExecutor

if TYPE_CHECKING:
    from bt_mission.executive.executive import Executive

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
REQUESTS = QoSProfile(depth=MOST_WAITING)
"""Of services that are offered."""

WAIT_S = 0.1
CLOCK_WAIT_S = 4.0
"""Wall time of the search for a publisher of ``/clock`` before this machine's clock is used; and of
standing time without a publisher before it counts as gone. Other participants of Fast DDS announce
themselves every 3 s, so discovery may take that long.
"""

SEARCH_S = 1.0
"""Wall time between two searches for a publisher of ``/clock`` that was missing at the start, s."""

LAST_ROUNDS = 20
"""Callbacks that may still run before the connection to a graph is closed."""

END_WAIT_S = 10.0
"""Wall time after which a mission that ends leaves the goals that nobody confirms."""


@dataclass(frozen=True)
class NodeOptions:
    """The options of a node.

    Attributes:
        namespace: The robot's namespace, in which relative names are.
        context: The rclpy context; None is the default one.
        use_sim_time: Follow ``/clock``.
        lean: No parameter services, log topic or type description for others to find.
        has_parameters: Parameter services even if `lean`, for viewers.
    """

    name: str = "bt_mission"
    namespace: str | None = None
    context: Context | None = None
    use_sim_time: bool = False
    lean: bool = False
    has_parameters: bool = False

    def arguments(self, **parameters: Any) -> dict[str, Any]:
        """Return the arguments of rclpy's constructor, with values of parameters."""
        if self.use_sim_time:
            parameters["use_sim_time"] = True
        if self.lean:
            parameters["start_type_description_service"] = False
        return {
            "node_name": self.name,
            "namespace": self.namespace,
            "context": self.context,
            "enable_rosout": not self.lean,
            "start_parameter_services": not self.lean or self.has_parameters,
            "parameter_overrides": [Parameter(name, value=it) for name, it in parameters.items()],
        }


def quiet_node(name: str, context: Context, namespace: str | None = None) -> Node:
    """Make a node that only watches."""
    return Node(**NodeOptions(name, namespace, context, lean=True).arguments())


def destroy_actions(node: Node) -> None:
    """Destroy the action clients and servers that a node has not destroyed.

    rclpy keeps them, and the whole DDS participant with them, until the garbage collector runs: a
    process that makes many nodes runs out of the ports of its domain.
    """
    for waitable in tuple(node.waitables):
        if isinstance(waitable, ActionClient | ActionServer):
            waitable.destroy()  # type: ignore[no-untyped-call]


def type_hash_of(node: Node, kind: Any) -> TypeHash:
    """Return the hash that identifies the installed version of a message's type.

    The name of the probe is random: other viewers, whose nodes have the same name, probe, too.
    """
    topic = f"~/probe_{secrets.token_hex(8)}"
    probe = node.create_subscription(kind, topic, lambda _: None, QoSProfile(depth=1))
    (own,) = node.get_subscriptions_info_by_topic(probe.topic_name)
    node.destroy_subscription(probe)
    type_hash: TypeHash = own.topic_type_hash
    return type_hash


_lent: list[Context] = []
"""The contexts that code of users has as the default one now."""


class as_default:  # noqa: N801 - named as a function; a generator costs ten calls a step
    """Have rclpy take a context for the default one, unless a program has initialized its own.

    Code of users asks that one: ``rclpy.ok()``, and clocks that sleep.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._before: Context | None = None

    def __enter__(self) -> None:
        defaults: Any = utilities
        before = self._before = defaults.g_default_context
        if before is None or not before.ok():
            defaults.g_default_context = self._context
        _lent.append(self._context)

    def __exit__(self, *_: object) -> None:
        _lent.pop()
        defaults: Any = utilities
        defaults.g_default_context = self._before


class ContextShutdown(SystemExit):
    """Code of a user shuts down the context of the whole process, which is not theirs."""


class SharedContext(Context):
    """A context that code of users has as the default one, and cannot shut down."""

    def shutdown(self) -> None:
        """Shut down, unless code of a user calls. Raises ContextShutdown."""
        self._refuse()
        super().shutdown()

    def try_shutdown(self) -> None:
        """Shut down if it is not yet, unless code of a user calls. Raises ContextShutdown."""
        self._refuse()
        super().try_shutdown()

    def _refuse(self) -> None:
        if self in _lent:
            what = "rclpy.shutdown() ends ROS for every node of the run; leave it out"
            raise ContextShutdown(what)


@dataclass(frozen=True)
class ProcessNode:
    """A node of this process, whose publishers can be tapped.

    Attributes:
        is_sensor: It sends only to subscriptions, and the messages of a topic have a fixed size:
            the same number of elements in each sequence, and of characters in each text.
    """

    node: Node
    is_sensor: bool = False


class GraphConnection:
    """A context and an executor on a graph of other processes.

    Time is the graph's: ``/clock`` if it has a publisher, else the clock of this machine.

    Args:
        wall_clock: Use this machine's clock, without looking for ``/clock``.
        ros_args: The arguments after ``--ros-args``, for all nodes of the context.
    """

    def __init__(self, *, wall_clock: bool = False, ros_args: Sequence[str] = ()) -> None:
        self._probe: Node | None = None
        with ExitStack() as made:
            self.context = rclpy.Context()
            rclpy.init(
                context=self.context,
                args=["--ros-args", *ros_args],
                signal_handler_options=SignalHandlerOptions.NO,
            )
            made.callback(self.context.shutdown)
            self.executor = LiveExecutor(context=self.context)
            made.callback(self.executor.shutdown)
            self.has_clock = not wall_clock and self._find_clock()
            self.lacks_clock = not (wall_clock or self.has_clock)
            """Whether the clock is that of this machine only because none was published."""
            self._exit = made.pop_all()
        self._since_last_time = Stopwatch()
        self._since_search = Stopwatch()
        self._seen_ns = 0
        self._ending: tuple[Executive, Stopwatch] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the graph."""
        self._exit.close()

    def host(self, node: Node) -> None:
        """Serve a node, too."""
        self.executor.add_node(node)
        if self._probe is not None:
            # Not earlier: with its last node a context leaves the graph, and loses its discovery.
            self._probe.destroy_node()
            self._probe = None

    def refuse_conflicts(
        self, node: Node, actions: Collection[str], *, allow_duplicates: bool = False
    ) -> str | None:
        """Look whether a mission can tell its robot, its clock and its servers from others.

        Args:
            node: The mission's, which is not served yet.
            actions: Those that the mission uses.
            allow_duplicates: Several nodes may publish the odometry and the clock, or serve an
                action.

        Returns:
            The nodes that do, if they may; None if none does.

        Raises:
            BtMissionError: Several do, or the QoS of an action's server does not match; with their
                names, and what to do.
        """

        def duplicates() -> str | None:
            return duplicate_publishers(node) or duplicate_servers(node, actions)

        def spin() -> None:
            self.executor.spin_once(timeout_sec=WAIT_S)

        why = settled(node, lambda: None if allow_duplicates else duplicates(), spin)
        if why is not None:
            raise BtMissionError(why, code="BT-914")
        for action in actions:
            if (conflict := qos_conflict(node, action)) is not None:
                raise BtMissionError(conflict, code="BT-917")
        return duplicates()

    def host_quiet(self, name: str, namespace: str | None = None) -> Node:
        """Make and serve a node that only watches, until the connection is closed."""
        node = quiet_node(name, self.context, namespace)
        self._exit.callback(node.destroy_node)
        self._exit.callback(destroy_actions, node)
        self.host(node)
        return node

    def drop(self, node: Node) -> None:
        """Serve a node no longer, and destroy it."""
        self.executor.remove_node(node)
        node.destroy_node()

    def step(self, executive: Executive | None, node: Node) -> None:
        """Serve what comes next, for at most a tenth of a second, and care for a mission.

        An exception in a callback ends it as failed; so does a clock that has gone. Its end is
        bounded by wall time, also where ROS time stands still.

        Args:
            executive: Of the mission that runs; without one an exception is the caller's.
            node: Whose clock is the mission's.
        """
        try:
            with as_default(self.context):
                self.executor.spin_once(timeout_sec=WAIT_S)
        except Interrupted:
            pass  # by a signal, on which the caller acts
        except BaseException as error:  # noqa: BLE001 - what ends this process is raised again
            _fail(executive, error)
        if executive is None:
            self._since_last_time = Stopwatch()
            return
        if self.has_clock:
            self._watch_clock(executive, node)
        elif self.lacks_clock:
            self._refuse_late_clock(executive, node)
        if executive.status is MissionStatus.ENDING:
            self._see_to_the_end(executive)

    def watch_users(self) -> ClockWatch:
        """Watch for code of users that blocks, from now on."""
        watch = ClockWatch(lambda: self.executor.callbacks_served, is_virtual=False)
        self._exit.callback(watch.close)
        return watch

    def drain(self) -> None:
        """Let pending results and responses be sent."""
        for _ in range(LAST_ROUNDS):
            self.executor.spin_once(timeout_sec=0.0)

    def _see_to_the_end(self, executive: Executive) -> None:
        if self._ending is None or self._ending[0] is not executive:
            self._ending = (executive, Stopwatch())
        executive.tick()
        if self._ending[1].elapsed_s > END_WAIT_S + executive.cleanups.limit_s:
            executive.abandon(f"not every goal had ended after {END_WAIT_S:g} s")

    def _find_clock(self) -> bool:
        probe = self._probe = quiet_node("bt_mission_probe", self.context)
        watch = Stopwatch()
        self.executor.add_node(probe)
        while not (has_clock := probe.count_publishers(CLOCK) > 0):
            if watch.elapsed_s > CLOCK_WAIT_S:
                break
            self.executor.spin_once(timeout_sec=WAIT_S)
        self.executor.remove_node(probe)
        return has_clock

    def _refuse_late_clock(self, executive: Executive, node: Node) -> None:
        """End a mission when ``/clock`` is published after it has begun on another clock."""
        if self._since_search.elapsed_s < SEARCH_S:
            return
        self._since_search = Stopwatch()
        if node.count_publishers(CLOCK):
            executive.fail(
                f"{CLOCK} is published only now: this mission runs on the clock of this machine, "
                f"so its times are wrong; run it again [BT-918]"
            )

    def _watch_clock(self, executive: Executive, node: Node) -> None:
        """End a mission when the publisher of ``/clock`` has left and time does not move."""
        now_ns = node.get_clock().now().nanoseconds
        if now_ns != self._seen_ns:
            self._seen_ns = now_ns
            self._since_last_time = Stopwatch()
        elif self._since_last_time.elapsed_s > CLOCK_WAIT_S and not node.count_publishers(CLOCK):
            executive.abandon(f"{CLOCK} has gone: time stands still")


def _fail(executive: Executive | None, error: BaseException) -> None:
    """End a mission as failed by an exception of a callback; without a mission, raise it."""
    try:
        refuse_leaving(error)
    except LeftError as left:
        error = left
    if executive is None or not isinstance(error, Exception):
        raise error
    executive.fail(callback_failure(error))
