"""Several robots in one world: apart in their topics, together in the physics."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from bt_mission.robots.model import load_robot
from sim.physics.spawn import MOST, RobotSpawn, RobotSpawnError, check, read
from sim.robot.fit import SpawnError
from sim.sensors.imu import Imu
from sim.simulation import Simulation
from sim.world.world import Spawn
from tests.support.simulated import alone, two

S, MS = 1_000_000_000, 1_000_000
OF_EACH = ("motor_power", "reset_odometry")


@pytest.fixture
def pair(waffle, make_world):
    """Two Waffles, 2 m apart, that look at each other; options are fields of the world."""

    def pair(seed: int = 1, second=waffle, gap: float = 2.0, **fields: object) -> Simulation:
        return Simulation(
            make_world(**fields),
            [
                RobotSpawn(waffle, "one", Spawn(x=-gap / 2)),
                RobotSpawn(second, "two", Spawn(x=gap / 2, yaw=180)),
            ],
            seed=seed,
        )

    return pair


def run(fleet: Simulation, seconds: float, **commands: tuple[float, float]) -> None:
    """Command each robot at 20 Hz."""
    for _ in range(round(seconds * 20)):
        for name, command in commands.items():
            fleet[name].command(*command)
        fleet.physics.advance_to(fleet.physics.time_ns + 50 * MS)
        for robot in fleet.robots:
            robot.read_odometry()


def test_each_goes_its_own_way(pair):
    """One drives, the other turns; odometry of each starts at zero."""
    fleet = pair()
    run(fleet, 2.0, one=(0.2, 0.0), two=(0.0, 0.5))
    assert fleet["one"].pose == pytest.approx((-0.6, 0, 0), abs=0.03)
    assert fleet["two"].pose[0] == pytest.approx(1.0, abs=0.01)
    assert fleet["one"].odometry.x == pytest.approx(0.4, abs=0.03)
    assert fleet["two"].odometry.yaw == pytest.approx(1.0, abs=0.1)
    assert fleet["two"].odometry.x == pytest.approx(0, abs=0.01)


def test_a_robot_drives_in_company_as_it_does_alone(pair, waffle, make_world, drive):
    """To a hundredth of a millimetre, as long as they do not touch."""
    fleet = pair(gap=10.0)
    single = alone(make_world(spawn={"x": -5.0}), waffle, seed=1)
    run(fleet, 3.0, one=(0.2, 0.3), two=(0.1, -0.8))
    drive(single, 3.0, 0.2, 0.3)
    assert fleet["one"].pose == pytest.approx(single.pose, abs=1e-5)


def test_they_collide_with_each_other(pair):
    """Each counts it, and names the other."""
    fleet = pair(gap=1.0)
    run(fleet, 3.0, one=(0.2, 0.0), two=(0.2, 0.0))
    assert (fleet["one"].collisions, fleet["two"].collisions) == (1, 1)
    assert (fleet["one"].collisions_with, fleet["two"].collisions_with) == ({"two": 1}, {"one": 1})
    assert fleet["one"].take_collisions()[0].obstacle == "two"
    assert fleet["two"].take_collisions()[0].obstacle == "one"


def test_they_collide_with_walls_too(pair):
    """Only the one that does is told."""
    fleet = pair(walls=[{"name": "wall", "from": [-0.5, -1], "to": [-0.5, 1], "thickness": 0.02}])
    run(fleet, 4.0, one=(0.2, 0.0))
    assert [c.obstacle for c in fleet["one"].take_collisions()] == ["wall"]
    assert fleet["one"].collisions_with == {}
    assert fleet["two"].collisions == 0


@pytest.mark.parametrize("second", ["waffle", "burger"])
def test_they_see_each_other_and_not_themselves(pair, second):
    """The screen around the other's hull: between the lidars 2 m, less lidar and hull."""
    robot = load_robot(second)
    fleet = pair(second=robot)
    scan = fleet["one"].scan(0)
    assert scan[0] == pytest.approx(2.0 + 0.064 - robot.hull.front, abs=0.04)
    assert np.isinf(scan[90:270]).all()
    back = fleet["two"].scan(0)
    assert back[0] == pytest.approx(2.0 - robot.lidar.x - 0.069, abs=0.04)


def test_a_screen_is_seen_out_to_its_corners(pair):
    """A Burger, whose lidar looks over a Waffle's body, sees the Waffle's whole width."""
    scan = pair(gap=0.7, second=load_robot("burger"))["two"].scan(0)
    # The Waffle's front, 0.663 m ahead of the lidar, from its middle out to 0.153 m.
    edge = math.degrees(math.atan2(0.153, 0.7 + 0.032 - 0.069))
    seen = [degrees for degrees in range(-90, 91) if math.isfinite(scan[degrees])]
    assert seen == list(range(-math.floor(edge), math.floor(edge) + 1))


@pytest.mark.egl
def test_a_camera_sees_the_other_and_not_its_own_screen(pair, waffle, render):
    """The other's is in the middle, in its colour; its own, around the lens, is not there."""
    fleet = pair()
    camera = render(fleet.physics, waffle.camera, "one/")
    picture = np.zeros((240, 320, 3), dtype=np.uint8)
    camera.draw(fleet.physics.data, picture)
    red, green, blue = picture[125, 160].astype(int)
    assert red > green + 40
    assert green > blue
    assert picture[5].min() > 100


def test_noise_depends_on_the_name_and_not_on_the_company(pair, waffle, make_world):
    """With or without the other, robot one reads the same."""
    walls = [{"from": [-3, -9], "to": [-3, 9]}]
    fleet = pair(walls=walls)
    single = Simulation(make_world(walls=walls), [RobotSpawn(waffle, "one", Spawn(x=-1))], seed=1)
    assert fleet["one"].scan(3)[180] == single["one"].scan(3)[180]
    turning, expected = (
        robots["one"].sensor(Imu).measure(3).angular_velocity for robots in (fleet, single)
    )
    assert turning == pytest.approx(expected, abs=1e-9)


def test_one_without_power_leaves_the_other_its_own(pair):
    """The motors of each are switched by themselves."""
    fleet = pair()
    fleet["one"].power_motors(on=False)
    run(fleet, 1.0, one=(0.2, 0.0), two=(0.2, 0.0))
    assert fleet["one"].velocity[0] == pytest.approx(0, abs=1e-4)
    assert fleet["two"].velocity[0] == pytest.approx(0.2, abs=1e-3)


def test_two_at_one_place_are_refused(waffle, make_world):
    """Both are named."""
    there = [RobotSpawn(waffle, "one", Spawn(x=0)), RobotSpawn(waffle, "two", Spawn(x=0.2))]
    with pytest.raises(SpawnError, match=r"a waffle \(one\) does not fit .* it touches 'two'"):
        Simulation(make_world(), there, seed=0)


def test_a_node_serves_them_under_their_names(make_stage, make_world, waffle):
    """Topics and services of each below its name, one clock, one reset."""
    here = make_stage(make_world(), robots=two(waffle))
    topics = {publisher.topic_name for publisher in here.sim.publishers}
    for name in ("one", "two"):
        for topic in ("scan", "odom", "tf", "map", "camera/image_raw"):
            assert f"/{name}/{topic}" in topics
    assert "/clock" in topics
    assert "/scan" not in topics
    own = {
        f"{name}/{what}" for name in ("one", "two") for what in ("motor_power", "reset_odometry")
    }
    assert {service.srv_name for service in here.sim.services} == {"reset_simulation"} | own


def test_a_command_reaches_the_robot_of_its_namespace(make_stage, make_world, waffle):
    """And its odometry comes back there, in frames without a prefix; a reset is one for all."""
    here = make_stage(make_world(), robots=two(waffle))
    messages: list[Odometry] = []
    here.ear.create_subscription(Odometry, "two/odom", messages.append, QoSProfile(depth=10))
    commands = here.ear.create_publisher(TwistStamped, "two/cmd_vel", 10)
    here.run(1 * S)
    message = TwistStamped()
    message.twist.linear.x = 0.2
    commands.publish(message)
    here.clock.run_until_quiet()
    here.run(1 * S + 200 * MS)
    assert messages[-1].pose.pose.position.x == pytest.approx(0.02, abs=0.01)
    assert (messages[-1].header.frame_id, messages[-1].child_frame_id) == ("odom", "base_footprint")
    first, second = here.sim.robots
    assert math.dist(first.pose[:2], (-1, 0)) < 1e-4
    assert second.pose[0] > 1.015
    here.ear.create_client(Trigger, "reset_simulation").call_async(Trigger.Request())
    here.clock.run_until_quiet()
    assert (first.pose[0], second.pose[0]) == pytest.approx((-1, 1), abs=1e-5)


# ---- their names -------------------------------------------------------------------------


def test_a_robot_alone_needs_no_name(waffle):
    """Its parts and topics have no prefix."""
    check([RobotSpawn(waffle)])
    assert RobotSpawn(waffle).prefix == ""
    assert RobotSpawn(waffle, "robot1").prefix == "robot1/"


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ([], "expected 1 to 16 robots in a world, got 0"),
        (["", "b"], "expected a name of small letters"),
        (["a", "B-2"], "got 'B-2'"),
        (["a", "a"], "two robots are named 'a'"),
        ([f"r{n}" for n in range(MOST + 1)], "got 17"),
    ],
)
def test_several_have_a_name_each(waffle, names, words):
    """The message says which is wrong."""
    with pytest.raises(RobotSpawnError, match=words):
        check([RobotSpawn(waffle, name) for name in names])


def test_one_is_read_from_a_word():
    """Name, model and place; the yaw or the place may be left out."""
    full = read("one=waffle@-1,0.5,90")
    assert (full.name, full.robot.name, full.spawn) == ("one", "waffle", Spawn(x=-1, y=0.5, yaw=90))
    assert read("two=burger@1,2").spawn == Spawn(x=1, y=2)
    assert read("two=burger").spawn is None


@pytest.mark.parametrize(
    "text", ["waffle", "one=", "one=waffle@", "one=waffle@1", "one=waffle@1,2,3,4", "a=waffle@x,y"]
)
def test_a_word_that_is_none_is_told_what_was_expected(text):
    """With an example."""
    with pytest.raises(RobotSpawnError, match=r"such as one=waffle@-1,0,90, got"):
        read(text)
