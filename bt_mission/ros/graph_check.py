"""The names of a mission in a running ROS graph: its actions, services and topics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rcl_interfaces.srv import GetParameters
from rclpy.action import get_action_names_and_types, get_action_server_names_and_types_by_node
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

from bt_mission.core.diagnostics import Diagnostic, did_you_mean, listed
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.language.follow import Follow
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import (
    NodeModel,
)
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.trees import used
from bt_mission.ros.graph import REQUESTS, WAIT_S, GraphConnection

LOOK_S = 4.0
"""Wall time after which a name counts as missing; Fast DDS announces a participant every 3 s."""

What = Literal["action", "service", "topic"]


@dataclass(frozen=True)
class Wanted:
    """One name that a mission uses, with the first step that uses it.

    Attributes:
        is_followed: Whether a variable follows the topic, so that it needs a publisher.
    """

    what: What
    name: str
    type: str
    step: NodeModel | Follow
    file: str
    is_followed: bool = False


@dataclass(frozen=True)
class NameFinding:
    """A name in the graph: its types, none if it is missing."""

    wanted: Wanted
    types: tuple[str, ...]
    hint: str | None = None

    @property
    def is_there(self) -> bool:
        """Whether it exists, with the wanted type."""
        return self.wanted.type in self.types

    def diagnostic(self) -> Diagnostic:
        """Diagnostics, each at the node that needs the missing thing."""
        wanted, step = self.wanted, self.wanted.step
        if self.types:
            message = f"{wanted.name} is a {listed(self.types)} in the graph, not a {wanted.type}"
        else:
            what = "publisher of" if wanted.is_followed else wanted.what
            message = f"no {what} {wanted.name} in the graph"
        return Diagnostic("BT-510", message, wanted.file, step.line, step.column, hint=self.hint)


def find_missing(mission: Mission, namespace: str | None = None) -> list[NameFinding]:
    """Join the graph and search for all names of a mission, for some seconds at most.

    Args:
        namespace: The robot's namespace; names without a leading slash are in it.
    """
    with GraphConnection(wall_clock=True) as graph:
        node = graph.host_quiet("bt_mission_check", namespace)
        wanted = list(_wanted(mission, node))
        watch = Stopwatch()
        while True:
            findings = [_finding(interface, node) for interface in wanted]
            if all(finding.is_there for finding in findings) or watch.elapsed_s > LOOK_S:
                return findings
            graph.executor.spin_once(timeout_sec=WAIT_S)


@dataclass(frozen=True)
class RunningServers:
    """Parameters of a node of action servers, and its actions, without their namespace."""

    parameters: Mapping[str, Any]
    actions: frozenset[str]


def find_servers(
    name: str, parameters: Sequence[str], namespace: str | None = None
) -> RunningServers | None:
    """Join the graph and ask a node for parameters, for some seconds at most.

    Args:
        name: The node's name.
        parameters: The names of the parameters; the node may have others.
        namespace: The namespace of the robot and the node.

    Returns:
        None if no such node answers.
    """
    with GraphConnection(wall_clock=True) as graph:
        node = graph.host_quiet("bt_mission_check", namespace)
        client = node.create_client(GetParameters, f"{name}/get_parameters", qos_profile=REQUESTS)
        watch = Stopwatch()
        while not (client.service_is_ready() and _actions_of(name, node)):
            if watch.elapsed_s > LOOK_S:
                return None
            graph.executor.spin_once(timeout_sec=WAIT_S)
        answer = client.call_async(GetParameters.Request(names=list(parameters)))
        graph.executor.spin_until_future_complete(answer, timeout_sec=LOOK_S)
        response = answer.result() if answer.done() else None
        if response is None:
            return None
        values = map(parameter_value_to_python, response.values)
        known = {
            parameter: value
            for parameter, value in zip(parameters, values, strict=False)
            if value is not None
        }
        return RunningServers(known, _actions_of(name, node))


def _actions_of(name: str, node: Node) -> frozenset[str]:
    """Return what a node of the same namespace serves, as far as is known of it by now."""
    namespace = node.get_namespace()
    if (name, namespace) not in node.get_node_names_and_namespaces():
        return frozenset()
    actions = get_action_server_names_and_types_by_node(node, name, namespace)
    return frozenset(full.rpartition("/")[2] for full, _ in actions)


def _wanted(mission: Mission, node: Node) -> Iterator[Wanted]:
    seen: set[tuple[str, str]] = set()
    names = used(mission)
    trees = [tree for tree in mission.all_trees if tree.is_main or tree.name in names]
    for follow in (followed for tree in trees for followed in tree.follow):
        name = node.resolve_topic_name(follow.settings.topic)
        if ("topic", name) not in seen:
            seen.add(("topic", name))
            yield Wanted("topic", name, follow.type, follow, follow.file, is_followed=True)
    for tree in trees:
        for step in tree.body.walk():
            if not isinstance(step, InterfaceNode):
                continue
            what = step.interface
            is_service = what == "service"
            resolve = node.resolve_service_name if is_service else node.resolve_topic_name
            name = resolve(step.ros_name)
            if (what, name) not in seen:
                seen.add((what, name))
                yield Wanted(what, name, step.type, step, tree.document.file)


def _finding(wanted: Wanted, node: Node) -> NameFinding:
    match wanted.what:
        case "action":
            there = dict(get_action_names_and_types(node))
        case "service":
            there = dict(node.get_service_names_and_types())
        case "topic":
            there = dict(node.get_topic_names_and_types())
            if wanted.is_followed:
                publishers = node.get_publishers_info_by_topic(wanted.name)
                there[wanted.name] = sorted({publisher.topic_type for publisher in publishers})
    types = tuple(there.get(wanted.name, ()))
    others = sorted(name for name in there if name != wanted.name)
    return NameFinding(wanted, types, None if types else did_you_mean(wanted.name, others))
