"""Recordings for tests that look at them: a short mission on the stage, and pieces of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile

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
    from bt_mission.recording.writer import RunRecorder  # noqa: PLC0415
    from bt_mission.sessions.load import load  # noqa: PLC0415 - after the environment is set
    from bt_mission.sessions.stage import Stage  # noqa: PLC0415

    folder = Path(mkdtemp())
    path = folder / "run.mcap"
    with (
        Stage(load(MISSION), image_folder=folder, say=lambda _: None) as stage,
        RunRecorder(stage, path) as recorder,
    ):
        while not stage.is_done:
            stage.step()
        assert stage.executive.status == "success", stage.executive.reason
        recorder.finish(stage.report(1.0).as_dict())
    return path


def edited(path: Path, keep: Callable[[Channel, int], bool]) -> Path:
    """The messages that are kept, as another recorder would have written them."""
    source, copy = RecordedFile(recording()), McapFile(path, "another")
    numbers: dict[Channel, int] = {}
    for channel, time_ns, data in source.messages():
        if keep(channel, time_ns):
            if channel not in numbers:
                numbers[channel] = copy.channel(
                    channel.topic, channel.type_name, channel.definition, {}
                )
            copy.write(time_ns, [(numbers[channel], data)])
    copy.close()
    return path


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
    numbers: dict[Channel, int] = {}
    for channel, time_ns, data in messages:
        if channel not in numbers:
            numbers[channel] = copy.channel(
                channel.topic, channel.type_name, channel.definition, {}
            )
        copy.write(time_ns, [(numbers[channel], data)])
    copy.close()
    return path
