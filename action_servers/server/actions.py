"""The table of actions: name, type, and how a goal becomes a maneuver.

What pictures, colours and maps are computed with takes longer to import than everything else, so
it is imported when such an action is offered: not with the module, and not by the first goal,
which would keep the base waiting.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from bt_mission_interfaces.action import (
    CameraSweep,
    ExploreForward,
    ExploreFrontiers,
    FindColour,
    Move,
    RecordDistance,
    TakePictures,
    Turn,
)
from nav2_msgs.action import (
    BackUp,
    DriveOnHeading,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    Wait,
)

from action_servers.camera.camera import CameraSwitch
from action_servers.core.grid import Floats
from action_servers.core.maneuver import Action, Maneuver, Observation, Refusal
from action_servers.core.tuning import FrontierTuning, NavigationTuning, Tuning
from action_servers.driving import (
    explore_forward,
    move,
    record_distance,
    recoveries,
    straight,
    turn,
)
from action_servers.robot_io.sensors import SensorSubscriptions
from bt_mission.core.robot.model import RobotModel


@dataclass(frozen=True)
class ServerContext:
    """What maneuvers are made with."""

    robot: RobotModel
    tuning: Tuning
    navigation: NavigationTuning
    frontiers: FrontierTuning
    sensors: SensorSubscriptions
    image_folder: Path
    turn_velocity: Callable[[], float]
    """Speed of a turn whose goal asks for 0, rad/s."""
    publish_distance: Callable[[float], None]
    """Sends the distance that is being recorded, m."""
    publish_path: Callable[[Floats], None]
    """Sends a path that is planned: points in the map, `n x 2` m."""


def action(name: str, kit: ServerContext) -> Action:
    """Return the action of that name; `ACTIONS` has the names."""
    return ACTIONS[name](kit)


def _common(kit: ServerContext) -> dict[str, Any]:
    return {"robot": kit.robot, "tuning": kit.tuning}


def _move(kit: ServerContext) -> Action:
    return Action("move", Move, partial(move.plan, **_common(kit)))


def _turn(kit: ServerContext) -> Action:
    def plan(goal: Any, now: Observation) -> Maneuver | Refusal:
        return turn.plan(goal, now, default_speed=kit.turn_velocity(), **_common(kit))

    return Action("turn", Turn, plan)


def _explore_forward(kit: ServerContext) -> Action:
    return Action("explore_forward", ExploreForward, partial(explore_forward.plan, **_common(kit)))


def _record_distance(kit: ServerContext) -> Action:
    plan = partial(record_distance.plan, publish=kit.publish_distance, **_common(kit))
    return Action("record_distance", RecordDistance, plan)


def _spin(kit: ServerContext) -> Action:
    return Action("spin", Spin, partial(turn.plan_spin, **_common(kit)))


def _backup(kit: ServerContext) -> Action:
    return Action("backup", BackUp, partial(straight.plan_back_up, **_common(kit)))


def _drive_on_heading(kit: ServerContext) -> Action:
    plan = partial(straight.plan_drive_on_heading, **_common(kit))
    return Action("drive_on_heading", DriveOnHeading, plan)


def _wait(_kit: ServerContext) -> Action:
    return Action("wait", Wait, lambda goal, _: recoveries.plan_wait(goal))


def _on_map(
    name: str, action_type: Any, kit: ServerContext, plan: Callable[..., Maneuver | Refusal]
) -> Action:
    """Return an action that drives along planned paths."""

    @contextmanager
    def navigating(maneuver: Any, _goal_id: str) -> Iterator[None]:
        maneuver.surroundings.on_path = kit.publish_path
        yield

    return Action(name, action_type, plan, needs_map=True, during=navigating)


def _navigate_to_pose(kit: ServerContext) -> Action:
    from action_servers.navigation import actions  # noqa: PLC0415 - see the module's docstring

    plan = partial(actions.plan_navigate_to_pose, robot=kit.robot, tuning=kit.navigation)
    return _on_map("navigate_to_pose", NavigateToPose, kit, plan)


def _navigate_through_poses(kit: ServerContext) -> Action:
    from action_servers.navigation import actions  # noqa: PLC0415 - see the module's docstring

    plan = partial(actions.plan_navigate_through_poses, robot=kit.robot, tuning=kit.navigation)
    return _on_map("navigate_through_poses", NavigateThroughPoses, kit, plan)


def _follow_waypoints(kit: ServerContext) -> Action:
    from action_servers.navigation import actions  # noqa: PLC0415 - see the module's docstring

    plan = partial(actions.plan_follow_waypoints, robot=kit.robot, tuning=kit.navigation)
    return _on_map("follow_waypoints", FollowWaypoints, kit, plan)


def _explore_frontiers(kit: ServerContext) -> Action:
    from action_servers.mapping import explore  # noqa: PLC0415 - see the module's docstring

    plan = partial(explore.plan, robot=kit.robot, tuning=kit.frontiers, navigation=kit.navigation)
    return _on_map("explore_frontiers", ExploreFrontiers, kit, plan)


def _with_camera(
    kit: ServerContext, plan: Callable[[CameraSwitch], Maneuver | Refusal]
) -> Maneuver | Refusal:
    planned = plan(kit.sensors.camera.user())
    if isinstance(planned, Refusal) or kit.sensors.camera.is_sent:
        return planned
    return Refusal(f"nobody publishes {kit.sensors.camera.topic}")


@contextmanager
def _looking(maneuver: Any, _goal_id: str) -> Iterator[None]:
    try:
        yield
    finally:
        maneuver.camera.off()


def _camera_sweep(kit: ServerContext) -> Action:
    from action_servers.camera import camera_sweep  # noqa: PLC0415 - see the module's docstring

    def plan(goal: Any, now: Observation) -> Maneuver | Refusal:
        store = camera_sweep.ImageFolder(kit.image_folder)
        return _with_camera(
            kit,
            lambda camera: camera_sweep.plan(goal, now, camera=camera, store=store, **_common(kit)),
        )

    @contextmanager
    def sweeping(sweep: Any, goal_id: str) -> Iterator[None]:
        sweep.store.name = f"sweep_{kit.sensors.observe().time_s:.3f}_{goal_id[:8]}"
        with _looking(sweep, goal_id):
            yield

    return Action("camera_sweep", CameraSweep, plan, during=sweeping)


def _take_pictures(kit: ServerContext) -> Action:
    from action_servers.camera import take_pictures  # noqa: PLC0415 - see the module's docstring

    def plan(goal: Any, _now: Observation) -> Maneuver | Refusal:
        return _with_camera(
            kit, lambda camera: take_pictures.plan(goal, camera=camera, **_common(kit))
        )

    return Action("take_pictures", TakePictures, plan, during=_looking)


def _find_colour(kit: ServerContext) -> Action:
    from action_servers.camera import find_colour  # noqa: PLC0415 - see the module's docstring

    def plan(goal: Any, _now: Observation) -> Maneuver | Refusal:
        return _with_camera(
            kit, lambda camera: find_colour.plan(goal, camera=camera, **_common(kit))
        )

    return Action("find_colour", FindColour, plan, during=_looking)


ACTIONS: Mapping[str, Callable[[ServerContext], Action]] = {
    "move": _move,
    "turn": _turn,
    "explore_forward": _explore_forward,
    "navigate_to_pose": _navigate_to_pose,
    "navigate_through_poses": _navigate_through_poses,
    "follow_waypoints": _follow_waypoints,
    "explore_frontiers": _explore_frontiers,
    "camera_sweep": _camera_sweep,
    "take_pictures": _take_pictures,
    "find_colour": _find_colour,
    "record_distance": _record_distance,
    "spin": _spin,
    "backup": _backup,
    "drive_on_heading": _drive_on_heading,
    "wait": _wait,
}
"""Every action that the servers offer, in the order in which they offer them."""
