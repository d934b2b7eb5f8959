"""The table of what goals may hold is that of the servers, and true of their types."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

from action_servers.camera.colours import HUES_DEG
from action_servers.core.goal_limits import MOST_POSES
from action_servers.core.goal_rules import ACTIONS
from action_servers.core.limits import COLOURS, NumberLimit, faults
from action_servers.core.tuning import TUNING
from bt_mission.core.robot.model import load_robot
from bt_mission.language.message_types import field_at, value_type
from bt_mission.ros.interface_types import action_type, shapes

WAFFLE = load_robot("waffle")


@pytest.mark.parametrize("name", ACTIONS)
def test_every_limit_names_a_field_of_the_type(name):
    """So does every range of the feedback."""
    rules = ACTIONS[name]
    found = shapes(rules.type)
    for limit in rules.limits(WAFFLE, TUNING):
        field_at(found.sends, limit.field)  # raises UnknownField
    for field in rules.feedback(action_type(rules.type).Goal()):
        assert found.asks is not None
        assert value_type(field_at(found.asks, field)) in ("integer", "number")


@pytest.mark.parametrize("name", ACTIONS)
def test_a_goal_of_each_type_can_be_asked(name):
    """A message with all fields at 0 meets no exception."""
    rules = ACTIONS[name]
    goal = action_type(rules.type).Goal()
    assert all(one is None or one for one in faults(goal, rules.limits(WAFFLE, TUNING)))
    assert rules.misfit(goal) is None or rules.misfit(goal)


def test_the_colours_are_those_with_a_hue():
    """In the same order."""
    assert tuple(HUES_DEG) == COLOURS


def test_limits_are_read_without_ros_and_numpy():
    """Nothing of what a run needs is loaded for a check."""
    code = (
        "import sys, action_servers.core.goal_rules\n"
        "print(sorted({'rclpy', 'mujoco', 'numpy', 'scipy', 'cv2'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (NumberLimit(field="a", low=1, high=5, unit="s", source=""), "from 1 to 5 s"),
        (
            NumberLimit(field="a", low=0, high=5, unit="s", source="", above=True),
            "above 0 and at most 5 s",
        ),
        (NumberLimit(field="a", low=0, high=float("inf"), unit="s", source=""), "0 s or more"),
    ],
)
def test_a_limit_is_told_in_words(limit, words):
    """What is accepted."""
    assert limit.words == words


def test_a_zero_with_a_meaning_is_accepted():
    """Beside the range, and only 0."""
    limit = NumberLimit(field="a", low=1, high=5, unit="s", source="", zero="the default")
    assert [limit.fault(value) is None for value in (0.0, 0.5, 1.0)] == [True, False, True]


def test_a_duration_counts_in_seconds():
    """As a message has it."""
    limit = NumberLimit(field="time", low=0, high=float("inf"), unit="s", source="")
    goal = SimpleNamespace(time=SimpleNamespace(sec=-2, nanosec=500_000_000))
    assert list(faults(goal, (limit,))) == ["time must not be negative, got -1.5 s"]


@pytest.mark.parametrize("name", ["follow_waypoints", "navigate_through_poses"])
def test_a_goal_holds_so_many_poses(name):
    """Each is placed on the map between two control steps."""
    misfit = ACTIONS[name].misfit
    assert misfit(SimpleNamespace(poses=[None] * MOST_POSES, goal_index=0)) is None
    beyond = SimpleNamespace(poses=[None] * (MOST_POSES + 1), goal_index=0)
    assert misfit(beyond) == "poses must be 1,000 or less, got 1,001"
