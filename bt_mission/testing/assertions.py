"""What a test claims of a run: that a condition always held, or held in time.

Claims are looked at once the run is there, at every control step that it had. A claim that does
not hold says when it broke first, what the condition had read then, and shows the tree.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

from bt_mission.core.errors import described
from bt_mission.core.text import seconds
from bt_mission.faults.errors import ScenarioError
from bt_mission.requirements.monitor import RequirementResult
from bt_mission.sessions.stage import Stage
from bt_mission.testing.errors import RequirementResults
from bt_mission.testing.moment import AttributeRecorder, Condition, Moment

READ = 6
"""So many of the values that a condition read are told in the one line of a verdict."""


@dataclass(frozen=True, repr=False)
class Verdict:
    """Whether a claim holds; false in a condition where it does not.

    Args:
        line: What was found, in one line.
        t: When it was decided, s since the start; None where that is the end of the run.
        details: All values that the condition read, and the tree, at that moment.
    """

    holds: bool
    line: str
    t: float | None = None
    details: str = ""

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
    """The claims that can be made of a run; :class:`bt_mission.testing.Run` is one."""

    stage: Stage

    def __init__(self) -> None:
        self.moments: list[Moment] = []
        """Every control step so far, in order."""
        self.broken: list[Verdict] = []
        self._expected_violations: set[str] = set()

    @property
    def requirements(self) -> Mapping[str, RequirementResult]:
        """What the mission's requirements have come to, by their names."""
        results = self.stage.runner.requirements.results()
        return RequirementResults({one.name: one for one in results})

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
    def unexpected_violations(self) -> tuple[str, ...]:
        """A line for each requirement that is violated, and was not expected to be."""
        return tuple(
            str(one)
            for name, one in self.requirements.items()
            if one.verdict == "violated" and name not in self._expected_violations
        )

    @property
    def missing_violations(self) -> tuple[str, ...]:
        """A line for each requirement that was expected to be violated, and is not."""
        return tuple(
            str(one)
            for name, one in self.requirements.items()
            if one.verdict != "violated" and name in self._expected_violations
        )

    def always(
        self,
        condition: Condition,
        *,
        after: float = 0.0,
        before: float | None = None,
        until: Condition | None = None,
    ) -> Verdict:
        """The condition held at every control step.

        Args:
            after: Look only from this time on, s since the start.
            before: Look only up to this time.
            until: Look only at the steps before this holds for the first time.
        """
        moments = self._between(after, before)
        if until is not None:
            moments = takewhile(lambda moment: not holds(until, moment), moments)
        return self._each(condition, moments, expected=True)

    def never(
        self, condition: Condition, *, after: float = 0.0, before: float | None = None
    ) -> Verdict:
        """The condition held at no control step."""
        return self._each(condition, self._between(after, before), expected=False)

    def eventually(
        self, condition: Condition, *, within: float | None = None, after: float = 0.0
    ) -> Verdict:
        """The condition held at some control step.

        Args:
            within: At most so many seconds after ``after``.
        """
        before = None if within is None else after + within
        last = None
        for last in self._between(after, before):
            if holds(condition, last):
                return Verdict(holds=True, line=f"held at {seconds(last.t)}", t=last.t)
        limit = f"within {within:g} s" if within is not None else "until the end"
        since = f" after {after:g} s" if after else ""
        if last is None:
            return self._checked(0, "")
        return self._broken(f"never held {limit}{since}; last seen", condition, last)

    def whenever(self, trigger: Condition, then: Condition, *, within: float) -> Verdict:
        """Each time that ``trigger`` began to hold, ``then`` held within so many seconds.

        Where the run ended before that time was over, and ``then`` had not held, it does not.
        """
        waiting: Moment | None = None
        held = False
        answered = 0
        last = None
        for last in self.moments:
            now = holds(trigger, last)
            if now and not held and waiting is None:
                waiting = last
            held = now
            if waiting is None:
                continue
            if holds(then, last):
                answered += 1
                waiting = None
            elif last.t > waiting.t + within + 1e-9:
                break
        if waiting is not None and last is not None:
            what = f"did not follow within {within:g} s of {seconds(waiting.t)}; last seen"
            return self._broken(what, then, last)
        return Verdict(holds=True, line=f"followed all {answered} times")

    def _each(self, condition: Condition, moments: Iterable[Moment], *, expected: bool) -> Verdict:
        looked = 0
        for moment in moments:
            looked += 1
            if holds(condition, moment) is not expected:
                return self._broken("did not hold" if expected else "held", condition, moment)
        many = "all" if expected else "none of"
        return self._checked(looked, f"held at {many} {looked} control steps")

    def _between(self, after: float, before: float | None) -> Iterable[Moment]:
        for moment in self.moments:
            if before is not None and moment.t > before + 1e-9:
                return
            if moment.t >= after - 1e-9:
                yield moment

    def _checked(self, looked: int, line: str) -> Verdict:
        if looked:
            return Verdict(holds=True, line=line)
        verdict = Verdict(holds=False, line="there is no control step at which to look")
        self.broken.append(verdict)
        return verdict

    def _broken(self, what: str, condition: Condition, moment: Moment) -> Verdict:
        values = read_by(condition, moment)
        told = [f"{name} = {short(value)}" for name, value in values.items()]
        line = f"{what} at {seconds(moment.t)}"
        if told:
            line += ": " + ", ".join(told[:READ])
        details = "\n".join([f"{line.split(':')[0]}:", *(f"  {one}" for one in told), moment.tree])
        verdict = Verdict(holds=False, line=line, t=moment.t, details=details)
        self.broken.append(verdict)
        return verdict


def read_by(condition: Condition, moment: Moment) -> dict[str, Any]:
    """What a condition reads of a moment."""
    seen: dict[str, Any] = {}
    condition(AttributeRecorder(moment, seen))  # type: ignore[arg-type]  # it is there to pass for one
    return seen


def short(value: Any) -> str:
    """A value in few characters."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple) and all(isinstance(one, float) for one in value):
        return "(" + ", ".join(f"{one:.4g}" for one in value) + ")"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
