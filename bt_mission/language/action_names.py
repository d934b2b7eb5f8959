"""Actions that have a kind of node of their own in the mission language: ours, and plug-ins'."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from importlib.metadata import entry_points


@dataclass(frozen=True)
class ActionName:
    """An action behind a short name: its ROS name, its type, and whether it drives the base.

    The name is relative, so that it lies in the namespace of the robot that the mission is for.
    """

    action: str
    type: str
    moves_base: bool = True
    needs_camera: bool = False


GROUP = "bt_mission.actions"
"""The entry points by which a package gives its actions short names; each is a `ActionName`."""

_OURS = {
    "explore_forward": ActionName("explore_forward", "bt_mission_interfaces/action/ExploreForward"),
    "explore_frontiers": ActionName(
        "explore_frontiers", "bt_mission_interfaces/action/ExploreFrontiers"
    ),
    "move": ActionName("move", "bt_mission_interfaces/action/Move"),
    "turn": ActionName("turn", "bt_mission_interfaces/action/Turn"),
    "camera_sweep": ActionName(
        "camera_sweep", "bt_mission_interfaces/action/CameraSweep", needs_camera=True
    ),
    "take_pictures": ActionName(
        "take_pictures",
        "bt_mission_interfaces/action/TakePictures",
        moves_base=False,
        needs_camera=True,
    ),
    "find_colour": ActionName(
        "find_colour",
        "bt_mission_interfaces/action/FindColour",
        moves_base=False,
        needs_camera=True,
    ),
    "record_distance": ActionName(
        "record_distance", "bt_mission_interfaces/action/RecordDistance", moves_base=False
    ),
    "execute_mission": ActionName("execute_mission", "bt_mission_interfaces/action/ExecuteMission"),
    "navigate_to_pose": ActionName("navigate_to_pose", "nav2_msgs/action/NavigateToPose"),
    "navigate_through_poses": ActionName(
        "navigate_through_poses", "nav2_msgs/action/NavigateThroughPoses"
    ),
    "follow_waypoints": ActionName("follow_waypoints", "nav2_msgs/action/FollowWaypoints"),
    "spin": ActionName("spin", "nav2_msgs/action/Spin"),
    "back_up": ActionName("backup", "nav2_msgs/action/BackUp"),
    "drive_on_heading": ActionName("drive_on_heading", "nav2_msgs/action/DriveOnHeading"),
}
"""Those that come with the package. Nav2's `Wait` has none: `wait` is the language's own."""

BROKEN: dict[str, str] = {}
"""Plug-ins that cannot be used, and why."""


def plugged(taken: Container[str]) -> dict[str, ActionName]:
    """Return the short names of installed packages; those that are broken go to `BROKEN`."""
    found: dict[str, ActionName] = {}
    for one in entry_points(group=GROUP):
        try:
            short = one.load()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a user's module raises
            BROKEN[one.name] = f"{one.value} cannot be imported: {type(error).__name__}: {error}"
            continue
        if not isinstance(short, ActionName):
            BROKEN[one.name] = f"{one.value} is no ActionName, but {type(short).__name__}"
        elif one.name in taken or not one.name.isidentifier():
            BROKEN[one.name] = f"{one.value} has a name that is taken or no name"
        else:
            found[one.name] = short
    return found


ACTION_NAMES = {**_OURS, **plugged(_OURS)}
"""The kinds whose values are goals."""
