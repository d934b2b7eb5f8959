"""Messages of a topic, whatever quality of service its publishers offer: heard, and as text."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from bt_mission.core.errors import BtMissionError
from bt_mission.core.stamps import NS
from bt_mission.graph_tools.values import SHOWN_ITEMS, as_json, as_yaml, plain
from bt_mission.language.message_types import UnknownField, field_at
from bt_mission.ros.interface_types import message_type, shape_of
from bt_mission.ros.subscriber import matching_qos

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

    from bt_mission.graph_tools.graph_session import GraphSession

DEPTH = 100
WAITING = 1_000
"""Messages kept for a slow terminal; beyond it the oldest are dropped."""


class TopicSubscriber:
    """Subscribes to a topic, and anew when its publishers offer something else.

    `take` gets each message, or with `raw` its bytes.

    Raises:
        UnknownType: When the type is not installed.
    """

    def __init__(
        self,
        session: GraphSession,
        topic: str,
        type_name: str,
        take: Callable[[Any], None],
        *,
        raw: bool = False,
    ) -> None:
        self._session = session
        self._topic = topic
        self._type = message_type(type_name)
        self._take = take
        self._raw = raw
        self._subscribe(self._matching_qos())
        self._next_look_ns = session.now_ns + NS

    def step(self) -> None:
        """Serve what comes next; once a second, look whether the publishers are other ones."""
        self._session.step()
        if self._session.now_ns >= self._next_look_ns:
            self._next_look_ns = self._session.now_ns + NS
            wanted = self._matching_qos()
            if self._session.node.count_publishers(self._topic) and wanted != self._qos:
                self._session.node.destroy_subscription(self._subscription)
                self._subscribe(wanted)

    def _matching_qos(self) -> QoSProfile:
        found = self._session.node.get_publishers_info_by_topic(self._topic)
        return matching_qos([one.qos_profile for one in found], DEPTH)

    def _subscribe(self, qos: QoSProfile) -> None:
        self._qos = qos
        self._subscription = self._session.node.create_subscription(
            self._type, self._topic, self._take, qos, raw=self._raw
        )


class MessageTexts:
    """Turns messages, or a field of them by its dotted name, into YAML documents or JSON lines.

    Raises:
        BtMissionError: When there is no such field.
    """

    def __init__(self, type_name: str, field: str | None, *, full: bool, json: bool) -> None:
        self._field = field
        self._most = None if full or json else SHOWN_ITEMS
        self._json = json
        self._waiting: deque[Any] = deque(maxlen=WAITING)
        if field is not None:
            try:
                field_at(shape_of(message_type(type_name)), field)
            except UnknownField as error:
                raise BtMissionError(f"--field: {error}") from error

    def take(self, message: Any) -> None:
        """Keep a message that came."""
        self._waiting.append(message)

    def texts(self, most: int | None = None) -> Iterator[str]:
        """Give the texts of what was taken since the last call, so many at most."""
        while self._waiting and most != 0:
            value = self._waiting.popleft()
            for name in self._field.split(".") if self._field else ():
                value = getattr(value, name)
            shown = plain(value, self._most)
            yield as_json(shown) if self._json else f"{as_yaml(shown)}---"
            most = None if most is None else most - 1
