"""A recording for pages: what is shown when, and how one moves in it."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import Any

import pytest

from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.web.page_requests import PageRequest
from bt_mission.views.web.replay import ForkOffer, ReplayedMission
from bt_mission.views.web.shown_mission import OpenPanels
from tests.support.recordings import recording


@pytest.fixture
def shown() -> ReplayedMission:
    """It, standing still at its start."""
    return ReplayedMission(Player(read_timeline(recording())))


def told(shown: ReplayedMission, revision: int = 0) -> dict[str, Any]:
    """What a page is told after a revision."""
    shown.look(OpenPanels(map=True))
    return shown.board.since(revision)


def ask(shown: ReplayedMission, do: str, **fields: Any) -> dict[str, Any]:
    """Ask for something; gives all that a new page would be told then."""
    shown.perform(PageRequest(do, **fields))
    return told(shown)


def test_of_a_fleet_the_robot_is_named():
    """Its mission may be that of another robot, too."""
    player = Player(read_timeline(recording()))
    name = player.timeline.path.name
    assert told(ReplayedMission(player))["state"]["source"] == name
    assert told(ReplayedMission(player, robot="tb1"))["state"]["source"] == f"{name}, robot tb1"


def test_an_instant_is_shown_as_it_was(shown: ReplayedMission):
    """Also coming back from later."""
    early = ask(shown, "go", number=1.0)
    assert early["state"]["mission"] == "there and back"
    assert early["state"]["status"] == "running"
    assert early["replay"]["at"] == 1.0
    late = ask(shown, "go", number=1e6)
    assert late["state"]["status"] == "success"
    assert late["replay"]["at"] == late["replay"]["duration"]
    assert len(late["goals"]) == 4
    assert dict(late["variables"])["room"].startswith("1.6")
    again = ask(shown, "go", number=1.0)
    for part in ("state", "goals", "nodes", "log", "requirements"):
        assert sorted(again.get(part, ()), key=str) == sorted(early.get(part, ()), key=str), part
    assert dict(again.get("variables", ())) == dict(early.get("variables", ()))


def test_a_page_that_went_back_forgets_what_was_later(shown: ReplayedMission):
    """Goals, values and lines of the log that are not known yet at that instant."""
    ask(shown, "go", number=1e6)
    revision = shown.board.revision
    shown.perform(PageRequest("go", number=1.0))
    changed = told(shown, revision)
    assert changed["values_are_new"]
    assert changed["log_is_new"]
    assert len(changed["goals"]) == 1


def test_what_stands_still_is_told_once(shown: ReplayedMission):
    """However often one looks."""
    told(shown)
    revision = shown.board.revision
    assert told(shown, revision) == {}
    assert shown.board.revision == revision


def test_steps_starts_speed_and_direction(shown: ReplayedMission):
    """As on a terminal; where there is nothing more, a notice says so."""
    first = ask(shown, "change", number=1)["replay"]["at"]
    second = ask(shown, "change", number=1)["replay"]["at"]
    assert 0 < first < second
    assert ask(shown, "change", number=-1)["replay"]["at"] == first
    assert ask(shown, "speed", number=4.0)["replay"]["speed"] == 4.0
    assert ask(shown, "reverse")["replay"]["is_backwards"]
    ask(shown, "go", number=0.0)
    assert ask(shown, "change", number=-1)["notice"] == [1, "nothing before this"]
    names = [node[0] for node in told(shown)["tree"]["nodes"]]
    drive = names.index("drive")
    started = ask(shown, "start", node=drive, number=1)["replay"]["at"]
    assert ask(shown, "start", node=drive, number=1)["replay"]["at"] > started
    assert ask(shown, "pause")["notice"][1] == "a mission that is over takes no wishes"
    ask(shown, "start", node=10_000, number=1)


def test_pages_are_told_how_it_is_forked_where_that_is_offered(shown: ReplayedMission):
    """The instant is theirs to add."""
    assert "fork" not in told(shown)
    offer = ForkOffer("bt-mission fork run.mcap --at", "a live run cannot run again")
    other = ReplayedMission(Player(read_timeline(recording())), offer)
    assert told(other)["fork"] == {
        "command": "bt-mission fork run.mcap --at",
        "refusal": "a live run cannot run again",
    }


def test_a_variable_is_known_over_all_of_the_recording(shown: ReplayedMission):
    """At whatever instant it is asked for."""
    told(shown)
    values = shown.board.series("room")
    assert values
    assert all(later[0] >= earlier[0] for earlier, later in pairwise(values))
    assert values[-1][1] == pytest.approx(1.64, abs=0.01)


def test_changes_are_marked_on_the_line_of_time(shown: ReplayedMission):
    """As shares of its length."""
    marks = told(shown)["marks"]
    assert marks == sorted(marks)
    assert 0 <= marks[0] <= marks[-1] <= 1


def test_the_robot_and_its_map_are_told_where_a_page_has_them_open(shown: ReplayedMission):
    """With its walls in runs."""
    ask(shown, "go", number=1.0)
    robot = shown.board.robot_since(0)
    assert len(robot["pose"]) == 3
    assert len(robot["scan"]) > 10
    assert json.loads(json.dumps(robot, allow_nan=False)) == robot
    grid = robot["grid"]
    assert sum(count for _, count in grid["runs"]) == grid["width"] * grid["height"]
