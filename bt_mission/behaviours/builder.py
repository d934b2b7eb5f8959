"""Steps of the mission language to py_trees behaviours."""

from __future__ import annotations

from dataclasses import replace

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours import control, decorators, leaves
from bt_mission.behaviours.action_leaf import ActionLeaf, Plan
from bt_mission.behaviours.evaluator import Evaluator, MessageFields, name_of, values_read
from bt_mission.behaviours.publish_leaf import PublishLeaf
from bt_mission.behaviours.python_leaf import make
from bt_mission.behaviours.runtime import Scope, placed
from bt_mission.behaviours.service_leaf import PendingCall, ServiceLeaf
from bt_mission.behaviours.subtree import Subtree
from bt_mission.behaviours.wait_for import PendingWait, WaitFor
from bt_mission.goals.attempt import Limits
from bt_mission.language.mission import Mission
from bt_mission.language.nodes import steps
from bt_mission.language.nodes.fields import LIMIT
from bt_mission.language.plugins import find_class


def build_tree(mission: Mission, scope: Scope) -> Behaviour:
    """The tree of a mission; its leaves read and write ``scope``.

    A root with children takes the mission's name where it has none. Nothing of ROS is needed to
    build it. Give each node its ``setup(runtime=...)`` before the first tick.
    """
    root = mission.tree
    if root.name is None and root.steps:
        root = replace(root, name=mission.name)
    return _Builder(mission, mission.file, scope).build(root, "0")


class _Builder:
    def __init__(self, mission: Mission, file: str, scope: Scope) -> None:
        self._mission = mission
        self._file = file
        self._scope = scope

    def build(self, step: steps.Step, path: str) -> Behaviour:
        values = Evaluator(step, path, self._file, self._scope)
        match step:
            case steps.Composite():
                children = [self.build(one, f"{path}.{i}") for i, one in enumerate(step.children)]
                return _composite(step, values, children)
            case steps.Decorator():
                return _decorator(step, values, self.build(step.child, f"{path}.0"))
            case steps.ActionStep():
                return self._action(step, values)
            case steps.ServiceStep():
                return self._service(step, values)
            case steps.WaitForStep():
                return self._wait_for(step, values)
            case steps.SubtreeStep():
                return self._subtree(step, path, values)
            case steps.PythonStep():
                return self._python(step, values)
        return _leaf(step, values)

    def _subtree(self, step: steps.SubtreeStep, path: str, values: Evaluator) -> Subtree:
        tree = self._mission.trees[step.tree]
        inner = self._scope.inner()
        builder = _Builder(self._mission, tree.document.file, inner)
        return Subtree(
            name_of(step),
            builder.build(tree.body, f"{path}.0"),
            lambda: {**tree.inputs, **values.inputs(step.inputs, step.takes)},
            inner,
            self._scope,
            step.outputs,
        )

    def _python(self, step: steps.PythonStep, values: Evaluator) -> Behaviour:
        with placed(values.place):
            kind = find_class(step.target, self._file)
        return make(
            kind,
            name_of(step),
            lambda: values.resolve(step.inputs),
            step.outputs,
            self._scope,
            values.place,
        )

    def _action(self, step: steps.ActionStep, values: Evaluator) -> ActionLeaf:
        def plan() -> Plan:
            return Plan(
                goal=values.resolve(step.goal),
                limits=Limits(
                    server=step.server_timeout,
                    answer=step.answer_timeout,
                    goal=values.limit(step.timeout),
                    silence=values.limit(step.silence_timeout),
                    cancel=step.cancel_timeout,
                    condition=None
                    if step.cancel_when is None
                    else values.condition("cancel_when", step.cancel_when),
                ),
                target=values.target(step.cancel_when),
            )

        return ActionLeaf(
            name_of(step),
            step.action,
            step.type,
            plan,
            Status.SUCCESS if step.on_cancel == "success" else Status.FAILURE,
            step.outputs,
            self._scope,
            values.place,
        )

    def _service(self, step: steps.ServiceStep, values: Evaluator) -> ServiceLeaf:
        def plan() -> PendingCall:
            return PendingCall(
                request=values.resolve(step.request),
                server_s=step.server_timeout,
                answer_s=values.number(step.timeout, LIMIT),
            )

        return ServiceLeaf(
            name_of(step),
            step.service,
            step.type,
            plan,
            step.outputs,
            self._scope,
            values.place,
        )

    def _wait_for(self, step: steps.WaitForStep, values: Evaluator) -> WaitFor:
        def plan() -> PendingWait:
            return PendingWait(
                timeout_s=values.limit(step.timeout),
                condition=values.condition("until", step.until),
                show=lambda message: values_read(step.until, MessageFields(message)),
            )

        return WaitFor(
            name_of(step),
            step.topic,
            step.type,
            plan,
            step.outputs,
            step.until.text,
            self._scope,
            values.place,
        )


def _leaf(step: steps.Step, values: Evaluator) -> Behaviour:
    name = name_of(step)
    match step:
        case steps.WaitStep():
            return leaves.Wait(name, values.seconds(step.seconds))
        case steps.LogStep():
            return leaves.Log(name, lambda: str(values.resolve(step.message)))
        case steps.CheckStep():
            return leaves.Check(name, values.question(step.condition))
        case steps.SetStep():
            return leaves.Set(name, lambda: values.assign(step.values))
        case steps.PublishStep():
            return PublishLeaf(
                name,
                step.topic,
                step.type,
                lambda: values.resolve(step.message),
                step.readers,
                step.server_timeout,
                values.place,
            )
    raise TypeError(f"no behaviour is known for a step of kind '{step.kind}'")


def _composite(step: steps.Composite, values: Evaluator, children: list[Behaviour]) -> Behaviour:
    name = name_of(step)
    match step:
        case steps.SequenceStep():
            return py_trees.composites.Sequence(name, step.memory, children)
        case steps.FallbackStep():
            return py_trees.composites.Selector(name, step.memory, children)
        case steps.ParallelStep():
            needed = range(len(children)) if step.succeed_when == "all" else step.succeed_when
            return control.Parallel(
                name,
                children,
                None if isinstance(needed, str) else needed,
                fail_fast=step.fail_when == "any",
                finish=step.rest == "finish",
            )
        case steps.ChooseStep():
            return control.Pick(name, children, values.lot(len(children), step.weights))
        case steps.WhenStep():
            return control.Pick(name, children, values.fork(step.condition))
    raise TypeError(f"no behaviour is known for a step of kind '{step.kind}'")


def _decorator(step: steps.Decorator, values: Evaluator, child: Behaviour) -> Behaviour:
    name = name_of(step)
    match step:
        case steps.RepeatStep():
            return decorators.Repeat(name, child, values.times(step.count))
        case steps.RetryStep():
            pause = values.seconds(step.pause)
            return decorators.Retry(name, child, values.times(step.attempts), pause)
        case steps.TimeoutStep():
            return control.Timeout(name, child, lambda: values.number(step.seconds, LIMIT))
        case steps.InvertStep():
            return py_trees.decorators.Inverter(name, child)
        case steps.ForceStep(status="success"):
            return py_trees.decorators.FailureIsSuccess(name, child)
        case steps.ForceStep():
            return py_trees.decorators.SuccessIsFailure(name, child)
        case steps.GuardStep():
            return control.Guard(name, child, values.question(step.condition))
        case steps.ForEachStep():
            take, leave = values.loop(step.variable)
            return control.ForEach(name, child, lambda: values.elements(step.elements), take, leave)
    raise TypeError(f"no behaviour is known for a step of kind '{step.kind}'")
