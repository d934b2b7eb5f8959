"""Requests of users to a running mission: pause, resume, step, stop, breakpoints."""

from __future__ import annotations

from collections.abc import Callable

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.events.source import ControlRequest, ControlResponse, Verb
from bt_mission.executive.executive import Executive
from bt_mission.executive.status import MissionStatus

MOST_BREAKPOINTS = 100
LONGEST_NAME = 1_000
"""Characters; breakpoints are kept, and listed in each response, also without a mission."""


class MissionControls:
    """Does what users request of a mission, between two ticks.

    Breakpoints that are set without a mission apply to later missions; they last until they are
    removed.

    Args:
        current: Returns the executive of the running mission, or None.
    """

    def __init__(self, current: Callable[[], Executive | None]) -> None:
        self._current = current
        self._breakpoints: dict[str, None] = {}

    def begin(self, executive: Executive) -> None:
        """Set the known breakpoints in a mission that starts, if it has such nodes."""
        for name in self._breakpoints:
            try:
                executive.breakpoints.add(name)
            except BtMissionError:
                continue  # of another mission

    @property
    def running(self) -> Executive:
        """The executive of the running mission; raises BtMissionError without one."""
        executive = self._current()
        if executive is None or not executive.status.is_active:
            raise BtMissionError("no mission is running", code="BT-916")
        return executive

    @property
    def breakpoints(self) -> list[str]:
        """Those of users, and those with which the mission was started, by name or path."""
        executive = self._current()
        own = () if executive is None else executive.breakpoints.names
        return list(dict.fromkeys((*self._breakpoints, *own)))

    def perform(self, request: ControlRequest) -> ControlResponse:
        """Do it, and return what was done, or why it was not."""
        try:
            return ControlResponse(True, self._performed(request.verb, request.node))
        except BtMissionError as error:
            return ControlResponse(False, str(error))

    def _performed(self, verb: Verb, node: str) -> str:
        match verb:
            case Verb.PAUSE | Verb.PAUSE_KEEPING_GOALS:
                return _pause(self.running, keep_goals=verb is Verb.PAUSE_KEEPING_GOALS)
            case Verb.RESUME:
                return _resume(self.running)
            case Verb.STEP:
                return _step(self.running)
            case Verb.STOP:
                self.running.interrupt("stopped on request")
                return "stopping; waiting until all goals have ended"
            case Verb.BREAK:
                return self._add(node)
            case Verb.UNBREAK:
                return self._remove(node)

    def _add(self, name: str) -> str:
        executive, known = self._current(), self.breakpoints
        if len(name) > LONGEST_NAME:
            raise BtMissionError(f"no node has a name of {len(name):,} characters", code="BT-916")
        if len(known) >= MOST_BREAKPOINTS and name not in known:
            raise BtMissionError(
                f"{MOST_BREAKPOINTS} breakpoints are set; remove one first", code="BT-916"
            )
        count = 0 if executive is None else executive.breakpoints.add(name)
        self._breakpoints[name] = None
        return f"pauses before '{name}'" + (f" ({count} nodes)" if count > 1 else "")

    def _remove(self, name: str) -> str:
        executive = self._current()
        if name not in self.breakpoints:
            raise BtMissionError(f"no breakpoint on '{name}'", code="BT-916")
        self._breakpoints.pop(name, None)
        if executive is not None and name in executive.breakpoints.names:
            executive.breakpoints.remove(name)
        return f"'{name}' no longer pauses"


def _pause(executive: Executive, *, keep_goals: bool) -> str:
    if executive.status is MissionStatus.RECOVERING:
        raise BtMissionError("the mission is being resumed; try again when it runs", code="BT-916")
    executive.pause("paused on request", keep_goals=keep_goals)
    running = ", ".join(f"'{leaf.name}'" for leaf in executive.running_leaves)
    return "paused" + (f"; still running: {running}" if running else "")


def _resume(executive: Executive) -> str:
    if executive.status is not MissionStatus.PAUSED:
        raise BtMissionError("the mission is not paused", code="BT-916")
    executive.resume()
    return "resumed"


def _step(executive: Executive) -> str:
    if executive.status is not MissionStatus.PAUSED:
        raise BtMissionError("the mission is not paused; pause it first", code="BT-916")
    executive.step()
    return "stepped one tick"
