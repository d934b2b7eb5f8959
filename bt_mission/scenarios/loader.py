"""From a scenario file to a scenario, or every error in it at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bt_mission.core.diagnostics import Diagnostic, InputError, did_you_mean, in_order, quoted
from bt_mission.core.errors import BtMissionError
from bt_mission.core.files import is_file, is_scenario, look_for
from bt_mission.core.yaml.document import Document, read
from bt_mission.faults.planned import WhenTrue
from bt_mission.language.checks.requirements import MissionNames, faults_of_names
from bt_mission.language.expressions.values import Plain
from bt_mission.language.inputs import SET_OPTION
from bt_mission.language.mission import Mission
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.requirements.written import requirements_of
from bt_mission.scenarios.faults import FaultReader
from bt_mission.scenarios.file import ScenarioFile
from bt_mission.scenarios.scenario import Expectation, Scenario
from bt_mission.sessions.check import examine
from bt_mission.sessions.goal_checks import OUR_SERVERS, ServerSettings
from sim.world.loader import load_world, world_in
from sim.world.world import World


@dataclass(frozen=True)
class ScenarioChanges:
    """What replaces values of a scenario file, as of a mission's."""

    set: Mapping[str, Plain] = field(default_factory=dict)
    seed: int | None = None
    world: str | None = None
    robot: str | None = None
    permissions: Permissions = ANYTHING
    servers: ServerSettings | None = OUR_SERVERS


def load_scenario(
    source: str | Path | Document, changes: ScenarioChanges | None = None
) -> Scenario:
    """Return the scenario in a file, or in what was read of one.

    Raises:
        InputError: With all its errors.
    """
    scenario, faults = examine_scenario(source, changes)
    if scenario is None:
        raise InputError(faults)
    return scenario


def examine_scenario(
    source: str | Path | Document, changes: ScenarioChanges | None = None
) -> tuple[Scenario | None, tuple[Diagnostic, ...]]:
    """Load and check a scenario; return it with all warnings, or None with all errors."""
    try:
        document = source if isinstance(source, Document) else read(source)
    except InputError as error:
        return None, error.faults
    return _Loader(document, changes or ScenarioChanges()).load()


class _Loader:
    """Puts a scenario together, and collects what is wrong with its parts."""

    def __init__(self, document: Document, changes: ScenarioChanges) -> None:
        self._document = document
        self._changes = changes
        self._faults: list[Diagnostic] = []

    def load(self) -> tuple[Scenario | None, tuple[Diagnostic, ...]]:
        document = self._document
        reader = NodeReader(document)
        written = reader.written(ScenarioFile, (), document.data)
        self._faults += reader.faults
        made = FaultReader(document)
        if isinstance(document.data, dict):
            for key, take in (("obstacles", made.obstacle), ("faults", made.fault)):
                several = document.data.get(key)
                for number, one in enumerate(several if isinstance(several, list) else ()):
                    take(one, (key, number))
        self._faults += made.wrong
        if written is None:
            return None, in_order(self._faults)
        world = self._world(written.world)
        mission = self._mission(written)
        if mission is not None:
            mission = self._with_requirements(mission, written)
            self._check_names(mission, written, made)
        if mission is None or any(one.severity == "error" for one in self._faults):
            return None, in_order(self._faults)
        start = written.start
        scenario = Scenario(
            name=written.scenario,
            description=written.description,
            mission=mission,
            world=world,
            start=None if start is None else (start.x, start.y, start.yaw),
            faults=tuple(made.faults),
            expect=_expectation(written),
            limit=written.limit,
            document=document,
        )
        return scenario, in_order(self._faults)

    # ---- the mission and its place -------------------------------------------------------

    def _mission(self, written: ScenarioFile) -> Mission | None:
        changes = self._changes
        given: dict[str, Any] = {
            "set": {**written.inputs, **changes.set},
            "seed": written.seed if changes.seed is None else changes.seed,
            "world": changes.world,
            "robot": changes.robot or written.robot,
            "permissions": changes.permissions,
            "servers": changes.servers,
        }
        if isinstance(written.mission, dict):
            mission, faults = examine(self._document.under("mission"), **given)
        else:
            path = self._mission_file(written.mission)
            if path is None:
                return None
            mission, faults = examine(path, **given)
        self._faults += [self._of_inputs(one) for one in faults]
        return mission

    def _mission_file(self, name: str) -> Path | None:
        path = self._beside(name) or look_for("missions", name, near=self._document.file)
        if path is None:
            message = f"no such mission: {quoted(name)}, beside this file or among the shipped ones"
            self._faults.append(self._document.fault(("mission",), message))
        elif is_scenario(path):
            message = f"{quoted(name)} is a scenario; expected a mission"
            self._faults.append(self._document.fault(("mission",), message))
            return None
        return path

    def _beside(self, name: str) -> Path | None:
        """Return the file at a path from the scenario, whatever folder is the working one."""
        path = Path(self._document.file).parent / name
        return path if path.suffix and is_file(path) else None

    def _of_inputs(self, fault: Diagnostic) -> Diagnostic:
        """Return an error of `--set` at the input of the scenario that it is about."""
        inputs = self._document.data.get("inputs")
        if fault.file != SET_OPTION or not isinstance(inputs, dict):
            return fault
        name = fault.source.partition("=")[0]
        if name not in inputs or name in self._changes.set:
            return fault
        return self._document.fault(("inputs", name), fault.message, fault.hint)

    def _world(self, written: Any) -> World | None:
        """Return the world of the scenario; what is named is looked for beside it."""
        if self._changes.world is not None or written is None:
            return None
        try:
            if isinstance(written, dict):
                return world_in(self._document, ("world",))
            return load_world(self._beside(written) or written, near=self._document.file)
        except InputError as error:
            is_missing = not isinstance(written, dict) and not error.faults[0].line
            if is_missing:
                first = error.faults[0]
                self._faults.append(
                    self._document.fault(
                        ("world",), f"{quoted(written)}: {first.message}", first.hint
                    )
                )
            else:
                self._faults += error.faults
        except BtMissionError as error:
            self._faults.append(self._document.fault(("world",), str(error)))
        return None

    # ---- what names parts of the mission -------------------------------------------------

    def _with_requirements(self, mission: Mission, written: ScenarioFile) -> Mission:
        known = {one.name for one in mission.requirements}
        for name in written.requirements.keys() & known:
            message = f"the mission has a requirement {quoted(name)} already"
            self._faults.append(self._document.fault(("requirements", name), message, key=True))
        self._faults += faults_of_names(self._document, MissionNames(mission))
        added = requirements_of(written.requirements)
        return replace(mission, requirements=(*mission.requirements, *added))

    def _check_names(self, mission: Mission, written: ScenarioFile, made: FaultReader) -> None:
        names = MissionNames(mission)
        for fault in made.faults:
            begins = fault.planned.begins
            if isinstance(begins, WhenTrue):
                for error in names.unknown_in(begins.condition.root):
                    self._faults.append(
                        fault.locate(
                            error.message, error.hint, begins.condition.text, error.column - 1
                        )
                    )
            leaf = fault.planned.arguments.get("leaf")
            if isinstance(leaf, str) and names.lacks(leaf):
                message = f"no node is named {quoted(leaf)}"
                self._faults.append(fault.locate(message, names.near(leaf), leaf, 0))
        expect = written.expect
        if expect.failed and names.lacks(expect.failed):
            message = f"no node is named {quoted(expect.failed)}"
            hint = names.near(expect.failed)
            self._faults.append(self._document.fault(("expect", "failed"), message, hint))
        known = [one.name for one in mission.requirements]
        for number, name in enumerate(expect.violated):
            if name not in known:
                message = f"there is no requirement {quoted(name)}"
                path = ("expect", "violated", number)
                self._faults.append(self._document.fault(path, message, did_you_mean(name, known)))
        for fault in made.faults:
            time_s = getattr(fault.planned.begins, "time_s", 0.0)
            if time_s >= written.limit:
                message = f"{time_s:g} s is past the limit of the scenario, {written.limit:g} s"
                self._faults.append(fault.locate(message, None, "", 0))


def _expectation(written: ScenarioFile) -> Expectation:
    expect = written.expect
    return Expectation(
        outcome=expect.outcome,
        reason=expect.reason or "",
        failed=expect.failed or "",
        after=expect.after,
        before=expect.before,
        violated=tuple(expect.violated),
        orphaned_goals=None if expect.orphaned_goals == "any" else expect.orphaned_goals,
        collisions=expect.collisions,
    )
