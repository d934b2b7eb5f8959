"""A test does not notice that its runs are recorded."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.testing.stages import Stages
from tests.support.thorough import sample

MISSION = """\
mission: broken
world: empty_arena
seed: 5
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.4}
      timeout: 4
      on_cancel: success
    - turn: {angle: 40}
      timeout: 30
"""

BROKEN: dict[str, Callable[[Any], Any]] = {
    "nothing": lambda _: None,
    "a topic": lambda faults: faults.drop("scan", share=0.3),
    "a receiver": lambda faults: faults.delay("odom", 0.1, receiver="bt_mission_servers"),
    "feedback": lambda faults: faults.freeze_feedback("explore_forward"),
    "answers": lambda faults: faults.delay_answers("turn", 0.5),
    "the robot": lambda faults: faults.lidar_noise(0.05),
    "an obstacle": lambda faults: faults.spawn_box(ahead=1.0),
    "a server": lambda faults: faults.kill_server("turn", lasting=2.0),
}


def run(folder: Path, fault: Callable[[Any], Any], *, records: bool) -> Any:
    """A run with a fault, to its end."""
    folder.mkdir()
    stages = Stages(folder, records=records)
    try:
        run = stages.run(MISSION)
        action = fault(stages.faults)
        if action is not None:
            run.at(1.0, action)
        run.until_done()
    finally:
        stages.close()
    return run


@pytest.mark.parametrize("what", sample(BROKEN, every=8))
def test_a_recorded_run_is_the_same(what: str, tmp_path: Path) -> None:
    """Whatever is broken in it; and the recording has all of it."""
    bare = run(tmp_path / "bare", BROKEN[what], records=False)
    recorded = run(tmp_path / "recorded", BROKEN[what], records=True)
    assert recorded.stage.trace.sha256 == bare.stage.trace.sha256
    assert recorded.recording.missing == ""
    path = tmp_path / "left.mcap"
    assert recorded.recording.leave(path)
    timeline = read_timeline(path)
    assert [line for line in timeline.trace if '"event": "pose"' not in line] == [
        line for line in recorded.history.events if '"event": "pose"' not in line
    ]
    assert TimelineSeeker(timeline).seek(timeline.end_ns).status == recorded.status
    recorded.recording.discard()
    assert not recorded.recording.leave(path)


def test_what_a_test_plays_is_recorded_too(tmp_path: Path) -> None:
    """Its goals, and their feedback."""
    stages = Stages(tmp_path, records=True)
    turn = stages.scripted_server("turn")
    run = stages.run("mission: m\ntree: {turn: {angle: 40}, timeout: 30}\n")
    run.until(lambda _: turn.goals)
    turn.goal.feed(current_angle=10.0, remaining_angle=30.0)
    run.advance(1.0)
    turn.goal.succeed()
    run.until_done()
    stages.close()
    path = tmp_path / "left.mcap"
    assert run.recording is not None
    run.recording.leave(path)
    shown = TimelineSeeker(timeline := read_timeline(path)).seek(timeline.end_ns - 500_000_000)
    assert shown.messages[0] == "current_angle 10.00, remaining_angle 30.00"
