"""Recorded runs, and a reader of them that is not ours."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.summary import Summary
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bt_mission.base.files import find
from bt_mission.recording.contents import RecordingOptions
from bt_mission.recording.file import McapFile
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

TWO_TURNS = """\
mission: two turns
world: empty_arena
seed: 3
tree:
  sequence:
    - log: off we go
    - turn: {angle: 90}
      timeout: 30
    - turn: {angle: -45}
      timeout: 30
      name: back
"""


@dataclass
class Received:
    """A message as the independent reader has it."""

    topic: str
    time_ns: int
    message: Any


def messages_for_others(path: Path, *topics: str) -> list[Received]:
    """Every message of a file, or of these topics, decoded by rosbags."""
    store = get_typestore(Stores.EMPTY)
    with Reader(path) as reader:
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        return [
            Received(connection.topic, time_ns, store.deserialize_cdr(data, connection.msgtype))
            for connection, time_ns, data in reader.messages()
            if not topics or connection.topic in topics
        ]


def summary_of(path: Path) -> Summary:
    """The summary of a file, read by the library of MCAP's makers."""
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return summary


@dataclass
class Recorded:
    """A run that has been recorded."""

    path: Path
    stage: Stage
    recorder: RunRecorder
    status: str
    trace: str


@pytest.fixture
def record(tmp_path: Path) -> Iterator[Callable[..., Recorded]]:
    """Run a mission on the stage: ``record("explore")``, ``record(text=..., camera="raw")``."""
    with ExitStack() as stages:

        def run(
            name: str = "",
            *,
            text: str = TWO_TURNS,
            camera: Any = "none",
            raw_actions: bool = False,
            file: McapFile | None = None,
            steps: int | None = None,
        ) -> Recorded:
            mission = load(find("missions", name)) if name else load(text)
            stages.close()
            stage = stages.enter_context(
                Stage(mission, image_folder=tmp_path / "images", say=lambda _: None)
            )
            path = tmp_path / "run.mcap"
            options = RecordingOptions(camera=camera, raw_actions=raw_actions)
            recorder = stages.enter_context(RunRecorder(stage, path, options, file=file))
            while not stage.is_done and (steps is None or steps > 0):
                stage.step()
                steps = None if steps is None else steps - 1
            if stage.is_done:
                recorder.finish(stage.report(1.0).as_dict())
            return Recorded(path, stage, recorder, str(stage.executive.status), stage.trace.sha256)

        yield run
