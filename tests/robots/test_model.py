"""Robot models: the shipped numbers, and the errors of a wrong file."""

import math
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import find, names
from bt_mission.base.yaml.document import read
from bt_mission.robots.drives import DifferentialDrive
from bt_mission.robots.model import RobotModel, SensorsModel, load_robot
from bt_mission.robots.statics import shares


def test_each_shipped_robot_has_the_name_of_its_file():
    """A robot is found by its name."""
    assert [load_robot(name).name for name in names("robots")] == names("robots")


@pytest.mark.parametrize(
    ("name", "linear", "angular", "separation", "scan_rate", "turning_radius"),
    [
        ("waffle", 0.26, 1.82, 0.287, 10.0, 0.238),
        ("burger", 0.22, 2.84, 0.160, 5.0, 0.124),
        ("turtlebot4", 0.306, 1.9, 0.233, 8.0, 0.171),
    ],
)
def test_models_have_the_published_figures(
    name, linear, angular, separation, scan_rate, turning_radius
):
    """Limits, wheel separation, scan rate and turning circle are published."""
    robot = load_robot(name)
    assert robot.max_linear_velocity == linear
    assert robot.max_angular_velocity == angular
    assert isinstance(robot.drive, DifferentialDrive)
    assert robot.drive.wheel_separation == separation
    assert robot.lidar.rate == scan_rate
    assert robot.turning_radius == pytest.approx(turning_radius, abs=5e-4)


def test_an_unknown_robot_is_refused():
    """As any other file, with the nearest name."""
    with pytest.raises(InputError, match="did you mean 'waffle'"):
        load_robot("wafle")


def test_waffle_hull_is_measured_from_the_axle():
    """Front 0.069 m, rear 0.197 m behind, half width 0.153 m with the wheels."""
    hull = load_robot("waffle").hull
    assert (hull.front, hull.rear, hull.half_width) == (0.069, -0.197, 0.153)


def test_angular_acceleration_follows_from_the_linear_one():
    """A wheel's rim speeds up no faster when turning than when driving straight."""
    for robot in differential_robots():
        rim = robot.max_angular_acceleration * robot.drive.wheel_separation / 2
        assert rim == pytest.approx(robot.max_linear_acceleration, rel=1e-3)


def test_axle_and_casters_stand_on_the_floor():
    """Wheels and casters of a level robot touch the floor."""
    for robot in differential_robots():
        for _, _, z in robot.drive.casters:
            assert z - robot.drive.caster_radius + robot.base_height == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("supports", "at", "carried"),
    [
        ([0, 0, -2], -0.5, [0.375, 0.375, 0.25]),
        ([0, 0, -2, -2], -1, [0.25] * 4),
        ([0, 0, -2, 2], 0, [0.25] * 4),
        ([0, 0, 0, -3], -1.5, [1 / 6, 1 / 6, 1 / 6, 0.5]),
        ([0, 0, -2, 2], -1.8, [0.05, 0.05, 0.9, 0]),
        ([0, 0, -1, 5, 5, 5], -0.5, [0.25, 0.25, 0.5, 0, 0, 0]),
    ],
)
def test_wheels_and_casters_carry_what_statics_says(supports, at, carried):
    """In balance, each its share of equal springs; one that would have to pull carries nothing."""
    assert shares(supports, at) == pytest.approx(carried)


def test_burger_has_no_camera():
    """The Burger carries none, the Waffle one that sees 59 degrees."""
    assert load_robot("burger").camera is None
    camera = load_robot("waffle").camera
    assert camera is not None
    assert math.degrees(camera.hfov) == pytest.approx(59.0, abs=0.01)


BOX = "shape: box\n  size: [0.266, 0.266, 0.094]    # m\n  centre: [-0.064, 0.0, 0.047]"
LOOP = "shape: polygon\n  outline: [[0, 0], [1, 1], [1, 0], [0, 1]]\n  bottom: 0\n  top: 1"
INERTIA = "base_inertia: [8.700e-3, 8.620e-3, 1.4613e-2]"
WHEEL = "wheel_inertia: [1.12e-5, 2.07e-5, 1.12e-5]"
HEAVY = "base_inertia: [8700, 8620, 14613]"
FRONT_RIGHT = "heading: 0, roller: 45}    # front right"


def written(tmp_path: Path, robot: str, changes: dict[str, str]) -> Path:
    """The file of a shipped robot with changes."""
    text = find("robots", robot).read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "odd.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("robot", "old", "new", "place", "message"),
    [
        ("waffle", "kind: differential", "kind: diferential", "drive.kind", "'differential'?"),
        ("waffle", "  kind: differential\n", "", "drive", "'kind' is missing"),
        ("waffle", "  wheel_y: 0.144 ", "  wheel_z: 0.144 ", "drive", "'wheel_y' is missing"),
        ("waffle", "  shape: box\n", "", "body", "'shape' is missing"),
        ("waffle", BOX, LOOP, "body.outline", "does not close"),
        ("waffle", "rays: 360 ", "rays: 360\n  sector: [90, -90]", "lidar", "to a larger bearing"),
        ("waffle", "wheel_radius: 0.033", "wheel_radius: 33", "drive.wheel_radius", "is it in m?"),
        ("waffle", "wheel_radius: 0.033", "wheel_radius: 5", "drive.wheel_radius", "at most 1 m"),
        (
            "waffle",
            "noise_std: 0.01",
            "noise_std: 1e9",
            "lidar.noise_std",
            "at most 1 m, got 1e+09",
        ),
        ("waffle", "gyro_noise: 2.0e-4", "gyro_noise: 9", "imu.gyro_noise", "at most 1 rad/s"),
        ("waffle", "control_rate: 20.0", "control_rate: 0.001", "control_rate", "at least 1 Hz"),
        ("waffle", "control_rate: 20.0", "control_rate: 4.0", "control_rate", "between any two"),
        ("waffle", "rays: 360", "rays: 1", "lidar.rays", "at least 8"),
        ("waffle", "odometry_rate: 20.0", "odometry_rate: 0.01", "odometry_rate", "at least 0.1"),
        ("waffle", "lar_velocity: 1.82", "lar_velocity: 182", "max_angular_velocity", "rad/s?"),
        ("waffle", "tion: 1.0 ", "tion: 1e6 ", "max_linear_acceleration", "is it in m/s^2?"),
        ("waffle", "nominal_voltage: 11.1", "nominal_voltage: 24", "battery", "must be between"),
        ("waffle", "wheel_y: 0.144 ", "wheel_y: 144 ", "drive.wheel_y", "at most 10 m, got 144"),
        ("waffle", "max_range: 3.5 ", "max_range: 3500 ", "lidar.max_range", "is it in m?"),
        ("waffle", "velocity: 0.26 ", "velocity: 260 ", "max_linear_velocity", "is it in m/s?"),
        ("waffle", "base_mass: 1.37291", "base_mass: 13729.1", "base_mass", "is it in kg?"),
        ("waffle", INERTIA, f"{INERTIA[:-10]}0.02]", "base_inertia", "more than 0.00862 + 0.0087"),
        ("waffle", INERTIA, HEAVY, "base_inertia", "check base_inertia and base_mass"),
        (
            "waffle",
            WHEEL,
            "wheel_inertia: [1e-5, 2e-5, 4e-5]",
            "drive.wheel_inertia",
            "no body has this inertia",
        ),
        ("waffle", WHEEL, "wheel_inertia: [1, 1, 1]", "drive.wheel_inertia", "and wheel_mass"),
        ("waffle", "# model: LDS-02", "model: LDS-03", "sensors.lidar.model", "LDS-01"),
        ("waffle", "slip: 0.0", "slip: 0.9", "sensors.odometry.slip", "at most 0.5"),
        ("waffle", "start_charge: 1.0", "start_charge: 9", "battery.start_charge", "at most 1"),
        ("waffle", "full_voltage: 12.3", "full_voltage: 9", "battery", "10.5 V must be below"),
        ("waffle", "imu: {noise: true}", "imu:\n    nois: true", "sensors.imu", "'noise'?"),
        (
            "burger",
            "- [-0.081,",
            "- [0.0,",
            "base_centre_of_mass",
            "the robot tips over",
        ),
        ("waffle", "mass: [-0.064,", "mass: [0.01,", "base_centre_of_mass", "the robot tips over"),
        (
            "husky",
            "mass: [-0.00065,",
            "mass: [-0.3,",
            "base_centre_of_mass",
            "carries it, (0.2",
        ),
        ("rosbot", "z: 0.138 ", "z: -0.138 ", "lidar.z", "the sensor is 0.138 m below the floor"),
        ("rosbot", FRONT_RIGHT, "heading: left}", "drive.wheels.1.heading", "got string 'left'"),
        ("rosbot", "-0.053, y: 0.1025", "-0.053, y: -102.5", "drive.wheels.2.y", "at least -10 m"),
    ],
)
def test_the_error_of_a_part_has_the_place_of_its_key(tmp_path, robot, old, new, place, message):
    """Or of the part that lacks one; of two errors where a key is unknown and another missing."""
    path = written(tmp_path, robot, {old: new})
    with pytest.raises(InputError) as caught:
        load_robot(path)
    keys = tuple(int(key) if key.isdigit() else key for key in place.split("."))
    expected = read(path).diagnostic("", keys, "")
    (error,) = (each for each in caught.value.diagnostics if message in each.headline)
    assert (error.line, error.column) == (expected.line, expected.column)
    assert len(caught.value.diagnostics) == (2 if "wheel_z" in new or "nois:" in new else 1)


def test_a_wrong_file_gets_every_error_with_its_place(tmp_path):
    """An unknown key, a text for a number and a negative rate are reported together."""
    changes = {
        "rays: 360": "rays: many",
        "wheel_radius: 0.033": "wheel_radius: -0.033",
        "name: waffle": "name: waffle\ncolour: red",
    }
    path = written(tmp_path, "waffle", changes)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    reported = str(caught.value)
    assert len(caught.value.diagnostics) == 3
    assert "unknown key 'colour'" in reported
    assert "expected more than 0.0, got the number -0.033" in reported
    assert "expected an integer, got string 'many'" in reported
    assert f"{path}:6:1" in reported


ROSBOT = find("robots", "rosbot").read_text(encoding="utf-8").splitlines(keepends=True)
FOUR = "".join(line for line in ROSBOT if line.startswith("    - {x: "))
THREE = """\
    - {x: 0.09055, y: 0.15684, heading: 2.618}
    - {x: -0.1811, y: 0.0, heading: 4.712}
    - {x: 0.09055, y: -0.15684, heading: 0.524}
"""


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"roller: -45": "roller: 0", "roller: 45": "roller: 0"}, "drive ahead, sideways and turn"),
        ({FOUR: THREE}, "headings and rollers (deg)"),
    ],
    ids=["four wheels that all roll ahead", "headings in rad, which are nearly parallel"],
)
def test_wheels_that_cannot_drive_every_way_are_refused(tmp_path, changes, message):
    """The error names the key and its place."""
    path = written(tmp_path, "rosbot", changes)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    (error,) = caught.value.diagnostics
    assert message in error.headline
    assert error.line == read(path).diagnostic("", ("drive", "wheels"), "").line


def test_a_round_body_has_a_round_hull():
    """A TurtleBot 4 sweeps no more when it turns than it takes when it stands."""
    robot = load_robot("turtlebot4")
    assert robot.turning_radius == robot.hull.front == -robot.hull.rear == robot.hull.half_width


def test_lidar_ranges_must_be_in_order():
    """The shortest range lies below the longest."""
    fields = load_robot("waffle").model_dump()
    fields["lidar"]["min_range"] = 4.0
    with pytest.raises(ValidationError, match=r"min_range 4\.0 m must be below max_range 3\.5 m"):
        RobotModel.model_validate(fields)


def test_sensors_are_set_apart_from_the_figures():
    """LDS-02: ranges and rays of its data sheet at the robot's rate; None keeps the figures."""
    waffle = load_robot("waffle")
    options = SensorsModel.model_validate({"lidar": {"model": "LDS-02"}})
    lidar = waffle.with_sensors(options).lidar
    assert (lidar.min_range, lidar.max_range, lidar.rays, lidar.rate) == (0.16, 8.0, 230, 10.0)
    assert waffle.with_sensors(SensorsModel()).lidar == waffle.lidar
    back = waffle.with_sensors(options).with_sensors(
        SensorsModel.model_validate({"lidar": {"model": "LDS-01"}})
    )
    assert back.lidar == waffle.lidar


def test_the_section_sensors_of_a_file_is_carried_out(tmp_path):
    """A Burger's LDS-02 turns at 5 Hz, so it has 460 rays."""
    changes = {"# model: LDS-02": "model: LDS-02", "slip: 0.0": "slip: 0.02"}
    robot = load_robot(written(tmp_path, "burger", changes))
    assert (robot.lidar.model, robot.lidar.rays) == ("LDS-02", 460)
    assert robot.sensors.odometry.slip == 0.02


def differential_robots() -> list[Any]:
    """The shipped robots with two driven wheels."""
    robots = map(load_robot, names("robots"))
    return [robot for robot in robots if isinstance(robot.drive, DifferentialDrive)]


def test_a_base_is_blind_behind_without_a_lidar_that_looks_there():
    """A sector of 270 degrees ahead leaves the ground behind unseen."""
    car = load_robot("f1tenth")
    assert car.sees_behind
    assert list(car.all_lidars) == ["scan", "scan_rear"]
    assert not RobotModel.model_validate(car.model_dump() | {"lidars": {}}).sees_behind


@pytest.mark.parametrize(
    ("sector", "yaw", "sees"),
    [((-135, 135), 180, True), ((-20, 20), 180, False), ((-90, 10), 180, False), (None, 0, True)],
)
def test_a_lidar_must_see_the_whole_width_behind(sector, yaw, sees):
    """A narrow beam straight back does not see what the corners of the hull meet."""
    data = load_robot("f1tenth").model_dump()
    rear = data["lidars"]["rear"] | {"sector": sector, "yaw": yaw}
    assert RobotModel.model_validate(data | {"lidars": {"rear": rear}}).sees_behind is sees
