"""A mission under test: steps, conditions, and what happened."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour
from rclpy.node import Node

from bt_mission.base.clock_watch import CONTAINED
from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control, seconds
from bt_mission.executive.report import Report, report_on
from bt_mission.language.mission import Mission
from bt_mission.ros.subscriber import LatestMessageSubscriber
from bt_mission.scenarios.faults import FaultInstance
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.scenarios.faults.targets import find_node
from bt_mission.scenarios.scenario import TIME_IS_UP
from bt_mission.sessions.scripted_server import ScriptedServer
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from bt_mission.testing.assertions import Assertions, holds
from bt_mission.testing.failure_recording import FailureRecording
from bt_mission.testing.history import History, Pose, Recorded, TestedGoal
from bt_mission.testing.moment import Condition, Moment

Action = Callable[["Run"], Any]
"""Something that a test does to a run at its time, such as a fault."""

LIMIT_S = 600.0
"""Virtual seconds after which a run counts as one that never ends."""

LAST_EVENTS = 12


@dataclass(frozen=True, eq=False)
class PendingActions:
    """Actions of a test that wait for their time or their condition.

    Attributes:
        what: How the test has asked for them.
        condition: None for a time.
        may_not_happen: Does the test pass without them?
    """

    actions: tuple[Action, ...]
    what: str
    condition: Condition | None = None
    may_not_happen: bool = False


class NeverHeldError(AssertionError):
    """A run did not reach the point that its test expected; the message has the tree."""


class Run(Assertions):
    """A mission on the stage, moved on by a test and asked by it.

    Times are virtual, in seconds since the start. The run can be asked about after it is closed;
    ``moments`` are its control steps so far, in order.

    Args:
        mission: The mission to run, with its world, robot and seed.
        folder: For pictures.
        options: For :class:`bt_mission.sessions.stage_robot.StageOptions`.
    """

    def __init__(self, mission: Mission, folder: Path, **options: Any) -> None:
        super().__init__()
        self.mission = mission
        self.options = StageOptions(**options)
        self.stage = Stage(mission, image_folder=folder, say=self._say, options=self.options)
        self.robot_run = self.stage.runs[0]
        self.history = History(self.stage)
        self._topics: dict[str, Recorded] = {}
        self.faults: list[FaultInstance] = []
        self.scripted: Mapping[str, ScriptedServer] = {}
        self.make_node: Callable[[str], Node] = self.stage.make_node
        self.recording: FailureRecording | None = None
        """Where the run is recorded."""
        self.replay_command: Callable[[], str] = str
        """Gives what to type to see the run again; empty where nothing is kept of it."""
        self._observer: Node | None = None
        self._error: Exception | None = None
        self._pending: list[PendingActions] = []
        self._beats = 0
        self._is_closed = False
        self.was_moved = False
        """Whether the test has run it, or a program beside it to its end."""
        self.stopped_s: float | None = None
        """When the test ended it, s since the start; None if it ended alone."""

    # ---- moving on -----------------------------------------------------------------------

    def step(self) -> Moment:
        """Run to the next control step; return it.

        Raises:
            ScenarioError: When the mission has ended.
        """
        executive = self.stage.executive
        while executive.cycles == self._beats:
            if self.is_done or self._is_closed:
                raise ScenarioError(f"the mission has ended: {self._ended}")
            self.stage.step()
            if self._error is not None:
                error, self._error = self._error, None
                raise error
        self._beats = executive.cycles
        moment = Moment.of(self)
        self.moments.append(moment)
        self._act_by_condition(moment)
        return moment

    def advance(self, seconds: float) -> Moment:
        """Run for some seconds, or to the mission's end; return the last control step."""
        end = self.t + seconds
        while not self.is_done and self.t < end - 1e-9:
            self.step()
        return self.now

    def until(self, condition: Condition, *, within: float = 60.0) -> Moment:
        """Run until a condition holds; return that control step.

        Raises:
            NeverHeldError: When it has not after ``within`` seconds, or at the mission's end.
        """
        end = self.t + within
        while self.t < end - 1e-9:
            if self.is_done:
                raise self._failed(f"the mission ended before the condition held: {self._ended}")
            moment = self.step()
            if holds(condition, moment):
                return moment
        raise self._failed(f"the condition did not hold within {within:g} s")

    def until_done(self, *, within: float = LIMIT_S) -> Report:
        """Run to the mission's end; return its report.

        Raises:
            NeverHeldError: When it has not ended after ``within`` seconds.
        """
        end = self.t + within
        while not self.is_done:
            if self.t >= end - 1e-9:
                raise self._failed(f"the mission did not end within {within:g} s")
            self.step()
        return self.report

    def do(self, *actions: Action) -> None:
        """Apply actions now."""
        self.stage.watch_users()
        with CONTAINED:
            for action in actions:
                action(self)

    def at(self, time: float, *actions: Action, may_not_happen: bool = False) -> None:
        """Apply actions at a time: after the measurements of that instant, before all else.

        Args:
            may_not_happen: If not, a test fails whose run ends before that time.

        Raises:
            ScenarioError: When that time is past.
        """
        if time < self.t - 1e-9:
            raise ScenarioError(f"{time:g} s is in the past: the run is at {self.t:g} s")
        self.stage.watch_users()
        pending = PendingActions(actions, f"run.at({time:g}, ...)", may_not_happen=may_not_happen)
        self._pending.append(pending)
        self.stage.clock.call_at(
            self.stage.start_ns + round(time * 1e9), lambda: self._do_within_a_step(pending)
        )

    def when(self, condition: Condition, *actions: Action, may_not_happen: bool = False) -> None:
        """Apply actions once, after the first control step at which a condition holds.

        Args:
            may_not_happen: If not, a test fails in whose run the condition never holds.
        """
        self._pending.append(
            PendingActions(
                actions, "run.when(...)", condition=condition, may_not_happen=may_not_happen
            )
        )

    # ---- asking --------------------------------------------------------------------------

    @property
    def t(self) -> float:
        """Virtual time since the start, s."""
        return self.history.seconds(self.stage.now_ns)

    @property
    def now(self) -> Moment:
        """The newest control step.

        Raises:
            ScenarioError: Before the first.
        """
        if not self.moments:
            raise ScenarioError("the run has no control step yet: call run.step() first")
        return self.moments[-1]

    @property
    def pose(self) -> Pose:
        """True pose of the base now: x m, y m, yaw rad."""
        return self.robot_run.robot.pose

    def events(self, kind: str) -> list[dict[str, Any]]:
        """The events of one kind in the run's trace, in order (docs/reference/trace.md)."""
        return [event for event in self.history.read_events() if event.get("event") == kind]

    @property
    def is_done(self) -> bool:
        """Has the mission ended, with every goal accounted for?"""
        return self.stage.is_done

    @property
    def status(self) -> str:
        """The :class:`~bt_mission.executive.status.MissionStatus`, such as ``running``."""
        return str(self.stage.executive.status)

    @property
    def reason(self) -> str:
        """Why the mission ended as it did; empty after success."""
        return self.stage.executive.reason

    @property
    def succeeded(self) -> bool:
        """Has the mission ended with success?"""
        return self.status == "success"

    @property
    def failed(self) -> bool:
        """Has the mission ended with failure?"""
        return self.status == "failure"

    @property
    def report(self) -> Report:
        """The summary of the run so far; its wall time is 0, which no test may depend on."""
        stage = self.stage
        results = stage.runner.requirements.results()
        warnings = stage.runner.warnings
        return report_on(self.mission, stage.executive, stage.trace, self.t, 0.0, results, warnings)

    @property
    def goals(self) -> tuple[TestedGoal, ...]:
        """Every goal sent, in order."""
        return tuple(self.history.goals.values())

    @property
    def log(self) -> list[str]:
        """What ``log`` nodes have said."""
        return [text for _, text in self.history.logged_lines]

    def leaf(self, name: str) -> Any:
        """The node of this name or path, as it is now."""
        return self.now.leaf(name)

    def find(self, name: str) -> Behaviour:
        """The node of this name, or at this path.

        Raises:
            ScenarioError: If not exactly one exists.
        """
        return find_node(self.stage.executive, name)

    def record(self, *topics: str) -> None:
        """Write down the messages of topics from now on; names and types are those of the graph.

        Raises:
            ScenarioError: For a topic without a publisher; it names those with one.
        """
        if self._observer is None:
            self._observer = self.stage.make_node("observer")
        node = self._observer
        known = {name: types[0] for name, types in node.get_topic_names_and_types()}
        for topic in topics:
            name = node.resolve_topic_name(topic)
            if name in self._topics:
                continue
            if name not in known:
                raise no_such("topic", name, sorted(known))
            recorded = self._topics[name] = Recorded(name, self.stage)
            LatestMessageSubscriber(node, name, known[name]).listen(recorded.add)

    def blame_test(self, error: Exception) -> None:
        """Have the present step raise an error of the test's own, once it is over."""
        self._error = self._error or error

    def topic(self, name: str) -> Recorded:
        """The messages of a topic that is recorded.

        Raises:
            ScenarioError: When it is not.
        """
        full = name if name.startswith("/") else f"/{name}"
        if full not in self._topics:
            recorded = ", ".join(self._topics) or "nothing"
            raise ScenarioError(
                f"{full} is not recorded, but {recorded}: call run.record('{name}') at the start"
            )
        return self._topics[full]

    def describe(self) -> str:
        """Everything that a person wants to know of a run that went wrong."""
        history = self.history
        parts = [
            f"{self.mission.name}: {self._ended}, at {seconds(self.t)}, seed {self.mission.seed}",
            history.tree_text(len(history.changes)),
        ]
        goals = [str(life) for life in self.goals[-LAST_EVENTS:]]
        parts += ["last goals:", *(f"  {line}" for line in goals)] if goals else []
        faults = [str(fault) for fault in self.faults[-LAST_EVENTS:]]
        parts += ["last faults:", *(f"  {line}" for line in faults)] if faults else []
        parts += ["last events:", *history.last_events(LAST_EVENTS)]
        for verdict in self.broken:
            parts += ["", verdict.details or verdict.line]
        return "\n".join(parts)

    def __repr__(self) -> str:
        failed = self.history.failed_path()
        what = self.reason
        if failed:
            names = " > ".join(node.name for node in failed)
            what = f"{names}: {failed[-1].feedback_message or 'failed'}"
        parts = [f"{self.mission.name}: {self.status} at {seconds(self.t)}", what]
        if command := self.replay_command():
            parts.append(f"if the test fails: {command}")
        return f"<run of {'; '.join(filter(None, parts))}>"

    # ---- the end -------------------------------------------------------------------------

    def close(self) -> tuple[str, ...]:
        """Interrupt a mission that runs on, and take everything down.

        Returns a line for each goal that has not ended.
        """
        if self._is_closed:
            return ()
        self.was_moved = self.was_moved or self.stage.executive.cycles > 0
        try:
            if self.stage.executive.status.is_active:
                self.stopped_s = self.t
            if self.stage.is_broken:
                self.stage.executive.abandon("the test was interrupted")
            self.stage.executive.interrupt(TIME_IS_UP)
            end = self.t + LIMIT_S
            while not self.is_done and self.t < end:
                self.stage.step()
        except BtMissionError as error:
            return (*self.stage.executive.goals_left_behind, str(error))
        else:
            return self.stage.executive.goals_left_behind
        finally:
            self._is_closed = True
            if self.recording is not None:
                self.recording.finish(self.report.as_dict())
            self.stage.__exit__()

    @property
    def _ended(self) -> str:
        return escape_control(f"{self.status}: {self.reason}" if self.reason else self.status)

    def _say(self, text: str) -> None:
        self.history.say(text)

    def _failed(self, what: str) -> NeverHeldError:
        history = self.history
        return NeverHeldError(
            f"{what}; at {seconds(self.t)}:\n{history.tree_text(len(history.changes))}"
        )

    @property
    def pending(self) -> tuple[PendingActions, ...]:
        """The actions whose time or condition has not come."""
        return tuple(self._pending)

    @property
    def untested(self) -> Iterator[str]:
        """A line for each thing that the test has prepared and that has not happened."""
        if not self.was_moved:
            yield f"the run of '{self.mission.name}' was never moved: call run.until_done()"
            return
        for pending in self._pending:
            if not pending.may_not_happen:
                yield f"{pending.what} never happened: the run was over at {seconds(self.t)}"

    def _do_within_a_step(self, pending: PendingActions) -> None:
        """What goes wrong in an action is the test's business, not the mission's."""
        self._pending.remove(pending)
        try:
            self.do(*pending.actions)
        except Exception as error:  # noqa: BLE001 - raised again once the step is over
            self.blame_test(error)

    def _act_by_condition(self, moment: Moment) -> None:
        for pending in tuple(self._pending):
            if pending.condition is not None and holds(pending.condition, moment):
                self._pending.remove(pending)
                self.do(*pending.actions)
