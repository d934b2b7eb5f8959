"""Goals against what is known of our action servers, of the robot, and of units."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from action_servers.core.action import Action, action, lacks_part
from action_servers.core.limits import Limit, NumberLimit
from bt_mission.base.actions import declared, declared_as
from bt_mission.base.diagnostics import Diagnostic
from bt_mission.base.parameters import specs
from bt_mission.base.stamps import NS
from bt_mission.base.yaml.document import Document
from bt_mission.language.action_names import plugged
from bt_mission.language.checks.types import Ranges
from bt_mission.language.expressions.expression import Text
from bt_mission.language.message_types import MAP_FRAME
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import Path
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.robots.model import RobotModel

if TYPE_CHECKING:
    from bt_mission.sessions.pose_checks import PoseChecker
    from sim.world.world import World

_AXES = ("x", "y", "z")
"""The names of the numbers of a point that is written as a list."""

_FAST_TURN = 5.0
"""From this value on a turning speed is probably in degrees a second; no robot here turns at it."""

_STEP_DEG = 15.0
_NEAR_DEG = 0.1
"""An angle in radians is recognized as a multiple of 15 degrees, up to this difference."""


@dataclass(frozen=True)
class ServerSettings:
    """Parameters of the action servers that decide which goals they refuse.

    Args:
        parameters: Values of their parameters, by name, if they differ from the defaults.
        velocities: Their highest speeds, by the robot's names, if these are lower.
        offered: The actions that they offer; None is all.
    """

    parameters: Mapping[str, Any] = field(default_factory=dict)
    velocities: Mapping[str, float] | None = None
    offered: frozenset[str] | None = None


OUR_SERVERS = ServerSettings()
"""The servers as they are started without any parameters."""


@cache
def _of_packages() -> Mapping[str, Action]:
    """Return the actions that other packages declare, with their limits."""
    return {named.name: named for named in plugged().values() if isinstance(named, Action)}


class ServerGoalRules:
    """The goals that the action servers accept, for one robot.

    Goals of other servers are not checked, and poses only on the map of a world. The yaw of named
    places is checked where they are defined (:func:`yaw_diagnostics`).
    """

    def __init__(
        self,
        robot: RobotModel,
        settings: ServerSettings = OUR_SERVERS,
        world: World | None = None,
        places: Collection[str] = (),
    ) -> None:
        self._robot = robot.model_copy(update=dict(settings.velocities or {}))
        self._settings = settings
        self._world = world
        self._places = places

    def diagnostics(
        self, document: Document, node: InterfaceNode, values: Mapping[str, Any]
    ) -> Iterator[Diagnostic]:
        """Yield why our servers refuse a goal, and numbers that look as if of another unit."""
        rules = self._rules(node)
        if rules is None or lacks_part(rules, self._robot):
            return
        refused = False
        for limit in rules.limits_with(self._robot, self._settings.parameters):
            value = _value(values, limit.field)
            why = None if value is None else limit.fault(value)
            if why is not None:
                refused = True
                yield self._refusal(document, node, limit, why, value)
            elif value is not None and isinstance(limit, NumberLimit):
                yield from _suspicion(document, node, limit, value)
        misfit = None
        if not refused and not _has_unknown(values):
            misfit = rules.misfit(_as_goal(values), self._robot)
        if misfit is not None:
            path = (*node.path, *node.sent_path)
            message = f"{misfit}: the server of {node.ros_name} cannot do that"
            yield document.diagnostic("BT-504", path, message)
        for path, pose in _poses(node, values):
            yield from self._pose_diagnostics(document, path, pose)

    def _pose_diagnostics(
        self, document: Document, path: Path, stamped: Mapping[str, Any]
    ) -> Iterator[Diagnostic]:
        """Yield why a robot cannot stand at a pose, and a yaw that looks like radians."""
        position, turn = stamped["pose"]["position"], stamped["pose"]["orientation"]
        why = None
        if self._checker is not None and stamped["header"]["frame_id"] in ("", MAP_FRAME):
            why = self._checker.why_unreachable(position["x"], position["y"])
        if why is not None:
            yield document.diagnostic("BT-505", path, why)
        yaw = math.degrees(2.0 * math.atan2(turn["z"], turn["w"]))
        place = document.find(path)
        keys = place.keys
        is_named = place.text is not None and place.text.strip() in self._places
        if is_like_radians(yaw) and not is_named and (keys is None or "yaw" in keys):
            last = 2 if keys is None else "yaw"
            yield in_radians(document, (*path, last), "the yaw of a pose", yaw)

    @cached_property
    def _checker(self) -> PoseChecker | None:
        """The map of the world, drawn when the first pose is met."""
        if self._world is None:
            return None
        from bt_mission.sessions.pose_checks import PoseChecker  # noqa: PLC0415 - SciPy takes long

        return PoseChecker(self._world, self._robot)

    def feedback(self, node: InterfaceNode, values: Mapping[str, Any]) -> Ranges:
        """Return the range of the feedback; empty if the goal is not known."""
        rules = self._rules(node)
        return {} if rules is None or _has_unknown(values) else rules.feedback(_as_goal(values))

    def _rules(self, node: InterfaceNode) -> Action | None:
        """Return the declaration for the goals of a node, if its action has one."""
        declaration = declared_as(node.ros_name)
        name = node.ros_name.rpartition("/")[2] if declaration is None else declaration.known.name
        offered = self._settings.offered
        if offered is not None and name not in offered:
            return None
        known = _of_packages().get(name) if declaration is None else declaration.known
        if known is None or known.type != node.type:
            return None
        return known if isinstance(known, Action) else action(name)

    def _refusal(
        self, document: Document, node: InterfaceNode, limit: Limit, why: str, value: Any
    ) -> Diagnostic:
        source = limit.source
        if self._settings.velocities is None:
            source = source.replace("the robot", f"the robot '{self._robot.name}'")
        path = _path(node, limit.field)
        if limit.field.partition(".")[0] not in node.sent:
            why = f"{limit.field} is missing, so it is {value!r}, and it must be {limit.words}"
        message = f"{why}: the server of {node.ros_name} refuses that (limit: {source})"
        hint = _in_degrees(limit, value) if isinstance(limit, NumberLimit) else limit.hint(value)
        return document.diagnostic("BT-504", path, message, hint)


def _value(values: Mapping[str, Any], dotted: str) -> Any:
    """Return a field of a goal, a duration in seconds; None if only the run has it."""
    part: Any = values
    for name in dotted.split("."):
        part = None if part is None else part[name]
    if isinstance(part, list):
        return None if _has_unknown(part) else part
    if isinstance(part, Mapping):
        return None if _has_unknown(part) else part["sec"] + part["nanosec"] / NS
    return part


def _path(node: InterfaceNode, dotted: str) -> Path:
    """Return the path of a field, also of a point written as a list."""
    path: Path = (*node.path, *node.sent_path)
    written: Any = node.sent
    for name in dotted.split("."):
        if isinstance(written, Mapping) and name in written:
            path, written = (*path, name), written[name]
        elif isinstance(written, tuple | list) and name in _AXES:
            path = (*path, _AXES.index(name))
    return path


def _has_unknown(value: Any) -> bool:
    match value:
        case Mapping():
            return any(_has_unknown(part) for part in value.values())
        case list() | tuple():
            return any(_has_unknown(part) for part in value)
    return value is None


def _as_goal(value: Any) -> Any:
    """Return the fields of a goal as the attributes that its message has."""
    if isinstance(value, Mapping):
        return SimpleNamespace(**{name: _as_goal(part) for name, part in value.items()})
    return [_as_goal(part) for part in value] if isinstance(value, list | tuple) else value


def _suspicion(
    document: Document, node: InterfaceNode, limit: NumberLimit, value: float
) -> Iterator[Diagnostic]:
    """Yield a warning for an angle that is accepted but looks as if it was of another unit."""
    path = _path(node, limit.field)
    if limit.unit == "deg" and is_like_radians(value):
        yield in_radians(document, path, f"'{limit.field}'", value)
    elif limit.unit == "rad" and is_like_degrees(value):
        turns = abs(value) / math.tau
        message = f"'{limit.field}' is in radians, and {value:g} of them are {turns:.1f} turns"
        yield document.diagnostic(
            "BT-309", path, message, _in_degrees(limit, value), severity="warning"
        )


def in_radians(document: Document, path: Path, what: str, value: float) -> Diagnostic:
    """Return the warning for a number of degrees that looks like radians."""
    degrees = round(math.degrees(value) / _STEP_DEG) * _STEP_DEG
    message = f"{what} is in degrees, and {value:g} looks like {degrees:g} of them in radians"
    hint = f"for {degrees:g} degrees write {degrees:g}"
    return document.diagnostic("BT-309", path, message, hint, severity="warning")


def _poses(
    node: InterfaceNode, values: Mapping[str, Any]
) -> Iterator[tuple[Path, Mapping[str, Any]]]:
    """Yield the poses that are written in a navigation goal and known, each with its path."""
    path = (*node.path, *node.sent_path)
    single, many = values.get("pose"), values.get("poses") or ()
    if isinstance(single, Mapping) and "pose" in node.sent and not _has_unknown(single):
        yield (*path, "pose"), single
    for index, pose in enumerate(many):
        if isinstance(pose, Mapping) and not _has_unknown(pose):
            yield (*path, "poses", index), pose


def yaw_diagnostics(mission: Mission) -> Iterator[Diagnostic]:
    """Yield each yaw that looks like radians in places, and in inputs of trees that are poses."""
    for name, (_, _, yaw) in mission.places.items():
        path: Path = ("places", name)
        if is_like_radians(yaw):
            keys = mission.document.find(path).keys
            last = 2 if keys is None else "yaw"
            what = f"the yaw of the place '{name}'"
            yield in_radians(mission.document, (*path, last), what, yaw)
    poses = {name: _pose_names(tree) for name, tree in mission.trees.items()}
    for tree in mission.all_trees:
        written = [((*tree.path, "inputs"), tree.inputs, poses.get(tree.name, frozenset()))]
        for use in tree.body.walk():
            if isinstance(use, TreeNode):
                path = (*use.path, "tree", "inputs")
                written.append((path, use.inputs, poses.get(use.tree, frozenset())))
        for path, values, wanted in written[tree.is_main :]:
            for name, value in values.items():
                match value:
                    case [_, _, int() | float() as yaw] if name in wanted and is_like_radians(yaw):
                        place = (*path, name, 2)
                        yield in_radians(tree.document, place, "the yaw of a pose", yaw)


def _pose_names(tree: Tree) -> frozenset[str]:
    """Return the variables that a tree uses as poses of its goals."""
    sent = [node.sent for node in tree.body.walk() if isinstance(node, InterfaceNode)]
    texts = [part for goal in sent for part in (goal.get("pose"), *_listed(goal.get("poses")))]
    return frozenset(text.text.removeprefix("$") for text in texts if isinstance(text, Text))


def _listed(value: Any) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else ()


def is_like_radians(value: float) -> bool:
    """Return whether a number of degrees looks like a usual angle in radians, such as 1.5708."""
    degrees = math.degrees(value)
    steps = round(degrees / _STEP_DEG)
    is_whole = abs(value - round(value)) < 1e-3
    return (
        steps != 0
        and abs(value) <= math.tau + 0.01
        and not is_whole
        and (abs(degrees - steps * _STEP_DEG) < _NEAR_DEG)
    )


def is_like_degrees(value: float) -> bool:
    """Return whether a number of radians looks like a usual angle in degrees, such as 90."""
    return abs(value) >= _STEP_DEG and value % _STEP_DEG == 0


def _in_degrees(limit: NumberLimit, value: float) -> str | None:
    """Return how the same number of degrees is written in a field in radians."""
    if limit.unit == "rad" and is_like_degrees(value):
        return f"for {value:g} degrees write '{value:g} * pi / 180'"
    in_radians = math.radians(value)
    if limit.unit == "rad/s" and abs(value) >= _FAST_TURN and limit.fault(in_radians) is None:
        return f"for {value:g} degrees a second write {in_radians:.4g}"
    return None


VELOCITIES = ("max_linear_velocity", "max_angular_velocity")
"""Parameters of the servers that also are numbers of a robot."""


def limiting_parameters() -> tuple[str, ...]:
    """Return the parameters of the servers by which they may refuse goals."""
    tunings = (action(name).tuning for name in declared())
    names = {name for tuning in tunings for name, _ in specs(tuning).values()}
    return *sorted(names), *VELOCITIES


def with_parameters(parameters: Mapping[str, Any], offered: frozenset[str]) -> ServerSettings:
    """Return the settings of servers that run, from the `limiting_parameters` of their node."""
    known = {name: value for name, value in parameters.items() if name not in VELOCITIES}
    velocities = {name: parameters[name] for name in VELOCITIES if name in parameters}
    return ServerSettings(known, velocities, offered)
