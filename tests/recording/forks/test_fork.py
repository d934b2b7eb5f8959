"""Forks without a change, at random instants of shipped missions."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from bt_mission.core.files import find
from bt_mission.core.nature import Nature, Profile
from bt_mission.recording.forks.change import ForkChange
from bt_mission.recording.forks.source import read_source
from bt_mission.recording.forks.stage import forked_stage
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from tests.support.thorough import sample


@pytest.mark.parametrize(
    ("name", "profile"),
    sample([("square", "usual"), ("explore", "none"), ("sweep", "harsh")], every=3),
)
def test_the_same_happens_again_wherever_it_is_forked(
    name: str, profile: Profile, tmp_path: Path
) -> None:
    """Byte for byte, to the end; campaigns/forks.py does it a thousand times."""
    path = tmp_path / "run.mcap"
    mission = load(find("missions", name))
    options = StageOptions(nature=Nature(profile))
    with Stage(mission, image_folder=tmp_path, say=lambda _: None, options=options) as stage:
        recorder = RunRecorder(stage, path)
        while not stage.is_done:
            stage.step()
        recorder.finish(stage.report(1.0).as_dict())
    source = read_source(path)
    for step_ns in random.Random(1).sample(list(source.steps_ns), 2):
        with forked_stage(source, ForkChange(), step_ns) as (again, finish):
            while not again.is_done:
                again.step()
            result = finish(again.reports(1.0))
            assert result.difference is None
            assert result.report.trace_sha256 == stage.trace.sha256
            assert again.trace.sha256 == source.summary["trace_sha256"]


def test_a_run_that_takes_too_long_is_interrupted(tmp_path: Path) -> None:
    """So that a search goes on."""
    path = tmp_path / "run.mcap"
    with Stage(
        load(find("missions", "square")), image_folder=tmp_path, say=lambda _: None
    ) as stage:
        recorder = RunRecorder(stage, path)
        while not stage.is_done:
            stage.step()
        recorder.finish(stage.report(1.0).as_dict())
    source = read_source(path)
    with forked_stage(source, ForkChange({"speed": 0.05}), source.steps_ns[9], limit_s=5.0) as (
        again,
        finish,
    ):
        while not again.is_done:
            again.step()
        report = finish(again.reports(1.0)).report
    assert (report.status, report.reason) == ("interrupted", "it had not ended after 5 s")
