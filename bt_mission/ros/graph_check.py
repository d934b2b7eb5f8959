"""The names of a mission in a ROS graph, running or listed: its actions, services and topics."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from rcl_interfaces.srv import GetParameters
from rclpy.action import get_action_names_and_types, get_action_server_names_and_types_by_node
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

from bt_mission.base.diagnostics import Diagnostic, did_you_mean, listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.base.yaml.document import read_source
from bt_mission.language.follow import Follow
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import (
    NodeModel,
)
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.trees import used
from bt_mission.ros.executors.action_endpoints import duplicate_servers, qos_conflict
from bt_mission.ros.executors.participants import Discovery
from bt_mission.ros.graph import REQUESTS, WAIT_S, GraphConnection, type_hash_of
from bt_mission.ros.interface_types import KINDS, action_type

LOOK_S = 4.0
"""Wall time after which a name counts as missing; Fast DDS announces a participant every 3 s."""

What = Literal["action", "service", "topic"]

NODE_NAME = "bt_mission_check"

_TYPE = re.compile(r"\w+/(?:action|srv|msg)/\w+")

Names = Mapping[What, Mapping[str, tuple[str, ...]]]
"""The names of a graph, with their types."""


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
    """A name in the graph: its types, none if it is missing.

    Attributes:
        has_other_fields: Whether the fields of its type differ from those that are installed here.
        conflict: Code and text of why an action should get no goal; empty if it can.
    """

    wanted: Wanted
    types: tuple[str, ...]
    hint: str | None = None
    has_other_fields: bool = False
    conflict: tuple[str, str] = ("", "")

    @property
    def is_there(self) -> bool:
        """Whether it exists, with the wanted type, and can be used."""
        is_usable = not self.has_other_fields and not self.conflict[0]
        return self.wanted.type in self.types and is_usable

    def diagnostic(self) -> Diagnostic:
        """Diagnostics, each at the node that needs the missing thing."""
        wanted, step = self.wanted, self.wanted.step
        code, conflict = self.conflict
        if code:
            return Diagnostic(code, conflict, wanted.file, step.line, step.column)
        if self.has_other_fields:
            message = (
                f"{wanted.name}: {wanted.type} has other fields in the graph than here, so no goal"
                " arrives; install the same release of its package on both sides"
            )
        elif self.types:
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
        node = graph.host_quiet(NODE_NAME, namespace)
        wanted = list(_wanted(mission, namespace))
        followed = [interface.name for interface in wanted if interface.is_followed]
        watch, discovery = Stopwatch(), Discovery(node)
        while True:
            is_over = discovery.is_over()
            names = _names_around(node, followed)
            findings = [_finding(interface, names, namespace) for interface in wanted]
            findings = [replace(each, conflict=_conflict(each.wanted, node)) for each in findings]
            are_there = all(finding.is_there for finding in findings)
            if is_over and (are_there or watch.elapsed_s > LOOK_S):
                return [_with_fields(finding, node) for finding in findings]
            graph.executor.spin_once(timeout_sec=WAIT_S)


def find_missing_in(
    listing: Path, mission: Mission, namespace: str | None = None
) -> list[NameFinding]:
    """Search for all names of a mission in a saved listing of a graph.

    Args:
        listing: The output of `ros2 action list -t` and its like.
        namespace: As for `find_missing`.

    Raises:
        BtMissionError: The file cannot be read, or is no listing with types.
    """
    names = _listed_names(listing)
    return [_finding(wanted, names, namespace) for wanted in _wanted(mission, namespace)]


def _listed_names(listing: Path) -> Names:
    """Read names and types, of which each says whether it is an action, a service or a topic."""
    folders: Mapping[str, What] = {"action": "action", "srv": "service", "msg": "topic"}
    names: dict[What, dict[str, tuple[str, ...]]] = {what: {} for what in folders.values()}
    for number, line in enumerate(read_source(listing).splitlines(), 1):
        if not line.startswith("/"):
            continue  # an empty line, a heading
        name, *words = line.replace(",", " ").split()
        types = tuple(filter(_TYPE.fullmatch, (word.strip("[]") for word in words)))
        kinds = {folders[kind.split("/")[1]] for kind in types}
        if len(kinds) != 1:
            example = ", ".join(f"'{example}'" for _, example in KINDS.values())
            raise BtMissionError(
                f"{listing}:{number}: expected a name and its type, such as {example}, got"
                f" {quoted(line.strip())}; list the graph with 'ros2 action list -t'",
                code="BT-513",
            )
        (what,) = kinds
        names[what][name] = types
    if not any(names.values()):
        raise BtMissionError(
            f"{listing} lists no action, service or topic; save 'ros2 action list -t'",
            code="BT-513",
        )
    return names


def _names_around(node: Node, followed: Sequence[str]) -> Names:
    """Return all names that a node has discovered; a followed topic has its publishers' types."""
    topics = {name: tuple(types) for name, types in node.get_topic_names_and_types()}
    for name in followed:
        publishers = node.get_publishers_info_by_topic(name)
        topics[name] = tuple(sorted({publisher.topic_type for publisher in publishers}))
    services = node.get_service_names_and_types()
    actions = get_action_names_and_types(node)
    return {
        "action": {name: tuple(types) for name, types in actions},
        "service": {name: tuple(types) for name, types in services},
        "topic": topics,
    }


def _conflict(wanted: Wanted, node: Node) -> tuple[str, str]:
    """Return code and text of why an action should get no goal; empty if it can."""
    if wanted.what != "action":
        return "", ""
    duplicates = duplicate_servers(node, [wanted.name])
    conflict = duplicates or qos_conflict(node, wanted.name)
    return ("BT-914" if duplicates else "BT-917", conflict) if conflict else ("", "")


def _with_fields(finding: NameFinding, node: Node) -> NameFinding:
    """Compare the fields of an action's feedback with those of the installed type."""
    if finding.wanted.what != "action" or not finding.is_there:
        return finding
    known = type_hash_of(node, action_type(finding.wanted.type).Impl.FeedbackMessage)
    servers = node.get_publishers_info_by_topic(f"{finding.wanted.name}/_action/feedback")
    is_other = any(server.topic_type_hash != known for server in servers)
    return replace(finding, has_other_fields=is_other)


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
        node = graph.host_quiet(NODE_NAME, namespace)
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


def _wanted(mission: Mission, namespace: str | None) -> Iterator[Wanted]:
    seen: set[tuple[str, str]] = set()
    names = used(mission)
    trees = [tree for tree in mission.all_trees if tree.is_main or tree.name in names]
    for follow in (followed for tree in trees for followed in tree.follow):
        name = _full(follow.settings.topic, namespace)
        if ("topic", name) not in seen:
            seen.add(("topic", name))
            yield Wanted("topic", name, follow.type, follow, follow.file, is_followed=True)
    for tree in trees:
        for step in tree.body.walk():
            if not isinstance(step, InterfaceNode):
                continue
            what = step.interface
            name = _full(step.ros_name, namespace)
            if (what, name) not in seen:
                seen.add((what, name))
                yield Wanted(what, name, step.type, step, tree.document.file)


def _full(name: str, namespace: str | None) -> str:
    """Return a name in the namespace of its robot, with a leading slash."""
    full: str = expand_topic_name(name, NODE_NAME, _rooted(namespace))
    return full


def _rooted(namespace: str | None) -> str:
    return f"/{(namespace or '').strip('/')}"


def _finding(wanted: Wanted, names: Names, namespace: str | None) -> NameFinding:
    there = names[wanted.what]
    types = there.get(wanted.name, ())
    same = [name for name in sorted(there) if wanted.type in there[name] and name != wanted.name]
    hint = None if wanted.type in types else _place_of(wanted, same, namespace)
    if hint is None and not types:
        hint = did_you_mean(wanted.name, (name for name in sorted(there) if name != wanted.name))
    return NameFinding(wanted, types, hint)


def _place_of(wanted: Wanted, same: Sequence[str], namespace: str | None) -> str | None:
    """Return a hint to names with the wanted type: in another namespace, or the only other."""
    relative = wanted.name.removeprefix(_rooted(namespace)).strip("/")
    elsewhere = [name for name in same if name.endswith(f"/{relative}")]
    if not elsewhere:
        return f"{same[0]} has this type; remap it, or name it so" if len(same) == 1 else None
    if len(elsewhere) > 1:
        return f"{listed(elsewhere)} have this type; give the --namespace of one of them"
    space = elsewhere[0].removesuffix(relative).strip("/")
    give = f"--namespace {space}" if space else "no --namespace"
    return f"{elsewhere[0]} has this type; give {give}"
