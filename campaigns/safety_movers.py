"""Explorations among obstacles that move, and what the robot did when one of them met it."""

from __future__ import annotations

import math
import tempfile
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import yaml
from bt_mission_interfaces.msg import Collision
from rclpy.parameter import Parameter
from safety_oracle import LEADS_S, Oracle, State

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from sim.world.loader import load_world
from sim.world.shapes import Obstacle

WORLDS = ("dqn_stage3", "dqn_stage4")
"""Four cylinders that go round the middle, and two that go to and fro, all at 0.1 m/s."""

SPEEDS = (0.1, 0.3, 0.5)
"""Of what moves, m/s; 0.1 is the worlds as they are."""

MISSION = "missions/explore_informed.yaml"
DURATION_S = 180
SPEED = 0.26
DRIVES, TURNS = 0.01, 0.02
"""m/s and rad/s commanded, from which the base drives or turns."""

END_M = 0.02
"""Depth of what counts as the hull's front or rear, m."""

KEPT_S = max(LEADS_S) + 1.0


@dataclass(frozen=True)
class Met:
    """One contact, by the truth.

    `doing` is what the base was commanded: "driving into", where the contact is on the end of the
    hull that leads, "driving", "turning" or "standing". `into` says whether what moves came on
    faster, towards the point of contact, than the robot did. `speed` and `speed_before` are the
    robot's at the contact and a second earlier, `mover_speed` that of what moves, all m/s.
    """

    obstacle: str
    is_mover: bool
    doing: str
    speed: float
    speed_before: float
    mover_speed: float
    was_run_into: bool = False
    was_seen: bool = False
    could_avoid: bool = False
    could_stand: bool = False


@dataclass(frozen=True)
class Outing:
    """One exploration: how far it went, and its contacts."""

    world: str
    mover_speed: float
    gives_way: bool
    driven_m: float
    met: tuple[Met, ...]


def outing(
    world: str,
    seed: int,
    seconds: int = DURATION_S,
    mover_speed: float = SPEEDS[0],
    gives_way: bool = True,  # noqa: FBT001, FBT002 - starmap
) -> Outing:
    """Explore for three virtual minutes."""
    given = {"duration": seconds, "speed": SPEED}
    with faster(world, mover_speed) as path, tempfile.TemporaryDirectory() as folder:
        mission = load(MISSION, set=given, seed=seed, world=path)
        with Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage:
            if not gives_way:
                stage.servers.set_parameters([Parameter("give_way_time", value=0.0)])
            met = tuple(_explore(stage))
            return Outing(world, mover_speed, gives_way, stage.runs[0].distance_travelled_m, met)


@contextmanager
def faster(world: str, speed: float) -> Iterator[str]:
    """Give a world in which what moves is so fast, m/s: a file, unless it is as shipped."""
    if speed == SPEEDS[0]:
        yield world
        return
    written = load_world(world).model_dump(by_alias=True, exclude_unset=True, mode="json")
    for cylinder in written["cylinders"]:
        motion = cylinder["motion"]
        if "period" in motion:
            motion["period"] = math.tau * math.hypot(cylinder["x"], cylinder["y"]) / speed
        else:
            motion["speed"] = speed
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", encoding="utf-8") as file:
        text: TextIO = file  # type: ignore[assignment]  # its file is a text file
        yaml.safe_dump(written, text)
        text.flush()
        yield file.name


def _explore(stage: Stage) -> Iterator[Met]:
    robot = stage.runs[0].robot
    obstacles = stage.sim.physics.world.obstacles
    movers = {obstacle.name: obstacle for obstacle in obstacles if obstacle.motion is not None}
    oracle = Oracle(robot.robot, obstacles)
    collisions: list[Collision] = []
    stage.node.create_subscription(Collision, "collisions", collisions.append, 10)
    start_ns = stage.sim.time_ns
    states: deque[State] = deque()
    while not stage.is_done:
        commanded = robot.commanded
        stage.step()
        now_s = (stage.sim.time_ns - start_ns) / 1e9
        states.append(State(now_s, robot.pose, robot.velocity))
        while states[0].time_s < now_s - KEPT_S:
            states.popleft()
        for collision in collisions:
            mover = movers.get(collision.obstacle)
            yield _met(collision, commanded, list(states), mover, robot.robot.hull, oracle)
        collisions.clear()


def _met(
    collision: Any,
    commanded: tuple[float, float],
    states: list[State],
    mover: Obstacle | None,
    hull: Any,
    oracle: Oracle,
) -> Met:
    now = states[-1]
    second_ago = next(state for state in states if state.time_s >= now.time_s - 1.0)
    ahead, left = _from_base(now, collision.point)
    linear, angular = commanded
    doing = "turning" if abs(angular) > TURNS else "standing"
    if abs(linear) > DRIVES:
        leads = ahead > hull.front - END_M if linear > 0 else ahead < hull.rear + END_M
        doing = "driving into" if leads else "driving"
    speeds = now.velocity[0], second_ago.velocity[0]
    if mover is None or mover.motion is None:
        return Met(collision.obstacle, False, doing, *speeds, 0.0)
    x, y, vx, vy = mover.motion.at(now.time_s)
    away = math.hypot(x - collision.point.x, y - collision.point.y)
    normal = (x - collision.point.x) / away, (y - collision.point.y) / away
    yaw = now.pose[2]
    rate_ahead, rate_left = now.velocity[0] - now.velocity[1] * left, now.velocity[1] * ahead
    own = (
        rate_ahead * math.cos(yaw) - rate_left * math.sin(yaw),
        rate_ahead * math.sin(yaw) + rate_left * math.cos(yaw),
    )
    could_avoid, could_stand = oracle.way_out(states, now.time_s)
    return Met(
        collision.obstacle,
        True,
        doing,
        *speeds,
        math.hypot(vx, vy),
        was_run_into=-(vx * normal[0] + vy * normal[1]) > own[0] * normal[0] + own[1] * normal[1],
        was_seen=oracle.is_seen(second_ago, mover),
        could_avoid=could_avoid,
        could_stand=could_stand,
    )


def _from_base(state: State, point: Any) -> tuple[float, float]:
    """How far ahead of the axle, and to the left, a point of the map lies, m."""
    x, y, yaw = state.pose
    across, along = point.x - x, point.y - y
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return cosine * across + sine * along, cosine * along - sine * across
