"""`check` finds what a simulation refuses before anything moves, in each kind of file."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from pathlib import Path

import jsonschema
import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import kind_of
from bt_mission.base.yaml.document import read, read_text
from bt_mission.cli.main import main
from bt_mission.robots.model import load_robot
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.loader import examine_scenario
from bt_mission.sessions.check import examine
from bt_mission.sessions.file_checks import requirements_schema, robot_schema, world_schema
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_checks import TOPICS, stage_problems, start_problem
from sim.physics.spawn import RobotSpawn
from sim.robot.description import sensors_of
from sim.robot.fit import SpawnError, is_clear
from sim.simulation import Simulation
from sim.world.world import Cylinder, Spawn, World
from tests.support.project import ROOT
from tests.support.thorough import sample

WORLDS = sorted((ROOT / "worlds").glob("*.yaml"))
ROBOTS = sorted((ROOT / "robots").glob("*.yaml"))
BURGER = (ROOT / "robots" / "burger.yaml").read_text(encoding="utf-8")
TOUCHING = (
    "name: tight\nsize: [4, 4]\nspawn: {x: 1.03, y: 0}\n"
    "walls: [{name: wall, from: [1.1, -1], to: [1.1, 1]}]\n"
)


def written(folder: Path, text: str) -> str:
    """Write a file; return its path."""
    path = folder / "file.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("path", sample([*WORLDS, *ROBOTS], 4), ids=lambda path: path.stem)
def test_every_shipped_world_and_robot_is_valid(path: Path) -> None:
    """The schema refuses none of them; their kind is known by their content."""
    kind = path.parent.name.removesuffix("s")
    schema = world_schema() if kind == "world" else robot_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    assert kind_of(path) == kind
    jsonschema.Draft202012Validator(schema).validate(read(path).data)


def test_several_kinds_are_checked_together(tmp_path: Path, capsys) -> None:
    """Each by its content."""
    requirements = written(tmp_path, "requirements: {keeps away: always clearance > 0.1}\n")
    files = [str(ROOT / "worlds/nav_arena.yaml"), str(ROOT / "robots/burger.yaml"), requirements]
    assert main(["check", *files]) == 0
    out = capsys.readouterr().out
    assert "world 'nav_arena' is valid (12 obstacles, 4 zones)" in out
    assert "robot 'burger' is valid (lidar, imu)" in out
    assert "requirements 'file' is valid (1 requirement)" in out
    jsonschema.Draft202012Validator(requirements_schema()).validate(read(requirements).data)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TOUCHING, "file.yaml:3:8: error: world tight: a waffle does not fit at the spawn"),
        (TOUCHING.replace("spawn", "spwan"), "error: unknown key 'spwan'"),
        (
            BURGER.replace("odometry_rate: 20", "odometry_rate: 30"),
            "odometry_rate: expected a rate",
        ),
        (BURGER.replace("name: burger", "nme: burger"), "unknown key 'nme'"),
        ("requirements: {a: always clearence > 0.1}\n", "did you mean 'clearance'?"),
    ],
)
def test_a_broken_file_is_refused_at_its_place(
    text: str, message: str, tmp_path: Path, capsys
) -> None:
    """With the exit code of bad input."""
    assert main(["check", written(tmp_path, text)]) == 2
    assert message in capsys.readouterr().err


def test_a_mission_is_checked_in_its_world(tmp_path: Path, capsys) -> None:
    """A spawn that touches a wall, and rates that do not fit."""
    (tmp_path / "tight.yaml").write_text(TOUCHING, encoding="utf-8")
    robot = BURGER.replace("odometry_rate: 20", "odometry_rate: 30")
    (tmp_path / "odd.yaml").write_text(robot, encoding="utf-8")
    path = written(tmp_path, "mission: m\nworld: tight.yaml\nrobot: odd.yaml\ntree: {wait: 1}\n")
    assert main(["check", path]) == 2
    err = capsys.readouterr().err
    assert "file.yaml:2:8: error: world tight: a burger does not fit" in err
    assert "file.yaml:3:8: error: robot burger: odometry_rate: expected a rate" in err


def test_a_start_outside_of_the_world_is_refused() -> None:
    """Its place is that of the scenario's start."""
    text = "scenario: s\nmission: square\nstart: {x: 50}\n"
    scenario, (fault, *_) = examine_scenario(read_text(text))
    assert scenario is None
    assert (fault.line, fault.message) == (
        3,
        "(50, 0) is outside the world 'empty_arena', which is 4 m by 4 m around (0, 0)",
    )


def test_a_floor_smaller_than_the_robot_is_refused() -> None:
    """Its wheels would be in the air beside it."""
    why = start_problem(World(name="tiny", size=(0.1, 0.1)), load_robot("waffle"))
    assert why == (
        "a wheel of the waffle at (0, 0, 0 deg) is beside the floor of 0.1 m x 0.1 m around (0, 0)"
        "; make the floor larger, or move the spawn"
    )


@pytest.mark.parametrize("robot", ["waffle", "turtlebot4", "f1tenth"])
@pytest.mark.parametrize("yaw", [0, 30, 45])
def test_what_touches_no_robot_however_it_is_turned_needs_no_physics(
    robot: str, yaw: float
) -> None:
    """A post is moved towards the robot; where geometry says that it is clear, physics agrees."""
    model = load_robot(robot)
    clear = []
    for step in range(30):
        post = Cylinder(name="post", x=0.6 - step * 0.02, y=0, radius=0.05)
        world = World(name="w", size=(4, 4), spawn=Spawn(yaw=yaw), cylinders=(post,))
        entrant = RobotSpawn(model)
        clear.append(is_clear(world, entrant, world.spawn))
        with nullcontext() if clear[-1] else suppress(SpawnError):
            Simulation(world, [entrant], seed=0)
    assert clear == sorted(clear, reverse=True)
    assert (clear[0], clear[-1]) == (True, False)


def test_camera_faults_need_a_camera() -> None:
    """In scenarios and in the ranges of a search."""
    text = "scenario: s\nmission: square\nrobot: burger\nfaults: ['at 1.0: camera_black']\n"
    _, (fault, *_) = examine_scenario(read_text(text))
    assert fault.message == "camera_black: the robot 'burger' has no camera"
    ranges = RangesFile(read_text("faults: {kinds: [network, camera]}\n"))
    ranges.check_mission(load("mission: m\ntree: {wait: 1}\n"))
    with pytest.raises(InputError, match="1:27: error: 'camera': the robot 'burger' has no camera"):
        ranges.check_mission(load("mission: m\nrobot: burger\ntree: {wait: 1}\n"))


def test_poses_of_a_loop_are_checked_one_by_one() -> None:
    """Each constant element of `for_each`, also by the name of a place."""
    text = (
        "mission: m\nworld: nav_arena\ntree:\n  for_each: {place: [[1, 0.5, 0], %s]}\n"
        "  do: {navigate_to_pose: {pose: $place}, timeout: 9}\n"
    )
    assert examine(text % "A")[0] is not None
    for wrong, message in (("[50, 0, 0]", "map"), ("zone Q", "unknown place 'zone Q'")):
        mission, (fault, *rest) = examine(text % wrong)
        assert mission is None
        assert message in fault.message
        assert (fault.line, rest) == (5, [])


def test_a_topic_that_nothing_publishes_is_doubted() -> None:
    """With the one that was meant."""
    follow = "{topic: battery_stat, type: sensor_msgs/msg/BatteryState, field: percentage, as: b}"
    mission = load(f"mission: m\nworld: nav_arena\nfollow: {follow}\ntree: {{log: $b}}\n")
    (fault,) = stage_problems(mission)
    assert fault.severity == "warning"
    assert fault.message == "nothing in the simulation publishes 'battery_stat'"
    assert fault.hint == "did you mean 'battery_state'?"


def test_the_topics_are_those_of_a_stage(tmp_path: Path) -> None:
    """Of one with a goal that drives, and with a camera."""
    mission = load(
        "mission: m\nworld: nav_arena\ntree: {navigate_to_pose: {pose: zone B}, timeout: 60}\n"
    )
    with Stage(mission, image_folder=tmp_path) as stage:
        for _ in range(40):
            stage.step()
        names = {name.strip("/") for name, _ in stage.sim.get_topic_names_and_types()}
    public = {
        topic for topic in names if "/_action/" not in topic and not topic.startswith("mission")
    }
    known = TOPICS | {kind.topic for kind in sensors_of(load_robot("waffle"))}
    # Those of other actions, of viewers, of faults and of arms are not there in this run.
    others = {"coverage", "waypoints", "total_distance"}
    assert known - public <= others | {"amcl_pose", "joint_commands"}
