"""Models of bases that do not roll on their wheels, with meshes, includes, rollers and knuckles."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.core.files import find
from bt_mission.core.robot.model import RobotModel, load_robot
from bt_mission.sessions.file_checks import check_robot
from sim.physics.names import STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world

KINDS = {"husky": "skid_steer", "rosbot": "omnidirectional", "f1tenth": "ackermann"}
TETRAHEDRON = "v 0 0 0\nv .02 0 0\nv 0 .02 0\nv 0 0 .02\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def written(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Write a shipped robot with a model: its figures as MJCF, as models of the field have them."""
    robot = load_robot(name)
    x, y, z = robot.base_centre_of_mass
    a, b, c = robot.base_inertia
    height, width = robot.drive.wheel_radius - robot.base_height, robot.drive.wheel_width / 2
    lx, ly, lz = robot.body.size
    cx, cy, cz = robot.body.centre
    wheels = "".join(
        f"""<body name="hub_{wheel}" pos="{px} {py} {height}" euler="0 0 {math.degrees(heading)}">
        {'<joint name="steer_' + wheel + '"/>' if name == "f1tenth" and "front" in wheel else ""}
        <inertial pos="0 0 0" mass="1e-4" diaginertia="1e-6 1e-6 1e-6"/>
        <body><joint name="{wheel}" axis="0 1 0"/>
          <geom class="tyre" size="{robot.drive.wheel_radius} {width}" euler="90 0 0"/>
          <body><joint axis="1 0 0"/><geom type="sphere" size="0.01" mass="1e-6"/></body>
        </body></body>"""
        for wheel, (px, py), heading in zip(
            robot.drive.names, robot.drive.places, robot.drive.headings, strict=True
        )
    )
    model = f"""<mujoco><compiler meshdir="assets"/>
    <default><default class="tyre"><geom type="cylinder" mass="1e-6"/></default></default>
    <include file="parts/meshes.xml"/>
    <worldbody><geom type="plane" size="9 9 1"/><body name="chassis"><freejoint/>
      <inertial pos="{x} {y} {z}" mass="{robot.base_mass}" diaginertia="{a} {b} {c}"/>
      <body name="cover" pos="{cx} {cy} {cz}">
        <geom type="box" mass="1e-6" size="{lx / 2} {ly / 2} {lz / 2}"/>
        <geom type="mesh" mesh="part" mass="0" contype="0" conaffinity="0"/></body>
      {wheels}</body></worldbody>
    <equality><joint joint1="{robot.drive.names[0]}" joint2="{robot.drive.names[1]}"/></equality>
    <actuator><motor joint="{robot.drive.names[0]}"/></actuator></mujoco>"""
    (folder / "assets").mkdir()
    (folder / "parts").mkdir()
    (folder / "assets" / "part.obj").write_text(TETRAHEDRON, encoding="utf-8")
    meshes = '<mujoco><asset><mesh name="part" file="part.obj"/></asset></mujoco>'
    (folder / "parts" / "meshes.xml").write_text(meshes, encoding="utf-8")
    figures = find("robots", name).read_text(encoding="utf-8")
    figures = re.sub(r"^base_(inertia|centre_of_mass):.*\n", "", figures, flags=re.MULTILINE)
    figures += (
        f"model:\n  file: mine.xml\n  base: chassis\n  wheels: [{', '.join(robot.drive.names)}]\n"
    )
    if name == "f1tenth":
        figures += "  steering: [steer_front_left_wheel, steer_front_right_wheel]\n"
    for old, new in changes:
        assert old in figures + model
        figures, model = figures.replace(old, new, 1), model.replace(old, new, 1)
    (folder / "mine.xml").write_text(model, encoding="utf-8")
    path = folder / "mine.yaml"
    path.write_text(figures, encoding="utf-8")
    return path


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


@pytest.mark.parametrize("name", KINDS)
def test_a_model_moves_as_the_same_robot_without_one(name: str, tmp_path: Path) -> None:
    """Its wheels, rollers and knuckles stand still; supports and servos have its mass."""
    path = written(tmp_path, name)
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
            "file: mine.xml",
            "file: mine.xml\n  steering: [a, b]",
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
    path = written(tmp_path, name, (old, new))
    with pytest.raises(InputError) as caught:
        check_robot(path)
    errors = [(each.code, each.message) for each in caught.value.diagnostics]
    assert any(each == code and message in text for each, text in errors), errors
