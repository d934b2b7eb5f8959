"""The base of a sweep or a search: a mission or a scenario, with all its files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import find, is_scenario
from bt_mission.base.nature import USUAL, Nature
from bt_mission.base.yaml.document import Document, read
from bt_mission.language.expressions.values import Plain
from bt_mission.language.mission import Mission, NodeFactory
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.scenarios.concrete.bundle import Bundle, bundle_of
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario, concrete
from bt_mission.scenarios.concrete.ranges import Parameter
from bt_mission.scenarios.loader import ScenarioChanges, load_scenario
from bt_mission.sessions.check import examine
from sim.world.loader import load_world


@dataclass(frozen=True)
class BaseChanges:
    """Changes that apply to every scenario of a sweep, besides the file.

    Attributes:
        set: Inputs, as texts or values.
        requirements: Further ones, as a scenario file has them.
        faults: Further ones, as texts.
        simulator: None is that of the scenario, or else MuJoCo.
        nature: None is what scenario, mission or world say; where none of them does, the usual one.
        limit: Virtual seconds after which a run is interrupted; None is what the scenario says.
    """

    set: Mapping[str, Plain] = field(default_factory=dict)
    requirements: Mapping[str, Any] = field(default_factory=dict)
    faults: Sequence[str] = ()
    world: str | None = None
    robot: str | None = None
    simulator: NodeFactory | None = None
    nature: Nature | None = None
    limit: float | None = None
    permissions: Permissions = ANYTHING


@dataclass(frozen=True)
class BaseScenario:
    """The scenario that is varied.

    Attributes:
        path: Its file, or that of its mission.
        mission: The mission without any variation.
        data: The content of the scenario's file, with names of the bundle.
        bundle: All files.
        is_scenario: Whether it was written as one.
        changes: The user's changes besides the file.
    """

    path: Path
    mission: Mission
    data: Mapping[str, Any]
    bundle: Bundle
    is_scenario: bool
    changes: BaseChanges = field(default_factory=BaseChanges)

    def concrete(
        self,
        values: Mapping[str, Any],
        *,
        number: int = 0,
        seed: int | None = None,
        faults: Sequence[Any] = (),
        plan: str = "",
    ) -> ConcreteScenario:
        """Return the scenario with these values, as `concrete` makes it.

        Args:
            seed: None is that of the scenario or the mission.
        """
        seed = self.mission.seed if seed is None else seed
        return concrete(
            self.data, self.bundle, values, number=number, seed=seed, faults=faults, plan=plan
        )


def load_base(
    path: Path, changes: BaseChanges, parameters: Sequence[Parameter] = ()
) -> BaseScenario:
    """Load the base, and check it with the ends of each parameter.

    Raises:
        InputError: With every error of the file, and for parameters that it lacks.
    """
    worlds = {str(value) for each in parameters if each.name == "world" for value in each.ends}
    robots = _robots(path, parameters)
    # A mission for varied robots need not suit the robot that it would have without them.
    robot = next(iter(robots), None) if changes.robot is None else changes.robot
    given = ScenarioChanges(
        changes.set, None, changes.world, robot, permissions=changes.permissions
    )
    written = is_scenario(path)
    simulator = changes.simulator
    if written:
        scenario = load_scenario(path, given)
        simulator = simulator or scenario.simulator
        mission = scenario.mission
        data = _as_written(scenario.document)
    else:
        mission = _mission(path, given)
        data = {"scenario": mission.name}
    world = data.get("world", mission.world) if changes.world is None else changes.world
    if isinstance(world, str):
        beside = Path(path).parent / world
        world = str(beside) if written and beside.suffix and beside.is_file() else world
        worlds.add(world)
    bundle = bundle_of(mission, worlds, robots, simulator)
    if not isinstance(data.get("mission"), dict):
        data["mission"] = Path(bundle.mission).name
    if isinstance(world, str):
        data["world"] = bundle.worlds[world]
    data["robot"] = bundle.robots[mission.robot]
    if changes.set:
        own = data.get("inputs", {})
        data["inputs"] = {**own, **{name: mission.inputs[name] for name in changes.set}}
    data |= {} if simulator is None else {"simulator": simulator.target}
    _add(data, "requirements", changes.requirements)
    if changes.faults:
        data["faults"] = [*data.get("faults", ()), *changes.faults]
    if changes.nature is not None:
        data["nature"] = changes.nature.written
    elif "nature" not in data and not _says_nature(mission, worlds, data.get("world")):
        data["nature"] = USUAL.written
    if changes.limit is not None:
        data["limit"] = changes.limit
    return BaseScenario(Path(path), mission, data, bundle, written, changes)


def _says_nature(mission: Mission, worlds: Iterable[str], written: Any) -> bool:
    """Return whether the mission, or one of its worlds, sets the nature of runs."""
    natures = [load_world(find("worlds", world, mission.file)).nature for world in worlds]
    here = isinstance(written, dict) and "nature" in written
    return here or any(nature is not None for nature in (mission.nature, *natures))


def _add(data: dict[str, Any], key: str, more: Mapping[str, Any]) -> None:
    if more:
        data[key] = {**data.get(key, {}), **more}


def _as_written(document: Document) -> dict[str, Any]:
    data: dict[str, Any] = deepcopy(document.data)
    return data


def _robots(path: Path, parameters: Sequence[Parameter]) -> list[str]:
    """Return the robots that are varied, in their order.

    Raises:
        InputError: There is no such robot.
    """
    robots = [str(value) for each in parameters if each.name == "robot" for value in each.ends]
    for name in robots:
        find("robots", name, near=path)
    return robots


def _mission(path: Path, changes: ScenarioChanges) -> Mission:
    mission, faults = examine(
        path,
        changes.set,
        changes.seed,
        changes.world,
        changes.robot,
        permissions=changes.permissions,
    )
    if mission is None:
        raise InputError(faults)
    return replace(mission, warnings=(*mission.warnings, *faults)) if faults else mission


def requirements_in_files(paths: Sequence[Path]) -> dict[str, Any]:
    """Return the requirements of files, as written.

    Raises:
        InputError: A file is not a file of requirements.
    """
    requirements: dict[str, Any] = {}
    for path in paths:
        document = read(path)
        written = document.data.get("requirements") if isinstance(document.data, dict) else None
        if not isinstance(written, dict):
            message = "expected a mapping 'requirements:'"
            raise InputError([document.diagnostic("BT-111", (), message)])
        requirements |= written
    return requirements
