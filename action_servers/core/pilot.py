"""The pilot: the one owner of the base.

It steps the maneuvers at the control rate and is alone in commanding velocities. At most one
maneuver that drives runs at a time; a new one replaces it. Whenever a driving maneuver ends, zero
velocity is commanded before the end is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NoReturn

from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO, ErrorCode, Fields, Finished, Maneuver, Observation
from action_servers.core.tuning import TUNING
from bt_mission.base.actions import REPLACED
from bt_mission.base.geometry import Twist2D

REFUSED_WHILE_MOVING = "another goal moves the {}; it is not replaced (on_new_goal: refuse)"
REFUSED_WHILE_DRIVING = "another goal drives the robot; it is not replaced (on_new_goal: refuse)"


@dataclass(frozen=True, slots=True)
class ManeuverOutcome:
    """The end of a goal, and the fields of its result."""

    status: Literal["succeeded", "aborted", "canceled"]
    error_code: int = 0
    reason: str = ""
    result: Fields | None = None
    """None if the maneuver raised in `result`."""
    cause: Exception | None = None
    """The exception of the maneuver, if any."""


@dataclass(slots=True, eq=False)
class ManeuverRun:
    """One running maneuver; `on_end` is called exactly once."""

    maneuver: Maneuver
    on_feedback: Callable[[Fields], None]
    on_end: Callable[[ManeuverOutcome], None]
    on_note: Callable[[str], object] = lambda _: None
    """Called once when the base gives way, and when it cannot."""
    part: str = ""
    """The part that it moves besides the base."""
    title: str = ""
    """Its goal, for the goal that it replaces."""
    needs_base: bool = field(init=False)

    def __post_init__(self) -> None:
        self.needs_base = self.maneuver.needs_base


class Pilot:
    """Runs maneuvers.

    `observe` returns the robot's state, `command` sends a velocity to the base; the `governor`
    decides which velocity is commanded instead of the one that a maneuver wants. While one maneuver
    drives or moves a part, a new one of that replaces it, or is refused if `replaces` is false. Of
    those that do not drive, at most `side_goals` run at a time.
    """

    def __init__(
        self,
        observe: Callable[[], Observation],
        command: Callable[[Twist2D], None],
        governor: Governor,
        *,
        replaces: bool = True,
        side_goals: int = TUNING.side_goals,
    ) -> None:
        self._observe = observe
        self._command = command
        self._governor = governor
        self._replaces = replaces
        self._side_goals = side_goals
        self._runs: list[ManeuverRun] = []
        self._stepped_s: float | None = None

    @property
    def idle(self) -> bool:
        """Whether nothing runs."""
        return not self._runs

    @property
    def _driving(self) -> list[ManeuverRun]:
        return [run for run in self._runs if run.needs_base]

    def _moving(self, part: str) -> list[ManeuverRun]:
        return [run for run in self._runs if part and run.part == part]

    def refusal(self, *, needs_base: bool, part: str = "") -> str | None:
        """Return why a maneuver is not to be started now, or None."""
        driving = len(self._driving)
        if self._moving(part):
            return None if self._replaces else REFUSED_WHILE_MOVING.format(part)
        if needs_base:
            return REFUSED_WHILE_DRIVING if driving and not self._replaces else None
        beside = len(self._runs) - driving
        if beside < self._side_goals:
            return None
        return f"{beside} goals that do not drive run already, which is the limit (side_goals)"

    def start(self, run: ManeuverRun) -> None:
        """Start a maneuver; its first step is at the next control step.

        If it drives, it replaces the one that does, whose goal is aborted.
        """
        why = ": ".join(filter(None, (REPLACED, run.title)))
        if run.needs_base:
            self._end_all(why, self._driving)
            self._governor.begin()
        self._end_all(why, self._moving(run.part))
        self._runs.append(run)

    def cancel(self, run: ManeuverRun) -> None:
        """End a maneuver at once, on request; without effect if it has ended."""
        self._end(run, ManeuverOutcome("canceled"))

    def fail(self, run: ManeuverRun, error: Exception) -> None:
        """End a maneuver at once, because of an exception; without effect if it has ended."""
        self._end(run, raised(error))

    def stop(self, reason: str, code: ErrorCode = ErrorCode.STOPPED) -> None:
        """End every maneuver, and command zero velocity in any case."""
        self._end_all(reason, list(self._runs), code)
        self._command(ZERO)

    def hold(self) -> None:
        """Hold the base from now on: maneuvers continue, but only zero is commanded."""
        self._governor.is_held = True
        if self._driving:
            self._command(ZERO)

    def release(self) -> None:
        """Let the maneuver that drives command the base again."""
        self._governor.is_held = False

    def stop_driving(self, reason: str, code: ErrorCode) -> None:
        """End the maneuver that drives, if any, with a code and a reason."""
        self._end_all(reason, self._driving, code)

    def step(self) -> None:
        """Make one control step."""
        if not self._runs:
            self._stepped_s = None
            return
        runs = tuple(self._runs)
        try:
            now = self._observe()
        except Exception as error:  # noqa: BLE001 - whatever a message holds, the base must stop
            for run in runs:
                self.fail(run, error)
            return
        before_s, self._stepped_s = self._stepped_s, now.time_s
        if before_s is not None and now.time_s < before_s:
            # What a maneuver does for a time, it would do for so much longer.
            self._end_all(
                f"the ROS clock was set back by {before_s - now.time_s:.2f} s", list(runs)
            )
            return
        for run in runs:
            if run in self._runs:
                self._step(run, now)

    def _step(self, run: ManeuverRun, now: Observation) -> None:
        # Without a goal that drives, nothing moves the base.
        governor = self._governor if run.needs_base else None
        try:
            if governor is not None:
                now = governor.look(now)
            answer = run.maneuver.step(now)
            if isinstance(answer, Twist2D) and answer.is_finite:
                allowed = None if governor is None else governor.allow(answer, now)
                if governor is not None and governor.notes:
                    for note in governor.notes:
                        run.on_note(note)
                    governor.notes.clear()
                feedback = run.maneuver.feedback()
                if feedback is not None:
                    run.on_feedback(feedback)
                # Last, so that an exception above is followed by zero and nothing else.
                if allowed is not None:
                    self._command(allowed.twist)
                return
            if not isinstance(answer, Finished):
                _refuse(answer)
        except Exception as error:  # noqa: BLE001 - a fault in one maneuver must not end the server
            self.fail(run, error)
            return
        self._end(
            run,
            ManeuverOutcome(answer.status, answer.error_code, answer.reason),
            with_feedback=True,
        )

    def _end_all(
        self, reason: str, runs: list[ManeuverRun], code: ErrorCode = ErrorCode.STOPPED
    ) -> None:
        for run in runs:
            self._end(run, ManeuverOutcome("aborted", code, reason))

    def _end(
        self, run: ManeuverRun, outcome: ManeuverOutcome, *, with_feedback: bool = False
    ) -> None:
        if run not in self._runs:
            return
        self._runs.remove(run)
        if run.needs_base:
            self._command(ZERO)
            if self._governor.give_way.times:
                summary = self._governor.give_way.summary
                reason = "; ".join(filter(None, (outcome.reason, summary)))
                outcome = replace(outcome, reason=reason)
        try:
            feedback = run.maneuver.feedback() if with_feedback else None
            if feedback is not None:
                run.on_feedback(feedback)
            outcome = replace(outcome, result=run.maneuver.result())
        except Exception as error:  # noqa: BLE001 - the goal must end, with what is known
            if outcome.status == "succeeded":
                outcome = raised(error)
        run.on_end(outcome)


def _refuse(answer: object) -> NoReturn:
    if not isinstance(answer, Twist2D):
        raise TypeError(f"a maneuver must answer with Twist2D or Finished, got {answer!r}")
    raise ValueError(f"a maneuver commanded {answer}")


def raised(error: Exception) -> ManeuverOutcome:
    """Return how a goal ends whose maneuver raised."""
    reason = f"{type(error).__name__}: {error}"
    return ManeuverOutcome("aborted", ErrorCode.UNKNOWN, reason, cause=error)


STOPPED = "stopped"
MOTORS_OFF = "motors off"


class Interlock:
    """Ends what the pilot does, and refuses goals until the cause is gone.

    A stop ends and refuses everything; motors that are off end and refuse only what drives. What
    drives is also refused while one of the `looks` returns a reason.
    """

    def __init__(self, pilot: Pilot, looks: Sequence[Callable[[], str | None]] = ()) -> None:
        self._pilot = pilot
        self._looks = looks
        self._stopped = False
        self._motors_on = True

    def stop(self) -> str:
        """Stop the base and end every goal; may be repeated. Return a message."""
        already, self._stopped = self._stopped, True
        self._pilot.stop(STOPPED)
        return "stopped already" if already else "stopped; goals are refused until release"

    def release(self) -> str:
        """Let goals be accepted again. Return a message."""
        was_stopped, self._stopped = self._stopped, False
        return "released" if was_stopped else "was not stopped"

    def set_motors(self, *, on: bool) -> None:
        """Note whether the motors are on; they count as on before the first call."""
        self._motors_on = on
        if not on:
            self._pilot.stop_driving(MOTORS_OFF, ErrorCode.MOTORS_OFF)

    def refusal(self, *, needs_base: bool, part: str = "") -> str | None:
        """Return why a goal is not accepted now, or None."""
        why = next(filter(None, (look() for look in self._looks)), None) if needs_base else None
        if why is not None:
            return why
        if self._stopped:
            return f"{STOPPED}; call the service release to continue"
        if needs_base and not self._motors_on:
            return f"{MOTORS_OFF}; switch them on with the service motor_power"
        return self._pilot.refusal(needs_base=needs_base, part=part)
