"""The last instant at which a change would have saved a recorded run."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

from bt_mission.base.verdicts import FAILING
from bt_mission.commands.fork.fork import ForkResult
from bt_mission.commands.fork.source import ForkError, ForkSource

LONGEST = 10.0
"""An attempt may take this many times as long as the recorded run, and :data:`MORE_S`."""

MORE_S = 60.0


@dataclass(frozen=True)
class Try:
    """A fork that was run.

    Args:
        step_ns: The control step of the fork.
        at_s: Its time since the start, s.
        status: The verdict of the run, or ``refused`` if the change did not fit there.
        virtual_s: Its end, s.
        is_saved: Whether it has succeeded, with no requirement violated.
    """

    step_ns: int
    at_s: float
    status: str
    reason: str
    virtual_s: float
    is_saved: bool

    @classmethod
    def of(cls, result: ForkResult) -> Try:
        """Return the summary of a fork."""
        report = result.report
        failing = [str(requirement) for requirement in report.requirements if requirement.fails]
        reason = "; ".join(filter(None, (report.reason, *failing)))
        ended = (report.verdict, reason, report.virtual_s, result.is_success)
        return cls(result.step_ns, result.at_s, *ended)


Attempt: TypeAlias = Callable[[int], Try]
"""Forks at a control step, ns."""


@dataclass(frozen=True)
class SweepResult:
    """The result of a sweep of forks.

    Args:
        tries: The attempts, in order.
        last: The last instant at which the change saves the mission; None if none does.
        next: The next control step, at which it does not; None at the end of the run.
        skipped: Omitted instants at which nodes changed.
        control_steps: The number of control steps of the recorded run.
    """

    tries: tuple[Try, ...]
    last: Try | None
    next: Try | None
    skipped: int
    control_steps: int

    def as_dict(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        return asdict(self)


def sweep(source: ForkSource, attempt: Attempt, most: int) -> Generator[Try, None, SweepResult]:
    """Fork at one control step after another, and yield the result of each.

    Variables are read when a node starts and by conditions, so first the steps are tried at which a
    node changed, from the last one back to the first that saves the mission. From there the next
    step is searched at which it is not saved. Each answer is that of a run: an earlier change need
    not have a better result, so nothing is known between the steps that were tried.

    Args:
        source: The recorded run.
        attempt: Forks it.
        most: The most steps that are tried at which a node changed; evenly spread.
    """
    tries: list[Try] = []
    instants = _instants(source)
    chosen = _spread(instants, most)
    last: Try | None = None
    beyond: Try | None = None
    for step_ns in reversed(chosen):
        attempted = attempt(step_ns)
        tries.append(attempted)
        yield attempted
        if attempted.is_saved:
            last = attempted
            break
        beyond = attempted
    if last is not None:
        steps = source.steps_ns
        low = steps.index(last.step_ns)
        high = len(steps) if beyond is None else steps.index(beyond.step_ns)
        stride = 1
        while high - low > 1:
            # Most often the next step already reads what it reads too late.
            middle = min(low + stride, (low + high) // 2 if stride > 1 else low + 1)
            attempted = attempt(steps[middle])
            tries.append(attempted)
            yield attempted
            if attempted.is_saved:
                last, low, stride = attempted, middle, stride * 2
            else:
                beyond, high = attempted, middle
    skipped = len(instants) - len(chosen)
    return SweepResult(tuple(tries), last, beyond, skipped, len(source.steps_ns))


def refused(source: ForkSource, step_ns: int, error: Exception) -> Try:
    """Return a try at which the change did not fit the run."""
    reason = str(error).splitlines()[0]
    return Try(step_ns, source.seconds(step_ns), "refused", reason, 0.0, is_saved=False)


def limit_of(source: ForkSource) -> float:
    """Return the virtual seconds after which an attempt counts as endless."""
    return LONGEST * source.end_s + MORE_S


def check_worth(source: ForkSource, *, has_more: bool) -> None:
    """Refuse to save a run that has succeeded.

    Args:
        has_more: Whether there are requirements that the recorded run did not have.

    Raises:
        ForkError: It has succeeded, with no requirement violated.
    """
    fails = any(requirement.get("verdict") in FAILING for requirement in source.requirements)
    if source.outcome[0] == "success" and not fails and not has_more:
        raise ForkError(
            f"{source.path}: the run succeeded and no requirement failed, so there is "
            f"nothing to save; --require FILE adds a requirement"
        )


def _instants(source: ForkSource) -> list[int]:
    """Return the control steps at which a node changed."""
    steps = set(source.steps_ns)
    changed = {event["t"] for event in source.events if event.get("event") == "status"}
    return sorted(changed & steps) or [source.steps_ns[0]]


def _spread(instants: Sequence[int], most: int) -> Sequence[int]:
    """Return at most `most` of the instants, the first and the last among them."""
    if len(instants) <= most:
        return instants
    if most == 1:
        return instants[:1]
    last = len(instants) - 1
    return [instants[round(index * last / (most - 1))] for index in range(most)]
