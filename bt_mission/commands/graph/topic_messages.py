"""Messages of a topic, with any quality of service of its publishers, and their rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from statistics import fmean, pstdev
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.stamps import NS
from bt_mission.commands.graph.values import SHOWN_ITEMS, as_json, as_yaml, plain
from bt_mission.language.message_types import UnknownField, field_at
from bt_mission.ros.interface_types import message_type, shape_of
from bt_mission.ros.subscriber import matching_qos

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

    from bt_mission.ros.graph_session import GraphSession

DEPTH = 100
WAITING = 1_000
"""Messages kept for a slow terminal; beyond it the oldest are dropped."""


class TopicSubscriber:
    """Subscribes to a topic, and again when its publishers change their offer.

    `take` gets each message, or with `raw` its bytes.

    Raises:
        UnknownType: The type is not installed.
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
        """Serve what is next; once a second, check whether the publishers have changed."""
        self._session.step()
        if self._session.now_ns >= self._next_look_ns:
            self._next_look_ns = self._session.now_ns + NS
            wanted = self._matching_qos()
            if self._session.node.count_publishers(self._topic) and wanted != self._qos:
                self._session.node.destroy_subscription(self._subscription)
                self._subscribe(wanted)

    def _matching_qos(self) -> QoSProfile:
        publishers = self._session.node.get_publishers_info_by_topic(self._topic)
        return matching_qos([publisher.qos_profile for publisher in publishers], DEPTH)

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
                raise BtMissionError(f"--field: {error}", code=error.code) from error

    def take(self, message: Any) -> None:
        """Keep a received message."""
        self._waiting.append(message)

    def texts(self, most: int | None = None) -> Iterator[str]:
        """Return at most `most` texts of the messages since the last call."""
        while self._waiting and most != 0:
            value = self._waiting.popleft()
            for name in self._field.split(".") if self._field else ():
                value = getattr(value, name)
            shown = plain(value, self._most)
            yield as_json(shown) if self._json else f"{as_yaml(shown)}---"
            most = None if most is None else most - 1


@dataclass(frozen=True)
class WindowRate:
    """The rate over a window: messages per second, and seconds between two messages."""

    hz: float
    mean_s: float
    least_s: float
    most_s: float
    deviation_s: float
    count: int


class RateMeter:
    """Keeps the times of the newest messages, with `window` periods between them."""

    def __init__(self, window: int) -> None:
        self._times_ns: deque[int] = deque(maxlen=window + 1)
        self.total = 0

    def note(self, time_ns: int) -> None:
        """Count a message. Time that goes back, as in a restarted simulation, restarts the rate."""
        if self._times_ns and time_ns < self._times_ns[-1]:
            self._times_ns.clear()
        self._times_ns.append(time_ns)
        self.total += 1

    def read(self) -> WindowRate | None:
        """Return the rate, or None before two messages of different times."""
        times = list(self._times_ns)
        if len(times) < 2 or times[-1] == times[0]:
            return None
        periods = [(after - before) / NS for before, after in pairwise(times)]
        mean, deviation = fmean(periods), pstdev(periods)
        return WindowRate(1 / mean, mean, min(periods), max(periods), deviation, len(periods))


class RateLines:
    """Notes when messages are received, without unpacking them.

    The rate is taken over a `window` of messages, in seconds of the session's own clock or, with
    `sim_time`, of ``/clock``.
    """

    def __init__(
        self,
        session: GraphSession,
        topic: str,
        type_name: str,
        window: int,
        *,
        sim_time: bool,
        json: bool,
    ) -> None:
        self._session = session
        self._topic = topic
        self._json = json
        self._meter = RateMeter(window)
        self._sim_time = sim_time
        self._seen = 0
        if sim_time:
            session.follow_clock()
        self._subscriber = TopicSubscriber(session, topic, type_name, self._take, raw=True)
        self._next_line_ns = session.now_ns + NS

    def step(self) -> Iterator[str]:
        """Serve what is next. Return a line once a second."""
        self._subscriber.step()
        if self._session.now_ns >= self._next_line_ns:
            self._next_line_ns += NS
            yield self._line()

    def _line(self) -> str:
        total = self._meter.total
        is_silent = total == self._seen
        self._seen = total
        rate = self._meter.read()
        if self._json:
            more = asdict(rate) if rate else {}
            return as_json({"topic": self._topic, "messages": total, "silent": is_silent, **more})
        if is_silent:
            return f"no message for a second; {total} messages so far"
        if rate is None:
            return f"{total} message so far"
        return (
            f"{rate.hz:8.2f} Hz   every {rate.mean_s:.4f} s ({rate.least_s:.4f} to "
            f"{rate.most_s:.4f}, deviation {rate.deviation_s:.4f})   {total} messages"
        )

    def _take(self, _: bytes) -> None:
        clock = self._session.node.get_clock()
        self._meter.note(clock.now().nanoseconds if self._sim_time else self._session.now_ns)
