"""Load a mission, from YAML or XML, and convert one form into the other.

The modules for XML are imported when needed: most missions are YAML.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import SUFFIXES
from bt_mission.base.yaml.document import Document, read, read_text
from bt_mission.language.expressions.values import Plain
from bt_mission.language.loader import read_mission, required
from bt_mission.language.message_types import FindShapes
from bt_mission.language.mission import Mission

XML = ".xml"


Source: TypeAlias = str | Path | Document
"""A mission: the path of its file, YAML or XML; its text; or its parsed data.

A `str` is a text if it has several lines or is a mapping in braces, else a path.
"""


def load(
    source: Source,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
) -> Mission:
    """Return a mission. Raises InputError with all its errors.

    `set` gives inputs other values (texts are read as by `--set`); `seed`, `world` and `robot`
    replace those of the file. Neither ROS nor servers are used: `examine` also compares the mission
    with the types of ROS, the servers, its world and its robot.
    """
    return required(read_mission(document_of(source), set, seed, world, robot))


def document_of(source: Source) -> Document:
    """Read a mission: XML by the ending of its name, else YAML. Raises InputError."""
    if isinstance(source, Document):
        return source
    if isinstance(source, str) and ("\n" in source or source.lstrip().startswith("{")):
        return read_text(source)
    if Path(source).suffix != XML:
        return read(source)
    from bt_mission.commands.convert.document import read_xml  # noqa: PLC0415 - see the module's docstring

    return read_xml(source)


def convert(path: str | Path) -> str:
    """Return a mission file in its other form: XML for Groot 2 of YAML, YAML of XML.

    Raises:
        InputError: With each place that is wrong, or that the other form cannot express.
        BtMissionError: For a file with another suffix.
    """
    from bt_mission.commands.convert.document import mission_yaml  # noqa: PLC0415 - the same
    from bt_mission.commands.convert.mission_writer import mission_xml  # noqa: PLC0415 - the same

    suffix = Path(path).suffix
    if suffix == XML:
        return mission_yaml(path)
    if suffix not in SUFFIXES:
        raise BtMissionError(
            f"{path}: expected a file with the suffix {', '.join((*SUFFIXES, XML))}", code="BT-1103"
        )
    return mission_xml(read(path), installed_shapes())


def palette(path: str | Path | None = None) -> str:
    """Return the models of all leaves for Groot 2, with every attribute that a mission uses.

    Raises:
        InputError: With all errors of the mission, and with what XML cannot express.
    """
    from bt_mission.commands.convert.mission_writer import mission_palette  # noqa: PLC0415 - the same
    from bt_mission.commands.convert.palette import palette_xml  # noqa: PLC0415 - the same

    shapes = installed_shapes()
    return palette_xml(shapes) if path is None else mission_palette(document_of(path), shapes)


def installed_shapes() -> FindShapes | None:
    """Return the lookup of fields of ROS types; None without ROS."""
    try:
        from bt_mission.ros.interface_types import shapes  # noqa: PLC0415 - only where ROS is there
    except ImportError:
        return None
    return shapes
