"""Requirements that a test checks of a run, and those of its mission.

A requirement is evaluated over the control steps that the run has had. One that does not hold says
when it was violated first, the values of its signals then, and shows the tree.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from bt_mission.base.actions import GOALS_AT, goals_at
from bt_mission.base.errors import described
from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.base.verdicts import RequirementResult
from bt_mission.language.expressions.syntax import SyntaxNode
from bt_mission.language.expressions.values import ExpressionError, Plain
from bt_mission.language.mission import Requirement
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.formula import Formula, signals_in
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.requirements.monitor import Monitor
from bt_mission.ros.signals import field_of
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.sessions.stage import Stage
from bt_mission.testing.errors import RequirementResults
from bt_mission.testing.moment import Condition, Moment

OF_MOMENT: Mapping[str, Callable[[Moment], Plain]] = {
    "time": lambda moment: moment.t,
    **{
        name: attrgetter(name)
        for name in ("x", "y", "yaw", "clearance", "collisions", "speed", "turn_rate", "distance")
    },
    "nearest": lambda moment: moment.nearest or "",
    "odometry.x": lambda moment: moment.odometry[0],
    "odometry.y": lambda moment: moment.odometry[1],
    "odometry.yaw": lambda moment: moment.odometry[2],
    "open_goals": lambda moment: len(moment.open_goals),
    **{
        name: lambda moment, part=part: goals_at(part, moment.open_goals)  # type: ignore[misc]
        for name, part in GOALS_AT.items()
    },
}
OF_NODE = ("running", "succeeded", "failed")


class MomentSignals:
    """The signals of requirements at one moment of a run: what tests read of it, too."""

    moment: Moment

    def reader(self, signal: SignalValue, /) -> Reader | str:
        """Return what gives a signal's value at the moment, or why moments do not have it."""
        name, arguments = signal.name, signal.arguments
        if name in OF_MOMENT:
            read = OF_MOMENT[name]
            return lambda: read(self.moment)
        if name in OF_NODE:
            return lambda: bool(getattr(self.moment.leaf(arguments[0]), name))
        if name == "$":
            return lambda: self.moment.variables[arguments[0]]
        if name == "topic":
            return lambda: field_of(self.moment.topic(arguments[0]), arguments[1])
        return "write it under 'requirements' of the mission, which is evaluated during the run"

    def lower_bound(self, _signal: SignalValue, /) -> None:
        """Return None: no signal of a moment has a bound that costs less."""

    def measured_by(self, _signal: SignalValue, /) -> str:
        """Return that signals of a moment are the truth."""
        return ""


_ANSWERS = frozenset(("holds", "line", "t", "margin", "details"))
"""The attributes by which a test looks at a verdict; its truth is `holds`."""


@dataclass(frozen=True, repr=False)
class Verdict:
    """Whether a requirement holds; false in a condition where it does not.

    Args:
        line: The verdict, and the values of the signals, in one line.
        t: When it was violated first, else the instant that decides, s since the start; None
            without one.
        margin: By how much it holds, below 0 by how much it is violated; None without a measure.
        details: The line, and the tree at that moment.
        was_read: Whether somebody has looked at it.
    """

    holds: bool
    line: str
    t: float | None = None
    margin: float | None = None
    details: str = ""
    was_read: bool = field(default=False, compare=False)

    def __getattribute__(self, name: str) -> Any:
        if name in _ANSWERS:
            object.__setattr__(self, "was_read", True)
        return object.__getattribute__(self, name)

    def __bool__(self) -> bool:
        return self.holds

    def __repr__(self) -> str:
        return f"<{self.line}>"


def holds(condition: Condition, moment: Moment) -> bool:
    """Look at a condition.

    Raises:
        ScenarioError: When it raises, with the time.
    """
    try:
        return bool(condition(moment))
    except ScenarioError:
        raise
    except Exception as error:
        raise ScenarioError(
            f"the condition raised {described(error)}, at {seconds(moment.t)}"
        ) from error


class Assertions:
    """What can be checked of a run; :class:`bt_mission.testing.Run` is one."""

    stage: Stage

    def __init__(self) -> None:
        self.moments: list[Moment] = []
        """Every control step so far, in order."""
        self._expected_violations: set[str] = set()
        self._checked: list[tuple[str, Verdict]] = []
        """The checks so far that do not hold, with their requirements."""

    @property
    def requirements(self) -> Mapping[str, RequirementResult]:
        """The verdicts of the mission's requirements, by their names."""
        results = self.stage.runner.requirements.results()
        return RequirementResults({result.name: result for result in results})

    def expect_violation(self, *names: str) -> None:
        """Assert that requirements are violated at the end of the run.

        The test fails where one of them is not, and where any other is.

        Raises:
            ScenarioError: For a requirement that the mission does not have.
        """
        for name in names:
            _ = self.requirements[name]
        self._expected_violations.update(names)

    @property
    def failing_requirements(self) -> tuple[str, ...]:
        """A line for each requirement that fails, and was not expected to be violated."""
        return tuple(
            str(result)
            for name, result in self.requirements.items()
            if result.fails and name not in self._expected_violations
        )

    @property
    def missing_violations(self) -> tuple[str, ...]:
        """A line for each requirement that was expected to be violated, and is not."""
        return tuple(
            str(result)
            for name, result in self.requirements.items()
            if result.verdict != "violated" and name in self._expected_violations
        )

    @property
    def unread_checks(self) -> tuple[str, ...]:
        """A line for each check that does not hold and that nobody has looked at."""
        return tuple(
            f"the result of run.check({text!r}) is not used, and it is: {verdict.line}"
            for text, verdict in self._checked
            if not verdict.was_read
        )

    def check(self, requirement: str) -> Verdict:
        """Evaluate a requirement over the control steps so far, as if the run ended there.

        One whose premise never came true does not hold, unless it begins with `may not apply:`. A
        test fails at its end if a verdict does not hold, and neither its truth nor one of its
        attributes was read: write ``assert run.check(...)``.

        It can name the signals that moments have: those of the simulation and of odometry, nodes,
        variables, `open_goals`, and topics that are recorded. `time` is since the start.

        Raises:
            ScenarioError: For an invalid requirement, a node that the mission does not have, and a
                topic that is not recorded.
        """
        try:
            root = Formula(requirement).root
        except ExpressionError as error:
            raise ScenarioError(f"{requirement}: {error}") from error
        signals = MomentSignals()
        monitor = Monitor(Requirement("", requirement), signals)
        for signals.moment in self.moments:
            monitor.step(round(signals.moment.t * NS))
        monitor.finish()
        result = monitor.result
        if not self.moments:
            verdict = Verdict(holds=False, line="the run has no control step to check")
            return self._kept(requirement, verdict)
        at = result.at if result.violated_at is None else result.violated_at
        if result.verdict in ("holds", "not applicable"):
            return Verdict(holds=True, line=result.outcome, t=at, margin=result.margin)
        signals.moment = next(
            (moment for moment in self.moments if moment.t == at), self.moments[-1]
        )
        values = {} if result.verdict == "unknown" else signals_of(root, signals)
        read = ", ".join(f"{key} = {short(value)}" for key, value in values.items())
        since = "" if result.violated_at is None else f", first at {seconds(result.violated_at)}"
        line = f"{result.outcome}{since}" + (f": {read}" if read else "")
        details = f"{requirement}: {line}\n{signals.moment.tree}"
        verdict = Verdict(holds=False, line=line, t=at, margin=result.margin, details=details)
        return self._kept(requirement, verdict)

    def _kept(self, requirement: str, verdict: Verdict) -> Verdict:
        self._checked.append((requirement, verdict))
        return verdict

    @property
    def broken(self) -> list[Verdict]:
        """The verdicts that do not hold."""
        return [verdict for _, verdict in self._checked]


def signals_of(root: SyntaxNode, signals: MomentSignals) -> dict[str, Any]:
    """Return the values of a formula's signals at a moment."""
    readers = {signal.key: signals.reader(signal) for signal in signals_in(root)}
    return {key: read() for key, read in readers.items() if not isinstance(read, str)}


def short(value: Any) -> str:
    """Return a value in few characters."""
    return f"{value:.4g}" if isinstance(value, float) else repr(value)
