"""What missions answer to faults of topics: which outcome, when, and the robot stands."""

from __future__ import annotations

from typing import Any

import pytest

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
TURN = """
mission: turns
world: empty_arena
tree:
  fallback:
    - turn: {angle: 90}
      timeout: 4
      name: drive
    - wait: 1
"""


@pytest.mark.parametrize(
    ("mission", "make", "ends", "outcome"),
    sample(
        [
            (
                DRIVE,
                lambda f: f.drop("scan"),
                1.95,
                "no scan for 1 s: the last is 1.05 s old (code 902)",
            ),
            (
                DRIVE,
                lambda f: f.drop("odom"),
                1.95,
                "no odometry for 1 s: the last is 1.00 s old (code",
            ),
            (
                TURN,
                lambda f: f.drop("odom"),
                1.95,
                "no odometry for 1 s: the last is 1.00 s old (code",
            ),
            (
                DRIVE,
                lambda f: f.drop("cmd_vel"),
                3.15,
                "blocked: commanded 0.20 m/s, no progress for 2",
            ),
            (
                DRIVE,
                lambda f: f.freeze("scan"),
                2.05,
                "no scan for 1 s: the last is 1.05 s old (code 902)",
            ),
            (
                TURN,
                lambda f: f.freeze("odom", fresh_stamps=True),
                2.9,
                (
                    "blocked: commanded 1.00 rad/s, no progress for 2 s; the base is held, "
                    "or refuses commands as late (code 906)"
                ),
            ),
            (
                DRIVE,
                lambda f: f.corrupt("scan", "nan"),
                1.95,
                "no scan for 1 s: the last is 1.05 s old",
            ),
            (
                DRIVE,
                lambda f: f.corrupt("odom", "nan"),
                1.95,
                "no odometry for 1 s: the last is 1.00 s",
            ),
            (
                DRIVE,
                lambda f: f.corrupt("odom", "zeros"),
                1.0,
                "odometry jumped by 0.15 m in 0.050 s",
            ),
            (
                DRIVE,
                lambda f: f.corrupt("scan", "future stamp"),
                1.0,
                "is stamped 10.00 s in the future",
            ),
            (
                TURN,
                lambda f: f.delay("odom", 0.05, jitter=0.2, in_order=False),
                1.45,
                "odometry jumped by 0.00 m in -0.100 s; was it reset? (code 903)",
            ),
        ],
        every=2,
    ),
)
def test_a_drive_ends_and_the_robot_stands(
    stage: Any, mission: str, make: Any, ends: float, outcome: str
) -> None:
    """Aborted with the reason, at that time; nothing was hit, no goal is left."""
    run = stage.run(mission)
    run.at(1.0, make(stage.faults))
    run.until(lambda s: s.leaf("drive").failed)
    assert run.t == ends
    assert outcome in run.leaf("drive").outcome
    run.until_done()
    assert run.check(f"whenever time >= {ends + 0.6}: abs(speed) < 0.01 and abs(turn_rate) < 0.01")
    assert run.now.collisions == 0
    assert [goal.status for goal in run.goals] == ["aborted"]
    assert run.close() == ()


@pytest.mark.parametrize(
    "make",
    sample(
        [
            lambda f: f.drop("scan", share=0.3),
            lambda f: f.drop("scan", lasting=0.8),
            lambda f: f.delay("scan", 0.3),
            lambda f: f.duplicate("odom", after=0.02),
            lambda f: f.duplicate("cmd_vel", times=3, after=0.1),
            lambda f: f.corrupt("scan", "nan", share=0.3),
        ],
        every=2,
    ),
)
def test_what_a_drive_bears(stage: Any, make: Any) -> None:
    """It stops before the wall, a little nearer where it hears late."""
    run = stage.run(DRIVE)
    run.at(5.0, make(stage.faults))
    run.until(lambda s: s.leaf("drive").succeeded, within=20)
    assert run.now.x == pytest.approx(1.335, abs=0.03)
    assert run.now.collisions == 0


def test_a_command_that_sticks_is_ended_by_the_limit(stage: Any) -> None:
    """The base hears the same again and again; the mission gives up, the goal is cancelled."""
    run = stage.run(TURN)
    stuck = stage.faults.freeze("cmd_vel", fresh_stamps=True)
    run.at(1.0, stuck)
    run.until(lambda s: s.leaf("drive").failed)
    assert (run.t, run.leaf("drive").outcome) == (4.15, "canceled by timeout: not done within 4 s")
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
