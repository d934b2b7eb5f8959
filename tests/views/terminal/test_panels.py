"""What the panels say."""

from __future__ import annotations

import pytest

from bt_mission.executive.events.events import NotTested, StateChanged
from bt_mission.executive.events.messages import BatteryState, FrameTransform
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.robot_state import RobotState
from bt_mission.executive.events.watched_mission import targets
from bt_mission.views.terminal.marks import ASCII_SIGNS, SIGNS, text_of
from bt_mission.views.terminal.panels import (
    goals_title,
    header,
    map_title,
    node_rows,
    path,
    requirement_rows,
    requirements_title,
    variable_rows,
)
from tests.support.watched import S, ScriptedExecutive, goal_in, known


@pytest.mark.parametrize(
    ("status", "reason", "shown"),
    [
        ("running", "", "explore  ▶ running  2.00 s  1.5 x  battery 87 %"),
        ("paused", "by hand", "explore  paused  2.00 s  1.5 x  battery 87 %  by hand"),
        ("success", "", "explore  ✓ success  2.00 s  battery 87 %"),
        ("failure", "'drive'", "explore  ✗ failure  2.00 s  battery 87 %  'drive'"),
    ],
)
def test_the_header_says_how_it_goes(
    executive: ScriptedExecutive, status: str, reason: str, shown: str
):
    """A mission that has ended has no pace."""
    robot = RobotState()
    robot.take(BatteryState(87.0, 12.0))
    executive.now_ns += 2 * S
    executive.stand(status, reason)
    assert text_of(header(known(executive), robot, 1.5, SIGNS)) == shown


def test_a_run_that_has_not_shown_what_was_planned_is_no_success(executive: ScriptedExecutive):
    """The header says what never happened, on a terminal as on a full screen."""
    mission = known(executive)
    mission.apply(NotTested(2 * S, "'at 500: drop scan' never happened"))
    mission.apply(StateChanged(2 * S, "run", "explore", "success", ""))
    shown = text_of(header(mission, RobotState(), None, SIGNS))
    assert shown.startswith("explore  ✗ untested")
    assert "'at 500: drop scan' never happened; the mission itself succeeded" in shown


def test_of_nothing_little_is_said():
    """Before an executive has told anything."""
    assert text_of(header(MissionState(), RobotState(), None, SIGNS)) == "no mission"
    assert goals_title(MissionState()) == "goals"
    assert node_rows(MissionState(), 0, 40, SIGNS) == []
    assert map_title(RobotState()) == "map"


@pytest.mark.parametrize(
    ("width", "shown"),
    [(80, "explore ▸ repeat ▸ drive"), (20, "… ▸ repeat ▸ drive"), (9, "… ▸ drive"), (5, "drive")],
)
def test_the_end_of_a_path_stays(width: int, shown: str):
    """It is what runs."""
    assert text_of(path(["explore", "repeat", "drive"], width, SIGNS)) == shown


def test_a_path_without_utf_8():
    """With signs of ASCII."""
    assert text_of(path(["a", "b", "c"], 6, ASCII_SIGNS)) == "~ > c"


@pytest.mark.parametrize(
    ("value", "shown"),
    [("6", "6"), ("-10.01606559753418", "-10.0161"), ('"left"', '"left"'), ("0.1234", "0.1234")],
)
def test_variables_are_short(executive: ScriptedExecutive, value: str, shown: str):
    """Six digits of a number say enough; texts are left as they are."""
    executive.detail(variables=(("x", value),))
    (row,) = variable_rows(known(executive), SIGNS)
    assert text_of(row) == f"x {shown}"


def test_the_words_of_a_node_are_shown_in_full(executive: ScriptedExecutive):
    """Over as many rows as it takes."""
    executive.change(drive="running")
    executive.change(2.0, drive="failure: aborted: no room to turn left, an obstacle stands there")
    rows = [text_of(row) for row in node_rows(known(executive), 3, 30, SIGNS)]
    assert rows == [
        "drive",
        "✗ failure, ran 2.00 s, since 2.00 s",
        "ActionLeaf, path 0.1.0",
        "aborted: no room to turn left,",
        "an obstacle stands there",
    ]


def test_a_node_tells_what_it_is_asked_to_do_and_what_came_of_it(executive: ScriptedExecutive):
    """Its goal, and how it has ended before."""
    asked = ("fwd_velocity 0.2", "success when distance >= reach", "within 30 s")
    executive.details = {"0.1.0": asked}
    executive.begin("again")
    executive.change(drive="running")
    executive.change(2.0, drive="failure: no room")
    executive.change(drive="invalid")
    executive.change(1.0, drive="running: 0.4 m")
    executive.detail(goals=(goal_in("active", goal_id="ab" * 16, action="/go", owner="drive"),))
    mission = known(executive)
    assert [text_of(row) for row in node_rows(mission, 3, 80, SIGNS)] == [
        "drive",
        "▶ running for 0.00 s, since 3.00 s",
        "ActionLeaf, path 0.1.0",
        "0.4 m",
        "fwd_velocity 0.2, success when distance >= reach, within 30 s",
        "▶ active  goal abababab at /go",
        "before: ✗ failure at 2.00 s, ran 2.00 s  no room",
    ]


def test_the_map_has_the_places_of_the_goal_that_is_open(executive: ScriptedExecutive):
    """Else of the last one that named any; of none once the mission has ended."""
    done = goal_in("succeeded", (1.0, 1.0), goal_id="a", action="/go", owner="go")
    is_open = goal_in("active", (2.0, 2.0), goal_id="b", action="/go", owner="go")
    executive.detail(
        goals=(done, is_open, goal_in("active", goal_id="c", action="/turn", owner="turn"))
    )
    assert targets(known(executive)) == ((2.0, 2.0),)
    executive.begin("two")
    executive.detail(goals=(done,))
    mission = known(executive)
    assert targets(mission) == ((1.0, 1.0),)
    mission.apply(StateChanged(S, "two", "explore", "success", ""))
    assert targets(mission) == ()


def test_a_robot_that_is_not_localised_is_told_with_its_frame():
    """Its pose is not one of the map."""
    robot = RobotState()
    robot.take((FrameTransform("odom", "base_link", 1.0, -2.0, 0.0),))
    assert map_title(robot) == "map: x 1.00  y -2.00 m in odom"


def test_the_header_says_what_is_violated(executive: ScriptedExecutive):
    """Before all that may be cut off in a narrow terminal."""
    executive.judge(is_slow="violated -0.1", keeps_away="open 0.2")
    shown = text_of(header(known(executive), RobotState(), None, SIGNS))
    assert shown == "explore  ▶ running  ✗ 1 of 2 violated  0.00 s"


def test_requirements_stand_in_columns_the_violated_ones_first(executive: ScriptedExecutive):
    """With the present margin, and what it is measured by."""
    executive.judge(keeps_away="open 0.25", is_slow="violated -0.1", ends="holds", sees="unknown")
    mission = known(executive)
    words = "  at 0.50 s  speed by odometry  always speed < 0.3"
    assert [text_of(row) for row in requirement_rows(mission, SIGNS)] == [
        f"✗ violated is slow     -0.1 m/s{words}",
        f"· unknown  sees                {words}",
        f"▶ open     keeps away +0.25 m/s{words}",
        f"✓ holds    ends                {words}",
    ]
    expected = "requirements: 1 violated, 1 unknown, 1 open, 1 holds"
    assert requirements_title(mission) == expected


def test_long_names_of_requirements_leave_room_for_margins(executive: ScriptedExecutive):
    """As everything, they are escaped."""
    executive.judge(**{"x" * 80: "open 0.25", "\x1b[31m": "open"})
    for row in requirement_rows(known(executive), ASCII_SIGNS):
        assert len(text_of(row[:3])) == len("> open     ") + 32 + len(" +0.25 m/s")
        assert "\x1b" not in text_of(row)
