"""Files that an XML file includes: found, and never outside of the folder that they may lie in."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePath

from bt_mission.btcpp.elements import XmlSource, parse
from bt_mission.core.diagnostics import quoted
from bt_mission.core.errors import HintedError
from bt_mission.core.yaml.document import read_source
from bt_mission.language.trees import MOST_FILES


class IncludeError(HintedError):
    """A file that cannot be included."""


@dataclass
class Includes:
    """The files of one mission, each read once.

    Attributes:
        texts: Those that may be included, by name; None is the disk.
    """

    texts: Mapping[str, str] | None = None
    _read: set[str] = field(default_factory=set)

    def take(self, path: str, package: str | None, within: tuple[str, ...]) -> XmlSource | None:
        """Return what a file includes; None for a file that was included before.

        Args:
            path: As it is written.
            package: The ROS package whose share folder it lies in; None is the folder of the file
                that includes it.
            within: The files that include each other down to this place, the last one first.

        Raises:
            IncludeError: For a file that is not there, or may not be included.
            InputError: For a file that is no XML.
        """
        name = self._found(path, package, within[0])
        if name in within:
            ring = " -> ".join(PurePath(one).name for one in (*reversed(within), name))
            raise IncludeError(f"the files include each other: {ring}")
        if name in self._read:
            return None
        self._read.add(name)
        if len(self._read) > MOST_FILES:
            raise IncludeError(f"more than {MOST_FILES} files are included")
        return parse(read_source(name) if self.texts is None else self.texts[name], name)

    def _found(self, path: str, package: str | None, file: str) -> str:
        if self.texts is not None:
            beside = os.path.normpath(Path(file).parent / path)
            like = [name for name in self.texts if PurePath(name).match(path)]
            found = next((name for name in (beside, *like) if name in self.texts), None)
            if found is None:
                raise IncludeError(f"no such file {quoted(path)}")
            return found
        where = "the folder of the file that includes it" if package is None else "the package"
        folder = Path(file).parent if package is None else share_folder(package)
        try:
            if package is None and not Path(file).is_file():
                raise IncludeError("a mission in a text has no folder to include files from")
            real = (folder / path).resolve(strict=True)
            is_inside = real.is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError):  # a ring of links, a name that is too long
            raise IncludeError(f"no such file {quoted(path)} in {where}") from None
        if not is_inside:
            raise IncludeError(f"{quoted(path)} lies outside of {where}")
        if not real.is_file():
            raise IncludeError(f"{quoted(path)} is no file")
        return str(folder / path)


def share_folder(package: str) -> Path:
    """Return the share folder of a ROS package. Raises IncludeError where it is not installed."""
    try:
        from ament_index_python.packages import (  # noqa: PLC0415 - the rest works without ROS
            get_package_share_directory,
        )

        return Path(get_package_share_directory(package))
    except ImportError:
        raise IncludeError("ROS 2 is not there, so its packages are unknown") from None
    except (LookupError, ValueError, OSError):
        hint = "source the workspace that it is in, or copy the file beside this one"
        raise IncludeError(f"no ROS package {quoted(package)} is installed", hint) from None
