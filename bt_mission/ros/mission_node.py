"""A node of its own for one mission."""

from __future__ import annotations

from rclpy.node import Node

from bt_mission.core.clock_messages import ValidClock
from bt_mission.language.mission import Mission
from bt_mission.ros.graph import NodeOptions, destroy_actions
from bt_mission.ros.mission_runner import MissionRunner, RunnerOptions


class MissionNode(ValidClock, Node):
    """A node that runs one mission; :attr:`runner` is what runs it.

    Args:
        mission: What to carry out.
        options: How to run it.
        node: How to make the node.

    Raises:
        BtMissionError: When the mission cannot be set up, such as an action of an unknown type.
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
