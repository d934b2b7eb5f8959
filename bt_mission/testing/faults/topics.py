"""Faults of topics: messages that get lost, come late, twice, again and again, or wrong."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from bt_mission.testing.errors import ScenarioError
from bt_mission.testing.faults.corruptions import changed_by, restamp
from bt_mission.testing.faults.fault import (
    Fates,
    Fault,
    FaultInstance,
    Maker,
    check_share,
    nanoseconds,
    passed,
)
from bt_mission.virtual_time import Delivery, Passing, Side


class TopicFaults(Maker):
    """Faults of topics, on their way to one receiver or to all.

    Where no ``receiver`` is named, all of them get the same: what is lost for one is lost for
    all, and ``run.record`` writes down what came.

    Arguments that all have: ``topic``, its name; ``receiver``, the name of the one node that is
    concerned; ``lasting``, for how many seconds of virtual time (None is until it is ended). A
    topic or receiver that is not there is a ScenarioError when the fault begins.
    """

    def drop(
        self,
        topic: str,
        *,
        share: float = 1.0,
        every: int | None = None,
        receiver: str | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Lose messages.

        :param share: of the messages, drawn from the mission's seed.
        :param every: lose each so-manieth message instead, beginning with the first.
        """
        check_share("drop", share)
        if every is not None and (every < 1 or share != 1.0):
            raise ScenarioError("drop: give a share, or every, a whole number from 1 up")

        def begin(fault: FaultInstance) -> None:
            counts: dict[str, int] = {}

            def tap(passing: Passing) -> Fates:
                if every is not None:
                    count = counts[passing.receiver] = counts.get(passing.receiver, -1) + 1
                    return passed(passing) if count % every else ()
                return () if share == 1 or fault.draw(passing).random() < share else passed(passing)

            _tap(fault, topic, tap, receiver)

        return self._fault(
            "drop",
            begin,
            lasting,
            topic=topic,
            share=share if every is None and share != 1 else None,
            every=every,
            receiver=receiver,
        )

    def delay(
        self,
        topic: str,
        by: float,
        *,
        jitter: float = 0.0,
        in_order: bool = True,
        receiver: str | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Deliver messages late.

        What is under way at the end still comes.

        :param by: so many seconds.
        :param jitter: and up to so many more, drawn from the mission's seed for each message.
        :param in_order: no message overtakes another; else the jitter lets them.
        """
        by_ns, jitter_ns = nanoseconds("delay", by), nanoseconds("jitter", jitter)

        def begin(fault: FaultInstance) -> None:
            last: dict[str, int] = {}

            def tap(passing: Passing) -> Fates:
                after_ns = 0
                if fault.ended_ns is None:
                    after_ns = by_ns
                    if jitter_ns:
                        after_ns += fault.draw(passing).randrange(jitter_ns + 1)
                if in_order:
                    due_ns = max(passing.time_ns + after_ns, last.get(passing.receiver, 0))
                    last[passing.receiver] = due_ns
                    after_ns = due_ns - passing.time_ns
                return (Delivery(passing.message, after_ns=after_ns),)

            # It stays when the fault has ended, so that nothing overtakes what is under way.
            name, node = fault.topic(topic), fault.receiver(receiver)
            taps = fault.run.stage.clock.taps
            taps.add(
                name,
                Side.MESSAGE,
                lambda p: passed(p) if node not in (None, p.receiver) else tap(p),
            )
            fault.undo(lambda: None)

        return self._fault(
            "delay",
            begin,
            lasting,
            topic=topic,
            by=by,
            jitter=jitter or None,
            in_order=None if in_order else False,
            receiver=receiver,
        )

    def duplicate(
        self,
        topic: str,
        *,
        times: int = 2,
        after: float = 0.0,
        share: float = 1.0,
        receiver: str | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Deliver messages more than once.

        :param times: how often.
        :param after: seconds from each to the next.
        :param share: of the messages, drawn from the mission's seed.
        """
        check_share("duplicate", share)
        if times < 2:
            raise ScenarioError(f"duplicate: expected 2 times or more, got {times!r}")
        after_ns = nanoseconds("after", after)

        def begin(fault: FaultInstance) -> None:
            def tap(passing: Passing) -> Fates:
                if share < 1 and fault.draw(passing).random() >= share:
                    return passed(passing)
                return [
                    Delivery(deepcopy(passing.message), after_ns=number * after_ns)
                    for number in range(times)
                ]

            _tap(fault, topic, tap, receiver)

        return self._fault(
            "duplicate",
            begin,
            lasting,
            topic=topic,
            times=times,
            after=after or None,
            share=share if share != 1 else None,
            receiver=receiver,
        )

    def freeze(
        self,
        topic: str,
        *,
        fresh_stamps: bool = False,
        receiver: str | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Deliver one message again and again: the first that comes, instead of all after it.

        :param fresh_stamps: with the stamps of those that they replace, as of a sensor that
            hangs while its driver goes on.
        """

        def begin(fault: FaultInstance) -> None:
            frozen: dict[str, Any] = {}

            def tap(passing: Passing) -> Fates:
                first = frozen.setdefault(passing.receiver, passing.message)
                again = deepcopy(first)
                if fresh_stamps:
                    restamp(again, passing.message)
                return (Delivery(again),)

            _tap(fault, topic, tap, receiver)

        return self._fault(
            "freeze",
            begin,
            lasting,
            topic=topic,
            fresh_stamps=fresh_stamps or None,
            receiver=receiver,
        )

    def corrupt(
        self,
        topic: str,
        how: str | Callable[[Any], Any],
        *,
        field: str | None = None,
        share: float = 1.0,
        receiver: str | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Deliver wrong messages.

        :param how: "nan", "inf", "zeros", "empty", "wrong frame", "old stamp" (10 s) or
            "future stamp" (10 s); or a function that changes a message, or gives another.
        :param field: only this field, by its dotted name (``pose.pose.position``).
        :param share: of the messages, drawn from the mission's seed.
        """
        check_share("corrupt", share)
        change = changed_by(how, field)

        def begin(fault: FaultInstance) -> None:
            def tap(passing: Passing) -> Fates:
                if share < 1 and fault.draw(passing).random() >= share:
                    return passed(passing)
                return (Delivery(change(passing.message)),)

            _tap(fault, topic, tap, receiver)

        return self._fault(
            "corrupt",
            begin,
            lasting,
            topic=topic,
            how=how,
            field=field,
            share=share if share != 1 else None,
            receiver=receiver,
        )


def _tap(
    fault: FaultInstance, topic: str, tap: Callable[[Passing], Fates], receiver: str | None
) -> None:
    fault.tap(fault.topic(topic), Side.MESSAGE, tap, fault.receiver(receiver))
