"""What happens, as JSON for programs."""

from __future__ import annotations

import json
from typing import Any

import pytest

from bt_mission.events.events import GoalChanged
from bt_mission.events.log import json_line
from bt_mission.events.mission_state import MissionState
from tests.support.watched import S, ScriptedExecutive


@pytest.fixture
def lines() -> Any:
    """Give what an executive tells as the objects that a program reads."""
    mission = MissionState()

    def read(executive: ScriptedExecutive) -> list[dict[str, Any]]:
        return [
            json.loads(json_line(one))
            for message in executive.take(needs_statuses=mission.needs_statuses).messages
            for one in mission.take(message)
        ]

    return read


def test_each_object_says_what_it_is_and_when(lines: Any):
    """Tree first; times are seconds of ROS time."""
    executive = ScriptedExecutive("patrol\n  go")
    executive.begin()
    executive.change(0.5, go="running")
    executive.say("here we go")
    executive.stand("paused", "paused on request")
    found = lines(executive)
    assert found[0] == {
        "event": "tree",
        "t": 1.0,
        "run": "run",
        "mission": "patrol",
        "nodes": [
            {"name": "patrol", "kind": "ActionLeaf", "path": "0", "parent": 0},
            {"name": "go", "kind": "ActionLeaf", "path": "0.0", "parent": 0},
        ],
    }
    assert found[2:] == [
        {
            "event": "status",
            "t": 1.5,
            "index": 1,
            "node": "go",
            "path": "0.0",
            "status": "running",
            "message": "",
        },
        {"event": "log", "t": 1.5, "text": "here we go"},
        {
            "event": "mission",
            "t": 1.5,
            "run": "run",
            "mission": "explore",
            "status": "paused",
            "reason": "paused on request",
        },
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
    [
        ("6", 6),
        ("[1.5, 2]", [1.5, 2]),
        ('"a"', "a"),
        ("NaN", "NaN"),
        ("[1, 2, ...", "[1, 2, ..."),
    ],
)
def test_values_of_variables_are_json_where_they_can_be(lines: Any, text: str, value: Any):
    """One that was cut, or is no number of JSON's, comes as its text."""
    executive = ScriptedExecutive()
    executive.begin()
    executive.detail(variables=(("x", text),))
    assert lines(executive)[-1] == {"event": "variable", "t": 1.0, "name": "x", "value": value}


def test_goals_and_progress(lines: Any):
    """A progress that is no number is left out: JSON has no NaN."""
    executive = ScriptedExecutive()
    executive.begin()
    executive.change(drive="running")
    goal = GoalChanged("ab", "/turn", "turn away", S, 2 * S, "active")
    executive.detail(running=(executive.progress("drive", 1.0, 2.0, "1 m"),), goals=(goal,))
    executive.detail(running=(executive.progress("drive", float("nan"), 2.0, "1 m"),))
    progress, moved, odd = lines(executive)[-3:]
    assert {key: progress[key] for key in ("event", "node", "label", "value", "limit")} == {
        "event": "progress",
        "node": "drive",
        "label": "travelled",
        "value": 1.0,
        "limit": 2.0,
    }
    assert (moved["event"], moved["state"], moved["t"], moved["sent"]) == ("goal", "active", 2, 1)
    assert "value" not in odd


def test_requirements_say_what_they_have_come_to(lines: Any):
    """With the names of `run --json`."""
    executive = ScriptedExecutive("patrol\n  go")
    executive.begin()
    executive.judge(is_slow="violated -0.1")
    assert lines(executive)[-1] == {
        "event": "requirement",
        "t": 1.0,
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
