"""An event of any class reaches a trace, the topics and whoever watches, by its class alone."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import pytest
from bt_mission_interfaces.msg import MissionLog

from bt_mission.executive.events import reader
from bt_mission.executive.events.codec import event_of, json_line
from bt_mission.executive.events.events import Event, FaultChanged, LogLine
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.ros.status_publisher import LOG

S = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Bumped(Event):
    """A toy: the robot has touched something while a node ran."""

    event_name = "bumped"

    time_ns: int
    node: int
    what: str
    speed: float
    places: tuple[str, ...] = ()


BUMP = Bumped(2 * S, 1, "a chair", 0.25, ("left", "front"))


@pytest.fixture
def batches(ros: Any) -> list[Batch]:
    """Emits a bump; gives what a watcher reads of the log."""
    batches: list[Batch] = []
    ros.client.create_subscription(
        MissionLog, "/bt_mission/log", lambda message: batches.append(reader.log(message)), LOG
    )
    ros.runner = ros.mission(
        "mission: m\ntree:\n  sequence: [{wait: 5, name: rest}]\n", has_controls=True
    )
    ros.run(0.5)
    ros.runner.executive.events.emit(BUMP)
    ros.run(0.5)
    return batches


def test_watchers_and_the_trace_get_it_whole(ros: Any, batches: list[Batch]) -> None:
    """The same object, with its words in the log and its fields as JSON; so does the trace."""
    executive = ros.runner.executive
    assert batches == [Batch(executive.run, (BUMP,))]
    mission = MissionState()
    feed = MissionFeed(mission)
    feed.take(Batch(executive.run, (executive.mission_state.tree,)))
    assert feed.take(batches[0]) == [BUMP]
    assert mission.now_ns == 2 * S
    words = "bumped: node rest, what a chair, speed 0.25, places ('left', 'front')"
    assert mission.log[-1].text == words
    line = json.loads(json_line(BUMP, executive.node_infos))
    node = {"node": "rest", "path": "0.0", "index": 1}
    fields = {"what": "a chair", "speed": 0.25, "places": ["left", "front"]}
    assert line == {"event": "bumped", "t": 2 * S, **node, **fields}
    lines = [json.loads(line) for line in ros.runner.trace.newest]
    (line,) = (element for element in lines if element.get("event") == "bumped")
    assert event_of(line, {}) == BUMP


@pytest.mark.parametrize(
    "event",
    [
        "{",
        "[]",
        "7",
        "[" * 100_000,
        '{"event": "unheard of"}',
        '{"event": "bumped", "node": 1}',
        '{"event": "bumped", "node": 1, "what": 3, "speed": "fast"}',
        '{"event": "status", "path": "0", "status": "SUCCESS", "message": ""}',
        '{"event": "fault", "number": 1, "what": "drop", "state": "begins", "with": 5}',
    ],
)
def test_what_cannot_be_read_is_the_line_that_describes_it(event: str) -> None:
    """Also an event of a newer version, and one that has a topic of its own."""
    message = MissionLog(run="r", text="in words", event=event)
    message.stamp.sec = 3
    assert reader.log(message) == Batch("r", (LogLine(3 * S, "in words"),))


def test_json_has_no_number_that_json_lacks() -> None:
    """Null stands for it."""
    bump = Bumped(S, 0, "", float("nan"))
    assert json.loads(json_line(bump))["speed"] is None
    fault = FaultChanged(S, 1, "drop", "begins", {"share": float("inf"), "of": [float("nan")]})
    assert json.loads(json_line(fault))["with"] == {"share": None, "of": [None]}
