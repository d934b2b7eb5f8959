"""Names of a running graph for shells that complete a word: quick rather than complete."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from bt_mission.graph_tools import graph_session
from bt_mission.graph_tools.graph_query import Kind, entries, query_graph

if TYPE_CHECKING:
    from rclpy.node import Node

LiveKind = Literal["actions", "topics", "services", "executives", "namespaces"]

LOOK_S = 1.0
"""How long to look, at most: a person has pressed a key."""
QUIET_S = 0.2
"""A graph in which nothing has come up for this long, is taken as known."""

_OF_GRAPH: dict[LiveKind, Kind] = {"actions": "action", "topics": "topic", "services": "service"}


def live_names(kind: LiveKind) -> list[str]:
    """List the names of a kind that the graph has, sorted; namespaces are those of nodes."""
    with graph_session.GraphSession() as session:
        query_graph(session, LOOK_S, QUIET_S)
        if kind == "executives":
            found = _executives(session.node)
        elif kind == "namespaces":
            found = {space for _, space in session.node.get_node_names_and_namespaces()} - {"/"}
        else:
            found = {one.name for one in entries(session.node, _OF_GRAPH[kind])}
    return sorted(found)


def _executives(node: Node) -> set[str]:
    from bt_mission.ros.discovery import STATE_TYPE  # noqa: PLC0415 - takes longer than the look

    return {
        name.removesuffix("/state")
        for name, types in node.get_topic_names_and_types()
        if name.endswith("/state") and STATE_TYPE in types
    }
