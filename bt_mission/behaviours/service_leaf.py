"""The leaf that calls a service once and waits for the answer, without ever blocking a tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.leaf import Leaf
from bt_mission.behaviours.runtime import (
    MissionFailure,
    Runtime,
    Scope,
    ServiceClient,
    placed,
    read_field,
)
from bt_mission.core.errors import BtMissionError

NS = 1_000_000_000


@dataclass(frozen=True)
class PendingCall:
    """What a call needs that is known only when the leaf starts.

    :param request: fields of the request.
    :param server_s: how long to wait for the server, s.
    :param answer_s: how long to wait for the answer, s.
    """

    request: Mapping[str, Any]
    server_s: float
    answer_s: float


class ServiceLeaf(Leaf):
    """Calls a service each time it starts; the answer makes it succeed.

    It fails when there is no server or no answer in time, and when the response has a field
    ``success`` that is false. Outputs are written from every response. An answer that comes
    after the leaf has ended, or was halted, changes nothing.

    :param service: name of the service, such as ``/stop``.
    :param type_name: its type, such as ``std_srvs/srv/Trigger``.
    :param plan: called at each start.
    :param outputs: response field to variable.
    :param scope: holds the variables that outputs go to.
    :param place: ``file:line:column`` of the step.
    """

    def __init__(
        self,
        name: str,
        service: str,
        type_name: str,
        plan: Callable[[], PendingCall],
        outputs: Mapping[str, str],
        scope: Scope,
        place: str,
    ) -> None:
        super().__init__(name)
        self.service = service
        self.type_name = type_name
        self._plan = plan
        self._outputs = outputs
        self._scope = scope
        self._place = place
        self._call = PendingCall({}, 0.0, 0.0)
        self._request: Any = None
        self._since_ns = 0
        self._answers: list[Any] = []
        self._forget: Callable[[], None] | None = None
        self._runtime: Runtime
        self._caller: ServiceClient

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime and make the client of the service."""
        self._runtime = kwargs["runtime"]
        with placed(self._place):
            self._caller = self._runtime.service_client(self.service, self.type_name)

    def initialise(self) -> None:
        """Begin anew; nothing that was called before is heard any more.

        :raises MissionFailure: when the request's values do not fit its type.
        """
        self._call = self._plan()
        try:
            self._request = self._caller.prepare(self._call.request)
        except BtMissionError as error:
            raise MissionFailure(f"{self._place}: '{self.name}' cannot start: {error}") from error
        self._answers, self._forget = [], None
        self._since_ns = self._runtime.now_ns

    def update(self) -> Status:
        """Call as soon as there is a server; then look for the answer, and at the limits."""
        waited_s = (self._runtime.now_ns - self._since_ns) / NS
        if self._forget is None:
            if self._caller.is_ready():
                self._since_ns = self._runtime.now_ns
                self._forget = self._caller.call(self._request, self._answers.append)
                return self._running("waiting for the answer")
            if waited_s >= self._call.server_s:
                return self._fail(f"no server after {self._call.server_s:g} s")
            return self._running("waiting for the server")
        if self._answers:
            return self._read(self._answers[0])
        if waited_s >= self._call.answer_s:
            return self._fail(f"no answer within {self._call.answer_s:g} s")
        return self._running("waiting for the answer")

    def terminate(self, new_status: Status) -> None:
        """Forget a call that has not been answered."""
        if self._forget is not None and not self._answers:
            self._forget()
            self._forget = None
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.feedback_message = "halted"

    def _read(self, response: Any) -> Status:
        for field, variable in self._outputs.items():
            self._scope.values[variable] = read_field(response, field)
        message = getattr(response, "message", "")
        said = message if isinstance(message, str) else ""
        if getattr(response, "success", True) is False:
            return self._fail(f"answered no success{f': {said}' if said else ''}")
        self.feedback_message = said
        return Status.SUCCESS

    def _running(self, message: str) -> Status:
        self.feedback_message = message
        return Status.RUNNING

    def _fail(self, message: str) -> Status:
        self.feedback_message = f"{self._caller.name}: {message}"
        return Status.FAILURE
