"""How often the messages of a topic come: measured over a window, and told each second."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from statistics import fmean, pstdev
from typing import TYPE_CHECKING

from bt_mission.core.stamps import NS
from bt_mission.graph_tools.topic_messages import TopicSubscriber
from bt_mission.graph_tools.values import as_json

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession


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
        """Count a message. Time that goes back, as a simulation that starts anew, begins anew."""
        if self._times_ns and time_ns < self._times_ns[-1]:
            self._times_ns.clear()
        self._times_ns.append(time_ns)
        self.total += 1

    def read(self) -> WindowRate | None:
        """The rate, or None before two messages of different times."""
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
        """Serve what comes next; gives a line once a second."""
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
            return f"silent for a second; {total} messages so far"
        if rate is None:
            return f"{total} message so far"
        return (
            f"{rate.hz:8.2f} Hz   every {rate.mean_s:.4f} s ({rate.least_s:.4f} to "
            f"{rate.most_s:.4f}, deviation {rate.deviation_s:.4f})   {total} messages"
        )

    def _take(self, _: bytes) -> None:
        clock = self._session.node.get_clock()
        self._meter.note(clock.now().nanoseconds if self._sim_time else self._session.now_ns)
