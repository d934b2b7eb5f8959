"""The types by which a mission is looked on at: exact fields, which are what goes over the wire."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.msg import (
    GoalRecord,
    MissionDetails,
    MissionLog,
    NodeProgress,
    Variable,
)


@pytest.mark.parametrize(
    ("message", "fields"),
    [
        (
            MissionDetails,
            (
                "builtin_interfaces/Time stamp, string run, uint32 ticks, uint32 goals_sent, "
                "sequence<bt_mission_interfaces/NodeProgress> running, "
                "sequence<bt_mission_interfaces/GoalRecord> goals, "
                "sequence<bt_mission_interfaces/Variable> variables, sequence<string> breakpoints"
            ),
        ),
        (
            NodeProgress,
            (
                "uint32 node, builtin_interfaces/Time since, string message, string label, "
                "double value, double limit"
            ),
        ),
        (
            GoalRecord,
            (
                "string goal_id, string action, string owner, builtin_interfaces/Time sent, "
                "builtin_interfaces/Time changed, string state, "
                "sequence<geometry_msgs/Point> targets"
            ),
        ),
        (Variable, "string name, string value"),
        (MissionLog, "builtin_interfaces/Time stamp, string run, string text, string event"),
    ],
)
def test_fields_are_exactly_these(message: Any, fields: str):
    """Name, type and order of each field: all three are part of the type's hash."""
    results = message.get_fields_and_field_types().items()
    assert ", ".join(f"{kind} {name}" for name, kind in results) == fields
