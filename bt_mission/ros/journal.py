"""Opens the journal of a mission: a new one, or one to go on from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.core.errors import BtMissionError
from bt_mission.executive.journal.file import JournalFile
from bt_mission.executive.journal.recorder import JournalRecorder
from bt_mission.executive.journal.recovery import Recovery
from bt_mission.executive.journal.state import JournalState, head_of, told
from bt_mission.ros.journal_messages import pack, unpack

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission
    from bt_mission.ros.mission_node import MissionNode


def open_journal(path: Path, mission: Mission, node: MissionNode, *, resume: bool) -> JournalFile:
    """Write a journal from now on; close it after the mission's end.

    :param resume: go on with the mission that stands there.
    :raises BtMissionError: when the file cannot be used for this mission.
    """
    head = head_of(mission, node.get_namespace())
    if resume and not path.exists():
        raise BtMissionError(f"{path}: there is no journal to go on from")
    file = JournalFile(path)
    try:
        if resume:
            story = told(file.read(), head, path)
            node.executive.resume_from(Recovery(story, node, unpack))
            JournalRecorder(file, story, node.executive, node, pack)
        else:
            _refuse_what_matters(file)
            story = JournalState(head)
            file.rewrite([head])
            JournalRecorder(file, story, node.executive, node, pack)
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
