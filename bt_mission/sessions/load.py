"""Load a mission file, YAML or XML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from bt_mission.btcpp.document import read_xml
from bt_mission.core.yaml.document import Document, read
from bt_mission.language.expressions.values import Plain
from bt_mission.language.loader import draft, finished
from bt_mission.language.mission import Mission

XML = ".xml"


def load(
    path: str | Path,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
) -> Mission:
    """Return the mission in a file, YAML or XML. Raises InputError with all its faults.

    `set` gives inputs other values (texts are read as `--set` reads them); `seed`, `world` and
    `robot` replace what the file says. ROS types, worlds and robots are not looked at here:
    that is for `check`.
    """
    return finished(draft(read_mission(path), set, seed, world, robot))


def read_mission(path: str | Path) -> Document:
    """Read a mission file: XML where its name says so, else YAML. Raises InputError."""
    return read_xml(path) if Path(path).suffix == XML else read(path)
