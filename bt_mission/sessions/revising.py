"""Reads a new version of a running mission that another process has sent.

The version comes as text, with the texts of the files that it includes: the executive reads no file
of the sender's choice. It may use the Python code that the running mission uses, and no other.

The API is :meth:`bt_mission.MissionRunner.revise` in this process, and the service ``~/revise``
(``bt_mission_interfaces/srv/ReviseMission``) from another one; `bt-mission revise` and the editor
use the service. A mission takes versions from other processes if it was started with `--editable`
(``editable`` of ``StageOptions``, ``AttachedOptions`` and ``MissionServerOptions``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.diagnostics import listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.language.loader import required
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.trees import all_steps
from bt_mission.sessions.check import WorldAndRobot, examine
from bt_mission.sessions.load import document_of_text

if TYPE_CHECKING:
    from sim.world.world import World

MOST_INCLUDED = 100
"""Files in one request."""


def read_revision(
    running: Mission,
    request: Any,
    permissions: Permissions = ANYTHING,
    place: World | None = None,
) -> Mission:
    """Return the new version of a running mission, checked with the world and robot of the run.

    Args:
        running: The running mission. Names of files count from its folder.
        request: Of ``bt_mission_interfaces/srv/ReviseMission``.
        permissions: What the running mission may use.
        place: The world that it runs in; None is that which the running mission names.

    Raises:
        InputError: With every error.
        BtMissionError: It uses Python code that the running mission does not use.
    """
    if len(request.include_names) != len(request.include_texts):
        raise BtMissionError("expected a text for each included file", code="BT-908")
    if len(request.include_names) > MOST_INCLUDED:
        raise BtMissionError(f"more than {MOST_INCLUDED} included files", code="BT-908")
    folder = Path(running.file).parent
    name = str(folder / (Path(request.file).name or "revision.yaml"))
    texts = {
        str(folder / include): text
        for include, text in zip(request.include_names, request.include_texts, strict=True)
    }
    permissions = replace(
        permissions,
        texts=texts,
        python="refuse" if permissions.python == "refuse" else "name",
    )
    mission = required(
        examine(
            document_of_text(request.text, name, texts),
            world=running.world,
            robot=running.robot,
            servers=None,
            permissions=permissions,
            given=WorldAndRobot(world=place),
        )
    )
    known = set(_targets(running))
    other = [target for target in _targets(mission) if target not in known]
    if other:
        raise BtMissionError(
            f"the running mission does not use this Python code: {listed(map(quoted, other))}; "
            "a revision may only use code that the mission was started with",
            code="BT-908",
        )
    return mission


def _targets(mission: Mission) -> Iterator[str]:
    for step in all_steps(mission):
        if isinstance(step, PythonNode):
            yield step.target
