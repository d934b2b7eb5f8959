"""The page of a recorded run: what is in it. No browser is needed to see that."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from bt_mission.cli import main
from bt_mission.views.drawing.path import LONGEST_PX, PATH, ROBOT, START, VIOLATED, WALL
from tests.support.recordings import edited, recording
from tests.support.report_pages import data_of

PageOf = Callable[[Path], Path]


@pytest.fixture
def data(hurried: Path, page_of: PageOf) -> dict[str, Any]:
    """The data of the page of a run that failed."""
    (result,) = data_of(page_of(hurried)).values()
    return result


def names_of(data: dict[str, Any]) -> list[str]:
    """The names of the nodes of the tree."""
    tree = next(message["tree"] for message in data["messages"] if "tree" in message)
    return [node[0] for node in tree["nodes"]]


def test_outcome_and_reason_are_in_the_markup(hurried: Path, page_of: PageOf):
    """So they are read where no script runs, too; as text."""
    text = page_of(hurried).read_text(encoding="utf-8")
    assert "<title>hurried &lt;b&gt;&amp;amp; failure · bt-mission</title>" in text
    assert '<span id="reason">&#x27;check $room &gt; 100&#x27; does not hold (room = ' in text


def test_nothing_is_fetched_and_only_its_own_script_runs(hurried: Path, page_of: PageOf):
    """A policy forbids the rest, with the checksums of script and style."""
    text = page_of(hurried).read_text(encoding="utf-8")
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src &#x27;none&#x27;; ")
    for tag in ("script", "style"):
        (content,) = re.findall(rf"<{tag}>(.*?)</{tag}>", text, re.DOTALL)
        checksum = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"{tag}-src &#x27;sha256-{checksum}&#x27;" in policy
    without_names = text.replace("http://www.w3.org/2000/svg", "")
    assert not re.findall(r"https?://|<link[^>]* href=\"(?!data:)", without_names)
    assert text.count("<script") == 2


def test_the_facts_of_the_run(data: dict[str, Any]):
    """As `run` has printed them."""
    facts = dict(data["details"]["facts"])
    assert facts["goals"] == "5"
    assert (facts["world"], facts["seed"], facts["collisions"]) == ("empty_arena", "0", "0")
    assert re.fullmatch(r"\d+\.\d\d s", facts["duration"])
    made = dict(data["details"]["made"])
    assert made["inputs"] == "speed = 0.25"
    assert "bt-mission" in made["versions"]
    (file,) = data["details"]["files"]
    assert "alert(1)</script>\n    - repeat" in file[1]


def test_the_way_to_the_failure(data: dict[str, Any]):
    """From the root to the leaf, with its message."""
    failure, names = data["details"]["failure"], names_of(data)
    way = [names[index] for index in failure["path"]]
    assert way == ["hurried <b>&amp;", "fallback", "check $room > 100"]
    assert failure["message"].startswith("does not hold (room = ")
    assert 0 < failure["at"] <= data["duration"]


def test_each_run_of_a_node_is_a_span(data: dict[str, Any]):
    """With its begin, end, status and message."""
    rows = data["details"]["spans"]["rows"]
    by_name = dict(zip(names_of(data), rows, strict=True))
    assert [status for _, _, status, _ in by_name["drive"]] == [2, 2]
    assert [status for _, _, status, _ in by_name["far away"]] == [3]
    assert rows[-1] == [], "it never ran"
    for begin, end, _, _ in by_name["drive"]:
        assert 0 <= begin < end <= data["duration"]
    leaves = {names_of(data)[index]: ends for index, ends, _ in data["details"]["leaves"]}
    assert leaves["drive"] == {"success": 2}


def test_goals_with_their_lives(data: dict[str, Any]):
    """Sent, accepted, canceled, ended; fields that say nothing are left out."""
    goals = data["details"]["goals"]
    assert [goal["owner"] for goal in goals] == [*["drive", "turn away"] * 2, "far away"]
    first = goals[0]
    assert first["sent"] <= first["accepted"] < first["cancel"] <= first["end"]
    assert first["status"] == "canceled"
    assert dict(first["values"]) == {"fwd_velocity": "0.25", "stopping_distance": "0.3"}
    assert "error_code" not in dict(first["result"])
    (distance,) = (
        field for field in first["feedback"] if field["name"] == "current_distance_travelled"
    )
    assert distance["v"] == sorted(distance["v"])
    assert first["messages"] > 10


def test_requirements_with_their_margins(data: dict[str, Any]):
    """And the instants that count."""
    slow, arrives = data["details"]["requirements"]
    assert (slow["name"], slow["verdict"], slow["unit"]) == ("is slow", "violated", "m/s")
    assert slow["violated_at"] < slow["at"]
    assert min(slow["chart"]["v"]) == pytest.approx(slow["margin"], abs=1e-3)
    assert (arrives["verdict"], arrives["chart"]) == ("violated", None)


def test_figures_against_time(data: dict[str, Any]):
    """Of the robot."""
    charts = {chart["name"]: chart for chart in data["details"]["charts"]}
    assert list(charts) == ["speed", "distance", "clearance", "battery"]
    for chart in charts.values():
        assert len(chart["t"]) == len(chart["v"]) <= 1200


def test_messages_are_those_of_a_live_page(data: dict[str, Any]):
    """In the order of time; the first has the tree, the last the end."""
    assert data["times"] == sorted(data["times"])
    assert len(data["times"]) == len(data["messages"])
    assert data["messages"][-1]["state"]["status"] == "failure"
    last: dict[str, str] = {}
    for message in data["messages"]:
        last |= dict(message.get("variables", ()))
    assert last["room"].startswith("1.")


def test_poses_and_scans_are_thinned(data: dict[str, Any]):
    """A few poses and one scan a second, to the centimetre."""
    seconds = data["duration"]
    assert seconds < len(data["poses"]["t"]) <= 5 * seconds + 1
    scans = [
        message["robot"]["scan"]
        for message in data["messages"]
        if message.get("robot", {}).get("scan")
    ]
    assert seconds / 2 < len(scans) <= seconds + 2
    assert all(isinstance(scan, int) for scan in scans[0])
    assert len(scans[0]) <= 2 * 180
    maps = [message for message in data["messages"] if message.get("robot", {}).get("grid")]
    assert len(maps) == 1, "the map does not change"


def test_a_recording_that_is_not_whole_says_so(page_of: PageOf, tmp_path: Path):
    """The page shows what is there."""
    cut = tmp_path / "cut.mcap"
    contents = recording().read_bytes()
    cut.write_bytes(contents[: len(contents) * 2 // 3])
    (data,) = data_of(page_of(cut)).values()
    assert "the file is incomplete, or the recorder was killed" in data["details"]["lacks"]
    assert data["cut"] == "the file is incomplete, or the recorder was killed"


def test_a_fault_that_never_began_is_shown(page_of: PageOf, tmp_path: Path):
    """In the headline of the page, and in its log."""
    path = tmp_path / "untested.mcap"
    mission = tmp_path / "waits.yaml"
    mission.write_text("mission: waits\nworld: empty_arena\ntree: {wait: 0.1}\n", encoding="utf-8")
    fault = ["--fault", "at 500: drop scan", "--fault", "at 600: drop odom may_not_happen"]
    assert main(["run", str(mission), "--record", str(path), *fault]) == 1
    page = page_of(path)
    what = "'at 500.0: drop scan' never happened"
    assert "<title>waits untested" in page.read_text(encoding="utf-8")
    (data,) = data_of(page).values()
    state = data["messages"][-1]["state"]
    assert state["verdict"] == "untested"
    assert state["reason"] == f"{what}; the mission itself succeeded"
    assert f"not tested: {what}" in str(data["messages"])
    assert "600" not in str(data["messages"])


def test_a_recording_of_the_executive_alone_has_a_page(page_of: PageOf, tmp_path: Path):
    """Of a robot elsewhere nothing may be known."""
    alone = edited(
        tmp_path / "alone.mcap", lambda channel, _: channel.topic.startswith("/bt_mission")
    )
    (data,) = data_of(page_of(alone)).values()
    assert data["poses"]["t"] == data["details"]["truth"]["t"] == []
    assert data["details"]["charts"] == []
    assert any(data["details"]["spans"]["rows"])


def test_a_picture_shows_the_path_over_the_map(hurried: Path, tmp_path: Path) -> None:
    """With the verdicts of requirements below; a violated one is red."""
    picture = tmp_path / "hurried.png"
    assert main(["report", str(hurried), "-o", str(picture)]) == 0
    image = Image.open(picture).convert("RGB")
    assert image.width == LONGEST_PX
    colours = {colour for _, colour in image.getcolors(1 << 24) or ()}
    assert {PATH, START, ROBOT, WALL, VIOLATED} <= colours
