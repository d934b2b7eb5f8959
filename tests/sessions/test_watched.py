"""A mission on the stage that somebody looks on at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.robot_state import RobotState
from bt_mission.ros import robot_relay, status_publisher
from bt_mission.ros.local_client import LocalExecutive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions

DRIVE = """\
mission: drive
world: empty_arena
seed: 3
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
      cancel_when: current_distance_travelled > 0.4
      on_cancel: success
      timeout: 30
    - turn: {angle: 45}
"""


def run(folder: Path, watcher: Any = None) -> str:
    """Run the mission, looked on at by a watcher or by nobody; gives the hash of its trace."""
    options = StageOptions(watched=watcher is not None)
    with Stage(load(DRIVE), image_folder=folder, say=lambda _: None, options=options) as stage:
        graph = LocalExecutive(stage) if watcher is not None else None
        link = graph.attach(graph.name) if graph is not None else None
        while not stage.is_done:
            stage.step()
            if link is not None:
                watcher(stage, link.take(needs_statuses=False))
                assert link.is_there
        if graph is not None and link is not None:
            graph.serve()
            watcher(stage, link.take(needs_statuses=False))
            link.close()
            graph.close()
        return stage.trace.sha256


def test_looking_on_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The same trace, bit for bit, though everything is told in every tick."""
    monkeypatch.setattr(status_publisher, "DETAILS_PERIOD_S", 0.0)
    monkeypatch.setattr(robot_relay, "EVERY_S", 0.0)
    mission, robot = MissionState(), RobotState()
    feed = MissionFeed(mission)
    farthest = [0.0]

    def look(stage: Stage, received: Any) -> None:
        for message in received.messages:
            feed.take(message)
        for reading in received.robot:
            robot.take(reading)
        if received.robot and robot.pose is not None:
            x, y, _ = stage.sim.robots[0].pose
            farthest[0] = max(farthest[0], abs(robot.pose.x - x), abs(robot.pose.y - y))

    watched = run(tmp_path, look)
    assert run(tmp_path) == watched
    assert (mission.status, [goal.state for goal in mission.goals.values()]) == (
        "success",
        ["canceled", "succeeded"],
    )
    assert farthest[0] < 0.02, "the robot is seen where it is"
    assert len(robot.trail) >= 7
    assert len(robot.scan_points()) > 300
    assert robot.map is not None
    assert robot.charge is not None
    assert robot.charge > 90
