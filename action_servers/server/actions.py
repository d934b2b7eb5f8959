"""The table of actions: name, type, and how a goal becomes a maneuver."""

from __future__ import annotations

from collections.abc import Callable, Iterator
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

from action_servers.camera import camera_sweep, find_colour, take_pictures
from action_servers.camera.camera import CameraSwitch
from action_servers.camera.camera_sweep import ImageFolder
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
from action_servers.mapping import explore
from action_servers.navigation.actions import (
    plan_follow_waypoints,
    plan_navigate_through_poses,
    plan_navigate_to_pose,
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


def actions(kit: ServerContext) -> tuple[Action, ...]:
    """Return every action that the servers offer."""
    common: dict[str, Any] = {"robot": kit.robot, "tuning": kit.tuning}
    return (
        *_driving(kit, common),
        *_watching(kit, common),
        Action("spin", Spin, partial(turn.plan_spin, **common)),
        Action("backup", BackUp, partial(straight.plan_back_up, **common)),
        Action(
            "drive_on_heading", DriveOnHeading, partial(straight.plan_drive_on_heading, **common)
        ),
        Action("wait", Wait, lambda goal, _: recoveries.plan_wait(goal)),
    )


def _driving(kit: ServerContext, common: dict[str, Any]) -> tuple[Action, ...]:
    def plan_turn(goal: Any, now: Observation) -> Maneuver | Refusal:
        return turn.plan(goal, now, default_speed=kit.turn_velocity(), **common)

    @contextmanager
    def navigating(maneuver: Any, _goal_id: str) -> Iterator[None]:
        maneuver.surroundings.on_path = kit.publish_path
        yield

    on_roads: dict[str, Any] = {"robot": kit.robot, "tuning": kit.navigation}
    navigate = partial(plan_navigate_to_pose, **on_roads)
    follow = partial(plan_follow_waypoints, **on_roads)
    explore_map = partial(
        explore.plan, robot=kit.robot, tuning=kit.frontiers, navigation=kit.navigation
    )
    return (
        Action("move", Move, partial(move.plan, **common)),
        Action("turn", Turn, plan_turn),
        Action("explore_forward", ExploreForward, partial(explore_forward.plan, **common)),
        Action("navigate_to_pose", NavigateToPose, navigate, needs_map=True, during=navigating),
        Action(
            "navigate_through_poses",
            NavigateThroughPoses,
            partial(plan_navigate_through_poses, **on_roads),
            needs_map=True,
            during=navigating,
        ),
        Action("follow_waypoints", FollowWaypoints, follow, needs_map=True, during=navigating),
        Action(
            "explore_frontiers", ExploreFrontiers, explore_map, needs_map=True, during=navigating
        ),
    )


def _watching(kit: ServerContext, common: dict[str, Any]) -> tuple[Action, ...]:
    def with_camera(plan: Callable[[CameraSwitch], Maneuver | Refusal]) -> Maneuver | Refusal:
        planned = plan(kit.sensors.camera.user())
        if isinstance(planned, Refusal) or kit.sensors.camera.is_sent:
            return planned
        return Refusal(f"nobody publishes {kit.sensors.camera.topic}")

    def plan_sweep(goal: Any, now: Observation) -> Maneuver | Refusal:
        store = ImageFolder(kit.image_folder)
        return with_camera(
            lambda camera: camera_sweep.plan(goal, now, camera=camera, store=store, **common)
        )

    def plan_pictures(goal: Any, _now: Observation) -> Maneuver | Refusal:
        return with_camera(lambda camera: take_pictures.plan(goal, camera=camera, **common))

    def plan_colour(goal: Any, _now: Observation) -> Maneuver | Refusal:
        return with_camera(lambda camera: find_colour.plan(goal, camera=camera, **common))

    @contextmanager
    def looking(maneuver: Any, _goal_id: str) -> Iterator[None]:
        try:
            yield
        finally:
            maneuver.camera.off()

    @contextmanager
    def sweeping(sweep: Any, goal_id: str) -> Iterator[None]:
        sweep.store.name = f"sweep_{kit.sensors.observe().time_s:.3f}_{goal_id[:8]}"
        with looking(sweep, goal_id):
            yield

    record = partial(record_distance.plan, publish=kit.publish_distance, **common)
    return (
        Action("camera_sweep", CameraSweep, plan_sweep, during=sweeping),
        Action("take_pictures", TakePictures, plan_pictures, during=looking),
        Action("find_colour", FindColour, plan_colour, during=looking),
        Action("record_distance", RecordDistance, record),
    )
