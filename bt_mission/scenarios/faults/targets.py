"""A robot on the stage for which faults are made, where no test moves the stage on."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.behaviour import Behaviour
from rclpy.node import Node

from bt_mission.executive.executive import Executive
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.scenarios.faults.fault import FaultInstance
from bt_mission.sessions.scripted_server import ScriptedServer
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageRun


class StageTarget:
    """A robot on a stage as the place of faults.

    What goes wrong with a fault ends all missions in good order, and is kept in `errors`.
    """

    def __init__(self, stage: Stage, robot_run: StageRun) -> None:
        self.stage = stage
        self.robot_run = robot_run
        self.faults: list[FaultInstance] = []
        self.errors: list[Exception] = []
        self.scripted = scripted_on(stage)

    def make_node(self, name: str) -> Node:
        """Return a new node for a scripted server."""
        return self.stage.make_node(name)

    def find(self, name: str) -> Behaviour:
        """Return the node of this name, or at this path. Raises ScenarioError."""
        return find_node(self.robot_run.executive, name)

    def blame_test(self, error: Exception) -> None:
        """Keep an error of a fault, and end the missions."""
        self.errors.append(error)
        for run in self.stage.runs:
            run.executive.interrupt(f"a fault could not be injected: {error}")


def scripted_on(stage: Stage) -> Mapping[str, ScriptedServer]:
    """Return the servers that a scenario scripts, by the full names of their actions."""
    servers = {}
    for node in stage.clock.get_nodes():
        server = getattr(node, "server", None)
        if isinstance(server, ScriptedServer):
            servers[node.resolve_topic_name(server.name)] = server
    return servers


def find_node(executive: Executive, name: str) -> Behaviour:
    """Return the node of this name, or at this path.

    Raises:
        ScenarioError: If not exactly one exists.
    """
    paths = {node: executive.path_of(node) for node in executive.nodes}
    matching = [node for node, path in paths.items() if name in (node.name, path)]
    if not matching:
        raise no_such("node", name, list(dict.fromkeys(node.name for node in paths)))
    if len(matching) > 1:
        named = ", ".join(f"'{paths[node]}'" for node in matching)
        raise ScenarioError(f"several nodes are named '{name}': use a path, {named}")
    return matching[0]
