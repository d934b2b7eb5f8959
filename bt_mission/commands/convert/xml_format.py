"""The XML of BehaviorTree.CPP as a format of mission files."""

from __future__ import annotations

from pathlib import Path

from bt_mission.commands.convert.document import document_of as document_of_text
from bt_mission.commands.convert.document import mission_yaml, read_xml
from bt_mission.commands.convert.mission_writer import mission_palette, mission_xml
from bt_mission.commands.convert.palette import palette_xml
from bt_mission.sessions.load import MissionFormat, document_of, installed_shapes

XML_FORMAT = MissionFormat(read_xml, document_of_text, mission_yaml, mission_xml)


def palette(path: str | Path | None = None) -> str:
    """Return the models of all leaves for Groot 2, with every attribute that a mission uses.

    Raises:
        InputError: With all errors of the mission, and with what XML cannot express.
    """
    shapes = installed_shapes()
    return palette_xml(shapes) if path is None else mission_palette(document_of(path), shapes)
