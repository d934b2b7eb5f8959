"""The section ``requirements`` of mission files: missions are read with it."""

from __future__ import annotations

from bt_mission.language.loader import MissionLoader
from bt_mission.language.mission import Requirement
from bt_mission.language.node_reader import NodeReader
from bt_mission.requirements.checks import requirement_diagnostics
from bt_mission.requirements.language.written import RequirementsFile, requirements_of

KEY = "requirements"


def read_requirements(reader: NodeReader) -> tuple[Requirement, ...]:
    """Return the requirements at the head of a mission; the reader notes what is wrong in them."""
    data = reader.document.data
    if not isinstance(data, dict) or KEY not in data:
        return ()
    written = reader.written(RequirementsFile, (), {KEY: data[KEY]})
    return () if written is None else requirements_of(written.requirements)


read_mission = MissionLoader(read_requirements, requirement_diagnostics).read
"""`MissionLoader.read`, with requirements."""
