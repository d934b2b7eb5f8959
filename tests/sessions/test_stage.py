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

from bt_mission.base.files import names
from bt_mission.base.yaml.document import read_text
from bt_mission.sessions import stage as stage_module
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage, StageError, free_folder
from bt_mission.sessions.stage_files import StageFiles
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions
from sim.world.loader import load_world
from tests.support.thorough import sample

DRIVE = """\
mission: drive
world: empty_arena
tree:
  explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
  name: drive
  timeout: 60
"""


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
        run = stage.run(DRIVE, seed=seed)
        run.until_done()
        hashes.append(run.stage.trace.sha256)
    assert hashes[0] == hashes[1] != hashes[2]


@pytest.mark.thorough
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
    run = stage.run(DRIVE)
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


def test_an_exception_in_a_servers_callback_ends_the_mission_with_its_cause(
    stage: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No traceback: the mission fails, the goal is cancelled and the robot stops."""
    run = stage.run(DRIVE)
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


@pytest.mark.parametrize(("limit_s", "failed"), [(600.0, 201), (0.0, 1)], ids=["count", "time"])
def test_a_callback_that_keeps_failing_does_not_hang_the_end(
    stage: Any, monkeypatch: pytest.MonkeyPatch, limit_s: float, failed: int
) -> None:
    """Where it is the mission's own tick, its goals cannot be seen to their end."""
    monkeypatch.setattr(stage_module, "RAISED_S", limit_s)
    run = stage.run(DRIVE)
    run.until(moves)

    def explode() -> None:
        raise RuntimeError("broken for good")

    monkeypatch.setattr(next(iter(run.stage.node.timers)), "callback", explode)
    with pytest.raises(StageError, match=rf"^{failed} callbacks failed in .* broken for good"):
        run.until_done()
    monkeypatch.undo()


def test_a_burger_drives_too(stage: Any) -> None:
    """The robot is the mission's choice."""
    run = stage.run(DRIVE, robot="burger")
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
    sample(
        [
            (0.3, 5, pytest.approx(0.32, abs=0.03), "canceled by condition"),
            (9, 2, pytest.approx(0.39, abs=0.03), "canceled by timeout: not done within 2 s"),
        ],
        2,
    ),
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
    run.until(lambda _: executive.status == "paused")
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


@pytest.mark.parametrize("is_offered", [False, True])
def test_a_rejection_is_logged_only_where_others_may_send_goals(
    stage: Any, capfd: pytest.CaptureFixture[str], *, is_offered: bool
) -> None:
    """The mission tells it, so it would stand on the terminal twice; ROS sends no reason."""
    run = stage.run("mission: m\ninputs: {far: 10000}\ntree: {turn: {angle: $far}, timeout: 9}")
    if is_offered:
        run.stage.offer_all()
    run.until_done()
    assert "angle must be from -3600 to 3600 deg" in run.stage.executive.reason
    assert ("goal rejected: angle must be" in capfd.readouterr().err) is is_offered


# ---- nodes that other processes see ---------------------------------------------------------

WAIT = """\
mission: wait
world: empty_arena
tree:
  sequence: [wait: 0.1]
"""


def services(folder: Path, *, visible: bool) -> tuple[set[str], set[str]]:
    """The names of all nodes and of all services of a run."""
    options = StageOptions(visible=visible)
    with Stage(load(WAIT), image_folder=folder, say=lambda _: None, options=options) as stage:
        while not stage.is_done:
            stage.step()
        node = stage.node
        names = {name for name, _ in node.get_service_names_and_types()}
        return set(node.get_node_names()), names


def test_every_node_that_others_see_answers_for_its_parameters(tmp_path):
    """`ros2 param list` asks each node that is announced, and waits for each that does not."""
    nodes, names = services(tmp_path, visible=True)
    assert {"bt_mission", "bt_mission_servers", "bt_mission_sim"} <= nodes
    assert {f"/{node}/list_parameters" for node in nodes} <= names


def test_nodes_that_nobody_sees_have_none(tmp_path):
    """They would cost time in every run."""
    _, names = services(tmp_path, visible=False)
    assert not {name for name in names if name.endswith("/list_parameters")}


# ---- what a recording keeps of the world ----------------------------------------------------

MEMBERS = [FleetRobot("", load(WAIT))]


@pytest.mark.parametrize("name", names("worlds"))
def test_a_world_that_stands_in_no_file_is_read_back_as_it_was(name: str) -> None:
    """Such as one of a scenario: in the form of a file."""
    world = load_world(name)
    result = StageFiles.find(MEMBERS, StageOptions(world=world))
    assert result.world is world
    (text,) = (
        first for file, first in result.contents.items() if file == f"worlds/{world.name}.yaml"
    )
    assert load_world(read_text(text.decode(), "copy")) == world


def test_a_world_of_a_file_is_kept_with_its_comments() -> None:
    """As it stands there."""
    path = Path(__file__).parents[2] / "worlds" / "empty_arena.yaml"
    result = StageFiles.find(MEMBERS, StageOptions(world=path))
    assert result.contents["worlds/empty_arena.yaml"] == path.read_bytes()
