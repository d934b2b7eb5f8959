"""Faults as records: set, changed, cleared; what cannot be is refused with what can."""

import math

import pytest

from sim.faults import FaultError, RobotFaultState, WheelFaults
from sim.robot.robot import PARTS
from sim.sensors.camera import CameraFaults
from sim.sensors.lidar import LidarFaults


@pytest.fixture
def wheels():
    """What the wheels were told."""
    return []


@pytest.fixture
def faults(wheels):
    """Those of a robot with which nothing is wrong."""
    return RobotFaultState(PARTS, wheels.append)


def test_at_the_start_nothing_is_wrong(faults):
    """And a sensor can tell by identity."""
    assert faults.present == {}
    assert faults["lidar"] is PARTS["lidar"]


def test_a_part_that_is_not_there_cannot_break(wheels):
    """But all is mended as ever."""
    faults = RobotFaultState(PARTS, wheels.append, {"camera": "a cart has no camera"})
    with pytest.raises(FaultError, match=r"^a cart has no camera$"):
        faults.set("camera", dead=True)
    faults.clear()
    assert faults.present == {}


def test_what_is_not_named_stays_as_it_is(faults):
    """Noise is set, then death; one is taken away again."""
    faults.set("lidar", noise=0.1)
    faults.set("lidar", dead=True)
    assert faults["lidar"] == LidarFaults(noise=0.1, dead=True)
    faults.set("lidar", dead=False)
    assert faults.present == {"lidar": LidarFaults(noise=0.1)}


def test_a_part_is_mended_or_all(faults, wheels):
    """The wheels are told of it, too."""
    faults.set("lidar", noise=0.1)
    faults.set("camera", black=True)
    faults.set("wheels", left_blocked=True)
    faults.clear("lidar")
    assert faults.present == {
        "camera": CameraFaults(black=True),
        "wheels": WheelFaults(left_blocked=True),
    }
    faults.clear()
    assert faults.present == {}
    assert faults["camera"] is PARTS["camera"]
    assert wheels == [WheelFaults(left_blocked=True), WheelFaults()]


def test_taken_back_by_its_values_it_is_none(faults):
    """Set to what it is without a fault."""
    faults.set("lidar", noise=0.1)
    faults.set("lidar", noise=0.0)
    assert faults["lidar"] is PARTS["lidar"]


@pytest.mark.parametrize(
    ("part", "changes", "expected"),
    [
        ("lidr", {}, r"no part 'lidr' that can break \(known: .*lidar, .*mean 'lidar'\?"),
        (
            "lidar",
            {"nose": 1},
            r"no fault 'nose' of the part 'lidar' \(known: dead, noise, .* 'noise'",
        ),
        ("lidar", {"noise": -0.1}, "lidar: noise: expected 0 to 10 m, got -0.1"),
        ("lidar", {"noise": math.nan}, "lidar: noise: expected 0 to 10 m, got nan"),
        ("lidar", {"noise": True}, "lidar: noise: expected 0 to 10 m, got True"),
        ("lidar", {"dropout": 1.1}, "expected 0 to 1 of all rays, got 1.1"),
        ("lidar", {"dead": 1}, "lidar: dead: expected True or False, got 1"),
        ("lidar", {"sectors": (-20, 20)}, r"sectors: expected \(\(FROM, TO\), .*, got \(-20, 20\)"),
        ("lidar", {"sectors": ((0, math.inf),)}, r"degrees from -360 to 360, left positive"),
        ("odometry", {"drift": "fast"}, "odometry: drift: expected -10 to 10 m/s, got 'fast'"),
        ("wheels", {"left_grip": 2}, r"left_grip: expected 0 to 1 \(1: as it is\), got 2"),
    ],
)
def test_what_cannot_be_is_refused(faults, part, changes, expected):
    """With what can; nothing has changed."""
    with pytest.raises(FaultError, match=expected):
        faults.set(part, **changes)
    assert faults.present == {}


def test_a_part_that_is_none_cannot_be_mended(faults):
    """It lists those that are."""
    with pytest.raises(FaultError, match="no part 'gripper' that can break"):
        faults.clear("gripper")
