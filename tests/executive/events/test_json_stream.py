"""What happens, as JSON for programs."""

from __future__ import annotations

import json
from typing import Any

import pytest

from bt_mission.executive.events.codec import json_line
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.mission_state import MissionState
from tests.support.watched import S, ScriptedExecutive, goal_in


@pytest.fixture
def lines() -> Any:
    """Give what an executive tells as the objects that a program reads."""
    mission = MissionState()
    feed = MissionFeed(mission)

    def read(executive: ScriptedExecutive) -> list[dict[str, Any]]:
        return [
            json.loads(json_line(event, mission.tree.nodes if mission.tree else ()))
            for batch in executive.take(needs_statuses=feed.needs_statuses).messages
            for event in feed.take(batch)
        ]

    return read


def test_each_object_says_what_it_is_and_when(lines: Any):
    """The start with the tree first; times are ns of ROS time, as in a trace."""
    executive = ScriptedExecutive("patrol\n  go")
    executive.begin()
    executive.change(0.5, go="running")
    executive.say("here we go")
    executive.stand("paused", "paused on request")
    result = lines(executive)
    assert result[0] == {
        "event": "start",
        "t": S,
        "run": "run",
        "mission": "patrol",
        "world": None,
        "robot": "",
        "seed": 0,
        "nodes": [
            {"name": "patrol", "kind": "ActionLeaf", "path": "0", "parent": 0},
            {"name": "go", "kind": "ActionLeaf", "path": "0.0", "parent": 0},
        ],
    }
    status = {"node": "go", "path": "0.0", "status": "RUNNING", "message": ""}
    paused = {"status": "paused", "reason": "paused on request"}
    assert result[2:] == [
        {"event": "status", "t": 1_500_000_000, **status},
        {"event": "log", "t": 1_500_000_000, "text": "here we go"},
        {"event": "mission", "t": 1_500_000_000, "run": "run", "mission": "explore", **paused},
    ]


def test_what_was_the_case_before_has_no_time(lines: Any):
    """Null, not a guess."""
    executive = ScriptedExecutive("patrol\n  go")
    executive.begin()
    executive.change(go="running")
    executive.forget()
    executive.begin()
    lines(executive)
    executive.change(go="running")
    executive.forget()
    (status,) = lines(executive)
    assert (status["event"], status["t"]) == ("status", None)


@pytest.mark.parametrize(
    ("text", "value"),
    [("6", 6), ("[1.5, 2]", [1.5, 2]), ('"a"', "a"), ("NaN", "NaN"), ("[1, 2, ...", "[1, 2, ...")],
)
def test_values_of_variables_are_json_where_they_can_be(lines: Any, text: str, value: Any):
    """One that was cut, or is no number of JSON's, comes as its text."""
    executive = ScriptedExecutive()
    executive.begin()
    executive.detail(variables=(("x", text),))
    assert lines(executive)[-1] == {"event": "variable", "t": S, "name": "x", "value": value}


def test_goals_and_progress(lines: Any):
    """A progress that is no number is left out: JSON has no NaN."""
    executive = ScriptedExecutive()
    executive.begin()
    executive.change(drive="running")
    active = goal_in("active", at_s=2.0)
    executive.detail(running=(executive.progress("drive", 1.0, 2.0, "1 m"),), goals=(active,))
    executive.detail(running=(executive.progress("drive", float("nan"), 2.0, "1 m"),))
    progress, moved, odd = lines(executive)[-3:]
    bounds = {"label": "travelled", "value": 1.0, "limit": 2.0}
    expected = {"event": "progress", "node": "drive", **bounds}
    assert {key: progress[key] for key in expected} == expected
    assert (moved["event"], moved["phase"], moved["t"]) == ("goal active", "active", 2 * S)
    assert "value" not in odd


def test_requirements_say_what_they_have_come_to(lines: Any):
    """With the names of `run --json`."""
    executive = ScriptedExecutive("patrol\n  go")
    executive.begin()
    executive.judge(is_slow="violated -0.1")
    assert lines(executive)[-1] == {
        "event": "requirement",
        "t": S,
        "name": "is slow",
        "requirement": "always speed < 0.3",
        "verdict": "violated",
        "margin": -0.1,
        "unit": "m/s",
        "at": 0.5,
        "violated_at": 0.5,
        "on_violation": "report",
        "sources": ["speed by odometry"],
        "why": "",
    }
