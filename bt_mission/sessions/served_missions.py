"""The missions that clients of ``execute_mission`` may run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base import files
from bt_mission.base.diagnostics import listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read_text
from bt_mission.language.loader import required
from bt_mission.language.permissions import Permissions, PythonUse, is_within
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import Source, suffixes

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission

TEXT_PERMISSIONS = Permissions(
    folders=(),
    includes=False,
    python="refuse",
    hint="a mission sent as text cannot use other files or Python code; a mission in a served "
    "folder can",
)
NO_PYTHON = "start `serve` with --allow-python to import the leaves of its folders"
NO_TEXT = (
    "missions sent as text are not accepted; put the mission in a served folder and send its "
    "path, or start `serve` with --allow-text"
)


@dataclass(frozen=True)
class ServedMissions:
    """The missions that clients may run: by default none.

    Attributes:
        folders: Whose missions, at any depth; links are followed before that is judged.
        allow_python: May they have Python leaves, from files of these folders?
        allow_text: May a goal bring a mission in its text? It uses no files and no Python code.
    """

    folders: tuple[Path, ...] = ()
    allow_python: bool = False
    allow_text: bool = False

    @property
    def python(self) -> PythonUse:
        """How Python leaves of these missions are handled."""
        return "import" if self.allow_python else "refuse"

    def load(self, goal: Any) -> Mission:
        """Return the mission of a goal of ``execute_mission``, by name or text, checked.

        Raises:
            InputError: With every error.
            BtMissionError: The mission is not offered; or the goal has neither or both, or an
                invalid seed.
        """
        if bool(goal.path) == bool(goal.text):
            raise BtMissionError("expected either a path or a text in the goal", code="BT-909")
        if goal.text and not self.allow_text:
            raise BtMissionError(NO_TEXT, code="BT-909")
        if goal.seed < -1:
            raise BtMissionError(
                f"seed: expected an integer from 0, or -1, got {goal.seed}", code="BT-909"
            )
        values = dict[str, str]()
        for text in goal.inputs:
            name, equals, value = text.partition("=")
            if not name or not equals:
                raise BtMissionError(
                    f"inputs: expected NAME=VALUE, got {quoted(text)}", code="BT-909"
                )
            values[name] = value
        seed = None if goal.seed < 0 else int(goal.seed)
        if goal.text:
            source: Source = read_text(goal.text)
            permissions = TEXT_PERMISSIONS
        else:
            source = self.find(goal.path)
            permissions = Permissions(
                self.folders,
                python=self.python,
                constructs=self.allow_python,
                hint=None if self.allow_python else NO_PYTHON,
            )
        return required(examine(source, values, seed, servers=None, permissions=permissions))

    def begin(self, _goal: Any, loaded: Mission) -> Mission:
        """Return the mission to start now, of a goal that was loaded when it came.

        Raises:
            BtMissionError: It may not start any more.
        """
        return loaded

    def find(self, wanted: str) -> Path:
        """Return the file of a mission: a path from a folder, or as `run` takes it; or a name.

        Raises:
            BtMissionError: The mission is not in the folders; the message is the same if it exists
                elsewhere.
        """
        path = Path(wanted)
        named = [path]
        if path.name and path.suffix not in suffixes():
            named = [path.with_name(f"{path.name}{suffix}") for suffix in files.SUFFIXES]
        for name in named:
            for candidate in (name, *(folder / name for folder in self.folders)):
                if is_within(candidate, self.folders) and files.is_file(candidate):
                    return candidate
        if not self.folders:
            raise BtMissionError(
                "no folder of missions is served; start `serve` with --missions DIR", code="BT-909"
            )
        where = "in the folders that are served"
        raise BtMissionError(
            f"{quoted(wanted)}: no such mission {where} (known: {listed(self.names())}); "
            "start `serve` with --missions DIR to serve another folder",
            code="BT-110",
        )

    def names(self) -> list[str]:
        """Return the names of the missions right in the folders, sorted."""
        known = suffixes()
        paths = (path for folder in self.folders for path in folder.iterdir())
        return sorted({path.stem for path in paths if path.suffix in known and files.is_file(path)})


def folders_to_serve(chosen: Sequence[Path]) -> tuple[Path, ...]:
    """Return the folders whose missions to serve: the chosen ones, or the first of the usual ones.

    Raises:
        BtMissionError: A folder does not exist.
    """
    absent = next((folder for folder in chosen if not folder.is_dir()), None)
    if absent is not None:
        raise BtMissionError(f"--missions {absent}: no such folder", code="BT-101")
    usual = (folder for folder in files.folders("missions") if folder.is_dir())
    return tuple(chosen) or tuple(usual)[:1]
