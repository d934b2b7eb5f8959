"""The standard services for the world of a simulation: which it is, which there are, its places."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Vector3
from rclpy.node import Node
from simulation_interfaces import msg, srv

from bt_mission.base.diagnostics import quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find, names
from bt_mission.base.geometry import Pose2D
from sim.ros import entity_messages
from sim.ros.requests import Code, Feature, Offer, RefusedError, fill_result, offer
from sim.ros.run_control import RunControl
from sim.world.loader import load_world
from sim.world.world import World

SPAWN = "spawn"
"""The name of the place where a robot alone starts."""

_ELSEWHERE = "a world is chosen at the start: bt-mission sim --world NAME"


class WorldServices:
    """The services for a world and its places. It is chosen at the start.

    `source` is its name or path.
    """

    def __init__(self, node: Node, control: RunControl, world: World, source: str) -> None:
        self._world, self._source = world, source
        offers = (
            Offer("GetCurrentWorld", self._get_current, (Feature.WORLD_INFO_GETTING,)),
            Offer("GetAvailableWorlds", self._get_available, (Feature.AVAILABLE_WORLDS,)),
            Offer("LoadWorld", _refuse),
            Offer("UnloadWorld", _refuse),
            Offer("GetNamedPoses", self._get_poses, (Feature.NAMED_POSES,)),
            Offer("GetNamedPoseBounds", self._get_pose_bounds, (Feature.POSE_BOUNDS,)),
        )
        self.features = offer(node, control, srv, offers)

    def _get_current(self, _: Any, response: Any) -> None:
        response.world = _resource(self._source, self._world)

    def _get_available(self, request: Any, response: Any) -> None:
        if request.filter.tags:
            raise RefusedError(Code.FEATURE_UNSUPPORTED, "worlds have no tags here: ask for none")
        unreadable = []
        for name in names("worlds"):
            try:
                response.worlds.append(_resource(name, load_world(name)))
            except BtMissionError:
                unreadable.append(name)
        notes = [f"cannot be read: {', '.join(unreadable)}"] if unreadable else []
        if request.additional_sources:
            sources = ", ".join(map(quoted, request.additional_sources[:10]))
            notes.append(f"not searched: {sources}")
        fill_result(response.result, Code.OK, "; ".join(notes))

    def _get_poses(self, request: Any, response: Any) -> None:
        spawn = self._world.spawn
        poses = [(SPAWN, "where a robot starts", [SPAWN], spawn.x, spawn.y, spawn.yaw)] + [
            (zone.name, f"a {zone.colour} zone", ["zone", "navigation_goal"], zone.x, zone.y, 0.0)
            for zone in self._world.zones
        ]
        for name, description, tags, x, y, yaw_deg in poses:
            if entity_messages.passes(request.tags, tags):
                named_pose = msg.NamedPose(name=name, description=description, tags=tags)
                entity_messages.fill_pose(named_pose.pose, Pose2D(x, y, math.radians(yaw_deg)))
                response.poses.append(named_pose)

    def _get_pose_bounds(self, request: Any, response: Any) -> None:
        zones = {zone.name: zone for zone in self._world.zones}
        if request.name in zones:
            radius = zones[request.name].radius
            response.bounds.type = entity_messages.SPHERE
            response.bounds.points = [Vector3(), Vector3(x=radius)]
        elif request.name != SPAWN:  # which has none
            known = ", ".join([SPAWN, *zones])
            text = f"no pose has the name {quoted(request.name[:60])}; there are {known}"
            raise RefusedError(Code.NOT_FOUND, text)


def _resource(source: str, world: World) -> Any:
    world_resource = msg.WorldResource(name=world.name, description=world.description)
    world_resource.world_resource.uri = find("worlds", source).resolve().as_uri()
    return world_resource


def _refuse(_request: Any, _response: Any) -> None:
    raise RefusedError(Code.FEATURE_UNSUPPORTED, _ELSEWHERE)
