"""Faults of topics: what they do to messages, and what a mission answers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.run import NeverHeldError
from tests.support.thorough import sample

WAITS = "mission: waits\ntree: {wait: 2}\n"


def recorded(stage: Any, fault: Any, topic: str = "odom", **options: Any) -> Any:
    """What came of a topic in two seconds, with a fault from the start."""
    run = stage.run(WAITS, **options)
    run.record(topic)
    run.do(fault)
    run.until_done()
    return run.topic(topic)


def numbers(times: Any) -> list[int]:
    """Times of messages at 20 Hz as numbers of their periods."""
    return [round(time * 20) for time in times]


# ---- what they do ------------------------------------------------------------------------


def test_a_dropped_topic_is_silent(stage: Any) -> None:
    """While it lasts; the trace tells when that was."""
    fault = stage.faults.drop("odom", lasting=0.5)
    run = stage.run(WAITS)
    run.record("odom")
    run.at(0.5, fault)
    run.until_done()
    assert numbers(run.topic("odom").times) == [*range(10), *range(20, 42)]
    assert [line for line in run.history.events if '"fault"' in line] == [
        (
            '{"event": "fault", "number": 1, "state": "begins", "t": 1500000000, "what": "drop", '
            '"with": {"topic": "odom"}}'
        ),
        '{"event": "fault", "number": 1, "state": "ends", "t": 2000000000, "what": "drop"}',
    ]
    assert str(run.faults[0]) == ("faults.drop(topic='odom', lasting=0.5) from 0.50 s to 1.00 s")


def test_a_share_of_a_topic_is_dropped_by_the_seed(stage: Any) -> None:
    """The same messages in every run of one seed, others in one of another."""
    three = [
        numbers(recorded(stage, stage.faults.drop("odom", share=0.3), seed=seed).times)
        for seed in (1, 1, 2)
    ]
    assert three[0] == three[1] != three[2]
    assert 20 <= len(three[0]) <= 36


def test_each_third_message_is_dropped(stage: Any) -> None:
    """Beginning with the first."""
    came = recorded(stage, stage.faults.drop("odom", every=3))
    assert numbers(came.times)[:6] == [1, 2, 4, 5, 7, 8]


def test_one_receiver_alone_misses_something(stage: Any) -> None:
    """The other gets all of it."""
    came = recorded(stage, stage.faults.drop("odom", receiver="bt_mission_servers"))
    assert len(came) == 42
    came = recorded(stage, stage.faults.drop("odom", receiver="/observer"))
    assert len(came) == 0


def test_a_delayed_topic_comes_late(stage: Any) -> None:
    """By the same time each; what is under way at the end still comes, and in its order."""
    came = recorded(stage, stage.faults.delay("odom", 0.12, lasting=1.0))
    late = [round(time - stamp(m), 3) for time, m in zip(came.times, came, strict=True)]
    assert late[:20] == [0.12] * 20
    assert late[20:] == [0.07, 0.02, *[0.0] * 20]


def test_jitter_keeps_the_order_or_not(stage: Any) -> None:
    """As the test wants it."""
    came = recorded(stage, stage.faults.delay("odom", 0.1, jitter=0.2))
    late = [time - stamp(m) for time, m in zip(came.times, came, strict=True)]
    stamps = [stamp(message) for message in came]
    assert stamps == sorted(stamps)
    assert min(late) >= 0.1
    assert max(late) <= 0.3
    assert len(set(late)) > 10
    loose = stage.faults.delay("odom", 0.1, jitter=0.2, in_order=False)
    stamps = [stamp(message) for message in recorded(stage, loose)]
    assert stamps != sorted(stamps)


def test_messages_come_twice(stage: Any) -> None:
    """At once, or some time after."""
    came = recorded(stage, stage.faults.duplicate("odom", times=3, after=0.01))
    assert came.times[:5] == (0.0, 0.01, 0.02, 0.05, 0.06)
    came = recorded(stage, stage.faults.duplicate("odom", share=0.5))
    assert 42 < len(came) < 84


def test_a_published_message_comes_alone(stage: Any) -> None:
    """As its types round it; those of other publishers are lost."""
    fields = {"percentage": 0.3, "voltage": math.nan, "cell_voltage": (0.1, math.inf)}
    fault = stage.faults.publish("battery_state", every=1.0, **fields)
    came = recorded(stage, fault, "battery_state")
    assert [round(message.percentage, 6) for message in came] == [0.3, 0.3, 0.3]
    assert all(math.isnan(message.voltage) for message in came)
    assert [[round(cell, 6) for cell in m.cell_voltage] for m in came] == [[0.1, math.inf]] * 3


def test_a_frozen_topic_repeats_itself(stage: Any) -> None:
    """With the old stamps, or fresh ones; the stamps of transforms, too."""
    assert {stamp(m) for m in recorded(stage, stage.faults.freeze("odom"))} == {0.0}
    came = recorded(stage, stage.faults.freeze("scan", fresh_stamps=True), "scan")
    assert [stamp(m) for m in came] == list(came.times)
    assert len({bytes(m.ranges) for m in came}) == 1
    came = recorded(stage, stage.faults.freeze("tf", fresh_stamps=True), "tf")
    assert [stamp(m.transforms[1]) for m in came] == list(came.times)


@pytest.mark.parametrize(
    ("how", "field", "check"),
    sample(
        [
            ("nan", None, lambda m: np.isnan(m.ranges).all() and np.isnan(m.angle_min)),
            ("nan", "ranges", lambda m: np.isnan(m.ranges).all() and m.angle_min == 0),
            ("inf", "range_max", lambda m: np.isinf(m.range_max) and not np.isinf(m.ranges).all()),
            ("zeros", "ranges", lambda m: len(m.ranges) == 360 and not any(m.ranges)),
            ("empty", "ranges", lambda m: len(m.ranges) == 0),
            ("wrong frame", None, lambda m: m.header.frame_id == "nowhere"),
            ("old stamp", None, lambda m: m.header.stamp.sec == 0),
            ("future stamp", None, lambda m: stamp(m) >= 10),
        ],
        2,
    ),
)
def test_what_can_be_wrong_with_a_message(stage: Any, how: str, field: Any, check: Any) -> None:
    """All of it, or one field."""
    came = recorded(stage, stage.faults.corrupt("scan", how, field=field), "scan")
    assert len(came) == 21
    assert all(check(message) for message in came)


def test_a_message_is_changed_by_a_function(stage: Any) -> None:
    """In place, or for another; some of them."""

    def mirror(scan: Any) -> None:
        scan.ranges = scan.ranges[::-1]
        scan.angle_min = 9.0

    came = recorded(stage, stage.faults.corrupt("scan", mirror, share=0.5), "scan")
    assert {m.angle_min for m in came} == {0.0, 9.0}
    came = recorded(stage, stage.faults.corrupt("scan", lambda m: type(m)()), "scan")
    assert {len(m.ranges) for m in came} == {0}


def test_faults_end_at_a_time_or_all_at_once(stage: Any) -> None:
    """And can begin again."""
    run = stage.run(WAITS)
    run.record("odom", "scan")
    blind, deaf = stage.faults.drop("odom"), stage.faults.drop("scan")
    run.at(0.5, blind)
    run.at(1.0, blind.end, deaf)
    run.at(1.5, blind)
    run.at(1.7, stage.faults.clear)
    run.until_done()
    assert numbers(run.topic("odom").times) == [*range(10), *range(20, 30), *range(34, 42)]
    assert [t for t in run.topic("scan").times if 1.0 <= t < 1.7] == []
    assert [fault.ended_ns for fault in run.faults] == [2e9, 2.7e9, 2.7e9]
    run.do(blind.end, stage.faults.clear)
    assert len(run.faults) == 3


# ---- what is not there --------------------------------------------------------------------


def test_a_fault_on_something_that_is_not_there(stage: Any) -> None:
    """Lists what is; an error at its time, also within a step."""
    run = stage.run(WAITS)
    with pytest.raises(ScenarioError, match=r"unknown topic '/scam'"):
        run.do(stage.faults.drop("scam"))
    with pytest.raises(ScenarioError, match=r"unknown node '/server'"):
        run.do(stage.faults.drop("scan", receiver="server"))
    run.at(0.1, stage.faults.delay("odo", 1.0))
    with pytest.raises(ScenarioError, match=r"unknown topic '/odo'"):
        run.until_done()
    assert run.faults == []
    run.until_done()
    assert run.succeeded


@pytest.mark.parametrize(
    ("fault", "reason"),
    sample(
        [
            (("odom", "nan", {"field": "pose.poze"}), "unknown field of PoseWithCovariance 'poze'"),
            (
                ("odom", "nan", {"field": "child_frame_id.x"}),
                "no field 'x' in 'base_footprint', a p",
            ),
            (("motors_on", "nan", {}), "Bool has nothing that 'nan' can change"),
            (
                ("odom", lambda m: 1 / 0, {}),
                r"the function raised ZeroDivisionError: .*test_topics",
            ),
            (("odom", lambda m: 5, {}), "change the Odometry, or to give another, got 5"),
        ],
        3,
    ),
)
def test_a_mistake_that_shows_with_a_message(stage: Any, fault: Any, reason: str) -> None:
    """Is the test's, and not a failure of the mission."""
    run = stage.run(WAITS)
    topic, how, options = fault
    run.do(stage.faults.corrupt(topic, how, **options))
    with pytest.raises(ScenarioError, match=reason):
        run.until_done()
    assert run.status == "running"
    run.do(stage.faults.clear)
    run.until_done()
    assert run.succeeded


def test_a_fault_goes_on_once_at_a_time(stage: Any) -> None:
    """A second beginning would have no end of its own; with the next run it is free again."""
    run = stage.run(WAITS)
    blind = stage.faults.drop("scan")
    run.do(blind)
    with pytest.raises(ScenarioError, match=r"faults.drop\(topic='scan'\) is already active: end"):
        run.do(blind)
    run.until_done()
    again = stage.run(WAITS)
    again.do(blind)
    again.step()


def test_messages_without_a_stamp_cannot_be_fresh(stage: Any) -> None:
    """Which shows with the first."""
    run = stage.run(WAITS)
    run.do(stage.faults.freeze("motors_on", fresh_stamps=True))
    with pytest.raises(ScenarioError, match="a Bool has no stamp to refresh"):
        run.step()
    with pytest.raises(NeverHeldError):
        run.until_done(within=0.5)


def stamp(message: Any) -> float:
    """The stamp of a message, s since the start."""
    header = message.header.stamp
    return header.sec - 1 + header.nanosec / 1e9
