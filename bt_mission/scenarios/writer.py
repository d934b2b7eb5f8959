"""The scenario of a run that a test has made, as far as it can be written as data."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import is_file, look_for
from bt_mission.base.yaml.document import read, read_text
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.executive.report import Report
from bt_mission.language.mission import Mission
from bt_mission.scenarios.faults.fault import Fault, FaultInstance
from bt_mission.scenarios.faults.faults import FAULTS
from bt_mission.scenarios.faults.planned import AfterStep, AtTime, Beginning, PlannedFault, Value
from bt_mission.scenarios.faults.text import parse_fault
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.scenarios.scenario import TIME_IS_UP
from bt_mission.sessions.own_nodes import name_of
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from sim.world.world import World

OBSERVER = "observer"
"""The node of a test that writes topics down; it changes nothing."""


DRAWN = frozenset(("share", "jitter"))
"""Arguments of faults that draw random numbers."""


class NotExpressibleError(BtMissionError):
    """A run has parts that cannot be written as data; `parts` describes each."""

    code = "BT-713"

    def __init__(self, parts: Sequence[str]) -> None:
        self.parts = tuple(parts)
        super().__init__("; ".join(parts))


class TestedRun(Protocol):
    """A run that a test has made."""

    mission: Mission
    stage: Stage
    options: StageOptions
    faults: list[FaultInstance]
    stopped_s: float | None
    """When the test ended it, s since the start; None if it ended alone."""

    @property
    def report(self) -> Report:
        """Its report."""


def scenario_text(run: TestedRun, name: str, folder: Path) -> str:
    """Return the scenario of a run that has ended.

    Args:
        name: Of the scenario.
        folder: Where it will be written; paths in it are relative to that.

    Raises:
        NotExpressibleError: With all parts that are not data.
    """
    refuse_inexpressible(run)
    report = run.report
    data: dict[str, Any] = {
        "scenario": name,
        **mission_as_data(run.mission, folder),
        "seed": run.mission.seed,
        **({"observe": run.mission.observe} if run.mission.observe else {}),
    }
    if isinstance(run.options.world, World):
        data["world"] = run.options.world.model_dump(mode="json")
    if run.options.start is not None:
        data["start"] = dict(zip(("x", "y", "yaw"), run.options.start, strict=True))
    if run.stage.runs[0].nature:
        data["nature"] = dict(run.stage.runs[0].nature)
    if run.faults:
        data["faults"] = [planned(fault).text for fault in run.faults]
    if run.stopped_s is not None:
        data["limit"] = run.stopped_s
    data["expect"] = {"outcome": report.status}
    if report.goals_left_behind:
        data["expect"]["orphaned_goals"] = report.goals_left_behind
    text = f"# Trace of the recorded run: {report.trace_sha256}\n"
    text += to_yaml(data)
    if read_text(text).data != data:
        raise NotExpressibleError(["texts that YAML reads as other values"])
    return text


def refuse_inexpressible(run: TestedRun) -> None:
    """Refuse a run that holds what is no data.

    Raises:
        NotExpressibleError: With all of it.
    """
    problems = [*_unusual(run)]
    for fault in run.faults:
        try:
            planned(fault)
        except NotExpressibleError as error:
            problems += error.parts
    try:
        mission_as_data(run.mission, Path())
    except NotExpressibleError as error:
        problems += error.parts
    if problems:
        raise NotExpressibleError(problems)


def planned(instance: FaultInstance) -> PlannedFault:
    """Return a fault that a run has had as data.

    Raises:
        NotExpressibleError: Where Python alone can say it.
    """
    fault = instance.fault
    if fault.what not in FAULTS:
        raise NotExpressibleError([f"{fault!r} is made by Python alone"])
    arguments = dict(_arguments(fault))
    lasting = fault.lasting
    if lasting is None and instance.is_ended_from_outside:
        if instance.is_ended_between:
            raise NotExpressibleError([f"{fault!r} was ended between two control steps"])
        if DRAWN & arguments.keys():
            raise NotExpressibleError(
                [f"{fault!r}, which draws by its `lasting`, was ended by the test"]
            )
        lasting = (instance.ended_ns - instance.began_ns) / 1e9 if instance.ended_ns else None
    planned_fault = PlannedFault(_beginning(instance), fault.what, arguments, lasting)
    try:
        again = parse_fault(planned_fault.text)
    except BtMissionError as error:
        raise NotExpressibleError([f"{fault!r}: {error}"]) from None
    if again != planned_fault:
        raise NotExpressibleError([f"{fault!r} cannot be written as text"])
    return planned_fault


def _beginning(instance: FaultInstance) -> Beginning:
    run = instance.run
    if instance.is_within_step or instance.began_ns == run.stage.start_ns:
        return AtTime(instance.began_s)
    return AfterStep(instance.began_s)


def _arguments(fault: Fault) -> Iterator[tuple[str, Value]]:
    """Yield the arguments of a fault, those of other names included."""
    kind = FAULTS[fault.what]
    for name, value in fault.parameters.items():
        if isinstance(value, Fault):
            yield name, value.obstacle
        elif not _is_data(value) or (name not in kind.parameters and not kind.takes_fields):
            raise NotExpressibleError([f"{fault!r}: '{name}' is no data"])
        else:
            yield name, _frozen(value)


def _is_data(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_is_data, value))
    return isinstance(value, bool | int | float | str)


def _frozen(value: Any) -> Value:
    return tuple(map(_frozen, value)) if isinstance(value, list | tuple) else value


def _unusual(run: TestedRun) -> Iterator[str]:
    """Yield what of the stage a scenario has no words for."""
    options = run.options
    if options.without:
        yield f"servers that the test plays: {', '.join(sorted(options.without))}"
    guests = set(run.stage.guests) - {OBSERVER}
    played = {f"scripted_{name}".replace("/", "_") for name in options.without}
    if guests - played:
        yield f"nodes of the test: {', '.join(sorted(guests - played))}"
    if options.nodes:
        yield f"nodes of the test: {', '.join(map(name_of, options.nodes))}"
    if options.simulator is not None:
        yield f"a simulator of the test: {name_of(options.simulator)}"
    if options.props != MOST_OBSTACLES:
        yield f"props={options.props}"
    if options.seed is not None or options.visible:
        yield "options of the stage"
    if run.report.status == "interrupted" and run.report.reason != TIME_IS_UP:
        yield f"an interruption by the test: {run.report.reason}"
    if run.stopped_s == 0:
        yield "a run without a step"


# ---- the mission and its place ---------------------------------------------------------------


def mission_as_data(mission: Mission, folder: Path) -> dict[str, Any]:
    """Return the keys of a scenario that name a mission, and what differs from its file.

    Args:
        folder: Where the scenario will be written; paths are relative to that.

    Raises:
        NotExpressibleError: With what is no data.
    """
    document = mission.document
    head = document.data if isinstance(document.data, Mapping) else {}
    data: dict[str, Any] = {}
    if is_file(Path(mission.file)):
        data["mission"] = _relative(Path(mission.file), folder)
    else:
        _refuse_files(head)
        data["mission"] = head
    if mission.world and mission.world != head.get("world"):
        data["world"] = _world(mission, folder)
    if mission.robot != head.get("robot", "waffle"):
        data["robot"] = mission.robot
    given = {
        name: value
        for name, value in mission.inputs.items()
        if value != head.get("inputs", {}).get(name)
    }
    return {**data, **({"inputs": given} if given else {})}


def _refuse_files(head: Mapping[str, Any]) -> None:
    """Refuse a mission as text that reads files beside the test."""
    if head.get("include"):
        raise NotExpressibleError(["the mission is a text that includes files"])
    if "python" in str(head) or head.get("nodes"):
        raise NotExpressibleError(["the mission is a text with Python code"])


def _world(mission: Mission, folder: Path) -> Any:
    """Return a world that is given instead of the mission's: its name or path."""
    assert mission.world is not None, "it is asked for where there is one"
    if not Path(mission.world).suffix:
        return mission.world
    path = look_for("worlds", mission.world, near=mission.file)
    if path is None:
        raise NotExpressibleError([f"the world {mission.world} does not exist any more"])
    is_temporary = path.name.startswith("world_")
    if not is_temporary:
        return _relative(path, folder)
    return read(path).data


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
