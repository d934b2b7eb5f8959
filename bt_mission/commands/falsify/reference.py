"""A correct mission: a failure that it shares is not a counterexample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find
from bt_mission.commands.falsify.candidate import Candidate, given_world
from bt_mission.commands.falsify.guide import BRANCH, Guide
from bt_mission.scenarios.concrete.base_scenario import BaseScenario, load_base
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.concrete.worker import ScenarioRunner, ScenarioWorker

OF_THE_MISSION = ("scenario", "description", "mission", "inputs", "world", "robot", "requirements")
"""Keys of a scenario that are not taken over as they are."""


@dataclass(frozen=True)
class Reference:
    """A correct mission in place of the one that is searched.

    Attributes:
        base: The mission in the scenario that is varied.
        runner: Runs scenarios of its bundle.
    """

    base: BaseScenario
    runner: ScenarioRunner

    async def passes(self, candidate: Candidate, guide: Guide) -> bool:
        """Return whether it runs in a candidate's scenario without a failure of the aim."""
        async for row in self.runner.rows([candidate.concrete(self.base, 0)]):
            return not row.is_error and guide.is_assumed(row) and not guide.failures(row)
        return False


def load_reference(path: Path, base: BaseScenario, ranges: RangesFile) -> BaseScenario:
    """Load a mission in the scenario of another: the same place, faults and requirements.

    The requirements of the mission count as well.

    Raises:
        InputError: With every error of its file, and for inputs of the ranges that it lacks.
        BtMissionError: It does not fit the scenario: a requirement names a node that it lacks, for
            example.
    """
    robot = str(find("robots", base.mission.robot, near=base.mission.file).resolve())
    changes = replace(base.changes, world=_place(base), robot=robot, requirements={})
    own = load_base(path, replace(changes, faults=(), limit=None), ranges.parameters)
    ranges.check_inputs(own.mission)
    kept = {key: value for key, value in base.data.items() if key not in OF_THE_MISSION}
    data = {**own.data, **kept}
    inputs = base.data.get("inputs", {})
    if taken := {name: value for name, value in inputs.items() if name in own.mission.inputs}:
        data["inputs"] = {**data.get("inputs", {}), **taken}
    if isinstance(base.data.get("world"), dict):
        data["world"] = base.data["world"]
    known = {requirement.name for requirement in own.mission.requirements}
    wanted: dict[str, Any] = {
        requirement.name: {"formula": requirement.text, "on_violation": requirement.on_violation}
        for requirement in base.mission.requirements
    }
    wanted |= {
        name: text
        for name, text in base.data.get("requirements", {}).items()
        if not name.startswith(BRANCH)
    }
    more = {name: value for name, value in wanted.items() if name not in known}
    data["requirements"] = {**own.data.get("requirements", {}), **more}
    made = replace(own, data=data)
    try:
        with ScenarioWorker(made.bundle) as worker:
            worker.load(made.concrete({}))
    except InputError as error:
        message = "; ".join(each.message for each in error.diagnostics if each.severity == "error")
        raise BtMissionError(
            f"{path}: does not fit the scenario: {message}", code="BT-711"
        ) from error
    return made


def _place(base: BaseScenario) -> str | None:
    """Return the file of a scenario's world; None if the scenario contains the world."""
    world = base.data.get("world")
    if not isinstance(world, str):
        return None
    return str(find("worlds", given_world(base, world), near=base.mission.file).resolve())
