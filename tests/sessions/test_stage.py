"""On the stage everything happens at exact virtual times, and the same way every time."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from bt_mission.core.errors import BtMissionError
from bt_mission.sessions.stage import StageError, free_folder
from tests.support.thorough import sample

DRIVE = """\
mission: drive
world: {world}
tree:
  explore_forward: {{fwd_velocity: 0.2, stopping_distance: 0.3}}
  name: drive
  timeout: 60
"""
DRIVE_EMPTY = DRIVE.format(world="empty_arena")


def moves(s: Any) -> bool:
    """Does the robot move?"""
    return abs(s.speed) > 0.1


def test_the_first_tick_is_one_period_after_the_start(stage: Any) -> None:
    """Virtual time starts at one second; the executive ticks at 20 Hz."""
    run = stage.run("mission: m\ntree: {wait: 0.1}")
    run.until_done()
    times = [e["t"] for e in run.events("status")]
    assert times == [1_050_000_000, 1_150_000_000]


def test_a_run_repeats_and_another_seed_differs(stage: Any) -> None:
    """The same seed gives the same trace, bit for bit, in one process."""
    hashes = []
    for seed in (5, 5, 6):
        run = stage.run(DRIVE_EMPTY, seed=seed)
        run.until_done()
        hashes.append(run.stage.trace.sha256)
    assert hashes[0] == hashes[1] != hashes[2]


@pytest.mark.process
@pytest.mark.parametrize("words", sample([["square", "--set", "side=0.2"], ["explore"]], every=2))
def test_two_processes_give_the_same_trace(tmp_path: Any, words: list[str]) -> None:
    """Also with another hash seed of Python, another environment and another folder."""
    outputs = []
    for number in (1, 2):
        folder = tmp_path / str(number)
        folder.mkdir()
        environment = os.environ | {"PYTHONHASHSEED": str(number), "PADDING": "x" * 1000 * number}
        done = subprocess.run(
            [sys.executable, "-m", "bt_mission", "run", *words, "--json"],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        outputs.append(done.stdout)
    keys = [_without_wall_times(output) for output in outputs]
    assert keys[0] == keys[1]


def _without_wall_times(output: str) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(output)
    del report["wall_s"], report["real_time_factor"]
    return report


def test_an_interrupted_mission_leaves_a_standing_robot(stage: Any) -> None:
    """The goal is cancelled, the base stands still within half a second, nothing is left."""
    run = stage.run(DRIVE_EMPTY)
    run.until(moves)
    run.stage.executive.interrupt("interrupted by Ctrl-C")
    interrupted_s = run.t
    run.until_done()
    assert run.status == "interrupted"
    assert run.t - interrupted_s <= 0.15
    assert run.report.goals_left_behind == 0
    while run.t < interrupted_s + 0.5:
        run.stage.step()
    linear, angular = run.stage.sim.robots[0].velocity
    assert math.hypot(linear, angular) < 0.01


def test_a_goal_outside_the_limits_is_rejected_and_nothing_moves(stage: Any) -> None:
    """0.9 m/s is more than a Waffle can do."""
    run = stage.run(DRIVE_EMPTY.replace("0.2", "0.9"))
    run.until_done()
    assert run.status == "failure"
    assert run.reason.startswith("'drive' rejected: /explore_forward: fwd_velocity")
    assert run.stage.runs[0].distance_travelled_m < 0.001


def test_an_action_server_that_does_not_exist_is_a_clear_failure(stage: Any) -> None:
    """After the server limit of five seconds, and the reason names it."""
    run = stage.run(
        "mission: m\ntree:\n"
        "  action: {name: /fly, type: bt_mission_interfaces/action/Turn, goal: {angle: 90}}\n"
        "  timeout: 9"
    )
    run.until_done()
    assert (run.status, run.reason) == (
        "failure",
        "'fly' server not available: /fly: no server after 5 s",
    )
    assert run.t == pytest.approx(5.05)


def test_an_exception_in_a_servers_callback_ends_the_mission_with_its_cause(
    stage: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No traceback: the mission fails, the goal is cancelled and the robot stops."""
    run = stage.run(DRIVE_EMPTY)
    run.until(moves)

    def explode() -> None:
        monkeypatch.undo()
        raise RuntimeError("broken callback")

    timer = next(iter(run.stage.sim.timers), None) or next(iter(run.stage.node.timers))
    monkeypatch.setattr(timer, "callback", explode)
    run.until_done()
    assert run.status == "failure"
    assert run.reason.startswith("a callback failed: RuntimeError: broken callback (test_stage.py:")
    assert run.report.goals_left_behind == 0


def test_a_callback_that_keeps_failing_does_not_hang_the_end(
    stage: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it is the mission's own tick, its goals cannot be seen to their end."""
    run = stage.run(DRIVE_EMPTY)
    run.until(moves)

    def explode() -> None:
        raise RuntimeError("broken for good")

    monkeypatch.setattr(next(iter(run.stage.node.timers)), "callback", explode)
    with pytest.raises(StageError, match=r"201 callbacks failed, the last .* broken for good"):
        run.until_done()
    monkeypatch.undo()


@pytest.mark.parametrize(
    ("overrides", "words"),
    [({"world": "atlantis"}, "atlantis"), ({"robot": "hexapod"}, "hexapod")],
)
def test_an_unknown_world_or_robot_is_named(
    stage: Any, overrides: dict[str, str], words: str
) -> None:
    """With what there is instead."""
    with pytest.raises(BtMissionError, match=words):
        stage.run(DRIVE_EMPTY, **overrides)


def test_a_burger_drives_too(stage: Any) -> None:
    """The robot is the mission's choice."""
    run = stage.run(DRIVE_EMPTY, robot="burger")
    run.until_done()
    assert (run.status, run.stage.runs[0].collisions) == ("success", 0)


def test_pictures_of_each_run_have_a_folder_of_their_own(tmp_path: Any) -> None:
    """The first free number."""
    assert free_folder(tmp_path).name == "run_001"
    (tmp_path / "run_001").mkdir()
    assert free_folder(tmp_path).name == "run_002"


def test_a_working_folder_that_is_gone_is_told(tmp_path: Path, monkeypatch: Any) -> None:
    """Not as an error of the machine: another shell may have deleted it."""
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    with pytest.raises(StageError, match="the working folder has been deleted; change to another"):
        free_folder(Path("pictures"))


@pytest.mark.parametrize(
    ("way_m", "timeout_s", "driven", "ended_as"),
    [
        (0.3, 5, pytest.approx(0.32, abs=0.03), "canceled by condition"),
        (9, 2, pytest.approx(0.39, abs=0.03), "canceled by timeout: not done within 2 s"),
    ],
)
def test_a_step_lets_nobody_drive_past_a_limit(
    stage: Any, way_m: float, timeout_s: float, driven: Any, ended_as: str
) -> None:
    """One step of a mission that stands at a breakpoint sends the goal; its limits end it."""
    run = stage.run(
        "mission: m\nworld: empty_arena\ntree:\n  sequence:\n    - wait: 1\n"
        "    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}\n      name: drive\n"
        f"      cancel_when: current_distance_travelled > {way_m}\n      timeout: {timeout_s}\n"
    )
    executive = run.stage.executive
    executive.breakpoints.add("drive")
    run.until(lambda _: executive.paused)
    executive.step()
    run.advance(20.0)
    assert (executive.mission_state.status, executive.mission_state.explanation) == (
        "paused",
        "breakpoint at 'drive'",
    )
    assert run.stage.runs[0].distance_travelled_m == driven
    executive.resume()
    run.until_done()
    assert run.reason.startswith(f"'drive' {ended_as}")
    assert len(run.goals) == 1


REFUSED = "mission: m\ninputs: {far: 10000}\ntree: {turn: {angle: $far}, timeout: 9}"


def test_a_rejection_that_the_mission_tells_is_not_logged_as_well(
    stage: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    """It would stand on the terminal twice."""
    run = stage.run(REFUSED)
    run.until_done()
    assert "angle must be from -3600 to 3600 deg" in run.stage.executive.reason
    assert "goal rejected" not in capfd.readouterr().err


def test_where_others_may_send_goals_rejections_are_logged(
    stage: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    """A rejection itself has no reason in ROS."""
    run = stage.run(REFUSED)
    run.stage.offer_all()
    run.until_done()
    assert "goal rejected: angle must be" in capfd.readouterr().err
