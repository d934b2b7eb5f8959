"""How often the messages of a topic come, told each second."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from bt_mission.graph_tools.listening import NS, Listener
from bt_mission.graph_tools.rate import RateMeter
from bt_mission.graph_tools.values import as_json

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession


class RateLines:
    """Notes when messages are received, without unpacking them.

    :param window: messages over which the rate is taken.
    :param sim_time: seconds of ``/clock`` instead of the hand's own clock.
    """

    def __init__(
        self,
        hand: GraphSession,
        topic: str,
        type_name: str,
        window: int,
        *,
        sim_time: bool,
        json: bool,
    ) -> None:
        self._hand = hand
        self._topic = topic
        self._json = json
        self._meter = RateMeter(window)
        self._sim_time = sim_time
        self._seen = 0
        if sim_time:
            hand.follow_clock()
        self._listener = Listener(hand, topic, type_name, self._take, raw=True)
        self._next_line_ns = hand.now_ns + NS

    def step(self) -> str | None:
        """Serve what comes next; gives a line once a second."""
        self._listener.step()
        if self._hand.now_ns < self._next_line_ns:
            return None
        self._next_line_ns += NS
        is_silent = self._meter.total == self._seen
        self._seen = self._meter.total
        rate = self._meter.read()
        if self._json:
            return as_json(
                {
                    "topic": self._topic,
                    "messages": self._meter.total,
                    "silent": is_silent,
                    **(asdict(rate) if rate else {}),
                }
            )
        if is_silent:
            return f"silent for a second; {self._meter.total} messages so far"
        if rate is None:
            return f"{self._meter.total} message so far"
        return (
            f"{rate.hz:8.2f} Hz   every {rate.mean_s:.4f} s ({rate.least_s:.4f} to "
            f"{rate.most_s:.4f}, deviation {rate.deviation_s:.4f})   {self._meter.total} messages"
        )

    def _take(self, _: bytes) -> None:
        clock = self._hand.node.get_clock()
        self._meter.note(clock.now().nanoseconds if self._sim_time else self._hand.now_ns)
