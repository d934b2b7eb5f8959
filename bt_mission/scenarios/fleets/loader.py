"""From a fleet file to a plan, or every error in it at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from bt_mission.base.diagnostics import (
    Diagnostic,
    InputError,
    did_you_mean,
    in_order,
    listed,
    quoted,
)
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find, look_for, names
from bt_mission.base.yaml.document import Document, read
from bt_mission.language.checks.python_code import factory_diagnostics
from bt_mission.language.expressions.values import Plain
from bt_mission.language.inputs import SET_OPTION
from bt_mission.language.mission import Mission, node_factories
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.requirements.checks import with_requirements
from bt_mission.robots.model import load_robot
from bt_mission.scenarios.fleets.file import FleetFile, FleetRobotForm
from bt_mission.scenarios.fleets.plan import FleetPlan
from bt_mission.sessions.check import WorldAndRobot
from bt_mission.sessions.named_files import NamedFiles
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from bt_mission.sessions.stage_robot import FleetRobot
from sim.physics.spawn import MOST, NAME, RobotSpawn
from sim.robot.fit import SpawnError
from sim.simulation import Simulation
from sim.world.loader import load_world
from sim.world.world import Spawn, World


@dataclass(frozen=True)
class FleetChanges:
    """Values that replace those of a fleet file.

    Attributes:
        set: Values of inputs: ``legs`` of every mission that has it, ``robot1.legs`` of one robot.
        seed: Instead of all seeds of the file: of the sensors, and of the first mission; those of
            the others count up from it.
        world: Name or path of another world.
        observe: Virtual time after each mission's end, s; None for the value of the files.
        require: Files with further requirements, of every mission.
    """

    set: Mapping[str, Plain] = field(default_factory=dict)
    seed: int | None = None
    world: str | None = None
    observe: float | None = None
    require: Sequence[Path] = ()
    permissions: Permissions = ANYTHING


def load_fleet(source: str | Path | Document, changes: FleetChanges | None = None) -> FleetPlan:
    """Return the fleet in a file, which may be a shipped one, or in what was read of one.

    Raises:
        InputError: With all its errors.
    """
    fleet, faults = examine_fleet(source, changes)
    if fleet is None:
        raise InputError(faults)
    return fleet


def examine_fleet(
    source: str | Path | Document, changes: FleetChanges | None = None
) -> tuple[FleetPlan | None, tuple[Diagnostic, ...]]:
    """Load and check a fleet; return it with all warnings, or None with all errors."""
    try:
        document = source
        if not isinstance(document, Document):
            document = read(look_for("missions", document) or document)
    except InputError as error:
        return None, error.diagnostics
    return _FleetLoader(document, changes or FleetChanges()).load()


class _FleetLoader:
    """Puts a fleet together, and collects what is wrong with its parts."""

    def __init__(self, document: Document, changes: FleetChanges) -> None:
        self._document = document
        self._changes = changes
        self._diagnostics: list[Diagnostic] = []
        self._files = NamedFiles(document, self._diagnostics, changes.permissions)
        self._declared: dict[str, Mapping[str, object]] = {}
        """The inputs of the missions that could be read, by the names of the robots."""

    def load(self) -> tuple[FleetPlan | None, tuple[Diagnostic, ...]]:
        """Return it with all warnings, or None with all errors."""
        document = self._document
        reader = NodeReader(document)
        written = reader.written(FleetFile, (), document.data)
        self._diagnostics += reader.diagnostics
        if written is None:
            return None, in_order(self._diagnostics)
        self._check_names(written)
        if len(written.robots) > MOST:
            return None, in_order(self._diagnostics)
        world = None if written.world is None else self._files.world(written.world, ("world",))
        checked_in = self._world_name(written) if world or self._changes.world else None
        seed = written.seed if self._changes.seed is None else self._changes.seed
        missions = {
            name: self._mission(name, form, seed + number, checked_in, world)
            for number, (name, form) in enumerate(written.robots.items())
        }
        self._check_inputs(written)
        missions = self._required(
            {
                name: self._observed(robot_mission, written)
                for name, robot_mission in missions.items()
            }
        )
        if self._changes.world is not None:
            world = load_world(self._changes.world, near=document.file)
        elif written.world is None:
            world = _world_of(missions)
        nodes = node_factories(document, written.nodes)
        self._diagnostics += factory_diagnostics(nodes, self._changes.permissions)
        if world is None or self._has_errors():
            return None, in_order(self._diagnostics)
        robots = [
            _placed(name, mission, written.robots[name], world)
            for name, mission in missions.items()
            if mission is not None
        ]
        self._check_places(world, robots)
        if self._has_errors():
            return None, in_order(self._diagnostics)
        plan = FleetPlan(
            written.fleet,
            world,
            seed,
            tuple(robots),
            written.description,
            nodes,
            document=document,
        )
        return plan, in_order(self._diagnostics)

    def _has_errors(self) -> bool:
        return any(diagnostic.severity == "error" for diagnostic in self._diagnostics)

    def _note(
        self, code: str, path: tuple[str, ...], message: str, hint: str | None = None
    ) -> None:
        self._diagnostics.append(self._document.diagnostic(code, path, message, hint))

    def _check_names(self, written: FleetFile) -> None:
        if not 1 <= len(written.robots) <= MOST:
            self._note(
                "BT-707", ("robots",), f"expected 1 to {MOST} robots, got {len(written.robots)}"
            )
        for name in written.robots:
            if not NAME.fullmatch(name):
                message = "expected a name of small letters, digits and '_', such as robot1, got "
                message += f"{quoted(name)}: it is the namespace of the robot's topics"
                self._diagnostics.append(
                    self._document.diagnostic("BT-707", ("robots", name), message, key=True)
                )

    def _mission(
        self, name: str, form: FleetRobotForm, seed: int, world: str | None, own_world: World | None
    ) -> Mission | None:
        if form.robot is not None and not self._is_robot(name, form.robot):
            return None
        own = form.seed if self._changes.seed is None else None
        text = self._files.text_of(form.mission, ("robots", name, "mission"))
        if text is not None:
            inputs = text.data.get("inputs") if isinstance(text.data, dict) else None
            self._declared[name] = inputs if isinstance(inputs, dict) else {}
        declared, prefix = self._declared.get(name, {}), f"{name}."
        given = self._changes.set.items()
        shared = {input_name: value for input_name, value in given if input_name in declared}
        alone = {
            input_name.removeprefix(prefix): value
            for input_name, value in given
            if input_name.startswith(prefix)
        }

        def locate(input_name: str, fault: Diagnostic) -> Diagnostic:
            if input_name in alone:
                column = fault.column + len(prefix)
                return replace(fault, source=f"{prefix}{fault.source}", column=column)
            if input_name in shared:
                return fault
            return self._document.diagnostic(
                fault.code, ("robots", name, "inputs", input_name), fault.message, fault.hint
            )

        mission = self._files.mission(
            text,
            locate,
            set={**form.inputs, **shared, **alone},
            seed=seed if own is None else own,
            world=world,
            robot=None if form.robot is None else str(self._files.beside(form.robot) or form.robot),
            permissions=self._changes.permissions,
            given=WorldAndRobot(None if self._changes.world else own_world),
        )
        if mission is not None and mission.map == "unknown":
            message = f"the mission '{mission.name}' draws its map ('map: unknown'), which a robot "
            message += "of a fleet cannot"
            self._note(
                "BT-707", ("robots", name, "mission"), message, "run it alone, without a fleet"
            )
        return mission

    def _check_inputs(self, written: FleetFile) -> None:
        """Note the values for robots that are not there, and for inputs that no mission has."""
        if len(self._declared) < len(written.robots):
            return  # the inputs of some are not known
        known = sorted({input_name for inputs in self._declared.values() for input_name in inputs})
        for given, value in self._changes.set.items():
            robot, dot, _ = given.rpartition(".")
            source = f"{given}={value}"
            if dot and robot not in written.robots:
                message = (
                    f"unknown robot {quoted(robot)} (the fleet's robots: {listed(written.robots)})"
                )
                hint = did_you_mean(robot, written.robots)
                self._diagnostics.append(
                    Diagnostic("BT-707", message, SET_OPTION, 1, 1, source, hint)
                )
            elif not dot and given not in known:
                message = f"no mission has an input {quoted(given)} (their inputs: {listed(known)})"
                hint = did_you_mean(given, known)
                self._diagnostics.append(
                    Diagnostic("BT-310", message, SET_OPTION, 1, 1, source, hint)
                )

    def _observed(self, mission: Mission | None, written: FleetFile) -> Mission | None:
        chosen = written.observe if self._changes.observe is None else self._changes.observe
        return mission if mission is None or chosen is None else replace(mission, observe=chosen)

    def _required(self, missions: Mapping[str, Mission | None]) -> dict[str, Mission | None]:
        """Return missions with further requirements; errors of some name their robots."""
        revised: dict[str, Mission | None] = {}
        wrong: dict[Diagnostic, list[str]] = {}
        for name, mission in missions.items():
            try:
                revised[name] = mission and with_requirements(mission, self._changes.require)
            except InputError as error:
                for diagnostic in error.diagnostics:
                    wrong.setdefault(diagnostic, []).append(name)
        for diagnostic, robots in wrong.items():
            whose = "" if len(robots) == len(missions) else f" [{', '.join(robots)}]"
            self._diagnostics.append(replace(diagnostic, message=f"{diagnostic.message}{whose}"))
        return revised

    def _is_robot(self, name: str, robot: str) -> bool:
        path = ("robots", name, "robot")
        near = Path(self._document.file)
        try:
            file = find("robots", self._files.beside(robot) or robot, near)
            if not self._changes.permissions.allows(file, "robots"):
                message = f"{quoted(robot)} is outside of the folder, and is not read"
                self._note("BT-112", path, message)
                return False
            load_robot(file)
        except InputError as error:
            if any(diagnostic.line for diagnostic in error.diagnostics):
                self._diagnostics += error.diagnostics
            else:
                self._note(
                    "BT-110",
                    path,
                    f"no such robot: {quoted(robot)}",
                    did_you_mean(Path(robot).stem, names("robots")),
                )
            return False
        return True

    # ---- the world -------------------------------------------------------------------------

    def _world_name(self, written: FleetFile) -> str | None:
        """Return the world by which missions are checked; None is their own."""
        if self._changes.world is not None:
            return self._changes.world
        if not isinstance(written.world, str):
            return None
        return str(self._files.beside(written.world) or written.world)

    def _check_places(self, world: World, robots: list[FleetRobot]) -> None:
        spawns = [
            RobotSpawn(
                load_robot(robot.mission.robot, near=robot.mission.file),
                robot.name,
                Spawn(x=robot.x, y=robot.y, yaw=robot.yaw),
            )
            for robot in robots
        ]
        try:
            Simulation(world, spawns, seed=0)
        except SpawnError as error:
            start = ("robots", error.robot, "start")
            has_start = self._document.has(*start)
            hint = None if has_start else "without a 'start', a robot stands at the world's spawn"
            self._note("BT-803", start, str(error), hint)
        except BtMissionError as error:
            self._note("BT-803", ("robots",), str(error))


def _world_of(missions: Mapping[str, Mission | None]) -> World | None:
    """Return the world of the first mission, which is what a fleet without one has."""
    first = next((mission for mission in missions.values() if mission is not None), None)
    return None if first is None else load_world(first.world or DEFAULT_WORLD, near=first.file)


def _placed(name: str, mission: Mission, written: FleetRobotForm, world: World) -> FleetRobot:
    start = written.start or world.spawn
    return FleetRobot(name, mission, start.x, start.y, start.yaw)
