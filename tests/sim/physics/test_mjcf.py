"""Robots with a MuJoCo model of their own: driving, their joints, and errors of a model."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.file_index import files_of
from bt_mission.base.files import find
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.sessions.file_checks import check_robot
from sim.physics.names import MODEL_PREFIX, STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.simulation import Simulation
from sim.world.loader import load_world
from sim.world.world import Spawn
from tests.support.robot_models import MODELLED, write_model

ROBOT, MODEL = find("robots", "waffle_arm"), find("robots", "waffle_arm").with_suffix(".xml")
ARM = ("joint1", "joint2", "joint3", "joint4")
FINGERS = ("gripper_left_joint", "gripper_right_joint")
ABOVE, BELOW = (0.0, 0.577, -0.319, 1.313), (0.0, 0.961, -0.217, 0.827)


def simulated(world: str = "fetch_arena", robot: str | Path = "waffle_arm") -> Simulation:
    """Simulate a robot; by default one with an arm, and a cube a metre ahead."""
    return Simulation(load_world(world), [RobotSpawn(load_robot(robot))], seed=1)


def drive(
    simulation: Simulation,
    seconds: float,
    linear: float = 0.0,
    angular: float = 0.0,
    lateral: float = 0.0,
) -> None:
    """Drive all robots for a time."""
    for _ in range(round(seconds * 20)):
        for robot in simulation.robots:
            robot.command(linear, angular, lateral=lateral)
        simulation.advance_to(simulation.time_ns + 10 * STEP_NS)


def send(robot: SimulatedRobot, names: tuple[str, ...], positions: tuple[float, ...]) -> None:
    """Command joints, without a limit of force."""
    assert robot.servos is not None
    robot.servos.command(names, positions)


@pytest.fixture
def fetching() -> Simulation:
    """A robot with an arm, and a cube a metre ahead."""
    return simulated()


def test_its_wheels_drive_it_as_its_file_says(fetching: Simulation) -> None:
    """A metre is a metre, by truth and by odometry, and nothing counts as a collision."""
    (robot,) = fetching.robots
    drive(fetching, 4.0, 0.2)
    drive(fetching, 1.0)
    assert robot.pose == pytest.approx((0.8, 0.0, 0.0), abs=1e-3)
    assert robot.read_odometry().x == pytest.approx(robot.pose[0], abs=2e-3)
    assert robot.collisions == 0


def test_wheels_of_other_models_drive_ahead(tmp_path: Path) -> None:
    """A velocity servo replaces a motor, an axis to the right turns forward, sizes do not count."""
    motors = [
        (f'<velocity joint="{wheel}" kv="0.15"', f'<motor joint="{wheel}" gear="3"')
        for wheel in ("wheel_left", "wheel_right")
    ]
    backward = 'name="wheel_left" type="hinge" axis="0 1 0"'
    axis = (backward, backward.replace("0 1 0", "0 -1 0"))
    size = ("<worldbody>", '<size njmax="1" nconmax="1"/><worldbody>')
    simulation = simulated(robot=changed(tmp_path, *motors, axis, size))
    drive(simulation, 4.0, 0.2)
    drive(simulation, 1.0)
    assert simulation.robots[0].pose == pytest.approx((0.8, 0.0, 0.0), abs=2e-3)


BESIDE = "{0} at (-0.177, -0.064, -0.005) m of the base touches the floor, which brakes the robot."


@pytest.mark.parametrize(
    ("casters", "nameless", "warnings", "driven"),
    [
        ("[[-0.177, 0.064, -0.005], [-0.177, -0.064, -0.005]]", ["left", "right"], [], 0.8),
        ("[caster_left, [-0.177, -0.064, -0.005]]", [], [], 0.8),
        ("[caster_left]", [], [BESIDE.format("'caster_right'")], 0.54),
        ("[caster_left]", ["right"], [BESIDE.format("a sphere")], 0.54),
    ],
)
def test_a_caster_has_a_name_or_a_place_and_one_that_is_not_listed_brakes(
    tmp_path: Path, casters: str, nameless: list[str], warnings: list[str], driven: float
) -> None:
    """A geom without a name is listed by its place; `check` names what else touches the floor."""
    changes = [(f' name="caster_{side}"', "") for side in nameless]
    path = changed(tmp_path, *changes, figures=("[caster_left, caster_right]", casters))
    warned = check_robot(path)[1]
    assert {(each.code, each.severity) for each in warned} <= {("BT-814", "warning")}
    assert [each.message.partition(" If")[0] for each in warned] == warnings
    simulation = simulated(robot=path)
    drive(simulation, 4.0, 0.2)
    drive(simulation, 1.0)
    assert simulation.robots[0].pose[0] == pytest.approx(driven, abs=5e-3)


def test_it_grips_carries_and_lays_down(fetching: Simulation) -> None:
    """The fingers stall at the cube, which rises with the arm; two runs are the same."""
    assert pick(fetching) == pick(simulated())


def pick(simulation: Simulation) -> str:
    """Pick the cube up; return a digest of everything at the end."""
    (robot,) = simulation.robots
    assert robot.servos is not None
    send(robot, FINGERS, (0.019, 0.019))
    send(robot, ARM, ABOVE)
    drive(simulation, 4.35, 0.2)
    drive(simulation, 1.0)
    send(robot, ARM, BELOW)
    drive(simulation, 1.5)
    send(robot, FINGERS, (-0.010, -0.010))
    drive(simulation, 1.0)
    held = dict(zip(robot.servos.names, robot.servos.readings["position"], strict=True))
    assert held[FINGERS[0]] == pytest.approx(0.005, abs=1e-3)
    send(robot, ARM, ABOVE)
    drive(simulation, 1.5)
    x, y, z = simulation.physics.objects["cube"]
    assert (x, y, z) == pytest.approx((1.0, 0.0, 0.105), abs=5e-3)
    assert robot.collisions == 0
    state = simulation.physics.record()
    return hashlib.sha256(state.qpos + state.qvel).hexdigest()


def test_joints_stay_within_their_limits_and_speed(fetching: Simulation) -> None:
    """A command beyond a limit goes to the limit, at no more than the highest speed."""
    (robot,) = fetching.robots
    assert robot.servos is not None
    send(robot, ("joint1",), (9.0,))
    fetching.advance_to(fetching.time_ns + 20 * STEP_NS)
    setpoint = fetching.physics.data.ctrl[fetching.physics.model.nu - 6]
    assert setpoint == pytest.approx(4.8 * 0.1)
    drive(fetching, 2.0)
    assert robot.servos.readings["position"][0] == pytest.approx(2.82, abs=1e-3)
    for names, positions in ((("elbow",), (1.0,)), (("joint1",), (math.nan,)), (ARM, (0.0,))):
        with pytest.raises(ValueError, match=r"elbow|finite|expected 4 positions"):
            robot.servos.command(names, positions)


def test_a_reset_puts_joints_and_objects_back(fetching: Simulation) -> None:
    """To the start of the robot's file, and of the world's."""
    (robot,) = fetching.robots
    assert robot.servos is not None
    positions, objects = robot.servos.readings["position"], fetching.physics.objects
    send(robot, ARM, BELOW)
    drive(fetching, 5.0, 0.2)
    assert robot.servos.readings["position"] != positions
    fetching.physics.reset()
    assert (robot.servos.readings["position"], fetching.physics.objects) == (positions, objects)


def test_two_robots_with_arms_share_a_world() -> None:
    """They collide with each other, and not with their own parts."""
    robots = [
        RobotSpawn(load_robot("waffle_arm"), name, Spawn(x=x, yaw=yaw))
        for name, x, yaw in (("one", -0.6, 0.0), ("two", 0.6, 180.0))
    ]
    simulation = Simulation(load_world("empty_arena"), robots, seed=0)
    drive(simulation, 0.5)
    assert [robot.collisions for robot in simulation.robots] == [0, 0]
    drive(simulation, 4.0, 0.2)
    assert simulation["one"].collisions_with["two"] >= 1


def test_a_copy_has_the_files_of_the_model_what_it_includes_and_its_meshes(tmp_path: Path) -> None:
    """`robots copy` takes them along. Names count from the model's folder and that of meshes."""
    assert [path.name for path in files_of(ROBOT)] == ["waffle_arm.yaml", "waffle_arm.xml"]
    files = files_of(write_model(tmp_path, "husky"))
    assert [path.relative_to(tmp_path).as_posix() for path in files] == [
        "husky.yaml",
        "husky.xml",
        "parts/meshes.xml",
        "assets/part.obj",
    ]


def test_the_model_is_attached_under_its_own_prefix() -> None:
    """So no name of the world or of another robot collides with one of it."""
    model = simulated("empty_arena").physics.model
    assert model.joint(f"{MODEL_PREFIX}joint1").range == pytest.approx([-2.827, 2.827])
    assert model.opt.timestep == STEP_NS / 1e9
    assert model.body_subtreemass[model.body("base").id] == pytest.approx(2.06191)


def driven(robot: RobotModel) -> tuple[list[float], list[float], tuple[str, ...]]:
    """Drive an arc, sideways where the base can; return the true pose, odometry and the joints."""
    simulation = Simulation(load_world("wide_arena"), [RobotSpawn(robot)], seed=1)
    drive(simulation, 3.0, 0.2, 0.3, 0.1 if robot.drive.slide_velocity else 0.0)
    (mine,) = simulation.robots
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


# ---- what is wrong with a model ------------------------------------------------------------------


def changed(folder: Path, *changes: tuple[str, str], figures: tuple[str, str] = ("", "")) -> Path:
    """Copy the robot with changes of its model and of its figures."""
    text, robot = MODEL.read_text(encoding="utf-8"), ROBOT.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    assert figures[0] in robot
    (folder / "waffle_arm.xml").write_text(text, encoding="utf-8")
    path = folder / "mine.yaml"
    path.write_text(robot.replace(*figures, 1), encoding="utf-8")
    return path


def refused(path: Path) -> list[tuple[str, str, str]]:
    """Return code, line of the file and message of each error."""
    with pytest.raises(InputError) as caught:
        check_robot(path)
    lines = path.read_text(encoding="utf-8").splitlines()
    return [
        (each.code, lines[(each.line or 1) - 1].strip(), each.message)
        for each in caught.value.diagnostics
    ]


WRONG = [
    ('kp="120"', 'kp="-"', "file: waffle_arm.xml", "MuJoCo: XML Error"),
    ("</worldbody>", "", "file: waffle_arm.xml", "mismatched tag"),
    ("<freejoint/>", "", "base: base_link", "got no free joint"),
    ('<body name="link1"', '<body><freejoint/></body><body name="link1"', "file:", "MuJoCo:"),
    ('mass="1.37291"', 'mass="0"', "base_mass:", "the whole model, 0.689 kg, got 2.06191"),
    ('mass="0.0285"', 'mass="0"', "file: waffle_arm.xml", "MuJoCo: Error: mass and inertia"),
    ('mass="1.37291"', 'mass="9"', "base_mass:", "the whole model, 9.689 kg, got 2.06191"),
    ('mass="1.37291"', 'mass="nan"', "file: waffle_arm.xml", "finite numbers, got nan"),
    ('name="joint2"', 'name="joint_2"', "file: waffle_arm.xml", "target 'joint2' for actuator"),
    ('class="servo" joint="joint3"', 'class="servo" joint="joint2"', "joint3:", "got 0 actuators"),
    ('position class="servo" joint="joint1"', 'motor joint="joint1"', "joint1:", "<position>"),
    ('range="-2.827 2.827"', 'range="-1 1"', "joint1:", "within the range of the model, -1 to 1"),
    ('"wheel_left" type="hinge" axis="0', '"wheel_left" axis="9', "wheels:", "along y of the base"),
    ('"wheel_left" type="hinge"', '"wheel_left" type="slide"', "wheels:", "is a slide joint"),
    ('pos="0 0.144 0.023"', 'pos="0 0.16 0.023"', "wheels:", "'wheel_left' at (0, 0.144, 0.023) m"),
    ('size="0.033 0.009', 'size="0.066 0.009', "wheel_radius:", "the model, 0.066 m, got 0.033"),
    ("<actuator>", '<actuator><motor joint="wheel_left"/>', "wheels:", "2 actuators drive the whe"),
    ('site name="base_scan"', 'site name="scan"', "lidar: base_scan", "no site 'base_scan'"),
    ('name="imu" pos="0 0 0.068"', 'name="imu" pos="0 0 0.1"', "x: 0.0 ", "(0, 0, 0.1) m, got"),
    ("<worldbody>", '<include file="../x.xml"/><worldbody>', "file:", "outside of its folder"),
    ("<worldbody>", '<include file="no.xml"/><worldbody>', "file:", "cannot read no.xml"),
    ("<worldbody>", '<include file="waffle_arm.xml"/><worldbody>', "file:", "includes itself"),
    ("<worldbody>", '<asset><mesh file="/etc/a.stl"/></asset><worldbody>', "file:", "outside"),
    ("<worldbody>", '<asset><mesh file="a.stl"/></asset><worldbody>', "file:", "cannot read a.stl"),
    ("<mujoco", '<!DOCTYPE m [<!ENTITY e "e">]><mujoco', "file:", "DOCTYPE is not supported"),
    ("<worldbody>", '<extension><plugin plugin="a"/></extension><worldbody>', "file:", "plugins"),
    ("<worldbody>", "<worldbody>" + "<frame>" * 80 + "</frame>" * 80, "file:", "nested more than"),
    ("<worldbody>", "<worldbody>" + "<site/>" * 6000, "file:", "more than 5,000 elements"),
    ('size="0.133 0.133 0.047"', 'size="1e99 0.1 0.1"', "file:", "larger than 1e+10"),
]


@pytest.mark.parametrize(("old", "new", "place", "message"), WRONG)
def test_an_error_of_the_model_names_key_and_reason(
    tmp_path: Path, old: str, new: str, place: str, message: str
) -> None:
    """At the key of the robot's file; the reason names the line of the model where there is one."""
    errors = refused(changed(tmp_path, (old, new)))
    assert any(
        code == "BT-813" and line.startswith(place) and message in text
        for code, line, text in errors
    ), errors


@pytest.mark.parametrize(
    ("figures", "code", "message"),
    [
        (("base: base_link", "base: base_lnk"), "BT-813", "did you mean 'base_link'?"),
        (("wheels: [wheel_left,", "wheels: [wheel_right,"), "BT-813", "is named twice"),
        (("    joint1: {min", "    elbow: {min"), "BT-813", "no joint 'elbow'"),
        (("caster_left, ", "caster_lft, "), "BT-813", "did you mean 'caster_left'?"),
        (("caster_left, ", "[0, 0, 1], "), "BT-813", "at (0, 0, 1) m of the base; the nearest is"),
        (("caster_left, ", "[0, 0], "), "BT-202", "'2' is missing"),
        (("min: -2.82", "min: 3"), "BT-307", "expected min < max"),
        (("base_mass: 2.06191 ", "base_mass: 3.0 "), "BT-813", "2.062 kg, got 3"),
        (("file: waffle_arm.xml", "file: absent.xml"), "BT-813", "cannot read absent.xml"),
        (("file: waffle_arm.xml", "file: ../waffle_arm.xml"), "BT-813", "must lie in the folder"),
        (("rate: 10.0 ", "rate: 30.0 "), "BT-804", "whole number of physics steps"),
        (("body:  ", "base_inertia: [1, 1, 1]\nbody:  "), "BT-307", "leave base_inertia out"),
        (("gripper:  ", "griper:  "), "BT-201", "unknown key 'griper'"),
    ],
)
def test_an_error_of_the_figures_names_its_key(
    tmp_path: Path, figures: tuple[str, str], code: str, message: str
) -> None:
    """Names that the model does not have, and numbers that contradict it."""
    errors = refused(changed(tmp_path, figures=figures))
    assert any(got == code and message in text for got, _, text in errors), errors


@pytest.mark.parametrize(
    ("name", "old", "new", "code", "message"),
    [
        ("husky", "[front_left_wheel,", "[", "BT-307", "expected 4 joints (front_left_wheel, "),
        ("rosbot", "[wheel_1,", "[wheel_9,", "BT-813", "no joint 'wheel_9'"),
        ("rosbot", "[wheel_1,", "[wheel_2,", "BT-813", "the joint 'wheel_2' is named twice"),
        ("husky", "  base: ", "  steering: [a, b]\n  base: ", "BT-307", "only an ackerm"),
        ("f1tenth", "[steer_front_left_wheel,", "[steer,", "BT-813", "no joint 'steer'"),
        (
            "husky",
            "wheelbase: 0.512",
            "wheelbase: 0.6",
            "BT-813",
            "but in the model it is at (0.2",
        ),
        ("husky", 'axis="0 1 0"', 'axis="0 1 0" type="slide"', "BT-813", "is a slide joint"),
        ("husky", "meshes.xml", "no.xml", "BT-813", "cannot read no.xml"),
        ("husky", 'meshdir="assets"', 'meshdir="/etc"', "BT-813", "outside of its folder"),
        ("husky", "parts/meshes.xml", "../meshes.xml", "BT-813", "outside of its folder"),
        ("husky", "<freejoint/>", "", "BT-813", "got no free joint"),
    ],
)
def test_an_error_of_a_planar_model_names_key_and_reason(
    tmp_path: Path, name: str, old: str, new: str, code: str, message: str
) -> None:
    """As for a model that rolls on its wheels."""
    errors = refused(write_model(tmp_path, name, (old, new)))
    assert any(got == code and message in text for got, _, text in errors), errors


def test_an_arm_needs_a_model(tmp_path: Path) -> None:
    """And so does what a model would have: a robot without one says its inertia."""
    text = ROBOT.read_text(encoding="utf-8")
    begin, end = text.index("model:   "), text.index("arm:   ")
    path = tmp_path / "mine.yaml"
    path.write_text(text[:begin] + text[end:], encoding="utf-8")
    messages = [message for _, _, message in refused(path)]
    assert "arm needs `model`, which has its joints" in messages
    assert "'base_inertia' is missing" in messages
    assert "'casters' is missing" in messages


def test_a_model_in_degrees_and_with_parts_of_a_world_is_attached(tmp_path: Path) -> None:
    """Its compiler applies to it; floor, lights, keys and sensors stay out."""
    changes = [
        ('angle="radian"', 'angle="degree"'),
        ('range="-2.827 2.827"', 'range="-161.98 161.98"'),
        ('range="-1.79 1.57"', 'range="-102.56 89.95"'),
        ('range="-0.942 1.382"', 'range="-53.97 79.18"'),
        ('range="-1.79 2.04"', 'range="-102.56 116.88"'),
        ("<worldbody>", '<worldbody><light pos="0 0 3"/><geom type="plane" size="9 9 1"/>'),
        ("</mujoco>", '<keyframe><key name="home"/></keyframe></mujoco>'),
        ("<worldbody>", '<option timestep="0.001" gravity="0 0 0"/><worldbody>'),
    ]
    model = simulated("empty_arena", changed(tmp_path, *changes)).physics.model
    usual = simulated("empty_arena").physics.model
    assert (model.ngeom, model.nlight, model.nkey) == (usual.ngeom, usual.nlight, 0)
    assert model.jnt_range == pytest.approx(usual.jnt_range, abs=1e-3)
    assert model.opt.gravity.tolist() == [0.0, 0.0, -9.81]
