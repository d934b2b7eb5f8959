"""The nodes of a stage: as they are elsewhere, but with publishers that a recorder can observe."""

from __future__ import annotations

from action_servers.mapping.node import MapperNode
from action_servers.server.node import ServersNode
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.observable_publisher import ObservableNode
from sim.ros.node import SimNode


class StageSimNode(ObservableNode, SimNode):
    """The simulator."""


class StageServersNode(ObservableNode, ServersNode):
    """The action servers of a robot."""


class StageMapperNode(ObservableNode, MapperNode):
    """The mapper of a robot."""


class StageMissionNode(ObservableNode, MissionNode):
    """The executive of a robot's mission."""
