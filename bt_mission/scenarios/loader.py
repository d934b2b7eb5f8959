"""From a scenario file to a scenario, or every error in it at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, in_order, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import Document, read
from bt_mission.language.checks.python_code import factory_diagnostics
from bt_mission.language.expressions.values import Plain
from bt_mission.language.mission import Mission, NodeFactory, node_factories
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.requirements.checks import MissionNames, diagnostics_of_names
from bt_mission.requirements.language.written import requirements_of
from bt_mission.scenarios.faults.planned import WhenTrue
from bt_mission.scenarios.file import ScenarioFile
from bt_mission.scenarios.scenario import Expectation, Scenario
from bt_mission.scenarios.servers import ServersReader
from bt_mission.scenarios.written_faults import FaultReader
from bt_mission.sessions.check import WorldAndRobot, has_camera
from bt_mission.sessions.goal_checks import OUR_SERVERS, ServerSettings
from bt_mission.sessions.named_files import NamedFiles
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from sim.world.loader import load_world
from sim.world.world import World


@dataclass(frozen=True)
class ScenarioChanges:
    """Values that replace those of a scenario file and its mission."""

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
        return None, error.diagnostics
    return _ScenarioLoader(document, changes or ScenarioChanges()).load()


class _ScenarioLoader:
    """Puts a scenario together, and collects what is wrong with its parts."""

    def __init__(self, document: Document, changes: ScenarioChanges) -> None:
        self._document = document
        self._changes = changes
        self._diagnostics: list[Diagnostic] = []
        self._files = NamedFiles(document, self._diagnostics, changes.permissions)

    def load(self) -> tuple[Scenario | None, tuple[Diagnostic, ...]]:
        document = self._document
        reader = NodeReader(document)
        written = reader.written(ScenarioFile, (), document.data)
        self._diagnostics += reader.diagnostics
        made = FaultReader(document)
        if isinstance(document.data, dict):
            for key, take in (("obstacles", made.obstacle), ("faults", made.fault)):
                several = document.data.get(key)
                for number, item in enumerate(several if isinstance(several, list) else ()):
                    take(item, (key, number))
        self._diagnostics += made.wrong
        self._diagnostics += (doubt for fault in made.faults for doubt in fault.doubts())
        if written is None:
            return None, in_order(self._diagnostics)
        has_world = self._changes.world is None and written.world is not None
        world = self._files.world(written.world, ("world",)) if has_world else None
        mission = self._mission(written, world)
        if mission is not None:
            mission = self._with_requirements(mission, written)
            if written.observe is not None:
                mission = replace(mission, observe=written.observe)
            nodes = node_factories(document, written.nodes)
            self._diagnostics += factory_diagnostics(nodes, self._changes.permissions)
            mission = replace(mission, nodes=(*mission.nodes, *nodes))
            self._check_names(mission, written, made)
            servers = ServersReader(document, mission)
            scripts = tuple(servers.read(written.servers))
            self._diagnostics += servers.diagnostics
            self._check_cameras(mission, made)
        if mission is None or self._has_errors():
            return None, in_order(self._diagnostics)
        start, simulator = written.start, self._simulator(written)
        self._check_start(mission, written, world)
        if self._has_errors():
            return None, in_order(self._diagnostics)
        scenario = Scenario(
            name=written.scenario,
            description=written.description,
            mission=mission,
            world=world,
            simulator=simulator,
            start=None if start is None else (start.x, start.y, start.yaw),
            nature=written.nature,
            faults=tuple(made.faults),
            servers=scripts,
            expect=_expectation(written),
            limit=written.limit,
            document=document,
        )
        return scenario, in_order(self._diagnostics)

    def _has_errors(self) -> bool:
        return any(diagnostic.severity == "error" for diagnostic in self._diagnostics)

    # ---- the mission and its place -------------------------------------------------------

    def _mission(self, written: ScenarioFile, world: World | None) -> Mission | None:
        changes = self._changes
        return self._files.mission(
            self._files.text_of(written.mission, ("mission",)),
            self._of_input,
            set={**written.inputs, **changes.set},
            seed=written.seed if changes.seed is None else changes.seed,
            world=changes.world,
            robot=changes.robot or written.robot,
            permissions=changes.permissions,
            servers=changes.servers,
            given=WorldAndRobot(world),
        )

    def _simulator(self, written: ScenarioFile) -> NodeFactory | None:
        """Return the simulator that the file names, and note its errors."""
        if written.simulator is None:
            return None
        simulator = NodeFactory(written.simulator, self._document, ("simulator",))
        self._diagnostics += factory_diagnostics([simulator], self._changes.permissions)
        return simulator

    def _of_input(self, name: str, fault: Diagnostic) -> Diagnostic:
        """Return an error of an input's value with the place where the value was given."""
        if name in self._changes.set:
            return fault
        return self._document.diagnostic(fault.code, ("inputs", name), fault.message, fault.hint)

    def _check_start(self, mission: Mission, written: ScenarioFile, world: World | None) -> None:
        """Note a start beside the floor of the world."""
        start = written.start
        if start is None:
            return
        try:
            world = world or load_world(mission.world or DEFAULT_WORLD, near=mission.file)
        except BtMissionError:
            return  # reported where the world is named
        length, width = world.size
        if abs(start.x) > length / 2 or abs(start.y) > width / 2:
            message = f"({start.x:g}, {start.y:g}) is outside the world '{world.name}', which is "
            message += f"{length:g} m by {width:g} m around (0, 0)"
            self._diagnostics.append(self._document.diagnostic("BT-709", ("start",), message))

    # ---- what names parts of the mission -------------------------------------------------

    def _with_requirements(self, mission: Mission, written: ScenarioFile) -> Mission:
        known = {requirement.name for requirement in mission.requirements}
        for name in written.requirements.keys() & known:
            message = f"the mission already has a requirement {quoted(name)}"
            self._diagnostics.append(
                self._document.diagnostic("BT-208", ("requirements", name), message, key=True)
            )
        self._diagnostics += diagnostics_of_names(self._document, MissionNames(mission))
        added = requirements_of(written.requirements)
        return replace(mission, requirements=(*mission.requirements, *added))

    def _check_cameras(self, mission: Mission, made: FaultReader) -> None:
        cameras = [fault for fault in made.faults if fault.name.startswith("camera_")]
        if cameras and not has_camera(mission):
            for fault in cameras:
                name = fault.name
                message = f"{name}: the robot '{mission.robot}' has no camera"
                self._diagnostics.append(fault.locate("BT-508", message, None, name))

    def _check_names(self, mission: Mission, written: ScenarioFile, made: FaultReader) -> None:
        names = MissionNames(mission)
        for fault in made.faults:
            begins = fault.begins
            if isinstance(begins, WhenTrue):
                for error in names.unknown_in(begins.condition.root):
                    self._diagnostics.append(
                        fault.locate(
                            error.code,
                            error.message,
                            error.hint,
                            begins.condition.text,
                            error.column - 1,
                        )
                    )
            leaf = fault.arguments.get("leaf")
            if isinstance(leaf, str) and names.lacks(leaf):
                message = f"unknown node {quoted(leaf)}"
                self._diagnostics.append(fault.locate("BT-705", message, names.near(leaf), leaf))
        expect = written.expect
        if expect.failed and names.lacks(expect.failed):
            message = f"unknown node {quoted(expect.failed)}"
            hint = names.near(expect.failed)
            self._diagnostics.append(
                self._document.diagnostic("BT-705", ("expect", "failed"), message, hint)
            )
        known = [requirement.name for requirement in mission.requirements]
        for number, name in enumerate(expect.violated):
            if name not in known:
                message = f"unknown requirement {quoted(name)}"
                path = ("expect", "violated", number)
                self._diagnostics.append(
                    self._document.diagnostic("BT-705", path, message, did_you_mean(name, known))
                )
        for fault in made.faults:
            time_s = getattr(fault.begins, "time_s", 0.0)
            if time_s >= written.limit:
                message = f"{time_s:g} s is past the limit of the scenario, {written.limit:g} s"
                self._diagnostics.append(fault.locate("BT-705", message))


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
