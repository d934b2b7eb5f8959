"""What the mission's executive tells of itself beyond statuses, for those who look on later.

The details of people who look on now come at the pace of the wall; these at that of the mission.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.serialization import serialize_message

from bt_mission.ros.mission_details import MissionDetailsBuilder

if TYPE_CHECKING:
    from bt_mission.core.cdr.decoder import Take
    from bt_mission.ros.mission_node import MissionNode

EVERY_NS = 500_000_000
"""ROS time between two messages while nothing happens but that running nodes get on."""

TYPE = "bt_mission_interfaces/msg/MissionDetails"


class DetailsRecorder:
    """Takes what is new of a mission, when something has happened and twice a second.

    :param take: takes it, serialized.
    """

    def __init__(self, mission: MissionNode, take: Take) -> None:
        self._take = take
        self._details = MissionDetailsBuilder(
            mission.status.run, mission.run, mission.status.indices
        )
        self._is_due = False
        self._told_ns: int | None = None
        """None before the first: details are of use to nobody before there is a tree."""

    def close(self) -> None:
        """Follow the mission no longer."""
        self._details.close()

    def hasten(self) -> None:
        """Something has happened: tell of it with the next look."""
        self._is_due = True

    def look(self, now_ns: int) -> None:
        """Tell what is new, if it is time."""
        is_late = self._told_ns is not None and not 0 <= now_ns - self._told_ns < EVERY_NS
        if self._is_due or is_late:
            self._is_due, self._told_ns = False, now_ns
            self._take(serialize_message(self._details.describe_news()))
