"""A separate node for one mission."""

from __future__ import annotations

from rclpy.node import Node

from bt_mission.language.mission import Mission
from bt_mission.ros.executors.clock_messages import ValidClock
from bt_mission.ros.graph import NodeOptions, destroy_actions
from bt_mission.ros.mission_runner import MissionRunner, RunnerOptions


class MissionNode(ValidClock, Node):
    """A node that runs one mission; :attr:`runner` is its runner.

    Args:
        mission: The mission to run.
        options: How to run it.
        node: How to make the node.

    Raises:
        BtMissionError: The mission cannot be set up, for example because of an unknown action type.
    """

    def __init__(
        self,
        mission: Mission,
        options: RunnerOptions | None = None,
        *,
        node: NodeOptions | None = None,
    ) -> None:
        super().__init__(**(node or NodeOptions()).arguments())
        try:
            self.runner = MissionRunner(self, mission, options)
        except BaseException:
            self.destroy_node()
            raise

    def destroy_node(self) -> None:
        """Leave the graph, with every client."""
        destroy_actions(self)
        super().destroy_node()  # type: ignore[no-untyped-call]  # rclpy's
