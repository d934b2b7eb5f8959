"""Faults of topics: messages that get lost, come late, twice, again and again, or wrong."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from bt_mission.faults.corruptions import ReadyMadeName, changed_by, restamp, setting
from bt_mission.faults.errors import ScenarioError
from bt_mission.faults.fault import Begin, Fates, FaultInstance, Tap
from bt_mission.faults.maker import (
    Maker,
    check_share,
    for_share,
    lost,
    makes_fault,
    nanoseconds,
    passed,
    repeated,
)
from bt_mission.faults.parameters import NodeName, Seconds, TopicName
from bt_mission.ros.interface_types import topic_type
from bt_mission.virtual_time import Delivery, Passing, Side


class TopicFaults(Maker):
    """Faults of topics, on their way to one receiver or to all.

    Where no ``receiver`` is named, all of them get the same: what is lost for one is lost for
    all, and ``run.record`` writes down what came.

    Arguments that all have: ``topic``, its name; ``receiver``, the name of the one node that is
    concerned; ``lasting``, for how many seconds of virtual time (None is until it is ended). A
    topic or receiver that is not there is a ScenarioError when the fault begins.
    """

    @makes_fault
    def drop(
        self,
        topic: TopicName,
        *,
        share: float = 1.0,
        every: int | None = None,
        receiver: NodeName | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Lose messages.

        Args:
            share: Of the messages, drawn from the mission's seed.
            every: Lose each so-manieth message instead, beginning with the first.
        """
        check_share("drop", share)
        if every is None:
            return _at(topic, receiver, for_share(share, lost))
        if every < 1 or share != 1.0:
            raise ScenarioError("drop: give a share, or every, an integer from 1 up")

        def drop_every(fault: FaultInstance, passing: Passing) -> Fates:
            count = fault.kept[passing.receiver] = fault.kept.get(passing.receiver, -1) + 1
            return passed(fault, passing) if count % every else ()

        return _at(topic, receiver, drop_every)

    @makes_fault
    def delay(
        self,
        topic: TopicName,
        by: Seconds,
        *,
        jitter: Seconds = 0.0,
        in_order: bool = True,
        receiver: NodeName | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Deliver messages late.

        What is under way at the end still comes.

        Args:
            by: So many seconds.
            jitter: And up to so many more, drawn from the mission's seed for each message.
            in_order: No message overtakes another; else the jitter lets them.
        """
        by_ns, jitter_ns = nanoseconds("delay", by), nanoseconds("jitter", jitter)

        def begin(fault: FaultInstance) -> None:
            last: dict[str, int] = {}

            def tap(passing: Passing) -> Fates:
                if node not in (None, passing.receiver):
                    return passed(fault, passing)
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
            name, node = fault.topic(topic), _name_of(fault, receiver)
            fault.run.stage.clock.taps.add(name, Side.MESSAGE, tap)
            fault.undo(lambda: None)

        return begin

    @makes_fault
    def duplicate(
        self,
        topic: TopicName,
        *,
        times: int = 2,
        after: Seconds = 0.0,
        share: float = 1.0,
        receiver: NodeName | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Deliver messages more than once.

        Args:
            times: How often.
            after: Seconds from each to the next.
            share: Of the messages, drawn from the mission's seed.
        """
        check_share("duplicate", share)
        return _at(topic, receiver, for_share(share, repeated("duplicate", times, after)))

    @makes_fault
    def freeze(
        self,
        topic: TopicName,
        *,
        fresh_stamps: bool = False,
        receiver: NodeName | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Deliver one message again and again: the first that comes, instead of all after it.

        Args:
            fresh_stamps: With the stamps of those that they replace, as of a sensor that hangs
                while its driver goes on.
        """

        def freeze(fault: FaultInstance, passing: Passing) -> Fates:
            again = deepcopy(fault.kept.setdefault(passing.receiver, passing.message))
            if fresh_stamps:
                restamp(again, passing.message)
            return (Delivery(again),)

        return _at(topic, receiver, freeze)

    @makes_fault
    def corrupt(
        self,
        topic: TopicName,
        how: ReadyMadeName | Callable[[Any], Any],
        *,
        field: str | None = None,
        share: float = 1.0,
        receiver: NodeName | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Deliver wrong messages.

        Args:
            how: "nan", "inf", "zeros", "empty", "wrong frame", "old stamp" (10 s) or "future stamp"
                (10 s); or a function that changes a message, or gives another.
            field: Only this field, by its dotted name (``pose.pose.position``).
            share: Of the messages, drawn from the mission's seed.
        """
        check_share("corrupt", share)
        change = changed_by(how, field)
        corrupt = for_share(share, lambda _, passing: (Delivery(change(passing.message)),))
        return _at(topic, receiver, corrupt)

    @makes_fault
    def set_fields(
        self, /, topic: TopicName, *, lasting: Seconds | None = None, **fields: Any
    ) -> Begin:
        """Give fields of the messages other values.

        Args:
            fields: By their dotted names, such as ``percentage=0.1``.
        """
        change = setting("set_fields", fields)

        def begin(fault: FaultInstance) -> None:
            name = fault.topic(topic)
            types = dict(fault.run.robot_run.node.get_topic_names_and_types())
            change(topic_type(types[name][0])())  # an unknown field is refused as it begins
            fault.tap(name, Side.MESSAGE, lambda _, it: (Delivery(change(it.message)),))

        return begin


def _at(topic: str, receiver: str | None, tap: Tap) -> Begin:
    return lambda fault: fault.tap(fault.topic(topic), Side.MESSAGE, tap, _name_of(fault, receiver))


def _name_of(fault: FaultInstance, receiver: str | None) -> str | None:
    return None if receiver is None else fault.node(receiver).get_fully_qualified_name()
