"""Faults that a viewer makes in a running simulation."""

from __future__ import annotations

from pathlib import Path

from bt_mission.commands.fork.change import ForkChange
from bt_mission.commands.fork.source import read_source
from bt_mission.commands.fork.stage import forked_stage
from bt_mission.recording.writer import RunRecorder
from bt_mission.scenarios.faults.live import LiveFaults
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions

MISSION = """\
mission: m
world: empty_arena
tree: {turn: {angle: 90}, timeout: 10}
"""


def test_a_run_with_faults_of_viewers_is_the_run_with_the_same_planned(tmp_path: Path) -> None:
    """Its recording has them, and gives the same trace. Impossible ones change nothing."""
    path = tmp_path / "run.mcap"
    (tmp_path / "m.yaml").write_text(MISSION)
    options = StageOptions(props=MOST_OBSTACLES)
    with Stage(
        load(tmp_path / "m.yaml"), image_folder=tmp_path, say=lambda _: None, options=options
    ) as stage:
        faults = LiveFaults(stage)
        recorder = RunRecorder(stage, path)
        asked = ["spawn_box at (1, 0.5)", "spawn_box at (900, 0)", "no_such", "drop scan lasting 1"]
        while not stage.is_done:
            stage.step()
            if asked and stage.executive.cycles >= 10:
                faults.make(asked.pop(0))
        recorder.finish(stage.report(1.0).as_dict())
        lines = faults.take_lines()
    texts = [text for text, _ in faults.begun]
    assert [text.partition(": ")[2] for text in texts] == [
        "spawn_box at (1, 0.5)",
        "drop scan lasting 1",
    ]
    assert [at for _, at in faults.begun] == [(1.0, 0.5), None]
    assert len(lines) == 4, lines
    source = read_source(path)
    assert list(source.faults) == texts
    with forked_stage(source, ForkChange(), source.steps_ns[-1]) as (again, finish):
        while not again.is_done:
            again.step()
        assert finish(again.reports(1.0)).difference is None
        assert again.trace.sha256 == source.summary["trace_sha256"]
