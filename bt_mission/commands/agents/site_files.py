"""The files of a site, each read once: the bytes that are compared are those that are used."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_index import files_of
from bt_mission.base.files import Kind, find
from bt_mission.base.output import make_folder_of, within, write_file
from bt_mission.base.versions import versions
from bt_mission.base.yaml.document import Document, read_source, read_text


@dataclass(frozen=True)
class SiteFiles:
    """World and robot of a site, as they were read.

    Attributes:
        site: The text of the site's own file.
        model: The files of the robot's MuJoCo model, by their paths from the robot's file.
    """

    site: str
    world: Document
    robot: Document
    world_text: str
    robot_text: str
    model: Mapping[str, bytes]

    @classmethod
    def read(cls, file: Path, text: str, world: str, robot: str) -> Self:
        """Read the files that a site names.

        Args:
            file: That of the site.
            text: Its text.
            world: As the site names it.
            robot: As the site names it.

        Raises:
            BtMissionError: One of them is missing, or cannot be read.
        """
        (world_text, world_document), (robot_text, robot_document) = (
            _read("worlds", world, file),
            _read("robots", robot, file),
        )
        model = _model_of(Path(robot_document.file))
        return cls(text, world_document, robot_document, world_text, robot_text, model)

    @cached_property
    def digests(self) -> Mapping[str, str]:
        """SHA-256 of each file, by the words for it in messages; and the version of the program."""
        texts = {"the site": self.site, "the world": self.world_text, "the robot": self.robot_text}
        contents = {name: text.encode("utf-8", "surrogatepass") for name, text in texts.items()}
        contents |= {f"the robot's {name}": content for name, content in self.model.items()}
        return {
            **{name: hashlib.sha256(content).hexdigest() for name, content in contents.items()},
            "the version of bt-mission": versions()["bt-mission"],
        }

    def write_to(self, folder: Path) -> tuple[Path, Path]:
        """Write world and robot for commands; return their paths."""
        world = folder / "worlds" / Path(self.world.file).name
        robot = folder / "robots" / Path(self.robot.file).name
        contents: dict[Path, str | bytes] = {world: self.world_text, robot: self.robot_text}
        contents |= {within(robot.parent, name): each for name, each in self.model.items()}
        for path, content in contents.items():
            make_folder_of(path)
            write_file(path, content)
        return world.absolute(), robot.absolute()


def differing(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return the names whose values differ, as words; empty if all are equal."""
    names = {name: None for name in (*before, *now) if before.get(name) != now.get(name)}
    return " and ".join(names)


def _read(kind: Kind, name: str, near: Path) -> tuple[str, Document]:
    path = find(kind, name, near).absolute()
    text = read_source(path)
    return text, read_text(text, str(path))


def _model_of(robot: Path) -> dict[str, bytes]:
    """Return the files of a robot's MuJoCo model, by their paths from the robot's file."""
    try:
        return {
            each.relative_to(robot.parent).as_posix(): each.read_bytes()
            for each in files_of(robot)[1:]
        }
    except (OSError, ValueError) as error:
        raise BtMissionError(f"{robot}: cannot read its model: {error}", code="BT-101") from error
