"""A mission on the stage that somebody looks on at."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.executive.events.events import Event
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.executive.events.watched_mission import WatchedMission
from bt_mission.ros import robot_relay, status_publisher
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRobot
from bt_mission.sessions.watching import RunSource, SessionGraph
from bt_mission.views.web.board import Board

DRIVE = """\
mission: drive
world: empty_arena
seed: 3
inputs: {far: 0.4}
requirements:
  slow: always speed < 0.5
tree:
  sequence:
    - log: off we go
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
      cancel_when: current_distance_travelled > $far
      on_cancel: success
      timeout: 30
    - turn: {angle: 45}
"""


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every look has all that there is: none waits for the wall clock."""
    monkeypatch.setattr(status_publisher, "DETAILS_PERIOD_S", 0.0)
    monkeypatch.setattr(robot_relay, "EVERY_S", 0.0)


class Watcher(WatchedMission):
    """What a view of this process knows of a mission."""

    def __init__(self, source: RunSource) -> None:
        super().__init__()
        self.source = source
        self.happened: list[Event] = []
        self.answers: list[str] = []

    def look(self) -> MissionState:
        """Take what has happened."""
        received = self.source.take(needs_statuses=self.needs_statuses)
        self.happened = self.take(received, 0.0)
        self.answers += [answer.text for answer in received.answers]
        return self.mission

    def ask(self, verb: Verb, node: str = "") -> str:
        """Send a request; gives the response."""
        self.source.send(ControlRequest(verb, node))
        self.look()
        return self.answers[-1]


@contextmanager
def watched(folder: Path, text: str | Path = DRIVE, **options: Any) -> Iterator[tuple[Stage, Any]]:
    """A mission on the stage, and what attaches a watcher."""
    made = options or {"mission": load(text)}
    with (
        Stage(**made, image_folder=folder, say=lambda _: None) as stage,
        closing(SessionGraph(stage)) as graph,
    ):
        yield stage, lambda name=graph.name: Watcher(graph.attach(name))


def until(stage: Stage, condition: Callable[[], Any]) -> None:
    """Step until a condition holds."""
    while not condition():
        assert not stage.is_done
        stage.step()


def test_looking_on_changes_nothing(tmp_path: Path):
    """The same trace, bit for bit, without a guest, though all is looked at after each step."""
    with Stage(load(DRIVE), image_folder=tmp_path, say=lambda _: None) as stage:
        until(stage, lambda: stage.is_done)
        unwatched = stage.trace.sha256, sorted(stage.node.get_service_names_and_types())
    farthest = 0.0
    with watched(tmp_path) as (stage, attach):
        watcher = attach()
        assert watcher.look().status == "", "nothing is known before the first tick but the tree"
        while not stage.is_done:
            stage.step()
            mission, state = watcher.look(), stage.executive.mission_state
            assert mission.now_ns <= stage.now_ns
            robot = mission.robot
            if robot.pose is not None:
                x, y, _ = stage.sim.robots[0].pose
                farthest = max(farthest, abs(robot.pose.x - x), abs(robot.pose.y - y))
            assert (mission.statuses, mission.goals) == (state.statuses, state.goals)
            assert (mission.explanation, mission.ends) == (state.explanation, state.ends)
        assert stage.guests == []
        seen = stage.trace.sha256, sorted(stage.node.get_service_names_and_types())
        assert seen == unwatched
    assert (mission.status, [goal.state for goal in mission.goals.values()]) == (
        "success",
        ["canceled", "succeeded"],
    )
    assert [(each.name, each.verdict) for each in mission.requirements] == [("slow", "holds")]
    assert mission.variables == {"far": "0.4"}
    assert "off we go" in [entry.text for entry in mission.log]
    assert farthest < 0.02, "the robot is seen where it is"
    assert len(robot.trail) >= 7
    assert len(robot.scan_points()) > 300
    assert robot.map is not None
    assert robot.charge is not None
    assert robot.charge > 90


def test_who_has_left_costs_nothing(tmp_path: Path):
    """Neither subscription nor callback is left."""
    with watched(tmp_path) as (stage, attach):
        executive = stage.executive
        before = len(executive.events), len(executive.after_tick)
        watcher = attach()
        assert (len(executive.events), len(executive.after_tick)) > before
        watcher.source.close()
        assert (len(executive.events), len(executive.after_tick)) == before


def test_who_comes_late_has_the_same_picture(tmp_path: Path):
    """As from another process: statuses without a time, so that no past is made up."""
    with watched(tmp_path) as (stage, attach):
        until(stage, lambda: stage.executive.goals_sent == 2)
        watcher = attach()
        board = Board()
        mission = watcher.look()
        board.show(mission, None)
        board.remember(mission, watcher.happened)
        state = stage.executive.mission_state
        assert (mission.statuses, mission.status) == (state.statuses, "running")
        assert [goal.state for goal in mission.goals.values()] == ["canceled", "sent"]
        assert mission.goals_changed_ns == state.goals_changed_ns
        assert mission.tip == state.tip == 3
        assert mission.requirements == state.requirements
        assert board.since(0)["past"]["begin"] == (mission.now_ns - stage.start_ns) / NS > 1
        until(stage, lambda: stage.is_done)
        assert watcher.look().status == "success"


def test_requests_are_done_and_answered_at_once(tmp_path: Path):
    """In the words of the services."""
    with watched(tmp_path) as (stage, attach):
        watcher = attach()
        until(stage, lambda: watcher.look().tip == 2)
        executive = stage.executive
        assert watcher.ask(Verb.STEP) == "the mission is not paused; pause it first"
        kept = "paused; still running: 'explore_forward'"
        assert watcher.ask(Verb.PAUSE_KEEPING_GOALS) == kept
        assert (watcher.mission.status, executive.reason) == ("paused", "paused on request")
        why = "paused on request; still running: 'explore_forward'"
        assert watcher.mission.conclusion == ("paused", why)
        assert watcher.ask(Verb.BREAK, "0.2") == "pauses before '0.2'"
        assert watcher.mission.breakpoints == ("0.2",)
        assert watcher.ask(Verb.RESUME) == "resumed"
        until(stage, lambda: watcher.look().status == "paused")
        assert watcher.mission.focus == 3
        ticks = executive.ticks
        assert watcher.ask(Verb.STEP) == "stepped one tick"
        until(stage, lambda: executive.ticks > ticks or watcher.look().tip == 3)
        assert watcher.ask(Verb.UNBREAK, "0.2") == "'0.2' no longer pauses"
        assert watcher.ask(Verb.PAUSE) == "paused"
        assert watcher.ask(Verb.STOP) == "stopping; waiting until all goals have ended"
        until(stage, lambda: stage.is_done)
        assert watcher.look().conclusion == ("interrupted", "stopped on request")
        assert watcher.ask(Verb.PAUSE) == "no mission is running"


def test_a_revision_is_shown_with_its_file(tmp_path: Path):
    """Nodes that stay keep their statuses; the file is the one of the new version."""
    file = tmp_path / "drive.yaml"
    file.write_text(DRIVE)
    longer = DRIVE + "    - log: done\n"
    with watched(tmp_path, file) as (stage, attach):
        watcher = attach()
        until(stage, lambda: watcher.look().tip == 2)
        assert stage.runner.revise(load(longer)).is_applied
        mission = watcher.look()
        watcher.check_file()
        assert (mission.tree.revision, len(mission.tree.nodes)) == (1, 5)
        assert mission.statuses[2] is Status.RUNNING
        late = attach()
        assert late.look().tree.revision == 1
        file.write_text(DRIVE + "# other\n")
        until(stage, lambda: stage.is_done)
        assert watcher.look().statuses == late.look().statuses == [Status.SUCCESS] * 5


def test_each_robot_of_a_fleet_can_be_watched(tmp_path: Path):
    """One after the other; each has its own events and its own place."""
    idle = load("mission: idle\ntree: {wait: 1}\n")
    robots = [FleetRobot("one", load(DRIVE), x=-1.0), FleetRobot("two", idle, x=1.0)]
    with watched(tmp_path, robots=robots) as (stage, attach):
        first, second = attach("/one/bt_mission"), attach("/two/bt_mission")
        until(stage, lambda: stage["two"].executive.is_done)
        assert (first.look().status, second.look().status) == ("running", "success")
        places = [watcher.mission.robot.pose.x for watcher in (first, second)]
        assert places == pytest.approx([stage[name].robot.pose[0] for name in ("one", "two")])
