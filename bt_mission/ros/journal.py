"""Opens the journal of a mission: a new one, or one to resume from."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.executive.journal.recorder import JournalRecorder
from bt_mission.executive.journal.recovery import Recovery
from bt_mission.executive.journal.store import Journal
from bt_mission.language.mission import Mission
from bt_mission.ros.interface_types import message_type
from bt_mission.ros.mission_runner import MissionRunner


def open_journal(path: Path, mission: Mission, runner: MissionRunner, *, resume: bool) -> Journal:
    """Write a journal from now on; close it after the mission's end.

    Args:
        resume: Resume the mission of that journal.

    Raises:
        BtMissionError: The file cannot be used for this mission.
    """
    journal, state = Journal(path, must_exist=resume), None
    namespace = runner.node.get_namespace()
    try:
        if resume:
            state = journal.resume(mission, namespace)
            runner.executive.resume_from(Recovery(state, runner, unpack))
            runner.requirements.resume(state.requirements)
        else:
            journal.begin(mission, namespace)
        results = runner.requirements.results
        JournalRecorder(journal, state, runner.executive, runner, pack, results)
    except BaseException:
        journal.close()
        raise
    return journal


def pack(value: Any) -> dict[str, str] | None:
    """Return a message with its type as JSON; None for any other object."""
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
