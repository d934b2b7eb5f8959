"""Checks of a loaded mission on this machine: worlds, robots, and the ROS types.

Every goal is compared with the fields of its action's type, every condition with the feedback,
every output with the result, and services and topics in the same way. Without ROS, a warning says
that this was not done.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from bt_mission.base import files
from bt_mission.base.actions import PARTS, declared_as
from bt_mission.base.diagnostics import (
    Diagnostic,
    InputError,
    did_you_mean,
    in_order,
    listed,
    quoted,
)
from bt_mission.base.errors import BtMissionError
from bt_mission.language.action_names import BY_TYPE
from bt_mission.language.checks.mission import tree_diagnostics
from bt_mission.language.checks.python_code import factory_diagnostics
from bt_mission.language.checks.warnings import word_inputs
from bt_mission.language.expressions.places import AnyPlace, Pose
from bt_mission.language.expressions.values import Plain
from bt_mission.language.inputs import SET_OPTION
from bt_mission.language.loader import Examined
from bt_mission.language.message_types import FindShapes
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.composites import ParallelNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.trees import reached
from bt_mission.requirements.mission_file import read_mission
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.sessions.goal_checks import (
    OUR_SERVERS,
    ServerGoalRules,
    ServerSettings,
    yaw_diagnostics,
)
from bt_mission.sessions.load import Source, document_of
from sim.world.loader import load_world
from sim.world.world import World


@dataclass(frozen=True)
class WorldAndRobot:
    """World and robot of a mission, where they were read already; None reads the file.

    Attributes:
        world: It may be another than that of the mission.
        is_elsewhere: Whether they are not known here, and any name may be that of a place.
    """

    world: World | None = None
    robot: RobotModel | None = None
    is_elsewhere: bool = False


UNREAD, ELSEWHERE = WorldAndRobot(), WorldAndRobot(is_elsewhere=True)


def examine(
    source: Source,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
    servers: ServerSettings | None = OUR_SERVERS,
    permissions: Permissions = ANYTHING,
    given: WorldAndRobot = UNREAD,
) -> Examined:
    """Load and check a mission; return it with all warnings, or None with all errors.

    What `load` refuses is checked as far as possible, so that no error hides another one. Nothing
    is raised. Python leaves are imported where `permissions` allow it.

    Args:
        source: As for `load`, as are `set`, `seed`, `world` and `robot`.
        servers: By their limits goals are judged; None where the goals are for other servers.
        permissions: The files and the Python code that the mission may use.
        given: World and robot that are not read from the files that the mission names.
    """

    def checked(values: Mapping[str, Plain]) -> Examined:
        check = partial(_diagnostics, servers=servers, permissions=permissions, given=given)
        zones: Mapping[str, Pose] | None = AnyPlace() if given.is_elsewhere else None
        if given.world is not None:
            zones = {zone.name: (zone.x, zone.y, 0.0) for zone in given.world.zones}
        try:
            document = document_of(source)
            return read_mission(document, values, seed, world, robot, permissions, zones, check)
        except InputError as error:
            return None, error.diagnostics

    values = dict(set or {})
    mission, diagnostics = checked(values)
    for name, value in values.items() if mission is None else ():
        others = {other: values[other] for other in values if other != name}
        without = frozenset(checked(others)[1])
        diagnostics = tuple(
            diagnostic if diagnostic in without else _of_value(diagnostic, name, value)
            for diagnostic in diagnostics
        )
    return mission, in_order(diagnostics)


def _of_value(diagnostic: Diagnostic, name: str, value: Plain) -> Diagnostic:
    """Return a diagnostic of a file as one of the value of an input on the command line."""
    if diagnostic.file == SET_OPTION or not diagnostic.line:
        return diagnostic
    message = f"{diagnostic.message}, in {diagnostic.file}:{diagnostic.line}:{diagnostic.column}"
    source = f"{name}={value}"
    return replace(
        diagnostic, message=message, file=SET_OPTION, line=1, column=len(name) + 2, source=source
    )


def _diagnostics(
    mission: Mission,
    servers: ServerSettings | None,
    permissions: Permissions,
    given: WorldAndRobot,
) -> Iterator[Diagnostic]:
    """Yield what does not fit this machine, and the errors of a mission's nodes."""
    is_staged = servers is not None
    yield from factory_diagnostics(mission.nodes, permissions, is_needed=is_staged)
    if not given.is_elsewhere:
        yield from _place_diagnostics(mission, permissions)
    yield from _parallel_diagnostics(mission)
    yield from word_inputs(mission)
    yield from yaw_diagnostics(mission)
    yield from _part_diagnostics(mission, servers, permissions, given.robot)
    find: FindShapes | None = None
    try:
        from bt_mission.ros.interface_types import shapes  # noqa: PLC0415 - the rest works without

        find = shapes
    except ImportError as error:
        message = f"ROS 2 is not available ({error}), so types and fields were not checked"
        hint = "try 'bt-mission doctor'"
        yield Diagnostic("BT-511", message, mission.file, hint=hint, severity="warning")
    yield from tree_diagnostics(
        mission, find, _goal_rules(mission, servers, permissions, given), permissions
    )


def _goal_rules(
    mission: Mission,
    servers: ServerSettings | None,
    permissions: Permissions,
    given: WorldAndRobot,
) -> ServerGoalRules | None:
    """Return what the servers accept with the mission's robot, if there is such a robot."""
    named: tuple[tuple[files.Kind, str | None], ...] = (
        ("robots", mission.robot),
        ("worlds", mission.world),
    )
    if servers is None or not all(
        name is None or _is_there(kind, name, mission, permissions) for kind, name in named
    ):
        return None
    try:
        robot = given.robot or load_robot(mission.robot, near=mission.file)
        world = given.world
        if mission.map != "known":
            world = None
        elif world is None and mission.world:
            world = load_world(mission.world, near=mission.file)
        return ServerGoalRules(robot, servers, world, mission.places)
    except BtMissionError:
        return None  # reported elsewhere, or when it is used


OTHER_NAMES = {
    **dict.fromkeys(
        ("turtlebot3", "turtlebot", "tb3", "turtlebot3_burger", "turtlebot3_waffle"),
        "a TurtleBot3 is 'waffle' or 'burger'",
    ),
    **dict.fromkeys(("turtlebot3_waffle_pi", "waffle_pi"), "write 'waffle'"),
    **dict.fromkeys(("tb4", "turtlebot4_standard", "turtlebot4_lite"), "write 'turtlebot4'"),
}
"""Robots as they are called elsewhere, in small letters."""


def _place_diagnostics(mission: Mission, permissions: Permissions) -> Iterator[Diagnostic]:
    """Yield a diagnostic for a world or robot that is not there."""
    document = mission.document
    places: tuple[tuple[files.Kind, str, str | None], ...] = (
        ("worlds", "world", mission.world),
        ("robots", "robot", mission.robot),
    )
    for kind, key, wanted in places:
        if wanted is None or _is_there(kind, wanted, mission, permissions):
            continue
        known = files.names(kind)
        message = f"unknown {key} {quoted(wanted)} (known: {listed(known)})"
        hint = OTHER_NAMES.get(wanted.lower()) or did_you_mean(wanted, known)
        written = document.data.get(key) == wanted
        yield (
            document.diagnostic("BT-110", (key,), message, hint)
            if written
            else Diagnostic("BT-110", message, f"--{key}", hint=hint)
        )


def _is_there(kind: files.Kind, wanted: str, mission: Mission, permissions: Permissions) -> bool:
    path = files.look_for(kind, wanted, mission.file)
    return path is not None and permissions.allows(path, kind)


Moved: TypeAlias = tuple[str, str]
"""A part of the robot, and the server that moves it where several may."""


def _parallel_diagnostics(mission: Mission) -> Iterator[Diagnostic]:
    """Yield a warning for every parallel of which two children move the same part."""
    for tree in mission.all_trees:
        for step in tree.body.walk():
            if not isinstance(step, ParallelNode):
                continue
            movers: dict[Moved, list[NodeModel]] = defaultdict(list)
            for child in step.children:
                for moved in {moved for step in reached(child, mission) for moved in _moved(step)}:
                    movers[moved].append(child)
            for (part, _), children in sorted(movers.items()):
                if len(children) > 1:
                    message = (
                        f"two branches of a parallel move the {part}: the later goal ends the "
                        "earlier, or both move it"
                    )
                    yield tree.document.diagnostic(
                        "BT-239", children[1].path, message, severity="warning"
                    )


def _moved(step: NodeModel) -> list[Moved]:
    """Return the parts that a step is known to move; of arms and grippers, with their server."""
    if not isinstance(step, GoalNode):
        return []
    parts = step.known_parts or ()
    server = step.ros_name.strip("/") if step.uses is None else ""
    return [(part, server if part in PARTS else "") for part in parts]


def has_camera(mission: Mission) -> bool:
    """Return whether the robot of a mission has a camera; a robot that cannot be read may."""
    try:
        return load_robot(mission.robot, near=mission.file).camera is not None
    except BtMissionError:
        return True  # reported elsewhere, or when it is used


def _part_diagnostics(
    mission: Mission,
    servers: ServerSettings | None,
    permissions: Permissions,
    robot: RobotModel | None,
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for every goal that needs a missing camera, arm or gripper."""
    steps = [
        (tree.document, step, part)
        for tree in mission.all_trees
        for step in tree.body.walk()
        if isinstance(step, GoalNode) and (part := _optional_part(step, servers))
    ]
    if not steps or not _is_there("robots", mission.robot, mission, permissions):
        return
    try:
        robot = robot or load_robot(mission.robot, near=mission.file)
    except BtMissionError:
        return  # reported elsewhere, or when it is used
    for document, step, part in steps:
        if getattr(robot, part) is None:
            a = "an" if part == "arm" else "a"
            message = f"{step.ros_name} needs {a} {part}; a {robot.name} has none"
            yield document.diagnostic("BT-508", step.path, message)


def _optional_part(step: GoalNode, servers: ServerSettings | None) -> str:
    """Return the part that a goal needs and that not every robot has; empty for none.

    Arms and grippers of other servers are unknown here.
    """
    known = BY_TYPE.get(step.type)
    if known is None:
        return ""
    if known.needs_camera:
        return "camera"
    if servers is None or declared_as(step.ros_name) is None:
        return ""
    return known.part if servers.offered is None or known.name in servers.offered else ""
