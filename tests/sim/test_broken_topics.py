"""Faults as others see them: on the topics of a robot, and mended by the reset service."""

import pytest
from std_srvs.srv import Trigger

S = 1_000_000_000
WALLS = [{"from": [2, -6], "to": [2, 6], "thickness": 0.2}]


@pytest.mark.parametrize(
    ("part", "silent", "goes_on"),
    [
        ("lidar", {"scan"}, {"odom", "imu", "joint_states", "tf"}),
        ("odometry", {"odom", "tf"}, {"scan", "imu", "joint_states", "ground_truth/odom"}),
        ("imu", {"imu"}, {"scan", "odom", "joint_states", "tf"}),
        ("joints", {"joint_states"}, {"scan", "odom", "imu", "tf"}),
        ("camera", {"camera/camera_info", "camera/image_raw"}, {"scan", "odom"}),
    ],
)
def test_a_dead_sensor_is_silent_and_comes_back(make_stage, make_world, part, silent, goes_on):
    """For a second; the others go on, and afterwards it goes on, too, with stamps of its time."""
    here = make_stage(make_world(walls=WALLS), *silent, *goes_on)
    here.run(2 * S)
    here.received.clear()
    here.sim.robots[0].faults.set(part, dead=True)
    here.run(3 * S)
    assert not any(here.messages(topic) for topic in silent)
    assert all(len(here.messages(topic)) >= 10 for topic in goes_on)
    here.sim.robots[0].faults.clear(part)
    here.run(4 * S)
    for topic in silent - {"tf"}:
        assert here.messages(topic)[0].header.stamp.sec == 3


@pytest.mark.parametrize("model", ["LDS-01", "LDS-02"])
def test_a_frozen_lidar_repeats_its_scan_with_fresh_stamps(make_stage, make_world, waffle, model):
    """The same ranges and another stamp each time, while the robot turns."""
    robot = waffle.with_sensors(type(waffle.sensors).model_validate({"lidar": {"model": model}}))
    here = make_stage(make_world(walls=WALLS), "scan", robot=robot)
    here.run(2 * S)
    here.sim.robots[0].faults.set("lidar", frozen=True)
    last = here.messages("scan")[-1].ranges.tobytes()
    here.received.clear()
    for tenth in range(20, 30):
        here.command(0.0, 1.0)
        here.run(tenth * S // 10)
    scans = here.messages("scan")
    assert len(scans) >= 9
    assert {scan.ranges.tobytes() for scan in scans} == {last}
    assert len({(scan.header.stamp.sec, scan.header.stamp.nanosec) for scan in scans}) == len(scans)


def test_the_reset_service_mends_all_and_takes_props_away(make_stage, make_world):
    """As at the start."""
    here = make_stage(make_world(walls=WALLS), "scan", props=1)
    here.run(2 * S)
    simulation = here.sim.robots[0]
    simulation.faults.set("lidar", dead=True)
    simulation.physics.props.place("box", 1.0, 0.0, radius=0.1)
    client = here.ear.create_client(Trigger, "reset_simulation")
    client.call_async(Trigger.Request())
    here.clock.run_until_quiet()
    assert simulation.faults.present == {}
    assert not simulation.physics.props
    here.received.clear()
    here.run(3 * S)
    assert here.messages("scan")


@pytest.mark.parametrize(
    ("faults", "check"),
    [
        ({"black": True}, lambda seen, before: not any(seen.data)),
        ({"frozen": True}, lambda seen, before: seen.data == before.data),
        ({"noise": 0.2}, lambda seen, before: seen.data != before.data),
        ({}, lambda seen, before: seen.data != before.data),
    ],
)
def test_a_camera_shows_black_or_the_last_or_noise(make_stage, make_world, faults, check):
    """While the robot turns before a wall of several colours."""
    boxes = [{"x": 1.5, "y": y / 2, "size": [0.1, 0.2, 0.4], "colour": "red"} for y in range(-3, 4)]
    here = make_stage(make_world(boxes=boxes), "camera/image_raw")
    here.run(15 * S // 10)
    before = here.messages("camera/image_raw")[-1]
    here.received.clear()
    here.sim.robots[0].faults.set("camera", **faults)
    here.command(0.0, 1.0)
    here.run(17 * S // 10)
    assert check(here.messages("camera/image_raw")[-1], before)
