"""From an XML file to the text of a YAML file."""

from __future__ import annotations

from pathlib import Path

from bt_mission.btcpp.document import read_xml
from bt_mission.btcpp.yaml_text import yaml_text
from bt_mission.core.diagnostics import InputError
from bt_mission.language.loader import draft


def mission_yaml(path: str | Path) -> str:
    """Return an XML file as a YAML file. Raises InputError with everything that is wrong with it.

    What is read is a mission without faults; whether its goals fit the types of ROS is for `check`.
    """
    document = read_xml(path)
    found = draft(document)
    if found.faults:
        raise InputError(found.faults)
    return yaml_text(document.data)
