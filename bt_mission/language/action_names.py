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

_OWN, _NAV2 = "bt_mission_interfaces/action", "nav2_msgs/action"
_OURS = {
    "explore_forward": ActionName("explore_forward", f"{_OWN}/ExploreForward"),
    "explore_frontiers": ActionName("explore_frontiers", f"{_OWN}/ExploreFrontiers"),
    "move": ActionName("move", f"{_OWN}/Move"),
    "turn": ActionName("turn", f"{_OWN}/Turn"),
    "camera_sweep": ActionName("camera_sweep", f"{_OWN}/CameraSweep", needs_camera=True),
    "take_pictures": ActionName(
        "take_pictures", f"{_OWN}/TakePictures", moves_base=False, needs_camera=True
    ),
    "find_colour": ActionName(
        "find_colour", f"{_OWN}/FindColour", moves_base=False, needs_camera=True
    ),
    "record_distance": ActionName("record_distance", f"{_OWN}/RecordDistance", moves_base=False),
    "execute_mission": ActionName("execute_mission", f"{_OWN}/ExecuteMission"),
    "navigate_to_pose": ActionName("navigate_to_pose", f"{_NAV2}/NavigateToPose"),
    "navigate_through_poses": ActionName("navigate_through_poses", f"{_NAV2}/NavigateThroughPoses"),
    "follow_waypoints": ActionName("follow_waypoints", f"{_NAV2}/FollowWaypoints"),
    "spin": ActionName("spin", f"{_NAV2}/Spin"),
    "back_up": ActionName("backup", f"{_NAV2}/BackUp"),
    "drive_on_heading": ActionName("drive_on_heading", f"{_NAV2}/DriveOnHeading"),
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
