"""Models of bases that do not roll on their wheels, with meshes, includes, rollers and knuckles."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.core.file_index import files_of
from bt_mission.core.robot.model import RobotModel, load_robot
from bt_mission.sessions.file_checks import check_robot
from sim.physics.names import STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world
from tests.support.robot_models import MODELLED, write_model


def test_a_copy_has_what_a_model_includes_and_its_meshes(tmp_path: Path) -> None:
    """Names count from the folder of the model, and from its folder of meshes."""
    files = files_of(write_model(tmp_path, "husky"))
    assert [path.relative_to(tmp_path).as_posix() for path in files] == [
        "husky.yaml",
        "husky.xml",
        "parts/meshes.xml",
        "assets/part.obj",
    ]


def driven(robot: RobotModel) -> tuple[list[float], list[float], tuple[str, ...]]:
    """Drive an arc, sideways where the base can; return the true pose, odometry and the joints."""
    simulation = Simulation(load_world("wide_arena"), [RobotSpawn(robot)], seed=1)
    (mine,) = simulation.robots
    sideways = 0.1 if robot.drive.slide_velocity else 0.0
    for _ in range(60):
        mine.command(0.2, 0.3, lateral=sideways)
        simulation.advance_to(simulation.time_ns + 10 * STEP_NS)
    odometry = mine.read_odometry()
    assert mine.collisions == 0
    return list(mine.pose), [odometry.x, odometry.y, odometry.yaw], mine.joints


@pytest.mark.parametrize("name", MODELLED)
def test_a_model_moves_as_the_same_robot_without_one(name: str, tmp_path: Path) -> None:
    """Its wheels, rollers and knuckles stand still; supports and servos have its mass."""
    path = write_model(tmp_path, name)
    assert check_robot(path)[0].name == name
    pose, odometry, joints = driven(load_robot(path))
    usual = driven(load_robot(name))
    assert joints == usual[2]
    assert pose == pytest.approx(usual[0], abs=2e-3)
    assert odometry == pytest.approx(usual[1], abs=2e-3)
    assert math.hypot(*pose[:2]) > 0.3


@pytest.mark.parametrize(
    ("name", "old", "new", "code", "message"),
    [
        ("husky", "[front_left_wheel,", "[", "BT-307", "expected 4 joints (front_left_wheel, "),
        ("rosbot", "[wheel_1,", "[wheel_9,", "BT-813", "no joint 'wheel_9'"),
        ("rosbot", "[wheel_1,", "[wheel_2,", "BT-813", "the joint 'wheel_2' is named twice"),
        (
            "husky",
            "file: husky.xml",
            "file: husky.xml\n  steering: [a, b]",
            "BT-307",
            "only an ackerm",
        ),
        ("f1tenth", "[steer_front_left_wheel,", "[steer,", "BT-813", "no joint 'steer'"),
        (
            "husky",
            "wheelbase: 0.512",
            "wheelbase: 0.6",
            "BT-813",
            "but in the model it is at (0.256",
        ),
        ("husky", 'axis="0 1 0"', 'axis="0 1 0" type="slide"', "BT-813", "is a slide joint"),
        ("husky", "meshes.xml", "no.xml", "BT-813", "cannot read no.xml"),
        ("husky", 'meshdir="assets"', 'meshdir="/etc"', "BT-813", "outside of its folder"),
        ("husky", "parts/meshes.xml", "../meshes.xml", "BT-813", "outside of its folder"),
        ("husky", "<freejoint/>", "", "BT-813", "got no free joint"),
    ],
)
def test_an_error_names_key_and_reason(
    tmp_path: Path, name: str, old: str, new: str, code: str, message: str
) -> None:
    """As for a model that rolls on its wheels."""
    path = write_model(tmp_path, name, (old, new))
    with pytest.raises(InputError) as caught:
        check_robot(path)
    errors = [(each.code, each.message) for each in caught.value.diagnostics]
    assert any(each == code and message in text for each, text in errors), errors
