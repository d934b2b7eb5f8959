"""Load a mission: from YAML, or from a format that a command adds for its suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from bt_mission.base.commands import loaded, points
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import SUFFIXES
from bt_mission.base.yaml.document import Document, read, read_text
from bt_mission.language.expressions.values import Plain
from bt_mission.language.loader import required
from bt_mission.language.message_types import FindShapes
from bt_mission.language.mission import Mission
from bt_mission.requirements.mission_file import read_mission

POINT = "mission_file"
"""The extension point of formats, which the suffix of their files follows."""

Source: TypeAlias = str | Path | Document
"""A mission: the path of its file; its text, which is YAML; or its parsed data.

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


@dataclass(frozen=True)
class MissionFormat:
    """A format of mission files besides YAML.

    Attributes:
        read: Reads a file. Raises InputError.
        read_text: Reads a text: that, the name of its file, and the texts of files that it
            includes, by their names. Raises InputError.
        to_yaml: Returns a file as YAML. Raises InputError for what YAML cannot express.
        from_yaml: Returns a mission in this format, with the lookup of the fields of ROS types.
            Raises InputError for what it cannot express.
    """

    read: Callable[[str | Path], Document]
    read_text: Callable[[str, str, Mapping[str, str]], Document]
    to_yaml: Callable[[str | Path], str]
    from_yaml: Callable[[Document, FindShapes | None], str]


def formats() -> Mapping[str, str]:
    """Return what has the format of mission files, by their suffix, but for YAML."""
    return points(POINT)


def suffixes() -> tuple[str, ...]:
    """Return the suffixes of mission files."""
    return (*SUFFIXES, *formats())


def format_of(suffix: str) -> MissionFormat | None:
    """Return the format of mission files with a suffix; None for those that are read as YAML."""
    target = formats().get(suffix)
    return None if target is None else loaded(target)


def document_of(source: Source) -> Document:
    """Read a mission, in the format of its suffix. Raises InputError."""
    if isinstance(source, Document):
        return source
    if isinstance(source, str) and ("\n" in source or source.lstrip().startswith("{")):
        return read_text(source)
    form = format_of(Path(source).suffix)
    return read(source) if form is None else form.read(source)


def document_of_text(text: str, name: str, texts: Mapping[str, str]) -> Document:
    """Read the text of a mission, in the format of the suffix of its file's name.

    Args:
        text: The text.
        name: Of its file, which need not exist.
        texts: Files that it includes, by their names.

    Raises:
        InputError: With every error.
    """
    form = format_of(Path(name).suffix)
    return read_text(text, name) if form is None else form.read_text(text, name, texts)


def convert(path: str | Path) -> str:
    """Return a mission file in its other form: XML for Groot 2 of YAML, YAML of XML.

    Raises:
        InputError: With each place that is wrong, or that the other form cannot express.
        BtMissionError: For a file with another suffix, or where no other form is installed.
    """
    suffix = Path(path).suffix
    form = format_of(suffix)
    if form is not None:
        return form.to_yaml(path)
    if suffix not in SUFFIXES or not formats():
        raise BtMissionError(
            f"{path}: expected a file with the suffix {', '.join(suffixes())}", code="BT-1103"
        )
    other: MissionFormat = loaded(next(iter(formats().values())))
    return other.from_yaml(read(path), installed_shapes())


def installed_shapes() -> FindShapes | None:
    """Return the lookup of fields of ROS types; None without ROS."""
    try:
        from bt_mission.ros.interface_types import shapes  # noqa: PLC0415 - only where ROS is there
    except ImportError:
        return None
    return shapes
