"""The servers of a scenario: actions whose goals get written answers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from action_msgs.srv import CancelGoal
from pydantic import Field
from rclpy.context import Context
from rclpy.node import Node
from typing_extensions import override

from bt_mission.base.diagnostics import Diagnostic, did_you_mean, listed, quoted
from bt_mission.base.yaml.document import Document
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.message_types import nested
from bt_mission.language.mission import Mission
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import Written
from bt_mission.language.trees import all_steps
from bt_mission.ros.interface_types import FillError, action_type, fill
from bt_mission.sessions.scripted_server import ScriptedGoal, ScriptedServer

Time = Annotated[float, fields.in_unit("s"), Field(ge=0)]
Values = dict[str, Any]


class FeedbackForm(Written):
    """Feedback of a goal: once, or again and again until the next."""

    after: Time = 0.0
    values: Values = {}
    every: Annotated[float, fields.in_unit("s"), Field(gt=0)] | None = None


class GoalForm(Written):
    """The answers to one goal; times are seconds since it arrived."""

    may_not_be_asked: bool = False
    answer: Literal["accept", "reject", "none"] = "accept"
    answer_after: Time = 0.0
    feedback: list[FeedbackForm] = []
    end: Literal["succeed", "abort", "cancel", "never"] = "succeed"
    after: Time = 0.1
    result: Values = {}
    cancel: Literal["confirm", "refuse", "ignore", "succeed", "abort"] = "confirm"


WrittenServers = dict[fields.Line, list[GoalForm]]


@dataclass(frozen=True)
class ServerScript:
    """An action and the answers to its goals, in the order in which they arrive.

    A goal behind the last one gets the usual answers: it is accepted and succeeds.

    Attributes:
        written: Its name in the scenario.
    """

    name: str
    type: str
    goals: tuple[GoalForm, ...]
    written: str

    def __call__(self, context: Context) -> "ScriptedNode":
        """Return its node, for a stage."""
        return ScriptedNode(self, context)

    def lines(self) -> dict[int | None, str]:
        """Return the lines about answers that got no goal, by number; None for all of them."""
        lines: dict[int | None, str] = {None: f"{self} got no goal"}
        for number in range(len(self.goals)):
            lines[number] = f"answer {number + 1} of {self} got no goal"
        return lines

    def unused(self, goals: int) -> Iterator[str]:
        """Yield the lines about unused answers, given the number of goals that have come."""
        lines = self.lines()
        if not goals and not any(goal.may_not_be_asked for goal in self.goals):
            yield lines[None]
            return
        for number, goal in enumerate(self.goals):
            if number >= goals and not goal.may_not_be_asked:
                yield lines[number]

    def __str__(self) -> str:
        return f"the scripted server of {self.name}"


class ScriptedNode(Node):
    """Offers the action of a script."""

    def __init__(self, script: ServerScript, context: Context) -> None:
        super().__init__(
            f"scripted_{script.name.strip('/').replace('/', '_')}",
            context=context,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self.server = _PlayingServer(self, script)
        self.script = script

    def untested(self) -> Iterator[str]:
        """Yield what of its script was not used, a line each."""
        yield from self.script.unused(len(self.server.goals))


class _PlayingServer(ScriptedServer):
    """Answers goals by a script."""

    def __init__(self, node: Node, script: ServerScript) -> None:
        super().__init__(node, script.type, script.name, accepts=None, cancels=None)
        self._script = script

    def _form(self, goal: ScriptedGoal) -> GoalForm:
        number = self.goals.index(goal)
        forms = self._script.goals
        return forms[number] if number < len(forms) else GoalForm()

    @override
    def on_goal(self, goal: ScriptedGoal) -> None:
        form = self._form(goal)
        if form.answer == "reject":
            self._after(form.answer_after, goal.reject)
            return
        if form.answer == "accept":
            self._after(form.answer_after, goal.accept)
        for number, feedback in enumerate(form.feedback):
            later = form.feedback[number + 1 :]
            until = later[0].after if later else None
            self._after(feedback.after, self._feeding(goal, feedback, until))
        if form.end != "never" and form.answer == "accept":
            self._after(form.after, lambda: self._end(goal, form.end))

    @override
    def on_cancel(self, goal: ScriptedGoal) -> None:
        cancel = self._form(goal).cancel
        if cancel == "ignore":
            return
        if cancel != "confirm":
            goal.answer_cancel(CancelGoal.Response.ERROR_REJECTED, taken=False)
        else:
            goal.answer_cancel()
        if cancel != "refuse":
            self._end(goal, "cancel" if cancel == "confirm" else cancel)

    def _end(self, goal: ScriptedGoal, end: str) -> None:
        if not goal.has_ended:
            result = nested(self._form(goal).result)
            {"succeed": goal.succeed, "abort": goal.abort, "cancel": goal.cancel}[end](**result)

    def _feeding(
        self, goal: ScriptedGoal, feedback: FeedbackForm, until: float | None
    ) -> Callable[[], None]:
        every, at = feedback.every, feedback.after

        def feed() -> None:
            nonlocal at
            if goal.has_ended or (until is not None and at >= until):
                return
            goal.feed(**nested(feedback.values))
            if every is not None:
                at += every
                self._after(every, feed)

        return feed

    def _after(self, seconds: float, act: Callable[[], None]) -> None:
        """Act after a time, or at once."""
        if seconds == 0:
            act()
            return

        def act_once() -> None:
            timer.cancel()
            act()

        timer = self.node.create_timer(seconds, act_once)


def action_of(mission: Mission, name: str) -> tuple[str, str] | None:
    """Return the ROS name and the type of an action that a mission uses, or that has a kind."""
    for step in all_steps(mission):
        if isinstance(step, GoalNode) and step.ros_name.strip("/") == name.strip("/"):
            return step.ros_name, step.type
    if name in ACTION_NAMES:
        return ACTION_NAMES[name].name, ACTION_NAMES[name].type
    return None


class ServersReader:
    """Finds the actions of the servers of a scenario, and checks their fields."""

    def __init__(self, document: Document, mission: Mission) -> None:
        self._document, self._mission = document, mission
        self.diagnostics: list[Diagnostic] = []

    def read(self, written: WrittenServers) -> Iterator[ServerScript]:
        """Yield those without errors."""
        for name, goals in written.items():
            known = action_of(self._mission, name)
            if known is None:
                self._note_unknown(name)
                continue
            count = len(self.diagnostics)
            kind = action_type(known[1])
            for number, goal in enumerate(goals):
                path = ("servers", name, number)
                self._check(kind.Result, goal.result, (*path, "result"))
                for place, feedback in enumerate(goal.feedback):
                    self._check(
                        kind.Feedback, feedback.values, (*path, "feedback", place, "values")
                    )
            if len(self.diagnostics) == count:
                yield ServerScript(*known, tuple(goals), name)

    def _note_unknown(self, name: str) -> None:
        steps = (step for step in all_steps(self._mission) if isinstance(step, GoalNode))
        names = list(dict.fromkeys([*(step.ros_name for step in steps), *ACTION_NAMES]))
        message = f"no action is named {quoted(name)} (known: {listed(names)})"
        hint = did_you_mean(name, names)
        self._diagnostics_at("BT-705", ("servers", name), message, hint, key=True)

    def _check(self, kind: type, values: Values, path: tuple[Any, ...]) -> None:
        try:
            fill(kind(), nested(values))
        except FillError as error:
            self._diagnostics_at(error.code, path, str(error))

    def _diagnostics_at(
        self,
        code: str,
        path: tuple[Any, ...],
        message: str,
        hint: str | None = None,
        *,
        key: bool = False,
    ) -> None:
        self.diagnostics.append(self._document.diagnostic(code, path, message, hint, key=key))
