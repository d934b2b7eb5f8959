"""What a drawing shows of a mission: its nodes, with what they do in a few words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from bt_mission.behaviours.evaluator import name_of
from bt_mission.language.expressions.expression import Expression, Template, Text
from bt_mission.language.expressions.values import show
from bt_mission.language.mission import Mission
from bt_mission.language.nodes import steps


class Family(StrEnum):
    """What belongs together looks alike."""

    COMPOSITE = "composite"
    DECORATOR = "decorator"
    CONDITION = "condition"
    ACTION = "action"
    MESSAGE = "message"
    SUBTREE = "subtree"
    OTHER = "other"


@dataclass(frozen=True)
class Sign:
    """How a kind of node is marked, without colour: a glyph, its form in ASCII, and in words."""

    glyph: str
    ascii: str
    words: str
    family: Family


SIGNS: Mapping[str, Sign] = {
    "sequence": Sign("→", "->", "sequence", Family.COMPOSITE),
    "fallback": Sign("?", "?", "fallback", Family.COMPOSITE),
    "parallel": Sign("⇉", "=>", "parallel", Family.COMPOSITE),
    "choose": Sign("⚄", "%", "choice", Family.COMPOSITE),
    "when": Sign("◇", "<>", "when", Family.CONDITION),
    "repeat": Sign("↻", "@", "repeat", Family.DECORATOR),
    "for_each": Sign("∀", "@", "for each", Family.DECORATOR),
    "retry": Sign("↺", "@", "retry", Family.DECORATOR),
    "timeout": Sign("◷", "t", "timeout", Family.DECORATOR),
    "invert": Sign("≠", "!", "invert", Family.DECORATOR),
    "force": Sign("=", "=", "force", Family.DECORATOR),
    "guard": Sign("◈", "<>", "guard", Family.CONDITION),
    "check": Sign("◇", "<>", "check", Family.CONDITION),
    "set": Sign("≔", ":=", "set", Family.OTHER),
    "wait": Sign("◷", "t", "wait", Family.OTHER),
    "log": Sign("¶", '"', "log", Family.OTHER),
    "publish": Sign("◁", "<|", "publish", Family.MESSAGE),
    "wait_for": Sign("▷", "|>", "wait for a message", Family.MESSAGE),
    "service": Sign("⇄", "<>", "service", Family.ACTION),
    "action": Sign("▶", ">", "action", Family.ACTION),
    "tree": Sign("▣", "[]", "tree", Family.SUBTREE),
    "python": Sign("λ", "py", "python", Family.OTHER),
}


@dataclass(frozen=True)
class DrawnNode:
    """One node of a drawing.

    :param name: as the tree calls it when it runs.
    :param details: what it does, in order of importance.
    """

    kind: str
    name: str
    details: tuple[str, ...]
    children: tuple[DrawnNode, ...]

    @property
    def sign(self) -> Sign:
        """How it is marked."""
        return SIGNS[self.kind]


def drawn(mission: Mission) -> DrawnNode:
    """The tree of a mission, with the trees that it uses in their places."""
    root = _node(mission.tree, mission)
    named = mission.tree.name is None and bool(mission.tree.steps)
    return DrawnNode(root.kind, mission.name, root.details, root.children) if named else root


def heading(mission: Mission) -> str:
    """What the mission is, in one line."""
    where = f" in {mission.world}" if mission.world else ""
    inputs = ", ".join(f"{name} {written(value)}" for name, value in mission.inputs.items())
    return f"{mission.name}{where} ({mission.robot})" + (f"; {inputs}" if inputs else "")


def _node(step: steps.Step, mission: Mission) -> DrawnNode:
    below: tuple[steps.Step, ...] = step.steps
    if isinstance(step, steps.SubtreeStep):
        below = (mission.trees[step.tree].body,)
    children = tuple(_node(child, mission) for child in below)
    return DrawnNode(step.kind, name_of(step), tuple(_details(step)), children)


def _details(step: steps.Step) -> list[str]:
    match step:
        case steps.Speaker():
            return _speaker(step)
        case steps.Composite():
            return _composite(step)
        case steps.Decorator():
            return _decorator(step)
        case steps.SubtreeStep():
            return [*_fields(step.inputs), *_outputs(step)]
        case steps.PythonStep():
            return [step.target, *_fields(step.inputs), *_outputs(step)]
    return _leaf(step)


def _leaf(step: steps.Step) -> list[str]:
    match step:
        case steps.SetStep():
            return [f"{name} = {written(value)}" for name, value in step.values.items()]
        case steps.WaitStep():
            return [f"{written(step.seconds)} s"]
        case steps.LogStep():
            return [step.message.text]
        case steps.CheckStep():
            return [] if step.name is None else [written(step.condition)]
    return []


def _composite(step: steps.Composite) -> list[str]:
    match step:
        case steps.SequenceStep(memory=False) | steps.FallbackStep(memory=False):
            return ["asks all again in every tick"]
        case steps.ParallelStep():
            return _parallel(step)
        case steps.ChooseStep(weights=weights) if weights:
            return [f"weights {', '.join(f'{one:g}' for one in weights)}"]
        case steps.WhenStep():
            otherwise = ["then the first, else the second"] if len(step.children) > 1 else []
            return [*_condition(step), *otherwise]
    return []


def _parallel(step: steps.ParallelStep) -> list[str]:
    if isinstance(step.succeed_when, str):
        succeeds = (
            f"succeeds when {step.succeed_when} {'do' if step.succeed_when == 'all' else 'does'}"
        )
    else:
        names = ", ".join(name_of(step.children[index]) for index in step.succeed_when)
        succeeds = f"succeeds when these do: {names}"
    fails = ["fails when it cannot succeed"] if step.fail_when == "impossible" else []
    rest = ["the rest finishes"] if step.rest == "finish" else []
    return [succeeds, *fails, *rest]


def _decorator(step: steps.Decorator) -> list[str]:
    match step:
        case steps.RepeatStep():
            return [f"{written(step.count)} times"]
        case steps.RetryStep():
            pause = "" if step.pause == 0 else f", {written(step.pause)} s apart"
            return [f"up to {written(step.attempts)} times{pause}"]
        case steps.TimeoutStep():
            return [f"{written(step.seconds)} s"]
        case steps.ForceStep():
            return [step.status]
        case steps.ForEachStep():
            return [f"{step.variable} in {written(step.elements)}"]
        case steps.GuardStep():
            return _condition(step)
    return []


def _condition(step: steps.GuardStep | steps.WhenStep) -> list[str]:
    """The condition, unless it is in the name."""
    return [] if step.name is None else [written(step.condition)]


def _speaker(step: steps.Speaker) -> list[str]:
    match step:
        case steps.ActionStep():
            return [
                *_called(step.action, step.name),
                *_fields(step.goal),
                *([f"{step.on_cancel} when {step.cancel_when.text}"] if step.cancel_when else []),
                *([f"within {written(step.timeout)} s"] if step.timeout is not None else []),
                *_outputs(step),
            ]
        case steps.ServiceStep():
            return [*_called(step.service, step.name), *_fields(step.request), *_outputs(step)]
        case steps.PublishStep():
            return [*_called(step.topic, step.name), *_fields(step.message)]
        case steps.WaitForStep():
            within = [f"within {written(step.timeout)} s"] if step.timeout is not None else []
            until = f"until {step.until.text}"
            return [*_called(step.topic, step.name), until, *within, *_outputs(step)]
    return []


def _called(topic: str, name: str | None) -> list[str]:
    """Whom it speaks to, unless that is its name."""
    return [] if name is None else [topic if topic.startswith("/") else f"/{topic}"]


def _fields(fields: Mapping[str, Any]) -> list[str]:
    return [f"{name} {written(value)}" for name, value in fields.items()]


def _outputs(step: steps.Writer) -> list[str]:
    return [f"{variable} := {source}" for source, variable in step.outputs.items()]


def written(value: Any) -> str:
    """A value as its author wrote it."""
    match value:
        case Expression() | Template() | Text():
            return value.text
        case Mapping():
            return "{" + ", ".join(f"{name}: {written(one)}" for name, one in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(written(one) for one in value) + "]"
    return show(value)
