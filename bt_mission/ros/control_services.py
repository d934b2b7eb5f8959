"""Services that control a running mission: pause, resume, step, stop, breakpoint, revise."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Any

from bt_mission_interfaces.srv import PauseMission, ReviseMission, SetBreakpoint
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.executive import Executive
from bt_mission.executive.status import MissionStatus
from bt_mission.language.revision import Revision
from bt_mission.ros.graph import REQUESTS

MOST_BREAKPOINTS = 100
LONGEST_NAME = 1_000
"""Characters; breakpoints are kept, and listed in each response, also without a mission."""


class ControlServices:
    """Offers ``~/pause``, ``~/resume``, ``~/step``, ``~/stop``, ``~/breakpoint``, ``~/revise``.

    Breakpoints that are set without a mission apply to later missions; they last until they are
    removed.

    Args:
        node: The node of the services; their names begin with its name.
        current: Returns the running mission, or None.
        revise: Continues with the version of a request of ``~/revise``; raises BtMissionError.
    """

    def __init__(
        self,
        node: Node,
        current: Callable[[], Executive | None],
        revise: Callable[[Any], Awaitable[Revision]],
    ) -> None:
        self._current = current
        self._revise_on_request = revise
        self._breakpoints: dict[str, None] = {}
        self._node = node
        served: list[tuple[Any, str, Callable[[Any, Any], Any]]] = [
            (PauseMission, "pause", self._pause),
            (Trigger, "resume", self._served(_resume)),
            (Trigger, "step", self._served(_step)),
            (Trigger, "stop", self._served(_stop)),
            (SetBreakpoint, "breakpoint", self._breakpoint),
        ]
        self._services = [
            node.create_service(kind, f"~/{name}", serve, qos_profile=REQUESTS)
            for kind, name, serve in served
        ]
        # It awaits ticks, so it must not hold the callback group of the tick's timer.
        alone = MutuallyExclusiveCallbackGroup()
        self._services.append(
            node.create_service(
                ReviseMission,
                "~/revise",
                self._revise,
                qos_profile=REQUESTS,
                callback_group=alone,
            )
        )

    def close(self) -> None:
        """Destroy the services."""
        while self._services:
            self._node.destroy_service(self._services.pop())

    def begin(self, executive: Executive) -> None:
        """Set the known breakpoints in a mission that starts, if it has such nodes."""
        for name in self._breakpoints:
            try:
                executive.breakpoints.add(name)
            except BtMissionError:
                continue  # of another mission

    def _running(self) -> Executive:
        executive = self._current()
        if executive is None or executive.status is not MissionStatus.RUNNING:
            raise BtMissionError("no mission is running", code="BT-916")
        return executive

    def _pause(self, request: Any, answer: Any) -> Any:
        def act(executive: Executive) -> str:
            executive.pause("paused on request", keep_goals=request.keep_goals)
            running = ", ".join(f"'{leaf.name}'" for leaf in executive.running_leaves)
            return "paused" + (f"; still running: {running}" if running else "")

        return self._served(act)(request, answer)

    def _breakpoint(self, request: Any, answer: Any) -> Any:
        try:
            answer.message, answer.success = self._change(request.node, remove=request.remove), True
        except BtMissionError as error:
            answer.message, answer.success = str(error), False
        answer.breakpoints = self._names
        return answer

    async def _revise(self, request: Any, answer: Any) -> Any:
        try:
            self._running()
            revision = await self._revise_on_request(request)
        except BtMissionError as error:
            answer.message, answer.success = str(error), False
        else:
            answer.message, answer.success = revision.as_text(), not revision.is_refused
            answer.revision = json.dumps(revision.as_dict())
        return answer

    @property
    def _names(self) -> list[str]:
        """The breakpoints of clients, and those with which the mission was started."""
        executive = self._current()
        own = () if executive is None else executive.breakpoints.names
        return list(dict.fromkeys((*self._breakpoints, *own)))

    def _change(self, name: str, *, remove: bool) -> str:
        executive = self._current()
        if not name:
            return f"{len(self._names)} set"
        if not remove:
            if len(name) > LONGEST_NAME:
                raise BtMissionError(
                    f"no node has a name of {len(name):,} characters", code="BT-916"
                )
            if len(self._names) >= MOST_BREAKPOINTS and name not in self._names:
                raise BtMissionError(
                    f"{MOST_BREAKPOINTS} breakpoints are set; remove one first", code="BT-916"
                )
            count = 0 if executive is None else executive.breakpoints.add(name)
            self._breakpoints[name] = None
            return f"pauses before '{name}'" + (f" ({count} nodes)" if count > 1 else "")
        if name not in self._names:
            raise BtMissionError(f"no breakpoint on '{name}'", code="BT-916")
        self._breakpoints.pop(name, None)
        if executive is not None and name in executive.breakpoints.names:
            executive.breakpoints.remove(name)
        return f"'{name}' no longer pauses"

    def _served(self, act: Callable[[Executive], str]) -> Callable[[Any, Any], Any]:
        def serve(_request: Any, answer: Any) -> Any:
            try:
                answer.message, answer.success = act(self._running()), True
            except BtMissionError as error:
                answer.message, answer.success = str(error), False
            return answer

        return serve


def _resume(executive: Executive) -> str:
    if executive.paused is None:
        raise BtMissionError("the mission is not paused", code="BT-916")
    executive.resume()
    return "resumed"


def _step(executive: Executive) -> str:
    if executive.paused is None:
        raise BtMissionError("the mission is not paused; pause it first", code="BT-916")
    executive.step()
    return "stepped one tick"


def _stop(executive: Executive) -> str:
    executive.interrupt("stopped on request")
    return "stopping; waiting until all goals have ended"
