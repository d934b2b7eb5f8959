"""Opens the journal of a mission: a new one, or one to resume from."""

from __future__ import annotations

import base64
from dataclasses import replace
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read_text
from bt_mission.executive.journal.recorder import JournalRecorder
from bt_mission.executive.journal.recovery import Recovery
from bt_mission.executive.journal.store import Journal, Key, rows_of_version
from bt_mission.language.loader import required
from bt_mission.language.mission import Mission
from bt_mission.language.permissions import Permissions
from bt_mission.requirements.mission_file import read_mission
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

        def version() -> dict[Key, Any]:
            return rows_of_version(runner.mission, namespace)

        JournalRecorder(journal, state, runner.executive, runner, pack, results, version)
    except BaseException:
        journal.close()
        raise
    return journal


def resumed_mission(path: Path, mission: Mission) -> Mission:
    """Return the newest version of the mission of a journal.

    Args:
        mission: As its file has it.

    Raises:
        BtMissionError: The journal cannot be read.
        InputError: The version in the journal has errors, on this machine.
    """
    journal = Journal(path, must_exist=True)
    try:
        state = journal.read()
    finally:
        journal.close()
    if state is None or state.about.revision is None or state.about.head.mission != mission.name:
        return mission
    head, sources = state.about.head, state.about.revision
    text = sources.texts.get(sources.file)
    if text is None:
        raise BtMissionError(f"{path}: lacks the text of {sources.file}", code="BT-906")
    revised = required(
        read_mission(
            read_text(text, sources.file),
            head.inputs,
            head.seed,
            mission.world,
            mission.robot,
            Permissions(texts=sources.texts),
        )
    )
    return replace(revised, requirements=mission.requirements, observe=mission.observe)


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
