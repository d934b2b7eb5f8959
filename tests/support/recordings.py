"""Recordings for tests that look at them: a short mission on the stage, and pieces of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

from bt_mission.language.mission import Mission
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions

Message = tuple[Channel, int, bytes]

MISSION = """\
mission: there and back
world: empty_arena
seed: 3
inputs: {reach: 0.4}
tree:
  sequence:
    - log: off we go
    - repeat: {count: 2}
      do:
        sequence:
          - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
            name: drive
            cancel_when: current_distance_travelled >= reach
            on_cancel: success
            timeout: 30
            outputs: {closest_obstacle: room}
          - turn: {angle: 60}
            name: turn away
            timeout: 30
"""


@cache
def recording() -> Path:
    """A recorded run of the mission; made once."""
    path = Path(mkdtemp()) / "run.mcap"
    stage = recorded_run(load(MISSION), path)
    assert stage.executive.status == "success", stage.executive.reason
    return path


def recorded_run(mission: Mission, path: Path, options: StageOptions | None = None) -> Stage:
    """Run a mission on the stage, and record it. Return the stage, which is closed."""
    images = path.parent / "images"
    with (
        Stage(mission, image_folder=images, say=lambda _: None, options=options) as stage,
        RunRecorder(stage, path) as recorder,
    ):
        while not stage.is_done:
            stage.step()
        recorder.finish(stage.report(1.0).as_dict())
    return stage


def write_messages(file: McapFile, messages: Iterable[Message]) -> Path:
    """Write messages into a file, and close it; return its path."""
    numbers: dict[Channel, int] = {}
    for channel, time_ns, data in messages:
        if channel not in numbers:
            numbers[channel] = file.channel(
                channel.topic, channel.type_name, channel.definition, {}
            )
        file.write(time_ns, [(numbers[channel], data)])
    file.close()
    return file.path


def edited(path: Path, keep: Callable[[Channel, int], bool]) -> Path:
    """The messages that are kept, as another recorder would have written them."""
    messages = RecordedFile(recording()).messages()
    kept = (message for message in messages if keep(message[0], message[1]))
    return write_messages(McapFile(path, "another"), kept)


def with_facts(
    path: Path, changes: Mapping[str, str | None], of: Path | None = None, note: str = "bt_mission"
) -> Path:
    """The recording with other facts of its run; None leaves one out.

    Args:
        of: Another recording.
        note: The record of the facts.
    """
    source, copy = RecordedFile(of or recording()), McapFile(path, "bt-mission")
    messages = list(source.messages())
    facts = {**source.notes[note], **changes}
    for name, texts in source.notes.items() if of else ():
        if name != note:
            copy.note(name, dict(texts))
    copy.note(note, {name: text for name, text in facts.items() if text is not None})
    for attached in source.attached:
        copy.attach(attached.name, attached.media_type, attached.data, attached.time_ns)
    return write_messages(copy, messages)
