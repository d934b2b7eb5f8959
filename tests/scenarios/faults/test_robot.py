"""Faults of the robot: what they do to its sensors and its base."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from tests.support.thorough import sample

WAITS = "mission: waits\nworld: empty_arena\ntree: {wait: 1.2}\n"


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


def test_the_lidar_hangs(stage: Any) -> None:
    """The same ranges with fresh stamps."""
    sound, broken = recorded(stage, "scan", stage.faults.lidar_frozen())
    assert {bytes(m.ranges) for m in broken} == {bytes(sound[-1].ranges)}
    assert len({m.header.stamp.nanosec for m in broken}) == len(broken) > 2


@pytest.mark.parametrize(
    ("topic", "fault"),
    sample(
        [
            ("scan", "lidar_dead"),
            ("odom", "odometry_dead"),
            ("tf", "odometry_dead"),
            ("imu", "imu_dead"),
            ("joint_states", "joints_dead"),
            ("camera/image_raw", "camera_dead"),
        ],
        3,
    ),
)
def test_a_sensor_is_dead(stage: Any, topic: str, fault: str) -> None:
    """It publishes nothing."""
    sound, broken = recorded(stage, topic, getattr(stage.faults, fault)())
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
    run.step()


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
    for fault in (stage.faults.push(1e6), stage.faults.shove(1e6)):
        with pytest.raises(ScenarioError, match=f"{fault.what}: "):
            run.do(fault)
    assert run.faults == []
    run.step()
