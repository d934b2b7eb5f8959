"""Scans as those of real robots: ranges vary with their length, and rays are lost on surfaces."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bt_mission.cli.main import main
from bt_mission.core.files import find
from bt_mission.core.robot.model import load_robot
from bt_mission.recording.reading import RecordedFile
from bt_mission.reproducing.diagnosis import diagnose
from bt_mission.reproducing.evidence import EvidenceReader
from bt_mission.reproducing.matching import matched
from tests.support.robot_bag import RobotBag

HALF_X, HALF_Y = 4.0, 3.0
"""Of a room, m."""
POST = (1.0, 2.2)
RAYS = 360
REST_S, SPEED = 2.0, 0.4


def _room(x: float, generator: np.random.Generator) -> Any:
    """Return the ranges of a lidar in a room, which has a dark wall ahead and a thin post."""
    angles = np.arange(RAYS) * math.tau / RAYS
    cos, sin = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, HALF_X - x, -HALF_X - x) / cos
        to_y = np.where(sin > 0, HALF_Y, -HALF_Y) / sin
    ranges = np.minimum(np.where(to_x > 0, to_x, np.inf), np.where(to_y > 0, to_y, np.inf))
    lost = np.where(ranges == to_x, 0.6, 0.2)  # in a dark wall, in another
    along = (POST[0] - x) * cos + POST[1] * sin
    across = np.abs(POST[1] * cos - (POST[0] - x) * sin)
    ranges = np.where((across < 0.04) & (along > 0), along, ranges)
    ranges += generator.normal(0.0, 0.01 * np.maximum(ranges - 1, 0.5))
    return np.where(generator.random(RAYS) < lost, np.inf, ranges)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot rests, drives through the room, and rests; it sends no goals, and has no map."""
    generator = np.random.default_rng(1)
    written = RobotBag(tmp_path_factory.mktemp("bag") / "room.mcap")
    for step in range(200):
        time_s = step * 0.05
        drives = REST_S <= time_s < 2 * REST_S + 3
        x = -1.0 + SPEED * min(max(time_s - REST_S, 0.0), REST_S + 3)
        written.odometry(time_s, x=x, speed=SPEED if drives else 0.0)
        if step % 2 == 0:
            written.scan(time_s, _room(x, generator).tolist(), increment=math.tau / RAYS)
    return written.close()


def test_a_lidar_that_loses_rays_keeps_its_walls(bag: Path) -> None:
    """Nothing comes, moves or fails: the walls and the post are in the world."""
    evidence = matched(EvidenceReader.of(RecordedFile(bag)).evidence(bag))
    diagnosis = diagnose(evidence, load_robot(find("robots", "burger")))
    assert [fault.name for fault in diagnosis.faults] == []
    middles = np.array([(HALF_X, 0.5), (-HALF_X, 0.5), (0.5, HALF_Y), (0.5, -HALF_Y)])
    assert diagnosis.around.distances(middles).max() < 0.1
    assert diagnosis.around.distances(np.array([POST]))[0] < 0.15


@pytest.mark.thorough
def test_a_path_without_goals_is_driven_after_the_same_rest(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Goals of the simulation have none of the recording to be compared with."""
    words = ["-o", str(tmp_path / "case"), "--robot", "burger", "--budget", "1"]
    assert main(["reproduce", str(bag), *words, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["verdict_recorded"]["outcome"] == "any"
    assert (result["goals_recorded"], result["events"]) == ([], [])
    assert [text for text in result["unexplained"] if "goals" in text] == []
    mission = (tmp_path / "case" / "mission.yaml").read_text(encoding="utf-8")
    assert "wait: 1.8" in mission
    assert mission.count("navigate_through_poses") == 1
