"""Noise is no fault: corrections of a localiser, and walls that are seen from a wrong pose."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bt_mission.base.files import find
from bt_mission.base.geometry import Pose2D
from bt_mission.commands.reproduce.diagnosis import diagnose
from bt_mission.commands.reproduce.evidence import Path2D
from bt_mission.commands.reproduce.mission import way_between
from bt_mission.commands.reproduce.motion import Drift
from bt_mission.commands.reproduce.sight import settled
from bt_mission.commands.reproduce.surroundings import StaticSurroundings
from bt_mission.commands.reproduce.tracing import Segment
from bt_mission.robots.model import load_robot
from tests.commands.reproduce.test_reproduce import evidence_of, recorded

TIMES = np.arange(0.0, 20.0, 0.05)


def drift_of(place: np.ndarray[Any, Any]) -> Drift:
    """Return the drift of a robot whose place ahead differs from its wheels by this, m."""
    zero = np.zeros(len(place))
    return Drift.of(np.diff(place, prepend=place[0]) / 0.05, zero, zero)


def test_a_place_that_is_corrected_often_is_not_pushed() -> None:
    """Every second, by some centimetres; only a much larger change counts."""
    draws = np.random.default_rng(1)
    noise = np.repeat(draws.normal(0, 0.03, 20), 20)
    drift = drift_of(noise)
    usual = drift.noise(TIMES, [])
    assert not any(drift.is_beyond(usual, begin, begin) for begin in np.arange(1.0, 19.0, 0.25))
    pushed = drift_of(noise + np.where(TIMES > 10.5, 0.3, 0.0))
    assert pushed.is_beyond(pushed.noise(TIMES, [(10.5, 10.5)]), 10.5, 10.5)


def test_a_jump_that_is_taken_back_is_no_push() -> None:
    """The robot was never there; one that stays there was moved."""
    exact = np.zeros(len(TIMES))
    back = drift_of(exact + np.where((TIMES > 10) & (TIMES < 10.2), 0.3, 0.0))
    assert not back.is_beyond(back.noise(TIMES, [(10.0, 10.2)]), 10.0, 10.2)
    stays = drift_of(exact + np.where(TIMES > 10, 0.02, 0.0))
    assert stays.is_beyond(stays.noise(TIMES, [(10.0, 10.0)]), 10.0, 10.0)


def test_a_scan_is_compared_where_it_fits_best() -> None:
    """Walls that a wrong pose turns and shifts are walls; a thing between them is one still."""
    corners = [(2.0, 1.5), (-2.0, 1.5), (-2.0, -1.5), (2.0, -1.5)]
    walls = [
        Segment(first, second)
        for first, second in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    room = StaticSurroundings(walls, np.empty((0, 2)), is_mapped=False, cells=None)  # type: ignore[arg-type]
    along = np.linspace(-1.4, 1.4, 60)
    points = np.vstack(
        [
            np.column_stack((np.full(60, 2.0), along)),
            np.column_stack((np.full(60, -2.0), along)),
            np.column_stack((along, np.full(60, 1.5))),
            [(0.5, 0.5), (0.52, 0.5), (0.54, 0.5)],
        ]
    )
    yaw, shift = math.radians(4), np.array([0.12, -0.08])
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    placed, distances = settled(room, points @ turn.T + shift, Pose2D(0.1, 0.0, 0.0))
    assert np.percentile(distances, 95) < 0.01
    assert np.abs(placed[-3:] - points[-3:]).max() < 0.02
    assert (distances[-3:] > 0.9).all()


def test_a_jump_of_the_localiser_alone_is_no_shove(tmp_path: Path) -> None:
    """The scans before and after it lie where the wheels have put the robot."""
    robot = load_robot(find("robots", "waffle"))
    evidence = evidence_of(recorded(tmp_path))
    track, jump = evidence.track, np.where(evidence.track.times > 1.5, 1.0, 0.0)
    moved = replace(track, x=track.x + 0.05 * jump, y=track.y - 0.03 * jump)
    assert diagnose(replace(evidence, track=moved), robot).faults == []


def test_a_goal_that_is_not_known_is_where_the_robot_fits() -> None:
    """Something may have pushed it to where no path leads, or all of its way is there."""
    way = np.linspace(0.0, 2.0, 41)
    track = Path2D(way * 10, way, np.zeros(41), np.zeros(41), "map")
    evidence = SimpleNamespace(track=track)
    for free_m, last in ((3.0, [2.0, 0.0, 0.0]), (1.5, [1.5, 0.0, 0.0])):
        poses = way_between(evidence, 0.0, 20.0, lambda x, _, free_m=free_m: x <= free_m)  # type: ignore[arg-type,misc]
        assert poses[-1] == pytest.approx(last, abs=0.011)
    assert way_between(evidence, 0.0, 20.0, lambda *_: False) == []  # type: ignore[arg-type]


@pytest.mark.thorough
@pytest.mark.parametrize("nature", ["usual", "harsh"])
def test_a_run_without_a_fault_has_none(tmp_path: Path, nature: str) -> None:
    """Whatever nature its sensors, its wheels and its localisation have."""
    robot = load_robot(find("robots", "waffle"))
    named = [
        fault.name
        for seed in range(10)
        for fault in diagnose(
            evidence_of(recorded(tmp_path, nature=nature, seed=seed)), robot
        ).faults
    ]
    assert len(named) <= 1
