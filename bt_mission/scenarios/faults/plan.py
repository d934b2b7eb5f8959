"""Planned faults in a run on the stage: each begins at its time or on its condition."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.executive.report import FaultOutcome
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.requirements.checks import MissionNames
from bt_mission.requirements.language.formula import Condition
from bt_mission.requirements.monitor import ConditionMonitor
from bt_mission.scenarios.faults.effects import mistakes_of_test
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.scenarios.faults.fault import Fault, FaultInstance, FaultTarget
from bt_mission.scenarios.faults.planned import AfterStep, AtTime, PlannedFault, Value, WhenTrue
from bt_mission.scenarios.faults.world import OBSTACLES
from bt_mission.sessions.session import StepCallback
from bt_mission.sessions.stage_signals import StageSignals


@dataclass(frozen=True)
class FaultProblem:
    """Why a planned fault cannot be made.

    Attributes:
        code: Of the error.
        number: Of the fault among those that are planned, from 0.
        part: The part of its text that is wrong; empty is the whole.
        offset: Where in that part, from 0.
    """

    code: str
    number: int
    message: str
    part: str = ""
    offset: int = 0
    hint: str | None = None


class FaultPlan:
    """Has faults begin in a run that has not started yet.

    Args:
        target: The run.
        planned: The faults, in the order in which those of one instant begin.
    """

    def __init__(self, target: FaultTarget, planned: Sequence[PlannedFault]) -> None:
        self.planned = tuple(planned)
        self.errors: dict[int, Exception] = {}
        """Why faults could not begin, by their numbers."""
        self._target = target
        self._stage = stage = target.stage
        self._run = target.robot_run
        self._run.facts["faults"] = json.dumps([fault.text for fault in planned])
        self.faults: list[Fault] = [fault.make() for fault in planned]
        self._signals: StageSignals | None = None
        self._conditions: dict[int, ConditionMonitor] = {}
        self._true: set[int] = set()
        self._watched: dict[int, Callable[[int], bool]] = {}
        """For faults that begin once a control step is over: whether they are due."""
        self._cycles = self._run.executive.cycles
        self._run.executive.untested.append(self._untested)
        for number, fault in enumerate(planned):
            self._plan(number, fault)
        if self._conditions:
            self._run.executive.after_tick.append(self._look)
        if self._watched:
            stage.attach(StepCallback(self._after_step))

    def problems(self) -> Iterator[FaultProblem]:
        """Yield what planned faults name, break or place, and what is not there at the start."""
        yield from self._misplaced()
        for number, fault in enumerate(self.planned):
            finders = self._finders(self.faults[number])
            for parameter in fault.kind.parameters.values():
                name = fault.arguments.get(parameter.name)
                if not parameter.names or not isinstance(name, str):
                    continue
                try:
                    finders[parameter.names](name)
                except ScenarioError as error:
                    yield FaultProblem("BT-704", number, str(error), name)
            if why := self._run.robot.faults.lacks.get(fault.kind.part):
                yield FaultProblem("BT-704", number, why, fault.kind.name)
            if isinstance(fault.begins, WhenTrue):
                yield from self._unknown(number, fault.begins.condition)

    def _misplaced(self) -> Iterator[FaultProblem]:
        """Yield the obstacles that are never on the floor, or have no room at the start.

        Those of the start are put there in their order, and taken away at the end.
        """
        with ExitStack() as placed:
            for number, fault in enumerate(self.planned):
                try:
                    self._check_floor(fault)
                    if fault.begins != AtTime(0.0):
                        continue
                    if fault.name == "remove_box":
                        placed.close()
                    elif fault.name in OBSTACLES:
                        instance = FaultInstance(self._target, self.faults[number])
                        placed.callback(instance.undo_all)
                        instance.fault.begin(instance)
                except ScenarioError as error:
                    yield FaultProblem("BT-704", number, str(error))

    def _check_floor(self, fault: PlannedFault) -> None:
        """Raise ScenarioError for a place of the map that is beside the floor."""
        match fault.arguments.get("at"):
            case (int() | float() as x, int() | float() as y):
                pass
            case _:
                return
        if fault.arguments.get("nearest_free"):
            return
        name = fault.arguments.get("box" if fault.name == "move_box" else "name")
        default = "box" if fault.name == "move_box" else fault.name.removeprefix("spawn_")
        with mistakes_of_test(fault.name):
            self._run.robot.physics.props.check_floor(str(name or default), x, y)

    def _unknown(self, number: int, condition: Condition) -> Iterator[FaultProblem]:
        """Yield the names in a condition that nobody knows, and signals that no value comes of."""
        errors = [*MissionNames(self._run.mission).unknown_in(condition.root)]
        for error in errors:
            offset = error.column - 1
            yield FaultProblem(
                error.code, number, error.message, condition.text, offset, error.hint
            )
        why = self._conditions[number].why_unknown
        if why and not errors:
            yield FaultProblem("BT-704", number, why, condition.text)

    def outcomes(self) -> tuple[FaultOutcome, ...]:
        """The outcome of each, in the order of the plan."""
        instances = {id(fault.fault): fault for fault in self._target.faults}
        states = []
        for number, fault in enumerate(self.planned):
            instance = instances.get(id(self.faults[number]))
            states.append(
                FaultOutcome(
                    fault=fault.text,
                    began=None if instance is None else instance.began_s,
                    ended=None if instance is None else instance.ended_s,
                    why=self._why_not(number, fault) if instance is None else "",
                    may_not_happen=fault.may_not_happen,
                )
            )
        return tuple(states)

    def _untested(self) -> Iterator[str]:
        return (outcome.untested for outcome in self.outcomes() if outcome.fails)

    # ---- beginning -----------------------------------------------------------------------

    def _plan(self, number: int, fault: PlannedFault) -> None:
        match fault.begins:
            case AtTime(time_s=time_s):
                at_ns = self._stage.start_ns + round(time_s * NS)
                self._stage.clock.call_at(at_ns, lambda: self._begin(number))
            case AfterStep(time_s=time_s):
                after_ns = self._stage.start_ns + round(time_s * NS)
                self._watched[number] = lambda now_ns: now_ns >= after_ns
            case WhenTrue(condition=condition, held_s=held_s):
                if self._signals is None:
                    self._signals = StageSignals(self._run.runner, self._run.robot)
                self._conditions[number] = ConditionMonitor(
                    condition, self._signals, round(held_s * NS)
                )
                self._watched[number] = lambda _: number in self._true

    def _look(self) -> None:
        """Evaluate the conditions at a control step."""
        assert self._signals is not None, "it is called only where there are conditions"
        self._signals.step()
        since_ns = self._run.runner.now_ns - self._stage.start_ns
        self._true |= {
            number for number, condition in self._conditions.items() if condition.step(since_ns)
        }
        self._signals.forget()

    def _after_step(self) -> None:
        """Have faults begin once a control step is over."""
        if self._run.executive.cycles == self._cycles:
            return
        self._cycles = self._run.executive.cycles
        for number, is_due in tuple(self._watched.items()):
            if is_due(self._stage.now_ns):
                del self._watched[number]
                self._begin(number)

    def _begin(self, number: int) -> None:
        if self._run.executive.is_done:
            return
        try:
            self.faults[number](self._target)
        except Exception as error:  # noqa: BLE001 - a fault must not break into the mission
            self.errors[number] = error
            self._target.blame_test(error)

    # ---- asking --------------------------------------------------------------------------

    def _finders(self, fault: Fault) -> Mapping[str, Callable[[str], Any]]:
        probe = FaultInstance(self._target, fault)
        return {
            "topic": probe.topic,
            "service": lambda name: name in self._served or probe.service(name),
            "node": probe.node,
            "leaf": self._target.find,
            "action": self._find_action,
        }

    @property
    def _served(self) -> frozenset[Value | None]:
        """The services that planned faults offer."""
        return frozenset(
            fault.arguments.get("service") for fault in self.planned if fault.name == "serve"
        )

    def _find_action(self, name: str) -> None:
        """Look for an action without having it offered before its time."""
        node = self._run.node
        full = node.resolve_topic_name(ACTION_NAMES[name].name if name in ACTION_NAMES else name)
        known = {node.resolve_topic_name(action.name) for action in ACTION_NAMES.values()}
        known |= {*self._run.servers.actions, *self._target.scripted}
        if full not in known:
            raise no_such("action", full, sorted(known))

    def _why_not(self, number: int, fault: PlannedFault) -> str:
        if number in self.errors:
            return f"it could not be injected: {self.errors[number]}"
        end_ns = self._run.executive.ended_ns or self._stage.now_ns
        end_s = (end_ns - self._stage.start_ns) / NS
        if isinstance(fault.begins, WhenTrue):
            return f"its condition was not true by the end at {seconds(end_s)}"
        return f"the mission ended at {seconds(end_s)}"
