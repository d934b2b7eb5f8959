"""The content of a running graph: names, types, and nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from rclpy.action import get_action_names_and_types
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.validate_full_topic_name import validate_full_topic_name

from bt_mission.base.dds.endpoints import node_of
from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.errors import BtMissionError, NotThereError
from bt_mission.base.stamps import NS
from bt_mission.ros import graph_session
from bt_mission.ros.graph_session import NODE_PREFIX, GraphSession, wait

if TYPE_CHECKING:
    from rclpy.node import Node

LOOK_S = 5.0
"""The time for which a missing name is searched; other participants announce themselves every 3 s,
and in a burst when a new one joins.
"""

QUIET_S = 1.0
"""A graph without changes for this time counts as known."""

FEEDBACK = "/_action/feedback"
STATUS = "/_action/status"

LIVE_LOOK_S, LIVE_QUIET_S = 1.0, 0.2
"""The same for completion in a shell: the user has pressed a key."""

Kind = Literal["action", "topic", "service"]
LiveKind = Literal["actions", "topics", "services", "executives", "namespaces"]

_OF_GRAPH: dict[LiveKind, Kind] = {"actions": "action", "topics": "topic", "services": "service"}


@dataclass(frozen=True)
class GraphEntry:
    """A name in the graph: `offers` serve or publish it, `uses` call or subscribe to it."""

    name: str
    types: tuple[str, ...]
    offers: tuple[str, ...] = ()
    uses: tuple[str, ...] = ()


def query_graph(session: GraphSession, seconds: float = LOOK_S, quiet_s: float = QUIET_S) -> None:
    """Wait until the graph is known: nothing new for `quiet_s`, or the time is over.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    seen: Any = None
    still_since_ns = session.now_ns

    def is_known() -> bool:
        nonlocal seen, still_since_ns
        sight = _sight(session.node)
        if sight != seen:
            seen, still_since_ns = sight, session.now_ns
        has_others = any(not _is_ours(name) for name, _ in sight[0])
        return has_others and session.now_ns - still_since_ns >= quiet_s * NS

    wait(session, seconds, is_known)


def _sight(node: Node) -> tuple[Sequence[tuple[str, str]], Any, Any]:
    return (
        sorted(node.get_node_names_and_namespaces()),
        node.get_topic_names_and_types(),
        node.get_service_names_and_types(),
    )


def entries(node: Node, kind: Kind, *, hidden: bool = False) -> list[GraphEntry]:
    """Return the names of a kind in the graph, sorted; with `hidden`, also those that ROS hides.

    Actions with clients only count, too, as do topics of other nodes.
    """
    names = sorted(_LOOK_UP[kind](node))
    if kind != "action" and not hidden:
        names = [(name, types) for name, types in names if not is_hidden(name)]
    if kind == "service":
        return [GraphEntry(name, tuple(types)) for name, types in names]
    suffix = FEEDBACK if kind == "action" else ""
    known = [
        GraphEntry(
            name,
            tuple(types),
            _nodes(node.get_publishers_info_by_topic(name + suffix)),
            _nodes(node.get_subscriptions_info_by_topic(name + suffix)),
        )
        for name, types in names
    ]
    return [entry for entry in known if kind == "action" or entry.offers or entry.uses]


def is_hidden(name: str) -> bool:
    """Return whether ROS hides a name: a part of it begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))


def type_of(session: GraphSession, kind: Kind, name: str, seconds: float = LOOK_S) -> str:
    """Return the type of a resolved name in the graph; wait for it for some seconds.

    Raises:
        NotThereError: It does not appear.
        BtMissionError: It has several types.
        KeyboardInterrupt: Ctrl-C.
    """
    look_up = _LOOK_UP[kind]
    if not wait(session, seconds, lambda: bool(dict(look_up(session.node)).get(name))):
        raise NotThereError(_not_there(session, kind, name, seconds))
    types = dict(look_up(session.node))[name]
    if len(types) > 1:
        raise BtMissionError(
            f"{name} has several types ({listed(types)}): choose one with --type", code="BT-912"
        )
    return str(types[0])


def resolved(node: Node, kind: Kind, name: str) -> str:
    """The full name, with the namespace where it has no leading slash.

    Raises:
        BtMissionError: When it is no name of ROS.
    """
    try:
        full = expand_topic_name(name, node.get_name(), node.get_namespace())
        validate_full_topic_name(full, is_service=kind == "service")
    except (ValueError, InvalidServiceNameException, InvalidTopicNameException) as error:
        words = str(error).splitlines()[0].partition(", at /")[0]
        raise BtMissionError(f"expected the name of {_an(kind)}: {words}", code="BT-307") from error
    resolve = node.resolve_service_name if kind == "service" else node.resolve_topic_name
    return str(resolve(name))


def _not_there(session: GraphSession, kind: Kind, name: str, seconds: float) -> str:
    known = [entry.name for entry in entries(session.node, kind)]
    head = f"no {kind} {name} in the graph (looked for {seconds:g} s); there "
    are = f"are: {listed(known)}" if known else f"is no {kind}"
    hint = did_you_mean(name, known)
    return f"{head}{are}{'; ' + hint if hint else ''}"


def _an(kind: Kind) -> str:
    return "an action" if kind == "action" else f"a {kind}"


def _nodes(endpoints: Iterable[Any]) -> tuple[str, ...]:
    return tuple(
        sorted({node_of(endpoint) for endpoint in endpoints if not _is_ours(endpoint.node_name)})
    )


def _is_ours(node_name: str) -> bool:
    return node_name.startswith(NODE_PREFIX)


_LOOK_UP: dict[Kind, Callable[[Node], list[tuple[str, list[str]]]]] = {
    "action": get_action_names_and_types,
    "topic": lambda node: node.get_topic_names_and_types(),
    "service": lambda node: node.get_service_names_and_types(),
}


def live_names(kind: LiveKind) -> list[str]:
    """List the names of a kind that the graph has, for shells, sorted: quick rather than complete.

    Namespaces are those of nodes.
    """
    with graph_session.GraphSession() as session:
        query_graph(session, LIVE_LOOK_S, LIVE_QUIET_S)
        if kind == "executives":
            names = _executives(session.node)
        elif kind == "namespaces":
            names = {space for _, space in session.node.get_node_names_and_namespaces()} - {"/"}
        else:
            names = {entry.name for entry in entries(session.node, _OF_GRAPH[kind])}
    return sorted(names)


def _executives(node: Node) -> set[str]:
    from bt_mission.ros.discovery import STATE_TYPE

    return {
        name.removesuffix("/state")
        for name, types in node.get_topic_names_and_types()
        if name.endswith("/state") and STATE_TYPE in types
    }
