"""The file of a recorded robot, on the disk beside its MuJoCo model if it has one."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path

from bt_mission.base.output import make_folder_of, write_file
from bt_mission.base.yaml.document import Document, read, read_text


class RobotFiles:
    """The file of a robot, and those of its model in a folder that lives as long as this object.

    Args:
        name: Of the robot's file among all files.
        files: The recorded files, by their names.
    """

    def __init__(self, name: str, files: Mapping[str, bytes]) -> None:
        document = read_text(files[name].decode(errors="replace"), name)
        if isinstance(document.data, dict) and "model" in document.data:
            folder = Path(tempfile.mkdtemp(prefix="bt_mission_robot_")).resolve()
            weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
            for each, data in files.items():
                path = (folder / each).resolve()
                if path.is_relative_to(folder):
                    make_folder_of(path)
                    write_file(path, data)
            document = read(folder / name)
        self.document: Document = document
        """The robot's file."""
