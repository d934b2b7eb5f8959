"""From the model of a written node to its step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.nodes import steps
from bt_mission.language.nodes import written as models
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.steps import Step

LimitsOf = Callable[[str], Mapping[str, Any]]


def step_of(
    kind: str, written: Any, below: list[Step], common: dict[str, Any], limits: LimitsOf
) -> Step:
    """Return a sound node as a step; `common` are the fields that every step has.

    `limits` tells what the mission says of the goals of an action, where its node says nothing.
    """
    if kind == "action":
        settings = written.action
        return _action(settings.name, settings.type, settings.goal, written, common, limits)
    if kind in ACTION_NAMES:
        short = ACTION_NAMES[kind]
        goal = getattr(written, kind)
        return _action(short.action, short.type, goal, written, common, limits)
    return _BUILD[kind](written, below, common)


def _repeat(written: models.RepeatNode, below: list[Step], common: dict[str, Any]) -> Step:
    return steps.RepeatStep(child=below[0], count=written.repeat.count, **common)


def _retry(written: models.RetryNode, below: list[Step], common: dict[str, Any]) -> Step:
    settings = written.retry
    return steps.RetryStep(
        child=below[0], attempts=settings.attempts, pause=settings.pause, **common
    )


def _for_each(written: models.ForEachNode, below: list[Step], common: dict[str, Any]) -> Step:
    ((variable, elements),) = written.for_each.items()
    return steps.ForEachStep(child=below[0], variable=variable, elements=elements, **common)


def _action(
    name: str,
    type_name: str,
    goal: Mapping[str, Any],
    written: Any,
    common: dict[str, Any],
    limits: LimitsOf,
) -> Step:
    modifiers = {key: getattr(written, key) for key in _GOAL_MODIFIERS}
    for key, value in limits(name).items():
        if modifiers[key] is None:
            modifiers[key] = value
    return steps.ActionStep(action=name, type=type_name, goal=goal, **modifiers, **common)


def _service(written: models.ServiceNode, _: list[Step], common: dict[str, Any]) -> Step:
    settings = written.service
    return steps.ServiceStep(
        service=settings.name,
        type=settings.type,
        request=settings.request,
        timeout=written.timeout,
        server_timeout=written.server_timeout,
        outputs=written.outputs,
        **common,
    )


def _wait_for(written: models.WaitForNode, _: list[Step], common: dict[str, Any]) -> Step:
    settings = written.wait_for
    return steps.WaitForStep(
        topic=settings.topic,
        type=settings.type,
        until=settings.until,
        timeout=written.timeout,
        outputs=written.outputs,
        **common,
    )


def _publish(written: models.PublishNode, _: list[Step], common: dict[str, Any]) -> Step:
    settings = written.publish
    return steps.PublishStep(
        topic=settings.topic,
        type=settings.type,
        message=settings.message,
        readers=written.readers,
        server_timeout=written.server_timeout,
        **common,
    )


_GOAL_MODIFIERS = tuple(models.GoalNode.model_fields.keys() - NodeModel.model_fields.keys())


_BUILD: dict[str, Callable[[Any, list[Step], dict[str, Any]], Step]] = {
    "sequence": lambda written, below, common: steps.SequenceStep(
        children=tuple(below), memory=written.memory, **common
    ),
    "fallback": lambda written, below, common: steps.FallbackStep(
        children=tuple(below), memory=written.memory, **common
    ),
    "choose": lambda written, below, common: steps.ChooseStep(
        children=tuple(below), weights=tuple(written.weights), **common
    ),
    "timeout": lambda written, below, common: steps.TimeoutStep(
        child=below[0], seconds=written.timeout, **common
    ),
    "invert": lambda _written, below, common: steps.InvertStep(child=below[0], **common),
    "force": lambda written, below, common: steps.ForceStep(
        child=below[0], status=written.force, **common
    ),
    "guard": lambda written, below, common: steps.GuardStep(
        child=below[0], condition=written.guard, **common
    ),
    "when": lambda written, below, common: steps.WhenStep(
        children=tuple(below), condition=written.when, **common
    ),
    "for_each": _for_each,
    "check": lambda written, _below, common: steps.CheckStep(condition=written.check, **common),
    "set": lambda written, _below, common: steps.SetStep(values=written.set, **common),
    "repeat": _repeat,
    "retry": _retry,
    "wait": lambda written, _below, common: steps.WaitStep(seconds=written.wait, **common),
    "log": lambda written, _below, common: steps.LogStep(message=written.log, **common),
    "service": _service,
    "wait_for": _wait_for,
    "publish": _publish,
    "python": lambda written, _below, common: steps.PythonStep(
        target=written.python, inputs=written.inputs, outputs=written.outputs, **common
    ),
}
