"""A recording as the source of another run: all that its run depended on, and its trace."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.nature_field import read_nature
from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.base.verdicts import conclusion
from bt_mission.base.versions import versions
from bt_mission.base.yaml.document import Document, read_text
from bt_mission.commands.fork.robot_files import RobotFiles
from bt_mission.executive.trace import VERSION
from bt_mission.language.checks.mission import tree_diagnostics
from bt_mission.language.checks.python_code import factory_diagnostics
from bt_mission.language.loader import Examined, required
from bt_mission.language.mission import Mission, NodeFactory, node_factories
from bt_mission.language.nodes.fields import ProgramEntry
from bt_mission.language.permissions import Permissions
from bt_mission.language.places import zones_in
from bt_mission.language.revision import compare
from bt_mission.recording.facts import RunFacts, robot_of
from bt_mission.recording.reading import RecordedFile
from bt_mission.recording.recorded_messages import RecordedMessage, TraceLine, fold
from bt_mission.recording.signal_samples import requirements_in
from bt_mission.requirements.mission_file import read_mission
from bt_mission.sessions.load import document_of_text
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

ROUNDING_NS = 1_000
"""Times are given in seconds with decimals; a smaller difference is the same instant, ns."""

LAST_LINES = 4
"""The end of the mission is among this many last lines of a trace: a pose may follow it."""

NO_PYTHON = Permissions(
    python="refuse",
    hint="--import-python runs its author's code from this machine",
)


class ForkError(BtMissionError):
    """A recording that cannot run again, or not with this change."""

    code = "BT-1003"


@dataclass(frozen=True)
class RecordedRevision:
    """A revision of a recorded mission.

    Attributes:
        time_ns: When, ns.
        cycle: The number of cycles of the executive before it.
        line: The number of its line in the trace.
        is_after_step: Whether it happened after the control step, not in it.
        keep_goals: Whether leaves that ran and had changed continued with their earlier values.
        written: The version as its file has it.
        mission: The same with the inputs of the run.
    """

    time_ns: int
    cycle: int
    line: int
    is_after_step: bool
    keep_goals: bool
    written: Mission
    mission: Mission


@dataclass(frozen=True)
class ForkSource:
    """A recorded run, with all data to run it again.

    Args:
        path: Of the recording.
        name: Of the robot; empty where it is alone.
        mission: As it was recorded, whatever stands on the disk now.
        written: The same as its file has it, without what was overridden for the run.
        world: The text of the world.
        robot_files: The file of the robot, and those of its model.
        stage: The options of the simulation, as the recorder wrote them down.
        faults: What was made to go wrong, as it is written.
        trace: The lines of the recorded trace.
        events: Their fields; the first names the format, and has no event.
        steps_ns: When the control steps were, ns.
        start_ns: When the run began, ns.
        summary: The result of the run; empty if the recording was cut.
        why_cut: Why the recording ends before its end; empty where it does not.
        differences: What is of another version here, a line each.
        revisions: The revisions of the mission, in order.
        fleet: The name of the recorded fleet; empty of a robot alone.
        others: The other robots of the fleet.
    """

    path: Path
    name: str
    mission: Mission
    written: Mission
    world: Document
    robot_files: RobotFiles
    stage: Mapping[str, Any]
    faults: Sequence[str]
    trace: Sequence[str]
    events: Sequence[Mapping[str, Any]]
    steps_ns: Sequence[int]
    start_ns: int
    summary: Mapping[str, Any]
    why_cut: str
    differences: tuple[str, ...]
    revisions: tuple[RecordedRevision, ...] = ()
    fleet: str = ""
    others: tuple[ForkSource, ...] = ()

    @property
    def end_s(self) -> float:
        """The last control step, s since the start."""
        return self.seconds(self.steps_ns[-1])

    @property
    def outcome(self) -> tuple[str, str]:
        """The status of the run and its reason; for a cut recording, that it was cut."""
        for event in reversed(self.events[-LAST_LINES:]):
            if event.get("event") == "mission":
                return str(event.get("status")), str(event.get("reason"))
        return "unknown", f"the recording ends here{self.why_cut and ': '}{self.why_cut}"

    def mission_at(self, step_ns: int) -> Mission:
        """Return the version of the mission that ran before a control step."""
        earlier = [revised.mission for revised in self.revisions if revised.time_ns < step_ns]
        return earlier[-1] if earlier else self.mission

    @property
    def is_whole(self) -> bool:
        """Whether its trace is complete."""
        return self.outcome[0] != "unknown"

    @property
    def conclusion(self) -> tuple[str, str]:
        """The recorded verdict of the run, and its reason."""
        results = [
            SimpleNamespace(name=each["name"], verdict=each.get("verdict", ""))
            for each in self.requirements
        ]
        untested = [str(each["what"]) for each in self.events if each.get("event") == "untested"]
        return conclusion(*self.outcome, results, untested)

    @property
    def requirements(self) -> list[dict[str, Any]]:
        """The results of the requirements, if recorded."""
        recorded = self.summary.get("requirements", [])
        return [
            requirement
            for requirement in recorded
            if isinstance(requirement, dict) and "name" in requirement
        ]

    def seconds(self, time_ns: int) -> float:
        """A time of the run, s since its start."""
        return (time_ns - self.start_ns) / NS

    def step_at(self, at_s: float) -> int:
        """Return the control step at a time, or the next one after it, ns.

        Args:
            at_s: Time since the start, s.

        Raises:
            ForkError: The time is not within the run.
        """
        if at_s < 0:
            raise ForkError(f"--at {at_s:g}: the run begins at 0 s")
        wanted = self.start_ns + round(at_s * NS) - ROUNDING_NS
        for step_ns in self.steps_ns:
            if step_ns >= wanted:
                return step_ns
        what = "the run" if self.is_whole else "the recording"
        raise ForkError(f"--at {at_s:g}: {what} ends at {seconds(self.end_s)}")

    def options(self, props: int = 0) -> StageOptions:
        """Return the options of a stage, besides the mission.

        Args:
            props: The least number of obstacles that can appear.
        """
        start = None if self.name else self._recorded["start"]
        return StageOptions(
            world=self.world,
            seed=self.stage["sensor_seed"],
            start=None if start is None else (start[0], start[1], start[2]),
            props=max(props, self.stage["props"]),
            watched=self.stage["has_tools"],
        )

    def member(self, mission: Mission) -> FleetRobot:
        """The robot for a stage, with what nature has drawn for it.

        Args:
            mission: That it runs.
        """
        x, y, yaw = self._recorded["start"] or (0.0, 0.0, 0.0)
        nature = read_nature(self._recorded["nature"])
        return FleetRobot(
            self.name, replace(mission, nature=nature), x, y, yaw, self.robot_files.document
        )

    @property
    def _recorded(self) -> Mapping[str, Any]:
        recorded: Mapping[str, Any] = self.stage["robots"][self.names.index(self.name)]
        return recorded

    @property
    def names(self) -> list[str]:
        """The robots of the fleet, in order."""
        return [robot["name"] for robot in self.stage["robots"]]


def read_source(
    path: Path, permissions: Permissions = NO_PYTHON, robot: str | None = None
) -> ForkSource:
    """Read a recording, to run it again.

    Args:
        robot: The robot of a fleet; None is the first. The others are among its `others`.

    Raises:
        RecordingError: The file is invalid or cannot be opened, or the robot is not in it.
        ForkError: The run cannot run again, with what is missing.
        InputError: A mission, world or robot in it cannot be read by this version.
    """
    source = _read(path, permissions, robot)
    others = (_read(path, permissions, name) for name in source.names if name != source.name)
    return replace(source, others=tuple(others))


def _read(path: Path, permissions: Permissions, robot: str | None) -> ForkSource:
    """Read the recording of one robot.

    Raises:
        RecordingError: The file is invalid or cannot be opened.
        ForkError: The run cannot run again, with what is missing.
        InputError: A mission, world or robot in it cannot be read by this version.
    """
    file = RecordedFile(path, robot)
    lines = _trace_of(file)
    facts = file.facts
    stage = _stage_of(path, facts, file.why_cut)
    if not lines:
        raise ForkError(f"{path}: contains no trace of the run{_cut(file.why_cut)}")
    events = [_event(line) for line in lines]
    version = events[0].get("trace_version")
    if version is None:
        raise ForkError(f"{path}: starts in the middle of the run; record the run from its start")
    if version != VERSION:
        raise ForkError(
            f"{path}: its trace has version {version}, and this bt-mission writes {VERSION}"
        )
    steps = tuple(event["t"] for event in events if event.get("event") == "pose")
    if not steps:
        raise ForkError(f"{path}: ends before the first control step{_cut(file.why_cut)}")
    written, mission = _missions_of(file, facts, permissions)
    return ForkSource(
        path=path,
        name=robot_of(facts.node),
        mission=mission,
        written=written,
        world=_text_of(file, "world", "worlds/"),
        robot_files=_robot_of(file, f"robots/{Path(mission.robot).stem}."),
        stage=stage,
        faults=facts.faults,
        trace=lines,
        events=events,
        steps_ns=steps,
        start_ns=facts.start_ns or 0,
        summary=facts.summary,
        why_cut=file.why_cut,
        differences=tuple(_other_versions(facts.versions)),
        revisions=tuple(_revisions_of(file, facts, events, mission, permissions)),
        fleet=facts.texts.get("fleet", ""),
    )


def _trace_of(file: RecordedFile) -> list[str]:
    lines: list[str] = []

    def take(_: int, happening: RecordedMessage) -> None:
        if isinstance(happening, TraceLine):
            lines.append(happening.text)

    fold(file, take)
    return lines


def _event(line: str) -> Mapping[str, Any]:
    try:
        event = json.loads(line)
    except (ValueError, RecursionError):
        event = None
    if not isinstance(event, dict) or ("event" in event and type(event.get("t")) is not int):
        raise ForkError(f"a line of the recorded trace is not an event: {line[:80]}")
    return event


def refusal(path: Path, facts: RunFacts, why_cut: str) -> str:
    """Return why a run cannot run again, by its facts; empty if it can."""
    try:
        _stage_of(path, facts, why_cut)
    except ForkError as error:
        return str(error)
    return ""


def _cut(why: str) -> str:
    return f" ({why})" if why else ""


def _stage_of(path: Path, facts: RunFacts, why_cut: str) -> Mapping[str, Any]:
    if not facts.texts:
        raise ForkError(
            f"{path}: contains no run of bt-mission; record one with `bt-mission run --record "
            f"FILE.mcap`{_cut(why_cut)}"
        )
    if "world" not in facts.texts:
        raise ForkError(
            f"{path}: has no seed: it was recorded on a running graph, and such a run cannot be "
            f"repeated"
        )
    stage = facts.stage
    if stage is None:
        by = facts.versions.get("bt-mission", "?")
        raise ForkError(
            f"{path}: lacks the files of world and robot and the options of the simulation: "
            f"recorded by an older bt-mission ({by}); record the run again"
        )
    if facts.texts.get("namespace", "/").strip("/") not in [
        robot["name"] for robot in stage["robots"]
    ]:
        raise ForkError(f"{path}: the recorded robots differ from those of the simulation")
    if stage["without"]:
        names = ", ".join(map(str, stage["without"]))
        raise ForkError(
            f"{path}: a test played the servers of {names}, which the recording does not contain"
        )
    if "simulator" in stage:
        raise ForkError(
            f"{path}: another simulator moved the robot, {stage['simulator']}; only runs in MuJoCo"
            " can be forked"
        )
    if made := [target for name, target, _ in stage["nodes"] if not name]:
        raise ForkError(f"{path}: needs nodes that a program created: {', '.join(made)}")
    if facts.changes:
        raise ForkError(
            f"{path}: it is itself a fork, of the run in {facts.texts.get('forked_from', '?')}: "
            "fork that one"
        )
    return stage


def _missions_of(
    file: RecordedFile, facts: RunFacts, permissions: Permissions
) -> tuple[Mission, Mission]:
    """Return the mission as its file has it, and as it was run."""
    texts = {
        attached.name: attached.data.decode(errors="replace")
        for attached in file.attached
        if attached.media_type == "text/plain"
    }
    name = facts.texts.get("file", "")
    if name not in texts:
        raise ForkError(f"{file.path}: lacks the mission file '{name}'")
    document = document_of_text(texts[name], name, texts)
    if isinstance(document.data, dict) and "fleet" in document.data:
        document = document.under("robots").under(robot_of(facts.node))
    if isinstance(document.data, dict) and isinstance(document.data.get("mission"), dict):
        document = document.under("mission")  # it was written in a scenario or a fleet
    seed = facts.texts.get("seed", "")
    if not seed.isdecimal():
        raise ForkError(f"{file.path}: has no seed")
    zones = zones_in(_text_of(file, "world", "worlds/").data)
    permissions = replace(permissions, texts=texts)
    check = partial(tree_diagnostics, permissions=permissions)
    written = required(read_mission(document, permissions=permissions, zones=zones))
    mission = required(
        read_mission(
            document,
            facts.inputs,
            int(seed),
            facts.texts.get("world"),
            facts.texts.get("robot"),
            permissions,
            zones,
            check,
        )
    )
    mission = replace(
        mission,
        nodes=(*mission.nodes, *_nodes_of(facts)),
        observe=float(facts.texts.get("observe", "0")),
        requirements=requirements_in(file),
    )
    faults = [*factory_diagnostics(mission.nodes, permissions)]
    if faults:
        raise InputError(faults)
    return written, mission


def _revisions_of(
    file: RecordedFile,
    facts: RunFacts,
    events: Sequence[Mapping[str, Any]],
    running: Mission,
    permissions: Permissions,
) -> Iterator[RecordedRevision]:
    """Yield each revision, with its mission.

    Raises:
        ForkError: Its files are missing.
        InputError: Its mission cannot be read by this version.
    """
    pose_ns = 0
    for line, event in enumerate(events):
        if event.get("event") == "pose":
            pose_ns = event["t"]
        if event.get("event") != "revised":
            continue
        version = required(_version_of(file, facts, event["number"], permissions))
        running = compare(running, version).after
        yield RecordedRevision(
            event["t"],
            event["cycle"],
            line,
            pose_ns == event["t"],
            event["keep_goals"],
            version,
            running,
        )


def _version_of(
    file: RecordedFile, facts: RunFacts, number: int, permissions: Permissions
) -> Examined:
    folder = f"revision_{number}/"
    if facts.stage is not None and len(facts.stage["robots"]) > 1:
        folder = f"{facts.node.strip('/').replace('/', '.')}/{folder}"
    texts = {
        attached.name.removeprefix(folder): attached.data.decode(errors="replace")
        for attached in file.attached
        if attached.media_type == "text/plain" and attached.name.startswith(folder)
    }
    if not texts:
        raise ForkError(f"{file.path}: lacks the files of revision {number}{_cut(file.why_cut)}")
    name = next(iter(texts))
    document = document_of_text(texts[name], name, texts)
    zones = zones_in(_text_of(file, "world", "worlds/").data)
    permissions = replace(permissions, texts=texts)
    check = partial(tree_diagnostics, permissions=permissions)
    return read_mission(document, permissions=permissions, zones=zones, check=check)


def _nodes_of(facts: RunFacts) -> Iterator[NodeFactory]:
    """Yield the factories of the user's nodes that the mission's file does not name."""
    stage = facts.stage
    assert stage is not None, "it was refused"
    for name, target, shown in stage["nodes"]:
        entry = ProgramEntry(target, shown) if shown else target
        yield from node_factories(read_text(json.dumps({"nodes": [target]}), name), [entry])


def _text_of(file: RecordedFile, what: str, prefix: str) -> Document:
    name, files = _attached(file, what, prefix)
    return read_text(files[name].decode(errors="replace"), name)


def _robot_of(file: RecordedFile, prefix: str) -> RobotFiles:
    return RobotFiles(*_attached(file, "robot", prefix))


def _attached(file: RecordedFile, what: str, prefix: str) -> tuple[str, Mapping[str, bytes]]:
    """Return the name of the first YAML file with a prefix, and all files of its folder."""
    for attached in file.attached:
        if attached.media_type == "application/yaml" and attached.name.startswith(prefix):
            folder = prefix.partition("/")[0] + "/"
            files = {each.name: each.data for each in file.attached if each.name.startswith(folder)}
            return attached.name, files
    raise ForkError(f"{file.path}: lacks the file of the {what}{_cut(file.why_cut)}")


def _other_versions(recorded: Mapping[str, Any]) -> Iterator[str]:
    for name, here in versions().items():
        then = recorded.get(name, here)
        if then != here:
            yield f"recorded with {name} {then}, installed is {here}"
