"""The files of a case: world, mission, scenario, picture."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_mission.base.output import write_file
from bt_mission.base.yaml.document import read_text
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.commands.reproduce.comparison import RunEnd
from bt_mission.commands.reproduce.diagnosed import DiagnosedFault
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.scenario import Scenario

WORLD, MISSION = "world.yaml", "mission.yaml"


@dataclass
class CaseFiles:
    """The files of a case on their way.

    Attributes:
        name: Of its files.
        folder: Where they are written; it exists.
        head: The keys of the scenario besides its faults.
        verdict: The recorded end.
    """

    name: str
    folder: Path
    head: Mapping[str, Any]
    verdict: RunEnd
    faults: list[DiagnosedFault] = field(default_factory=list)

    @property
    def scenario_file(self) -> Path:
        """The scenario."""
        return self.folder / f"{self.name}.scenario.yaml"

    def text(self, faults: Sequence[PlannedFault], notes: Sequence[str] = ()) -> str:
        """Return the scenario with these faults."""
        data = dict(self.head)
        if faults:
            data["faults"] = [fault.text for fault in faults]
        expect: dict[str, Any] = {"outcome": self.verdict.outcome}
        if self.verdict.violated:
            expect["violated"] = list(self.verdict.violated)
        data["expect"] = {**expect, "orphaned_goals": "any"}
        return "".join(f"# {line}\n" for line in notes) + to_yaml(data)

    def scenario(self, faults: Sequence[PlannedFault]) -> Scenario:
        """Return the scenario with these faults, ready to run.

        Raises:
            InputError: With every error, such as a requirement that names no node of the mission.
        """
        return load_scenario(read_text(self.text(faults), str(self.scenario_file)))

    def write(self, faults: Sequence[PlannedFault], notes: Sequence[str]) -> None:
        """Write the scenario."""
        write_file(self.scenario_file, self.text(faults, notes))


def write_mission_files(folder: Path, files: Mapping[str, str], main: str) -> None:
    """Write the recorded files of a mission: its own as ``mission.yaml``, others beside it.

    Files outside of the mission's folder in the project keep their names below the folder.
    """
    write_file(folder / MISSION, files[main])
    place = str(Path(main).parent)
    for name, text in files.items():
        if name == main or name.startswith(("worlds/", "robots/")):
            continue
        relative = os.path.normpath(os.path.relpath(name, place))
        target = folder / relative
        if folder.resolve() not in target.resolve().parents:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        write_file(target, text)
