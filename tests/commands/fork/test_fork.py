"""Forks without a change at random instants of shipped missions, and of revised missions."""

from __future__ import annotations

import random
import shutil
from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.srv import ReviseMission

from bt_mission.base.files import find
from bt_mission.base.nature import Nature, Profile
from bt_mission.commands.fork.change import ForkChange
from bt_mission.commands.fork.edit import edited
from bt_mission.commands.fork.fork import ForkResult
from bt_mission.commands.fork.robot_files import RobotFiles
from bt_mission.commands.fork.source import NO_PYTHON, ForkSource, read_source
from bt_mission.commands.fork.stage import forked_stage
from bt_mission.recording.verification import RecordedRequirements
from bt_mission.recording.writer import RunRecorder
from bt_mission.requirements.checks import read_requirements
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from tests.support.recordings import recorded_run
from tests.support.robot_models import write_model
from tests.support.thorough import sample

SAME = ForkChange()


def forked(source: ForkSource, step_ns: int, change: ForkChange = SAME) -> tuple[Stage, ForkResult]:
    """Fork a run at a step, to its end; return the stage, which is closed, and the result."""
    with forked_stage(source, change, step_ns) as (stage, finish):
        while not stage.is_done:
            stage.step()
        return stage, finish(stage.reports(1.0))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "inputs", "profile"),
    sample(
        [("square", {"side": 0.4}, "usual"), ("explore", {}, "none"), ("sweep", {}, "harsh")],
        every=9,
    ),
)
def test_the_same_happens_again_wherever_it_is_forked(
    name: str, inputs: dict[str, Any], profile: Profile, tmp_path: Path
) -> None:
    """Byte for byte, to the end; benchmarks/commands/fork/forks.py does it a thousand times."""
    path = tmp_path / "run.mcap"
    options = StageOptions(nature=Nature(profile))
    stage = recorded_run(load(find("missions", name), set=inputs), path, options)
    source = read_source(path)
    for step_ns in random.Random(1).sample(list(source.steps_ns), 2):
        again, result = forked(source, step_ns)
        assert result.difference is None
        assert result.report.trace_sha256 == stage.trace.sha256
        assert again.trace.sha256 == source.summary["trace_sha256"]


def test_a_robot_with_a_model_is_forked_where_its_files_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The recording has the MuJoCo model, with what it includes and its meshes."""
    home, path = tmp_path / "home", tmp_path / "run.mcap"
    home.mkdir()
    robot = write_model(home, "rosbot")
    text = f"mission: m\nrobot: {robot}\ntree: {{turn: {{angle: 20}}, timeout: 9}}\n"
    recorded_run(load(text), path)
    shutil.rmtree(home)
    monkeypatch.chdir(tmp_path)
    source = read_source(path)
    assert forked(source, source.steps_ns[9])[1].difference is None
    folder = Path(source.robot_files.document.file).parent
    assert {each.name for each in folder.rglob("*") if each.is_file()} == {
        *("rosbot.yaml", "rosbot.xml", "meshes.xml", "part.obj")
    }


def test_the_files_of_a_model_stay_in_a_folder_that_goes_with_them() -> None:
    """A name that leads out of the folder is left out."""
    files = RobotFiles(
        "robots/a.yaml", {"robots/a.yaml": b"model: {}", "../left_out.xml": b"<mujoco/>"}
    )
    folder = Path(files.document.file).parents[1]
    assert [path.name for path in folder.rglob("*.*")] == ["a.yaml"]
    assert not (folder.parent / "left_out.xml").exists()
    del files
    assert not folder.exists()


BASE = """\
mission: m
world: empty_arena
inputs: {speed: 0.1}
requirements:
  turns: 'eventually succeeded("left")'
  is slow: always speed < 0.5
tree:
  sequence:
    - turn: {angle: 90}
      name: left
      timeout: 60
    - wait: 1
      name: pause
"""
SECOND = BASE.replace("  sequence:\n", "  sequence:\n    - log: hello\n").replace(
    "wait: 1", "wait: 2"
)
THIRD = SECOND + "    - move: {secs: 1, linear_velocity: speed}\n      name: late\n"
FOURTH = THIRD.replace("angle: 90", "angle: 60")


@pytest.fixture(scope="module")
def revised(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with a revision before a tick, one on request, and one after a step."""
    folder = tmp_path_factory.mktemp("revised")
    path = folder / "run.mcap"
    with Stage(
        load(BASE), image_folder=folder, say=lambda _: None, options=StageOptions(editable=True)
    ) as stage:
        recorder = RunRecorder(stage, path)
        runner = stage.runner
        stage.clock.call_at(2_000_000_000, lambda: runner.revise(load(SECOND)))
        request = ReviseMission.Request(file="<text>", text=THIRD)
        stage.clock.call_at(
            2_500_000_000, lambda: stage.clock.create_task(runner.revise_on_request, request)
        )
        while not stage.is_done:
            stage.step()
            if runner.executive.revisions == 2 and stage.now_ns >= 3_000_000_000:
                assert runner.revise(load(FOURTH), keep_goals=True).is_applied
        recorder.finish(stage.report(1.0).as_dict())
        assert (stage.executive.status, stage.executive.revisions) == ("success", 3)
    return path


@pytest.mark.parametrize("at_s", sample([0.5, 1.0, 5.0], 3))
def test_a_revised_run_happens_again(revised: Path, at_s: float) -> None:
    """Wherever it is forked: its revisions take place at their instants."""
    source = read_source(revised)
    kinds = [(version.is_after_step, version.keep_goals) for version in source.revisions]
    assert kinds == [(False, False), (False, False), (True, True)]
    again, result = forked(source, source.step_at(at_s))
    assert result.difference is None
    assert again.trace.sha256 == source.summary["trace_sha256"]


def test_a_change_after_a_revision_is_one_of_the_version_of_that_time(
    revised: Path, tmp_path: Path
) -> None:
    """Another tree is a further revision there; later recorded ones do not happen."""
    source = read_source(revised)
    step_ns = source.step_at(1.9)
    other = tmp_path / "other.yaml"
    other.write_text(THIRD.replace("wait: 2", "wait: 0.5") + "    - log: bye\n")
    change = edited(source, other, NO_PYTHON, step_ns)
    again, result = forked(source, step_ns, change)
    names = [node.name for node in again.executive.nodes]
    assert names == ["m", "log", "left", "pause", "late", "log"]
    assert (result.report.status, again.executive.revisions) == ("success", 3)
    assert result.same_events > 40
    assert source.seconds(step_ns) == pytest.approx(1.9, abs=0.05)


def test_a_revised_run_is_verified_with_the_nodes_of_each_version(
    revised: Path, tmp_path: Path
) -> None:
    """The verdicts are those of the run; a node of a later version can be named."""
    recorded = RecordedRequirements(revised)
    own = recorded.verify(recorded.own()).results
    assert [result.verdict for result in own] == ["holds", "holds"]
    file = tmp_path / "more.yaml"
    file.write_text(
        """requirements: {ends: 'eventually succeeded("late")', rests: 'never running("late")'}"""
    )
    results = recorded.verify(read_requirements([file], recorded.names)).results
    assert [result.verdict for result in results] == ["holds", "violated"]
