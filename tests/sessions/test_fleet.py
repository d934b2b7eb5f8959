"""Two robots carry out two missions in one world, on one clock."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage, StageError
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

LIMIT_NS = 300_000_000_000

# Short and relative names lie in the namespace of the robot.
LEGS = """\
mission: legs
robot: {robot}
seed: 4
tree:
  repeat: {{count: {count}}}
  do:
    sequence:
      - explore_forward: {{fwd_velocity: {speed}, stopping_distance: 0.4}}
        name: drive
        timeout: 60
      - action:
          name: turn
          type: bt_mission_interfaces/action/Turn
          goal: {{angle: {angle}}}
        name: turn away
        timeout: 30
"""

Make = Callable[..., Stage]


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Make]:
    """Put robots into one world: ``fleet(Member(...), Member(...))``."""
    with ExitStack() as stages:

        def start(*members: FleetRobot, world: str = "dqn_stage1") -> Stage:
            stages.close()
            return stages.enter_context(
                Stage(
                    robots=members,
                    image_folder=tmp_path,
                    options=StageOptions(world=world, seed=3),
                )
            )

        yield start


def legs(robot: str = "waffle", *, speed: float = 0.2, angle: float = 120.0, count: int = 2) -> Any:
    """A mission of some legs through the room, with a turn after each."""
    return load(LEGS.format(robot=robot, speed=speed, angle=angle, count=count))


def two() -> tuple[FleetRobot, FleetRobot]:
    """A Waffle and a Burger that start a metre and a half apart, back to back."""
    return (
        FleetRobot("robot1", legs(), x=0.75, y=0.3, yaw=20.0),
        FleetRobot("robot2", legs("burger", speed=0.15, angle=-100.0), x=-0.75, yaw=180.0),
    )


def finished(stage: Stage) -> Stage:
    """Step to the end."""
    while not stage.is_done:
        assert stage.now_ns < LIMIT_NS, "the missions do not end"
        stage.step()
    return stage


def test_two_robots_run_two_missions_at_once(fleet):
    """Both succeed, no goal is left behind, and nothing is touched."""
    stage = finished(fleet(*two()))
    for run in stage.runs:
        assert (str(run.executive.status), run.executive.reason) == ("success", "")
        assert run.executive.goals_sent == 4
        assert run.executive.goals_left_behind == ()
        assert run.robot.distance_travelled > 1.0
    assert sum(run.collisions for run in stage.runs) == 0


@pytest.mark.thorough
def test_goals_go_to_the_servers_of_the_own_robot(fleet):
    """By the namespace; the other robot stays where it is."""
    alone = FleetRobot("robot1", legs(count=1), x=0.75, yaw=20.0)
    idle = FleetRobot("robot2", load("mission: idle\ntree:\n  wait: 30\n"), x=-0.75)
    stage = fleet(alone, idle)
    actions: set[str] = set()
    stage["robot1"].trace.lines.subscribe(
        lambda line: actions.add(json.loads(line).get("action", "/robot1/"))
    )
    finished(stage)
    assert {name.rpartition("/")[0].rstrip("/") for name in actions} == {"/robot1"}
    assert stage["robot2"].robot.distance_travelled < 0.01
    assert stage["robot1"].robot.distance_travelled > 0.3


def test_a_mission_that_maps_is_refused(fleet):
    """Before anything starts."""
    maps = load("mission: map\nmap: unknown\ntree:\n  wait: 1\n")
    with pytest.raises(StageError, match="robot1: a fleet has no mapper"):
        fleet(FleetRobot("robot1", maps))


@pytest.mark.thorough
def test_robots_see_each_other(fleet):
    """One that stands in the way of the other is an obstacle like any other."""
    driver = FleetRobot("robot1", legs(count=1), x=-1.2)
    idle = FleetRobot("robot2", load("mission: idle\ntree:\n  wait: 30\n"), x=0.8, yaw=90.0)
    stage = finished(fleet(driver, idle, world="empty_arena"))
    assert sum(run.collisions for run in stage.runs) == 0
    x, _, _ = stage["robot1"].robot.pose
    hull_to_hull = 0.8 - stage["robot2"].robot.robot.hull.half_width - x - 0.069
    assert hull_to_hull == pytest.approx(0.4, abs=0.04)
