"""The leaf that waits until a message of a topic meets a condition."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.leaf import Leaf
from bt_mission.behaviours.runtime import (
    LatestMessage,
    MissionFailure,
    Runtime,
    Scope,
    placed,
    read_field,
)

NS = 1_000_000_000


@dataclass(frozen=True)
class PendingWait:
    """What a wait needs that is known only when the leaf starts.

    :param timeout_s: how long to wait, s; None is no limit.
    :param condition: looks at a message; a text that says what was met ends the wait.
    :param show: what the condition reads of a message, for people.
    """

    timeout_s: float | None
    condition: Callable[[Any], str | None]
    show: Callable[[Any], str]


class WaitFor(Leaf):
    """Succeeds at the first tick after a message has met the condition; latches until then.

    Messages count from the moment the leaf is reached. A topic that is latched tells its newest
    message at once.

    :param topic: name of the topic, such as ``/battery_state``.
    :param type_name: its type, such as ``sensor_msgs/msg/BatteryState``.
    :param plan: called at each start.
    :param outputs: field of the message that met the condition, to variable.
    :param text: the condition as it is written.
    :param scope: holds the variables that outputs go to.
    :param place: ``file:line:column`` of the step.
    """

    def __init__(
        self,
        name: str,
        topic: str,
        type_name: str,
        plan: Callable[[], PendingWait],
        outputs: Mapping[str, str],
        text: str,
        scope: Scope,
        place: str,
    ) -> None:
        super().__init__(name)
        self.topic = topic
        self.type_name = type_name
        self._plan = plan
        self._outputs = outputs
        self._text = text
        self._scope = scope
        self._place = place
        self._watch: PendingWait | None = None
        self._since_ns = 0
        self._newest: Any = None
        self._met: tuple[str, Any] | None = None
        self._error: MissionFailure | None = None
        self._runtime: Runtime
        self._reader: LatestMessage

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime and subscribe."""
        self._runtime = kwargs["runtime"]
        with placed(self._place):
            self._reader = self._runtime.subscriber(self.topic, self.type_name)

    def initialise(self) -> None:
        """Begin to listen."""
        self._watch = self._plan()
        self._since_ns = self._runtime.now_ns
        self._newest = self._met = self._error = None
        self._reader.listen(self._hear)

    def update(self) -> Status:
        """Look at what was heard, and at the limit; what comes with the deadline wins."""
        assert self._watch is not None
        self._reader.look_around()
        if self._error is not None:
            raise self._error
        if self._met is not None:
            self.feedback_message, message = self._met
            for field, variable in self._outputs.items():
                self._scope.values[variable] = read_field(message, field)
            return Status.SUCCESS
        limit_s = self._watch.timeout_s
        if limit_s is not None and self._runtime.now_ns - self._since_ns >= limit_s * NS:
            self.feedback_message = self._in_vain(limit_s)
            return Status.FAILURE
        self.feedback_message = self._last() or "no message yet"
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Listen no more."""
        self._reader.leave(self._hear)
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.feedback_message = "halted"

    def _hear(self, message: Any) -> None:
        """Ask the condition; errors in it are kept for the next tick."""
        assert self._watch is not None
        if self._met is not None or self._error is not None:
            return
        self._newest = message
        try:
            met = self._watch.condition(message)
        except MissionFailure as error:
            self._error = error
            return
        if met is not None:
            self._met = met, message

    def _last(self) -> str:
        if self._newest is None or self._watch is None:
            return ""
        return self._watch.show(self._newest)

    def _in_vain(self, limit_s: float) -> str:
        name = self._reader.name
        if self._newest is None:
            return f"{name}: no message within {limit_s:g} s; {self._reader.why_silent()}"
        return f"{name}: '{self._text}' was not met within {limit_s:g} s (last: {self._last()})"
