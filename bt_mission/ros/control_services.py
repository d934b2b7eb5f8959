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
from bt_mission.executive.controls import MissionControls
from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.language.revision import Revision
from bt_mission.ros.graph import REQUESTS

TRIGGERS = {Verb.RESUME: "resume", Verb.STEP: "step", Verb.STOP: "stop"}
"""The services whose requests have no fields, by what they do."""


class ControlServices:
    """Offers ``~/pause``, ``~/resume``, ``~/step``, ``~/stop``, ``~/breakpoint``, ``~/revise``.

    Args:
        node: The node of the services; their names begin with its name.
        controls: Does what is requested.
        revise: Continues with the version of a request of ``~/revise``; raises BtMissionError.
    """

    def __init__(
        self,
        node: Node,
        controls: MissionControls,
        revise: Callable[[Any], Awaitable[Revision]],
    ) -> None:
        self._controls = controls
        self._revise_on_request = revise
        self._node = node
        served: list[tuple[Any, str, Callable[[Any, Any], Any]]] = [
            (PauseMission, "pause", self._pause),
            *((Trigger, name, self._triggered(verb)) for verb, name in TRIGGERS.items()),
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

    def _perform(self, verb: Verb, answer: Any, node: str = "") -> Any:
        response = self._controls.perform(ControlRequest(verb, node))
        answer.success, answer.message = response.is_done, response.text
        return answer

    def _triggered(self, verb: Verb) -> Callable[[Any, Any], Any]:
        return lambda _, answer: self._perform(verb, answer)

    def _pause(self, request: Any, answer: Any) -> Any:
        return self._perform(Verb.PAUSE_KEEPING_GOALS if request.keep_goals else Verb.PAUSE, answer)

    def _breakpoint(self, request: Any, answer: Any) -> Any:
        if request.node:
            verb = Verb.UNBREAK if request.remove else Verb.BREAK
            self._perform(verb, answer, request.node)
        else:
            answer.success, answer.message = True, f"{len(self._controls.breakpoints)} set"
        answer.breakpoints = self._controls.breakpoints
        return answer

    async def _revise(self, request: Any, answer: Any) -> Any:
        try:
            _ = self._controls.running
            revision = await self._revise_on_request(request)
        except BtMissionError as error:
            answer.message, answer.success = str(error), False
        else:
            answer.message, answer.success = revision.as_text(), not revision.is_refused
            answer.revision = json.dumps(revision.as_dict())
        return answer
