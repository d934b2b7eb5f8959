"""A world for the services of entities, and their requests and answers in short."""

import math
from typing import Any

from simulation_interfaces import msg

from sim.ros.requests import Code
from tests.sim.ros.conftest import result_of

WORLD: dict[str, Any] = {
    "size": [10, 10],
    "spawn": {"x": -1.0, "y": 0.5, "yaw": 90},
    "walls": [{"name": "the wall", "from": [-2, 3], "to": [2, 3], "thickness": 0.2}],
    "cylinders": [
        {
            "name": "circling",
            "x": 2,
            "y": 0,
            "radius": 0.15,
            "motion": {"around": [0, 0], "period": 80},
        }
    ],
    "zones": [{"name": "dock", "x": 1.0, "y": -2.0, "radius": 0.3}],
}


def pose_message(x: float, y: float, yaw: float = 0.0, frame: str = "") -> msg.SpawnEntity:
    """A request's part that has a pose."""
    request = msg.SpawnEntity()
    request.initial_pose.header.frame_id = frame
    pose = request.initial_pose.pose
    pose.position.x, pose.position.y = float(x), float(y)
    pose.orientation.z, pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return request


def spawn(sim, x=1.0, y=1.0, yaw=0.0, *, frame="", **fields):
    """Ask for a box, unless told otherwise; return the answer."""
    pose = pose_message(x, y, yaw, frame).initial_pose
    fields = {"uri": "box", "allow_renaming": True} | fields
    return sim.ask("SpawnEntity", initial_pose=pose, **fields)


def state_of(sim, name: str) -> tuple[float, ...]:
    """Where an entity is, and how it moves: x, y, yaw, vx, vy, turn."""
    answer = sim.ask("GetEntityState", entity=name)
    assert result_of(answer) == (Code.OK, "")
    state = answer.state
    q, linear = state.pose.orientation, state.twist.linear
    yaw = math.remainder(2 * math.atan2(q.z, q.w), math.tau)
    place = state.pose.position
    return (place.x, place.y, yaw, linear.x, linear.y, state.twist.angular.z)


def new_state(x, y, yaw=0.0, *, frame="", linear=(0.0, 0.0, 0.0), turn=0.0) -> msg.EntityState:
    """A state to set."""
    state = msg.EntityState()
    state.header.frame_id = frame
    state.pose = pose_message(x, y, yaw).initial_pose.pose
    ahead = state.twist.linear
    ahead.x, ahead.y, ahead.z = map(float, linear)
    state.twist.angular.z = turn
    return state


def entities(sim, **filters) -> list[str]:
    """Names that pass filters."""
    answer = sim.ask("GetEntities", filters=msg.EntityFilters(**filters))
    assert answer.result.result == Code.OK
    return list(answer.entities)
