"""Messages of a topic as text."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any

from bt_mission.core.errors import BtMissionError
from bt_mission.graph_tools.values import SHOWN_ITEMS, as_json, as_yaml, plain
from bt_mission.language.message_types import UnknownField, field_at
from bt_mission.ros.interface_types import message_type, shape_of

WAITING = 1_000
"""Messages kept for a slow terminal; beyond it the oldest are dropped."""


class Echo:
    """Turns messages into YAML documents, or lines of JSON.

    :param type_name: of the messages.
    :param field: dotted name of the one that is wanted; None is the whole message.
    :param full: do not cut lists.
    :raises BtMissionError: when there is no such field.
    """

    def __init__(self, type_name: str, field: str | None, *, full: bool, json: bool) -> None:
        self._field = field
        self._most = None if full else SHOWN_ITEMS
        self._json = json
        self._waiting: deque[Any] = deque(maxlen=WAITING)
        if field is not None:
            try:
                field_at(shape_of(message_type(type_name)), field)
            except UnknownField as error:
                raise BtMissionError(f"--field: {error}") from error

    def take(self, message: Any) -> None:
        """A message came."""
        self._waiting.append(message)

    def texts(self, most: int | None = None) -> Iterator[str]:
        """The texts of the messages that have come since the last call, so many at most."""
        while self._waiting and most != 0:
            value = self._waiting.popleft()
            for name in self._field.split(".") if self._field else ():
                value = getattr(value, name)
            shown = plain(value, self._most)
            yield as_json(shown) if self._json else f"{as_yaml(shown)}---"
            most = None if most is None else most - 1
