"""The robot of the page "Your own robot" is valid, drives every way, and sees all around."""

import re
from pathlib import Path

import pytest

from bt_mission.core.files import names
from bt_mission.core.robot.model import load_robot
from bt_mission.core.yaml.document import read_text
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world

PAGE = Path("docs/how-to/your-robot.md").read_text(encoding="utf-8")
[EXAMPLE] = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


def test_the_robot_of_the_page_slides_on_three_wheels():
    """To the left, and to no other side."""
    robot = load_robot(read_text(EXAMPLE, "trike.yaml"))
    assert (len(robot.drive.places), len(robot.all_lidars), robot.sees_behind) == (3, 2, True)
    simulation = Simulation(load_world("empty_arena"), [RobotSpawn(robot)], seed=1)
    driven = simulation.robots[0]
    for _ in range(40):
        driven.command(0.0, 0.0, 0, 0.2)
        simulation.advance_to(driven.physics.time_ns + 50_000_000)
    assert driven.pose == pytest.approx((0.0, 0.38, 0.0), abs=0.01)


def test_the_page_lists_every_shipped_robot():
    """Each by its name."""
    assert all(f"`{name}`" in PAGE for name in names("robots"))
