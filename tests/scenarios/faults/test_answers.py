"""What missions answer to faults of topics and of the robot: outcome, time, and where it stands."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.support.faulty_runs import outcome
from tests.support.thorough import sample

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


@pytest.mark.parametrize(
    ("mission", "fault", "ends", "output"),
    sample(
        [
            (DRIVE, "drop scan", 1.95, "no scan for 1 s: the last is 1.05 s old (code 902)"),
            (DRIVE, "drop odom", 1.95, "no odometry for 1 s: the last is 1.00 s old (code"),
            (TURN, "drop odom", 1.95, "no odometry for 1 s: the last is 1.00 s old (code"),
            (DRIVE, "drop cmd_vel", 3.15, "blocked: commanded 0.20 m/s, no progress for 2"),
            (DRIVE, "freeze scan", 2.05, "no scan for 1 s: the last is 1.05 s old (code 902)"),
            (TURN, "freeze odom fresh_stamps", 2.9, "refuses commands as late (code 906)"),
            (DRIVE, "corrupt scan nan", 1.95, "no scan for 1 s: the last is 1.05 s old"),
            (DRIVE, "corrupt odom nan", 1.95, "no odometry for 1 s: the last is 1.00 s"),
            (DRIVE, "corrupt odom zeros", 1.0, "odometry jumped by 0.15 m in 0.050 s"),
            (DRIVE, "corrupt scan 'future stamp'", 1.0, "is stamped 10.00 s in the future"),
            (
                TURN,
                "delay odom 0.05 jitter 0.2 in_order false",
                1.45,
                "odometry jumped by 0.00 m in -0.100 s; was it reset? (code 903)",
            ),
            (DRIVE, "odometry_dead", 2.05, "no odometry for 1 s: the last is 1.05 s old"),
            (DRIVE, "lidar_dead", 2.05, "no scan for 1 s: the last is 1.05 s old"),
            (DRIVE, "block_wheel both", 2.9, "blocked: commanded 0.20 m/s, no progress"),
            (DRIVE, "block_wheel left", 3.05, "astray: commanded straight on, turning at"),
            (DRIVE, "motors_off", 1.05, "motors off (code 907)"),
            (TURN, "block_wheel both", 2.9, "blocked: commanded 1.00 rad/s, no progress"),
            (SWEEP, "camera_dead", 2.1, "no image from the camera within 2 s"),
            (DRIVE, "battery_charge 0", 1.05, "motors off (code 907)"),
        ],
        every=3,
    ),
)
def test_a_drive_ends_and_the_robot_stands(
    stage: Any, mission: str, fault: str, ends: float, output: str
) -> None:
    """Aborted with the reason, at that time; nothing was hit, no goal is left."""
    run = stage.run(mission)
    stage.plan(run, f"at {0.05 if mission is SWEEP else 1.0}: {fault}")
    time, reason = outcome(run, "drive")
    assert time == ends
    assert output in reason
    run.until_done()
    assert run.check(f"whenever time >= {ends + 0.6}: abs(speed) < 0.01 and abs(turn_rate) < 0.02")
    assert run.now.collisions == 0
    assert [goal.status for goal in run.goals] == ["aborted"]
    assert run.close() == ()


@pytest.mark.parametrize(
    ("mission", "at", "fault"),
    sample(
        [
            (DRIVE, 5.0, "drop scan share 0.3"),
            (DRIVE, 5.0, "drop scan lasting 0.8"),
            (DRIVE, 5.0, "delay scan 0.3"),
            (DRIVE, 5.0, "duplicate odom after 0.02"),
            (DRIVE, 5.0, "duplicate cmd_vel times 3 after 0.1"),
            (DRIVE, 5.0, "corrupt scan nan share 0.3"),
            (DRIVE, 1.0, "lidar_noise 0.03"),
            (DRIVE, 1.0, "lidar_dead lasting 0.5"),
            (DRIVE, 1.0, "lidar_blind (-20, 20)"),
            (DRIVE, 1.0, "lidar_blind share 0.5"),
            (DRIVE, 1.0, "odometry_error left_radius 0.1"),
            (DRIVE, 1.0, "odometry_drift 0.05"),
            (DRIVE, 1.0, "push 20 seconds 0.5"),
            (DRIVE, 1.0, "shove 0.5"),
            (TURN, 1.0, "block_wheel left"),
            (TURN, 1.0, "imu_dead"),
            (TURN, 1.0, "joints_dead"),
            (TURN, 1.0, "shove turn -3"),
            (TURN, 1.0, "slip_wheel left"),
        ],
        every=3,
    ),
)
def test_what_a_drive_bears(stage: Any, mission: str, at: float, fault: str) -> None:
    """It comes to its end, and nothing is hit; where it hears late, it stops a little nearer."""
    run = stage.run(mission)
    stage.plan(run, f"at {at}: {fault}")
    assert outcome(run, "drive")[1] == "success"
    assert run.check("never clearance < 0.2")
    if at == 5.0:
        assert run.now.x == pytest.approx(1.335, abs=0.03)


def test_a_command_that_sticks_is_ended_by_the_limit(stage: Any) -> None:
    """The base hears the same again and again; the mission gives up, the goal is cancelled."""
    run = stage.run(TURN.replace("timeout: 20", "timeout: 4"))
    stuck = stage.faults.freeze("cmd_vel", fresh_stamps=True)
    run.at(1.0, stuck)
    assert outcome(run, "drive") == (4.15, "canceled by timeout: not done within 4 s")
    assert run.now.turn_rate == pytest.approx(1.0, abs=0.01)
    run.do(stuck.end)
    run.until_done()
    assert run.now.turn_rate == pytest.approx(0.0, abs=0.01)


def test_a_run_with_faults_repeats(stage: Any) -> None:
    """Bit for bit."""
    hashes = []
    for _ in range(2):
        run = stage.run(DRIVE, seed=5)
        run.do(
            stage.faults.drop("scan", share=0.3),
            stage.faults.delay("odom", 0.05, jitter=0.1, in_order=False),
        )
        run.advance(4.0)
        run.close()
        hashes.append(run.stage.trace.sha256)
    assert hashes[0] == hashes[1]


def test_wrong_figures_turn_the_robot_wrong(stage: Any) -> None:
    """Odometry says 90 degrees."""
    run = stage.run(TURN)
    run.do(stage.faults.odometry_error(separation=0.2))
    assert outcome(run, "drive")[1] == "success"
    assert run.now.odometry[2] == pytest.approx(math.radians(90), abs=0.03)
    assert run.now.yaw == pytest.approx(1.2 * math.radians(90), abs=0.05)


def test_without_grip_the_robot_does_not_stop(stage: Any) -> None:
    """Its wheels stand, and that is all it knows."""
    run = stage.run(DRIVE)
    run.at(1.0, stage.faults.slip_wheel("both", 0.0))
    assert outcome(run, "drive")[1] == "success"
    assert run.now.speed == pytest.approx(0.2, abs=0.01)
