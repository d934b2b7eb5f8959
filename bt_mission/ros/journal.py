"""Opens the journal of a mission: a new one, or one to go on from."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.core.errors import BtMissionError
from bt_mission.executive.journal.file import JournalFile
from bt_mission.executive.journal.recorder import JournalRecorder
from bt_mission.executive.journal.recovery import Recovery
from bt_mission.executive.journal.state import JournalState, head_of, told
from bt_mission.language.mission import Mission
from bt_mission.ros.interface_types import message_type
from bt_mission.ros.mission_runner import MissionRunner


def open_journal(
    path: Path, mission: Mission, runner: MissionRunner, *, resume: bool
) -> JournalFile:
    """Write a journal from now on; close it after the mission's end.

    Args:
        resume: Go on with the mission that stands there.

    Raises:
        BtMissionError: When the file cannot be used for this mission.
    """
    head = head_of(mission, runner.node.get_namespace())
    if resume and not path.exists():
        raise BtMissionError(f"{path}: there is no journal to go on from")
    file = JournalFile(path)
    try:
        if resume:
            story = told(file.read(), head, path)
            runner.executive.resume_from(Recovery(story, runner, unpack))
            runner.requirements.resume(story.requirements)
        else:
            _refuse_what_matters(file)
            story = JournalState(head)
            file.rewrite([head])
        results = runner.requirements.results
        JournalRecorder(file, story, runner.executive, runner, pack, results)
    except BaseException:
        file.close()
        raise
    return file


def _refuse_what_matters(file: JournalFile) -> None:
    """Raise for a file that is not empty, and not the journal of a mission that has ended."""
    if file.path.stat().st_size == 0:
        return
    story = JournalState({})
    for record in file.read():
        story.take(record)
    if story.end is None:
        raise BtMissionError(
            f"{file.path}: a mission that has not ended stands there; go on with it by --resume, "
            "or delete the file"
        )


def pack(value: Any) -> dict[str, str] | None:
    """Return a message with its type as JSON; None for what is no message."""
    if not hasattr(type(value), "get_fields_and_field_types"):
        return None
    package, folder = type(value).__module__.split(".")[:2]
    data = base64.b64encode(serialize_message(value)).decode()
    return {"type": f"{package}/{folder}/{type(value).__name__}", "data": data}


def unpack(packed: dict[str, str]) -> Any:
    """Return the message.

    Raises:
        BtMissionError: When its type is not installed.
    """
    data = base64.b64decode(packed["data"])
    return deserialize_message(data, message_type(packed["type"]))
