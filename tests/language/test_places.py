"""Named places: those of a mission, and the zones of its world."""

from __future__ import annotations

import random
from typing import Any

import pytest

from bt_mission.base.yaml.document import read_text
from bt_mission.language.expressions.expression import Expression, Late, Text
from bt_mission.scenarios.loader import examine_scenario
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

HEAD = (
    "mission: m\nworld: nav_arena\ninputs: {home: zone B, route: [A, dock]}\n"
    "places: {dock: [50 cm, 0, 180 deg], door: {x: 1.0, y: 0.5}}\n"
)
RNG = random.Random(0)


def pose(text: str) -> Any:
    """Return what a goal of `navigate_to_pose` sends as its pose."""
    mission = load(f"{HEAD}tree: {{navigate_to_pose: {{pose: {text}}}}}\n")
    node: Any = mission.tree
    result = node.sent["pose"]
    assert isinstance(result, Text)
    assert result.text == text
    return Late(result, mission.inputs, RNG).as_value()


def messages(text: str, head: str = HEAD) -> list[str]:
    """Return what is said of a mission."""
    _, faults = examine(f"{head}tree:\n  {text}\n")
    return [f"{fault.message}; {fault.hint}" for fault in faults if fault.severity == "error"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("dock", [0.5, 0.0, 180.0]),
        ("door", [1.0, 0.5, 0.0]),
        ("A", [-1.85, -1.76, 0.0]),
        ("zone A", [-1.85, -1.76, 0.0]),
        ("$home", [1.85, -1.02, 0.0]),
        ("home", [1.85, -1.02, 0.0]),
        ("\"'dock'\"", [0.5, 0.0, 180.0]),
    ],
)
def test_a_name_is_a_pose(text: str, value: list[float]) -> None:
    """Also one that a variable holds; the text stays for drawings."""
    if text.startswith('"'):
        mission: Any = load(f"{HEAD}tree: {{navigate_to_pose: {{pose: {text}}}}}\n")
        assert Late(mission.tree.sent["pose"], {}, RNG).as_value() == value
        return
    assert pose(text) == value


def test_a_list_of_names_is_a_list_of_poses() -> None:
    """Each alone, or all in a variable."""
    text = "{follow_waypoints: {poses: $route}, timeout: 9}"
    mission: Any = load(f"{HEAD}tree: {text}\n")
    poses = Late(mission.tree.sent["poses"], mission.inputs, RNG).as_value()
    assert poses == [[-1.85, -1.76, 0.0], [0.5, 0.0, 180.0]]
    assert messages(text) == []
    assert messages("{follow_waypoints: {poses: [A, door, [1, 0.5, 0]]}, timeout: 9}") == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("zone Q", "unknown place 'zone Q' (places: A, B, C, D, dock, door); None"),
        ("dok", "unknown place 'dok' (places: A, B, C, D, dock, door); did you mean 'dock'?"),
        ("$missing", "'$missing' is an undefined variable (defined: home, route); None"),
    ],
)
def test_a_name_that_no_place_has_is_an_error(text: str, message: str) -> None:
    """It lists those that there are."""
    assert messages(f"{{navigate_to_pose: {{pose: {text}}}, timeout: 9}}") == [message]


def test_without_places_the_error_says_so() -> None:
    """The world may have no zones."""
    result = messages("{navigate_to_pose: {pose: zone A}, timeout: 9}", "mission: m\n")
    assert result == [
        (
            "unknown place 'zone A': the mission has no 'places' and names no world; "
            "write 'world: NAME' at its head, or a pose: [x m, y m, yaw deg]"
        )
    ]


def test_a_place_is_checked_like_a_pose() -> None:
    """There must be room for the robot."""
    head = "mission: m\nworld: nav_arena\nplaces: {far: [50, 0]}\n"
    (message,) = messages("{navigate_to_pose: {pose: far}, timeout: 9}", head)
    assert "map" in message


@pytest.mark.parametrize("written", ["3", "[1]", "{x: 1}", "[1, 2, 3, 4]", "[a, 2]", "[1 s, 2]"])
def test_a_malformed_place_is_refused(written: str) -> None:
    """With the forms that there are."""
    assert messages("wait: 1", f"mission: m\nplaces: {{p: {written}}}\n")


def test_a_scenario_has_the_zones_of_its_own_world() -> None:
    """Those of the mission's world are not there."""
    text = (
        "scenario: s\nworld: {name: w, size: [4, 4], zones: [{name: Z, x: 1, y: 0.5}]}\n"
        "mission:\n  mission: m\n  world: nav_arena\n"
        "  tree: {navigate_to_pose: {pose: %s}, timeout: 9}\n"
    )
    scenario, _ = examine_scenario(read_text(text % "Z"))
    assert scenario is not None
    sent: Any = scenario.mission.tree
    assert isinstance(sent.sent["pose"].expression, Expression)
    none, faults = examine_scenario(read_text(text % "A"))
    assert none is None
    assert faults[0].message == "unknown place 'A' (places: Z)"
