"""The material of a search, from its mission: names, limits, compared values, and events.

:func:`material_of` reads it from the mission; :func:`present_in` keeps what exists in its runs.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

from action_servers.core.tuning import TUNING
from bt_mission.base.errors import BtMissionError
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.syntax import Comparison, EvaluationScope, Name, SyntaxNode
from bt_mission.language.expressions.values import ExpressionError, Plain
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.action import GoalNode, ShortActionNode
from bt_mission.language.nodes.base import ConditionalNode, NodeModel
from bt_mission.language.nodes.decorators import RepeatNode, TimeoutNode
from bt_mission.language.nodes.interfaces import InterfaceNode, ServiceNode, WaitForNode
from bt_mission.language.trees import all_steps
from bt_mission.requirements.checks import MissionNames
from bt_mission.requirements.language.formula import Condition, Formula, root_of, signals_in, walk
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.ros.interface_types import action_type, message_type
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.worker import ScenarioRunner
from bt_mission.scenarios.faults.corruptions import setting
from bt_mission.scenarios.faults.drawable import TOPICS, FieldValues
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.faults import FAULTS

T = TypeVar("T")

CAMERA_TOPIC = {"camera/image_raw": "sensor_msgs/msg/Image"}
ROBOT_TOPICS = {
    "imu": "sensor_msgs/msg/Imu",
    "battery_state": "sensor_msgs/msg/BatteryState",
    "joint_states": "sensor_msgs/msg/JointState",
}
"""Topics of a robot that a requirement may name without their types."""

LIMITS = ("timeout", "server_timeout", "acceptance_timeout", "feedback_timeout", "cancel_timeout")
"""Fields of the nodes that send goals, call services and wait for messages."""

BESIDE_S = 0.1
"""Periods are drawn so much below and above a limit, s: two control steps."""

WELL_BEYOND = 1.4
"""A silence of this times a limit is noticed, however seldom messages come."""

LONGEST_LIMIT_S = 30.0
"""Longer limits are not tried: a run would take too long."""

MOST_BRANCHES = 24
"""Conditions whose distance is measured; each costs an evaluation at every control step."""


class Branch(NamedTuple):
    """A condition of a mission as a requirement can express it.

    Attributes:
        place: The node's name, and the key of the condition.
        condition: A condition on signals.
        has_two: Whether both results of the condition are possible.
    """

    place: str
    condition: str
    has_two: bool


@dataclass(frozen=True)
class Material:
    """The material from which the faults of a mission are drawn.

    Attributes:
        leaves: Nodes that send goals and have a unique name.
        actions: Of its goals.
        topics: With the names of their types.
        services: That it calls.
        limits: Periods just below and above its time limits and those of the servers, s.
        trusted: The topics that it reads, each with periods just below, just above and well above
            its own limits, s.
        fields: Values of feedback, results and messages beside what they are compared with.
        events: Conditions at which faults may begin.
        branches: Its conditions.
    """

    leaves: tuple[str, ...]
    actions: tuple[str, ...]
    topics: Mapping[str, str]
    services: tuple[str, ...]
    limits: tuple[float, ...]
    trusted: Mapping[str, tuple[float, ...]]
    fields: tuple[FieldValues, ...]
    events: tuple[str, ...]
    branches: tuple[Branch, ...]
    uses_camera: bool
    uses_battery: bool
    lacking: frozenset[str] = frozenset()
    """Names of faults of parts that the robot lacks."""


def material_of(mission: Mission) -> Material:
    """Gather what a mission gives to draw from."""
    steps = list(all_steps(mission))
    goals = [step for step in steps if isinstance(step, GoalNode)]
    labels = Counter(step.label for step in steps)
    leaves = tuple(goal.label for goal in goals if labels[goal.label] == 1)
    speaking = (step.label for step in steps if isinstance(step, InterfaceNode))
    waiting = tuple(label for label in speaking if labels[label] == 1)
    comparisons = list(_comparisons(mission))
    signals = [signal for each in mission.requirements for signal in signals_in(root_of(each))]
    uses_camera = any(
        ACTION_NAMES[goal.short].needs_camera for goal in goals if isinstance(goal, ShortActionNode)
    )
    topics = _topics(mission, steps, signals) | (CAMERA_TOPIC if uses_camera else {})
    branches = tuple(_branches(mission, set(leaves)))[:MOST_BRANCHES]
    return Material(
        leaves,
        tuple(dict.fromkeys(goal.ros_name for goal in goals)),
        topics,
        tuple(dict.fromkeys(step.ros_name for step in steps if isinstance(step, ServiceNode))),
        tuple(_limits(mission, steps)),
        _trusted(mission, steps, signals),
        tuple(_field_values(comparisons, goals, topics)),
        tuple(dict.fromkeys(_events(waiting, branches))),
        branches,
        uses_camera,
        "battery_state" in topics,
    )


# ---- topics and limits -------------------------------------------------------------------------


def _topics(mission: Mission, steps: list[NodeModel], signals: list[SignalValue]) -> dict[str, str]:
    topics = dict(TOPICS)
    for tree in mission.all_trees:
        topics |= {followed.settings.topic.strip("/"): followed.type for followed in tree.follow}
    topics |= {
        step.ros_name.strip("/"): step.type for step in steps if isinstance(step, WaitForNode)
    }
    named = filter(None, map(_topic_of, signals))
    return topics | {name: ROBOT_TOPICS[name] for name in named if name in ROBOT_TOPICS}


def _topic_of(signal: SignalValue) -> str:
    """Return the topic that a signal names; "" for none."""
    if signal.name in ("age", "topic"):
        return signal.arguments[0].strip("/")
    return "battery_state" if signal.name == "battery" else ""


def _limits(mission: Mission, steps: list[NodeModel]) -> Iterator[float]:
    written: list[Any] = [TUNING.hold_after, TUNING.sensor_timeout, TUNING.blocked_after]
    for step in steps:
        if isinstance(step, GoalNode | ServiceNode | WaitForNode):
            written += [getattr(step, name, None) for name in LIMITS]
        elif isinstance(step, TimeoutNode):
            written.append(step.seconds)
    written += [followed.settings.timeout for tree in mission.all_trees for followed in tree.follow]
    known = {value for text in written if (value := _number(text, mission)) is not None}
    for limit in sorted(known):
        if BESIDE_S < limit <= LONGEST_LIMIT_S:
            yield from (round(limit - BESIDE_S, 6), round(limit + BESIDE_S, 6))


def _trusted(
    mission: Mission, steps: list[NodeModel], signals: list[SignalValue]
) -> dict[str, tuple[float, ...]]:
    """Return the topics that nodes, variables and requirements read, with periods of silence."""
    read: list[tuple[str, Any]] = [
        (followed.settings.topic, followed.settings.timeout)
        for tree in mission.all_trees
        for followed in tree.follow
    ]
    read += [(step.ros_name, step.timeout) for step in steps if isinstance(step, WaitForNode)]
    read += [(name, None) for name in map(_topic_of, signals) if name]
    read += [
        (signal.arguments[0], value)
        for requirement in mission.requirements
        for signal, value in _compared(root_of(requirement), {}, signals_in)
        if signal.name == "age"
    ]
    limits: dict[str, set[float]] = {topic.strip("/"): set() for topic, _ in read}
    for topic, limit in read:
        value = _number(limit, mission)
        if value is not None and value <= LONGEST_LIMIT_S:
            limits[topic.strip("/")].add(value)
    return {
        topic: tuple(
            round(period, 6)
            for limit in sorted(known)
            for period in (limit + BESIDE_S, WELL_BEYOND * limit, limit - BESIDE_S)
            if period > BESIDE_S
        )
        for topic, known in limits.items()
    }


def _number(value: Any, mission: Mission) -> float | None:
    """Return a number with the mission's inputs; None if only a run has it."""
    if isinstance(value, Expression):
        with suppress(BtMissionError):
            value = value.evaluate(mission.inputs, random.Random(0))
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and math.isfinite(value) else None


# ---- comparisons -------------------------------------------------------------------------------


class _Compared(NamedTuple):
    """A field of a message, and what it is compared with."""

    fault: str
    target: str
    field: str
    value: Plain


def _comparisons(mission: Mission) -> Iterator[_Compared]:
    for tree in mission.all_trees:
        sources = _sources(tree)
        for step, condition in _conditions(tree):
            for name, value in _compared(condition.root, mission.inputs, _names_in):
                own = _own_field(step, name)
                yield from (
                    _Compared(*place, value) for place in (own or sources.get(name.name, ()))
                )
    known = {node.label: node.ros_name for node in all_steps(mission) if isinstance(node, GoalNode)}
    for requirement in mission.requirements:
        for signal, value in _compared(root_of(requirement), {}, signals_in):
            if signal.name == "feedback" and signal.arguments[0] in known:
                node, field = signal.arguments
                yield _Compared("set_feedback", known[node], field, value)
            elif signal.name == "topic":
                yield _Compared(
                    "set_fields", signal.arguments[0].strip("/"), signal.arguments[1], value
                )
            elif signal.name == "battery":
                yield _Compared("set_fields", "battery_state", "percentage", value)


def _conditions(tree: Tree) -> Iterator[tuple[NodeModel, Expression]]:
    for node in tree.body.walk():
        conditions: list[Any] = []
        if isinstance(node, GoalNode | WaitForNode | ConditionalNode):
            conditions.append(node.condition)
        elif isinstance(node, RepeatNode):
            conditions += [node.settings.before, node.settings.after]
        yield from (
            (node, condition) for condition in conditions if isinstance(condition, Expression)
        )


def _sources(tree: Tree) -> dict[str, tuple[tuple[str, str, str], ...]]:
    """Return the source fields of variables, by the variables' names."""
    sources: dict[str, tuple[tuple[str, str, str], ...]] = {}
    for followed in tree.follow:
        settings = followed.settings
        place = ("set_fields", settings.topic.strip("/"), settings.field)
        sources[followed.variable] = (*sources.get(followed.variable, ()), place)
    for node in tree.body.walk():
        if isinstance(node, GoalNode | WaitForNode):
            fault = "set_result" if isinstance(node, GoalNode) else "set_fields"
            for field, variable in node.outputs.items():
                place = (fault, node.ros_name.strip("/"), field)
                sources[variable] = (*sources.get(variable, ()), place)
    return sources


def _own_field(node: NodeModel, name: Name) -> tuple[tuple[str, str, str], ...]:
    """Return the field of a node's own messages that a name in its condition is."""
    if name.variable:
        return ()
    if isinstance(node, GoalNode):
        return (("set_feedback", node.ros_name, name.name),)
    if isinstance(node, WaitForNode):
        return (("set_fields", node.ros_name.strip("/"), name.name),)
    return ()


def _compared(
    root: SyntaxNode, inputs: Mapping[str, Plain], parts_of: Callable[[SyntaxNode], Iterable[T]]
) -> Iterator[tuple[T, Plain]]:
    """Yield each part of one side of a comparison with the constant on its other side."""
    for node in walk(root):
        if not isinstance(node, Comparison):
            continue
        for left, right in pairwise((node.first, *(part for _, _, part in node.rest))):
            for side, other in ((left, right), (right, left)):
                value = _value(other, inputs)
                if value is not None:
                    yield from ((part, value) for part in parts_of(side))


def _names_in(root: SyntaxNode) -> list[Name]:
    return [part for part in walk(root) if isinstance(part, Name)]


def _value(node: SyntaxNode, inputs: Mapping[str, Plain]) -> Plain | None:
    try:
        return node.evaluate(EvaluationScope(inputs, {}, random.Random(0)))
    except ExpressionError:
        return None


def _field_values(
    compared: list[_Compared], goals: list[GoalNode], topics: Mapping[str, str]
) -> Iterator[FieldValues]:
    """Yield the values beside each comparison, and some of results that others depend on."""
    values_of: dict[tuple[str, str, str], list[Any]] = {}
    for comparison in compared:
        values_of.setdefault(comparison[:3], []).extend(_beside(comparison.value))
    for goal in goals:
        for field in goal.outputs:
            values_of.setdefault(("set_result", goal.ros_name.strip("/"), field), [-1.0, 0.0, 1.0])
    types = {client.ros_name.strip("/"): client.type for client in goals}
    for (fault, target, field), values in values_of.items():
        type_name = (topics if fault == "set_fields" else types).get(target.strip("/"))
        fitting = tuple(
            dict.fromkeys(value for value in values if _fits(fault, type_name, field, value))
        )
        if fitting:
            yield FieldValues(fault, target, field, fitting)


def _beside(value: Plain) -> list[Any]:
    """Return a value, and those just below and above it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return [value, not value] if isinstance(value, bool) else [value, ""]
    if not math.isfinite(value):
        return []
    step = max(abs(value) * 0.01, 0.01)
    numbers = [value - step, value, value + step, 0.0, 2 * value]
    whole = [int(value) - 1, int(value), int(value) + 1]
    return [*whole, *(round(float(number), 6) for number in numbers)]


def _fits(fault: str, type_name: str | None, field: str, value: Any) -> bool:
    """Return whether a field of the messages of a type takes a value."""
    if type_name is None:
        return False
    if fault == "set_fields":
        message = message_type(type_name)()
    else:
        kind = action_type(type_name)
        message = kind.Result() if fault == "set_result" else kind.Feedback()
    present = message
    try:
        for part in field.split("."):
            present = getattr(present, part)
        setting(fault, {field: value})(message)
    except (ScenarioError, AttributeError):
        return False
    return isinstance(value, type(present))


# ---- conditions as requirements ------------------------------------------------------------------


def _branches(mission: Mission, leaves: set[str]) -> Iterator[Branch]:
    """Yield the conditions of the main tree that a requirement can express."""
    names = MissionNames(mission)
    for node, condition in _conditions(mission.main):
        if isinstance(node, WaitForNode) or (
            isinstance(node, GoalNode) and node.label not in leaves
        ):
            continue
        text = _over_signals(node, condition, mission)
        try:
            root = Condition(text).root
        except ExpressionError:
            continue  # it is constant, draws, or uses what requirements lack
        if not any(names.unknown_in(root)):
            yield Branch(node.label, text, has_two=not isinstance(node, GoalNode))


def _over_signals(node: NodeModel, condition: Expression, mission: Mission) -> str:
    """Return a condition with signals in the place of its names."""
    text = condition.text
    variables = set(mission.inputs) | {followed.variable for followed in mission.follow}
    for name in sorted(condition.references, key=lambda reference: reference.column, reverse=True):
        start = name.column - 1
        end = start + len(name.shown)
        is_field = isinstance(node, GoalNode) and not name.variable and name.name not in variables
        signal = f'feedback("{node.label}", "{name.name}")' if is_field else f"${name.name}"
        text = text[:start] + signal + text[end:]
    return text


def _events(waiting: tuple[str, ...], branches: tuple[Branch, ...]) -> Iterator[str]:
    """Yield conditions at which something may go wrong: as nodes begin and end, and near limits."""
    for leaf in waiting:
        yield from (f'{word}("{leaf}")' for word in ("running", "succeeded", "failed"))
    for branch in branches:
        root = Condition(branch.condition).root
        match root:
            case Comparison(first=SignalValue(key=key), rest=((sign, _, bound),)):
                value = _value(bound, {})
                if sign in (">", ">=") and isinstance(value, int | float) and value > 0:
                    yield from (f"{key} > {share * value:g}" for share in (0.5, 0.95))


def branch_formulas(branches: tuple[Branch, ...]) -> dict[str, str]:
    """Return requirements whose margins are the distances to what a run did not do, by names."""
    formulas: dict[str, str] = {}
    for branch in branches:
        forms = [("true", f"never {branch.condition}")]
        if branch.has_two:
            forms.append(("false", f"always {branch.condition}"))
        for end, text in forms:
            with suppress(ExpressionError):
                Formula(text)
                formulas[f"{branch.place}: {branch.condition} is {end}"] = text
    return formulas


# ---- what exists -------------------------------------------------------------------------------

PROBE_S = 0.05
"""A probe ends after the first control step, s."""

NEVER = "when time > 1000000"
"""When the faults of a probe begin: names are looked for before the run."""

SENSORS = tuple(fault.part for fault in FAULTS.values() if fault.name == f"{fault.part}_dead")


async def present_in(material: Material, base: BaseScenario, runner: ScenarioRunner) -> Material:
    """Return the part of a material that exists in short runs.

    All is tried in one run, and each alone only if that fails.
    """
    probes = {
        **{("topic", topic): f"{NEVER}: drop {topic}" for topic in material.topics},
        **{("action", action): f"{NEVER}: reject_goals {action}" for action in material.actions},
        **{
            ("service", service): f"{NEVER}: ignore_service {service}"
            for service in material.services
        },
        **{("sensor", sensor): f"{NEVER}: {sensor}_dead" for sensor in SENSORS},
    }
    if not await _missing(base, runner, [list(probes.values())]):
        return material
    wrong = await _missing(base, runner, [[probe] for probe in probes.values()])
    lost = {key for number, key in enumerate(probes) if number in wrong}
    lacking = (fault.name for fault in FAULTS.values() if ("sensor", fault.part) in lost)
    topics = {
        topic: kind for topic, kind in material.topics.items() if ("topic", topic) not in lost
    }
    actions = tuple(action for action in material.actions if ("action", action) not in lost)
    known = {*topics, *(action.strip("/") for action in actions)}
    return replace(
        material,
        topics=topics,
        trusted={topic: each for topic, each in material.trusted.items() if topic in topics},
        actions=actions,
        services=tuple(
            service for service in material.services if ("service", service) not in lost
        ),
        fields=tuple(field for field in material.fields if field.target.strip("/") in known),
        lacking=frozenset(lacking),
    )


async def _missing(
    base: BaseScenario, runner: ScenarioRunner, probes: Iterable[list[str]]
) -> set[int]:
    """Return the numbers of the probes that cannot run."""
    made = []
    for number, faults in enumerate(probes):
        probe = base.concrete({}, number=number, faults=faults)
        data = {**probe.data, "limit": PROBE_S, "faults": faults, "expect": {"outcome": "any"}}
        made.append(ConcreteScenario(number, data, {}, "", probe.bundle_digest))
    return {row.number async for row in runner.rows(made) if row.is_error}
