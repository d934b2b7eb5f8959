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
class Node:
    """One node of a drawing.

    :param name: as the tree calls it when it runs.
    :param details: what it does, in order of importance.
    """

    kind: str
    name: str
    details: tuple[str, ...]
    children: tuple[Node, ...]

    @property
    def sign(self) -> Sign:
        """How it is marked."""
        return SIGNS[self.kind]


def drawn(mission: Mission) -> Node:
    """The tree of a mission, with the trees that it uses in their places."""
    root = _node(mission.tree, mission)
    named = mission.tree.name is None and bool(mission.tree.steps)
    return Node(root.kind, mission.name, root.details, root.children) if named else root


def heading(mission: Mission) -> str:
    """What the mission is, in one line."""
    where = f" in {mission.world}" if mission.world else ""
    inputs = ", ".join(f"{name} {written(value)}" for name, value in mission.inputs.items())
    return f"{mission.name}{where} ({mission.robot})" + (f"; {inputs}" if inputs else "")


def _node(step: steps.Step, mission: Mission) -> Node:
    below: tuple[steps.Step, ...] = step.steps
    if isinstance(step, steps.Subtree):
        below = (mission.trees[step.tree].body,)
    children = tuple(_node(child, mission) for child in below)
    return Node(step.kind, name_of(step), tuple(_details(step)), children)


def _details(step: steps.Step) -> list[str]:
    match step:
        case steps.Speaker():
            return _speaker(step)
        case steps.Composite():
            return _composite(step)
        case steps.Decorator():
            return _decorator(step)
        case steps.Subtree():
            return [*_fields(step.inputs), *_outputs(step)]
        case steps.Python():
            return [step.target, *_fields(step.inputs), *_outputs(step)]
    return _leaf(step)


def _leaf(step: steps.Step) -> list[str]:
    match step:
        case steps.Set():
            return [f"{name} = {written(value)}" for name, value in step.values.items()]
        case steps.Wait():
            return [f"{written(step.seconds)} s"]
        case steps.Log():
            return [step.message.text]
        case steps.Check():
            return [] if step.name is None else [written(step.condition)]
    return []


def _composite(step: steps.Composite) -> list[str]:
    match step:
        case steps.Sequence(memory=False) | steps.Fallback(memory=False):
            return ["asks all again in every tick"]
        case steps.Parallel():
            return _parallel(step)
        case steps.Choose(weights=weights) if weights:
            return [f"weights {', '.join(f'{one:g}' for one in weights)}"]
        case steps.When():
            otherwise = ["then the first, else the second"] if len(step.children) > 1 else []
            return [*_condition(step), *otherwise]
    return []


def _parallel(step: steps.Parallel) -> list[str]:
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
        case steps.Repeat():
            return [f"{written(step.count)} times"]
        case steps.Retry():
            pause = "" if step.pause == 0 else f", {written(step.pause)} s apart"
            return [f"up to {written(step.attempts)} times{pause}"]
        case steps.Timeout():
            return [f"{written(step.seconds)} s"]
        case steps.Force():
            return [step.status]
        case steps.ForEach():
            return [f"{step.variable} in {written(step.elements)}"]
        case steps.Guard():
            return _condition(step)
    return []


def _condition(step: steps.Guard | steps.When) -> list[str]:
    """The condition, unless it is in the name."""
    return [] if step.name is None else [written(step.condition)]


def _speaker(step: steps.Speaker) -> list[str]:
    match step:
        case steps.Action():
            return [
                *_called(step.action, step.name),
                *_fields(step.goal),
                *([f"{step.on_cancel} when {step.cancel_when.text}"] if step.cancel_when else []),
                *([f"within {written(step.timeout)} s"] if step.timeout is not None else []),
                *_outputs(step),
            ]
        case steps.Service():
            return [*_called(step.service, step.name), *_fields(step.request), *_outputs(step)]
        case steps.Publish():
            return [*_called(step.topic, step.name), *_fields(step.message)]
        case steps.WaitFor():
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
