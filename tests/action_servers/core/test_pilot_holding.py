"""Facts about a base that the pilot holds."""

from __future__ import annotations

from typing import Any

import pytest

from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO, Observation, Reason
from action_servers.core.pilot import ManeuverRun, Pilot
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import load_robot
from tests.support.fake_robot import in_the_open

FORWARD = Twist2D(0.2, 0.1)


class Forward:
    """A maneuver that drives on, and notes whether it is held."""

    needs_base = True

    def __init__(self) -> None:
        self.held: list[Reason | None] = []

    def step(self, now: Observation) -> Twist2D:
        self.held.append(now.held_by)
        return FORWARD

    def feedback(self) -> None:
        return None

    def result(self) -> dict[str, Any]:
        return {}


@pytest.fixture
def commands() -> list[Twist2D]:
    """What the base is told."""
    return []


@pytest.fixture
def pilot(commands: list[Twist2D]) -> Pilot:
    """A pilot without a maneuver."""
    return Pilot(lambda: in_the_open(1.0), commands.append, Governor(load_robot("waffle")))


def start(pilot: Pilot) -> Forward:
    """A maneuver in its care."""
    maneuver = Forward()
    pilot.start(ManeuverRun(maneuver, lambda _: None, lambda _: None))
    return maneuver


def test_a_base_that_is_held_stands_while_its_maneuver_goes_on(pilot, commands):
    """Zero at once and at each step; the maneuver sees why the base does not follow."""
    maneuver = start(pilot)
    pilot.step()
    pilot.hold()
    assert commands == [FORWARD, ZERO]
    pilot.step()
    pilot.step()
    pilot.release()
    pilot.step()
    assert commands == [FORWARD, ZERO, ZERO, ZERO, FORWARD]
    assert maneuver.held == [None, Reason.EXECUTIVE, Reason.EXECUTIVE, None]


def test_a_goal_that_comes_while_the_base_is_held_waits(pilot, commands):
    """Nothing is commanded where nothing drives; the goal has the base afterwards."""
    pilot.hold()
    assert commands == []
    start(pilot)
    pilot.step()
    pilot.release()
    pilot.step()
    assert commands == [ZERO, FORWARD]
