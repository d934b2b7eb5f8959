"""Faults of the robot, and what a mission answers: which outcome, when, and where it stands."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from bt_mission.faults.errors import ScenarioError
from tests.support.thorough import sample

WAITS = "mission: waits\nworld: empty_arena\ntree: {wait: 1.2}\n"
DRIVE = """
mission: drives
world: empty_arena
tree:
  fallback:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
      timeout: 20
      name: drive
    - wait: 1
"""
TURN = DRIVE.replace(
    "explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}", "turn: {angle: 90}"
)
SWEEP = TURN.replace("turn: {angle: 90}", "camera_sweep: {sweep_angle: 45, image_count: 2}")


def recorded(stage: Any, topic: str, fault: Any) -> Any:
    """What comes of a topic in 1.2 s, half of it with a fault, while the robot stands."""
    run = stage.run(WAITS)
    run.record(topic)
    run.at(0.61, fault)
    run.until_done()
    messages = run.topic(topic)
    return [
        [m for m, t in zip(messages, messages.times, strict=True) if (t > 0.62) is broken]
        for broken in (False, True)
    ]


def outcome(run: Any) -> tuple[float, str]:
    """When the drive ended, and how."""
    run.until(lambda s: s.leaf("drive").failed or s.leaf("drive").succeeded)
    result = run.leaf("drive")
    return result.since, result.outcome or result.status


# ---- what they do ------------------------------------------------------------------------


def test_the_lidar_is_noisy_or_off(stage: Any) -> None:
    """By so many metres, in every direction."""
    sound, broken = recorded(stage, "scan", stage.faults.lidar_noise(0.1))
    spread = np.std(np.subtract(broken[-1].ranges, sound[0].ranges))
    assert spread == pytest.approx(0.1, abs=0.02)
    sound, broken = recorded(stage, "scan", stage.faults.lidar_bias(-0.3))
    assert np.mean(np.subtract(broken[-1].ranges, sound[0].ranges)) == pytest.approx(-0.3, abs=0.01)


def test_the_lidar_is_blind_in_part(stage: Any) -> None:
    """In sectors, or in a share of all directions."""
    _, broken = recorded(stage, "scan", stage.faults.lidar_blind((-20, 20), (170, -170)))
    lost = np.isinf(broken[-1].ranges)
    assert set(np.flatnonzero(lost)) == {*range(21), *range(340, 360), *range(170, 191)}
    _, broken = recorded(stage, "scan", stage.faults.lidar_blind(share=0.4))
    assert np.isinf(broken[-1].ranges).mean() == pytest.approx(0.4, abs=0.1)


def test_the_lidar_hangs_or_is_dead(stage: Any) -> None:
    """The same ranges with fresh stamps, or nothing."""
    sound, broken = recorded(stage, "scan", stage.faults.lidar_frozen())
    assert {bytes(m.ranges) for m in broken} == {bytes(sound[-1].ranges)}
    assert len({m.header.stamp.nanosec for m in broken}) == len(broken) > 2
    sound, broken = recorded(stage, "scan", stage.faults.lidar_dead())
    assert (len(sound) > 2, broken) == (True, [])


@pytest.mark.parametrize(
    ("topic", "make"),
    [
        ("odom", lambda f: f.odometry_dead()),
        ("tf", lambda f: f.odometry_dead()),
        ("imu", lambda f: f.imu_dead()),
        ("joint_states", lambda f: f.joints_dead()),
        ("camera/image_raw", lambda f: f.camera_dead()),
    ],
)
def test_a_sensor_is_dead(stage: Any, topic: str, make: Any) -> None:
    """It publishes nothing."""
    sound, broken = recorded(stage, topic, make(stage.faults))
    assert (len(sound) > 2, broken) == (True, [])


def test_odometry_drifts(stage: Any) -> None:
    """While the robot stands."""
    _, broken = recorded(stage, "odom", stage.faults.odometry_drift(0.5, turn=30))
    pose = broken[-1].pose.pose
    assert math.hypot(pose.position.x, pose.position.y) == pytest.approx(0.3, abs=0.03)
    assert 2 * math.asin(pose.orientation.z) == pytest.approx(math.radians(18), abs=0.03)


def test_the_camera_shows_something_else(stage: Any) -> None:
    """Black, noise, or the same."""
    _, broken = recorded(stage, "camera/image_raw", stage.faults.camera_black())
    assert not any(broken[-1].data)
    sound, broken = recorded(stage, "camera/image_raw", stage.faults.camera_noise(0.1))
    assert bytes(broken[-1].data) != bytes(sound[-1].data)
    sound, broken = recorded(stage, "camera/image_raw", stage.faults.camera_frozen())
    assert bytes(broken[-1].data) == bytes(sound[-1].data)


def test_two_faults_of_one_figure(stage: Any) -> None:
    """The later counts, and when it ends, the other does again."""
    run = stage.run(WAITS)
    lidar = run.stage.sim.robots[0].faults
    weak, strong = stage.faults.lidar_noise(0.1), stage.faults.lidar_noise(0.5)
    seen = []
    for action in (weak, strong, stage.faults.lidar_dead(), strong.end, weak.end):
        run.do(action)
        seen.append((lidar["lidar"].noise, lidar["lidar"].dead))
    run.do(stage.faults.clear)
    assert seen == [(0.1, False), (0.5, False), (0.5, True), (0.1, True), (0.0, True)]
    assert lidar.present == {}


# ---- what a mission answers ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("mission", "make", "ended", "output"),
    sample(
        [
            (DRIVE, lambda f: f.lidar_dead(), 2.05, "no scan for 1 s: the last is 1.05 s old"),
            (
                DRIVE,
                lambda f: f.odometry_dead(),
                2.05,
                "no odometry for 1 s: the last is 1.05 s old",
            ),
            (
                DRIVE,
                lambda f: f.block_wheel("left"),
                3.05,
                "astray: commanded straight on, turning at",
            ),
            (
                DRIVE,
                lambda f: f.block_wheel("both"),
                2.9,
                "blocked: commanded 0.20 m/s, no progress",
            ),
            (
                TURN,
                lambda f: f.block_wheel("both"),
                2.9,
                "blocked: commanded 1.00 rad/s, no progress",
            ),
            (DRIVE, lambda f: f.motors_off(), 1.05, "motors off (code 907)"),
            (DRIVE, lambda f: f.battery_charge(0.0), 1.05, "motors off (code 907)"),
            (SWEEP, lambda f: f.camera_dead(), 2.1, "no image from the camera within 2 s"),
        ],
        every=2,
    ),
)
def test_a_drive_ends_and_the_robot_stands(
    stage: Any, mission: str, make: Any, ended: float, output: str
) -> None:
    """Aborted with the reason, at that time; nothing was hit, no goal is left."""
    run = stage.run(mission)
    run.at(0.05 if mission is SWEEP else 1.0, make(stage.faults))
    result = outcome(run)
    assert result[0] == ended
    assert output in result[1]
    run.until_done()
    assert run.check(f"whenever time >= {ended + 0.6}: abs(speed) < 0.01 and abs(turn_rate) < 0.02")
    assert run.now.collisions == 0
    assert run.close() == ()


@pytest.mark.parametrize(
    ("mission", "make"),
    sample(
        [
            (DRIVE, lambda f: f.lidar_noise(0.03)),
            (DRIVE, lambda f: f.lidar_dead(lasting=0.5)),
            (DRIVE, lambda f: f.lidar_blind((-20, 20))),
            (DRIVE, lambda f: f.lidar_blind(share=0.5)),
            (DRIVE, lambda f: f.odometry_error(left_radius=0.1)),
            (DRIVE, lambda f: f.odometry_drift(0.05)),
            (DRIVE, lambda f: f.push(20, seconds=0.5)),
            (DRIVE, lambda f: f.shove(0.5)),
            (TURN, lambda f: f.block_wheel("left")),
            (TURN, lambda f: f.imu_dead()),
            (TURN, lambda f: f.joints_dead()),
            (TURN, lambda f: f.shove(turn=-3)),
            (TURN, lambda f: f.slip_wheel("left")),
        ],
        every=2,
    ),
)
def test_what_a_drive_bears(stage: Any, mission: str, make: Any) -> None:
    """It comes to its end, and nothing is hit."""
    run = stage.run(mission)
    run.at(1.0, make(stage.faults))
    assert outcome(run)[1] == "success"
    assert run.check("never clearance < 0.2")


def test_wrong_figures_turn_the_robot_wrong(stage: Any) -> None:
    """Odometry says 90 degrees."""
    run = stage.run(TURN)
    run.do(stage.faults.odometry_error(separation=0.2))
    assert outcome(run)[1] == "success"
    assert run.now.odometry[2] == pytest.approx(math.radians(90), abs=0.03)
    assert run.now.yaw == pytest.approx(1.2 * math.radians(90), abs=0.05)


def test_without_grip_the_robot_does_not_stop(stage: Any) -> None:
    """Its wheels stand, and that is all it knows."""
    run = stage.run(DRIVE)
    run.at(1.0, stage.faults.slip_wheel("both", 0.0))
    assert outcome(run)[1] == "success"
    assert run.now.speed == pytest.approx(0.2, abs=0.01)


def test_a_push_moves_the_robot(stage: Any) -> None:
    """For a time, or at once."""
    for fault, moved in (
        (stage.faults.push(20, seconds=0.3), 0.1),
        (stage.faults.shove(0, 1), 0.01),
    ):
        run = stage.run(WAITS)
        run.at(0.2, fault)
        run.until_done()
        assert math.hypot(run.now.x, run.now.y) > moved
        assert str(run.faults[0]).endswith(" at 0.20 s")


def test_what_cannot_be(stage: Any) -> None:
    """Is refused, with what can."""
    run = stage.run(WAITS)
    faults = stage.faults
    for fault, reason in (
        (faults.push(1e6), "push: "),
        (faults.shove(1e6), "shove: "),
    ):
        with pytest.raises(ScenarioError, match=reason):
            run.do(fault)
    assert run.faults == []
