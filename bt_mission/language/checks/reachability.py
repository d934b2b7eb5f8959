"""Which nodes of a mission can succeed and fail, and what follows: nodes that nobody reaches.

Only what is certain is used: a goal may always end either way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.nodes.steps import (
    CheckStep,
    ChooseStep,
    FallbackStep,
    ForceStep,
    ForEachStep,
    GuardStep,
    InvertStep,
    LogStep,
    ParallelStep,
    RepeatStep,
    RetryStep,
    SequenceStep,
    SetStep,
    Step,
    SubtreeStep,
    TimeoutStep,
    WaitStep,
    WhenStep,
    Writer,
)

Ends = frozenset[str]
"""How a node can end: "success", "failure", both, or not at all."""

EITHER: Ends = frozenset({"success", "failure"})
_SUCCESS: Ends = frozenset({"success"})
_FAILURE: Ends = frozenset({"failure"})
_SWAP = {"success": "failure", "failure": "success"}


def ends_of(tree: Step, uses: Mapping[str, Ends] | None = None) -> dict[int, Ends]:
    """Return how each step of a tree can end, by the step's `id`.

    `uses` says how named trees end; of others it is not known.
    """
    ends: dict[int, Ends] = {}
    for step in reversed(list(tree.walk())):
        if uses and isinstance(step, SubtreeStep):
            ends[id(step)] = uses.get(step.tree, EITHER)
        else:
            ends[id(step)] = _ends(step, [ends[id(below)] for below in step.steps])
    return ends


def _ends(step: Step, below: list[Ends]) -> Ends:
    rule = _RULES.get(type(step))
    return EITHER if rule is None else rule(step, below)


def _parallel(_step: Any, below: list[Ends]) -> Ends:
    return EITHER if any("failure" in one for one in below) else frozenset().union(*below)


def _guard(step: GuardStep, below: list[Ends]) -> Ends:
    return below[0] if step.condition is True else below[0] | _FAILURE


def _check(step: CheckStep, _below: list[Ends]) -> Ends:
    if isinstance(step.condition, bool):
        return _SUCCESS if step.condition else _FAILURE
    return EITHER


def _in_turn(below: list[Ends], goes_on: str) -> Ends:
    """How children one after another end, each asked when the one before ended in `goes_on`."""
    found: Ends = frozenset()
    for ends in below:
        found |= ends - {goes_on}
        if goes_on not in ends:
            return found
    return found | {goes_on}


_RULES: dict[type[Step], Callable[[Any, list[Ends]], Ends]] = {
    SequenceStep: lambda _, below: _in_turn(below, "success"),
    FallbackStep: lambda _, below: _in_turn(below, "failure"),
    ParallelStep: _parallel,
    ChooseStep: lambda _, below: frozenset().union(*below),
    WhenStep: lambda _, below: frozenset().union(*below, _SUCCESS if len(below) == 1 else ()),
    RepeatStep: lambda _, below: below[0],
    RetryStep: lambda _, below: below[0],
    ForEachStep: lambda _, below: below[0] | _SUCCESS,
    TimeoutStep: lambda _, below: below[0] | _FAILURE,
    GuardStep: _guard,
    InvertStep: lambda _, below: frozenset(_SWAP[end] for end in below[0]),
    ForceStep: lambda step, below: frozenset({step.status}) if below[0] else below[0],
    CheckStep: _check,
    WaitStep: lambda _step, _below: _SUCCESS,
    LogStep: lambda _step, _below: _SUCCESS,
    SetStep: lambda _step, _below: _SUCCESS,
}
"""How a step of each kind ends, from how those below it can; others can end either way."""


def unreached(document: Document, tree: Step) -> Iterator[Diagnostic]:
    """Yield a warning for every child that stands behind one at which its parent always ends."""
    ends = ends_of(tree)
    for step in tree.walk():
        if not isinstance(step, SequenceStep | FallbackStep):
            continue
        goes_on = "success" if isinstance(step, SequenceStep) else "failure"
        never = "succeeds" if isinstance(step, SequenceStep) else "fails"
        for before, after in zip(step.children, step.children[1:], strict=False):
            if goes_on not in ends[id(before)]:
                message = f"never reached: the node before it, in line {before.line}, never {never}"
                yield document.fault(after.path, message, severity="warning")
                break


def restarted(document: Document, tree: Step) -> Iterator[Diagnostic]:
    """Yield a warning for every child that takes time and is begun anew in each tick.

    That is what `memory: false` does to all but the last child: whoever has ended is asked again
    in the next tick, with new goals, while a later sibling runs.
    """
    for step in tree.walk():
        if not isinstance(step, SequenceStep | FallbackStep) or step.memory:
            continue
        ended = "succeeded" if isinstance(step, SequenceStep) else "failed"
        for child in step.children[:-1]:
            if any(isinstance(part, WaitStep | Writer) for part in child.walk()):
                message = (
                    f"once it has {ended}, this {child.kind} begins anew in every tick while a "
                    f"later one runs: the {step.kind} in line {step.line} has 'memory: false'"
                )
                hint = "put what takes time last, or leave 'memory' out"
                yield document.fault(child.path, message, hint, severity="warning")
