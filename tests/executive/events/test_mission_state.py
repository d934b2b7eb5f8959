"""A mission as its executive tells of it: late, out of order, with gaps, and again."""

from __future__ import annotations

import pytest
from py_trees.common import Status

from bt_mission.executive.events.events import (
    BreakpointsChanged,
    Event,
    FaultChanged,
    GoalChanged,
    LogLine,
    NodeChanged,
    NodeInfo,
    NodesReset,
    RequirementChanged,
    RunStarted,
    StateChanged,
    VariableChanged,
)
from bt_mission.executive.events.feed import MissionFeed, in_order
from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.mission_state import MOST_GOALS, MissionState
from tests.support.watched import S, ScriptedExecutive, goal_in, requirement, state_of, tree


def take_all(feed: MissionFeed, executive: ScriptedExecutive) -> list[Event]:
    """Hand over what waits, with the service for latecomers."""
    happened: list[Event] = []
    for _ in range(2):
        for batch in executive.take(needs_statuses=feed.needs_statuses).messages:
            happened += feed.take(batch)
    return happened


def watched() -> tuple[ScriptedExecutive, MissionFeed, MissionState]:
    """An executive, and a watcher that knows nothing yet."""
    feed = MissionFeed(MissionState())
    return ScriptedExecutive(), feed, feed.mission


def named(mission: MissionState) -> dict[str, str]:
    """Each node's status."""
    assert mission.tree is not None
    statuses = zip(mission.tree.nodes, mission.statuses, strict=True)
    return {node.name: status.value.lower() for node, status in statuses}


def test_changes_from_the_first_on_need_no_question():
    """Nothing has happened before number 1."""
    executive, feed, mission = watched()
    executive.begin()
    executive.change(explore="running", look_around="running")
    executive.change(2.5, look_around="success: canceled by condition")
    happened = take_all(feed, executive)
    assert executive.asked == 0
    kinds = [type(event) for event in happened]
    assert kinds == [RunStarted, StateChanged, NodeChanged, NodeChanged, NodeChanged]
    assert named(mission)["look around"] == "success"
    assert mission.messages[1] == "canceled by condition"
    assert (mission.ran_ns[1], mission.elapsed_ns) == (round(2.5 * S), round(2.5 * S))
    assert not feed.needs_statuses


def test_who_comes_late_asks_once_and_goes_on_from_there():
    """What the answer has taken into account is not applied a second time."""
    executive, feed, mission = watched()
    result = executive.begin()
    executive.change(explore="running", look_around="running")
    executive.forget()
    feed.take(result)
    assert feed.sequence is None
    before = executive.statuses
    late = executive.change(1.0, look_around="success")
    later = executive.change(1.0, repeat="running")
    assert feed.take(later) == []
    feed.take(before)
    assert feed.sequence is None, "one change is missing"
    feed.take(executive.statuses)
    running, invalid = ("explore", "repeat"), ("drive", "turn away")
    statuses = dict.fromkeys(running, "running") | dict.fromkeys(invalid, "invalid")
    assert named(mission) == statuses | {"look around": "success"}
    assert feed.take(late) == []
    assert mission.since_ns[1] is None, "nobody saw when"


def test_a_gap_is_noticed_and_closed():
    """Lost messages cost a question, not the truth."""
    executive, feed, mission = watched()
    executive.begin()
    executive.change(explore="running")
    take_all(feed, executive)
    executive.change(look_around="running")
    executive.forget()
    executive.change(1.0, look_around="failure: aborted")
    happened = take_all(feed, executive)
    assert executive.asked == 1
    (change,) = (event for event in happened if isinstance(event, NodeChanged))
    assert change.status is Status.FAILURE
    assert mission.messages[1] == "aborted"


def test_the_tree_may_come_after_its_first_changes():
    """Topics have no order among each other."""
    executive, feed, mission = watched()
    result = executive.begin()
    change = executive.change(explore="running")
    assert feed.take(change) == []
    feed.take(result)
    assert named(mission)["explore"] == "running"


def test_another_run_begins_anew():
    """Nothing of the mission before is left, and what is late of it changes nothing."""
    executive, feed, mission = watched()
    executive.begin("one")
    executive.change(explore="running", drive="running")
    executive.detail(variables=(("legs", "6"),))
    take_all(feed, executive)
    stale = executive.change(drive="success")
    stale_details = executive.detail(variables=(("legs", "7"),))
    executive.forget()
    executive.begin("two")
    take_all(feed, executive)
    assert feed.take(stale) == feed.take(stale_details) == []
    assert (mission.variables, mission.running) == ({}, {})
    assert set(named(mission).values()) == {"invalid"}
    assert feed.take(Batch("one", (NodeChanged(None, 0, Status.RUNNING, ""),), 9, True)) == []


def test_the_tip_is_the_newest_running_node_without_running_children():
    """A tick tells of children before their parents; where they stand in the tree counts."""
    executive, feed, mission = watched()
    executive.begin()
    executive.change(drive="running", repeat="running", explore="running")
    take_all(feed, executive)
    assert mission.tip == 3
    executive.change(drive="success")
    take_all(feed, executive)
    assert mission.tip == 2, "the repeat itself, in a pause of its own"
    executive.change(repeat="success", explore="success")
    take_all(feed, executive)
    assert mission.tip is None


def test_progress_counts_for_nodes_that_run():
    """Details and changes overtake each other: those of a node that has ended are not shown."""
    executive, feed, mission = watched()
    executive.begin()
    executive.change(drive="running")
    early = executive.detail(running=(executive.progress("drive", 1.0, 2.0, "1.00 m"),))
    executive.forget()
    executive.change(3.0, drive="running")
    executive.forget()
    feed.take(executive.begin("run"))
    feed.take(early)
    executive.change(drive="running")
    take_all(feed, executive)
    assert (mission.messages[3], mission.progress[3].value) == ("1.00 m", 1.0)
    executive.change(1.0, drive="success: done")
    take_all(feed, executive)
    assert (mission.messages[3], mission.progress) == ("done", {})
    feed.take(early)
    assert mission.messages[3] == "done"


def test_goals_and_variables_happen_when_they_change():
    """Complete details, which come for latecomers, are no news."""
    executive, feed, mission = watched()
    executive.begin()
    sent = goal_in()
    executive.detail(goals=(sent,), variables=(("legs", "6"),), goals_sent=1)
    executive.detail(goals=(sent,), variables=(("legs", "6"),), goals_sent=1)
    happened = take_all(feed, executive)
    assert [event for event in happened if isinstance(event, GoalChanged | VariableChanged)] == [
        sent,
        VariableChanged(S, "legs", "6"),
    ]
    assert (mission.goals_sent, mission.goals["ab"].state) == (1, "sent")


def test_an_index_beyond_the_tree_is_ignored():
    """A message of a broken executive ends nobody's view."""
    executive, feed, _ = watched()
    executive.begin()
    take_all(feed, executive)
    assert feed.take(Batch("run", (NodeChanged(None, 99, Status.RUNNING, ""),), 1, True)) == []


def test_requirements_may_come_before_the_tree():
    """Those of another run are not the mission's; only what is new happens."""
    executive, feed, mission = watched()
    executive.begin("first")
    executive.judge(is_slow="violated -0.1")
    take_all(feed, executive)
    executive.run = "second"
    executive.judge(is_slow="open 0.1", keeps_away="open")
    take_all(feed, executive)
    executive.begin("second")
    happened = take_all(feed, executive)
    assert [event.name for event in happened if isinstance(event, RequirementChanged)] == [
        "is slow",
        "keeps away",
    ]
    executive.judge(1, is_slow="violated -0.1", keeps_away="open")
    (changed,) = take_all(feed, executive)
    assert isinstance(changed, RequirementChanged)
    assert (changed.name, changed.verdict, changed.margin) == ("is slow", "violated", -0.1)
    assert [requirement.name for requirement in mission.failing] == ["is slow"]


def test_a_reset_takes_back_how_a_node_has_ended_but_for_the_round():
    """Until what it is part of starts again, people are shown how it had ended."""
    mission = state_of()
    for event in (
        NodeChanged(S, 0, Status.RUNNING, ""),
        NodeChanged(S, 2, Status.RUNNING, ""),
        NodeChanged(2 * S, 3, Status.FAILURE, "blocked"),
        NodesReset(2 * S, (3,)),
    ):
        mission.apply(event)
    assert mission.statuses[3] is Status.INVALID
    assert (mission.shown_nodes()[3].status, mission.shown_nodes()[3].message) == (
        Status.FAILURE,
        "blocked",
    )
    mission.apply(NodeChanged(3 * S, 2, Status.SUCCESS, ""))
    mission.apply(NodeChanged(4 * S, 2, Status.RUNNING, ""))
    assert mission.shown_nodes()[3].status is Status.INVALID


def test_the_way_to_the_failure_is_that_of_the_last_one():
    """Of two branches that have failed, the one that made the tree fail."""
    mission = state_of("pick\n  first\n    a\n  second\n    b")
    for time_s, node, status in (
        (1, 2, Status.FAILURE),
        (1, 1, Status.FAILURE),
        (2, 4, Status.FAILURE),
        (2, 3, Status.FAILURE),
        (2, 0, Status.FAILURE),
    ):
        mission.apply(NodeChanged(time_s * S, node, status, ""))
    assert mission.failure_path() == (0, 3, 4)
    mission.apply(NodeChanged(3 * S, 0, Status.RUNNING, ""))
    assert mission.failure_path() == ()


def test_goals_that_have_ended_are_not_kept_for_ever():
    """A mission may send goals for days; one that is open is kept, however old it is."""
    mission = state_of()
    mission.apply(goal_in("active", goal_id="open"))
    for number in range(MOST_GOALS + 50):
        mission.apply(goal_in("active", goal_id=str(number)))
        mission.apply(goal_in("succeeded", goal_id=str(number)))
    assert len(mission.goals) == len(mission.goals_changed_ns) == MOST_GOALS
    assert list(mission.goals)[:2] == ["open", "51"]


def test_the_goal_that_ended_first_is_forgotten_first():
    """However many are open."""
    mission = state_of()
    for number in range(MOST_GOALS):
        mission.apply(goal_in("active", goal_id=str(number)))
    for number in (7, 3):
        mission.apply(goal_in("succeeded", goal_id=str(number)))
    for goal in ("a", "b", "c"):
        mission.apply(goal_in("active", goal_id=goal))
    assert {"3", "7"}.isdisjoint(mission.goals)
    assert len(mission.goals) == len(mission.goals_changed_ns) == MOST_GOALS + 1


# ---- what stands in the log, and what does not ------------------------------------------------


DRIVE = NodeInfo("drive", "ActionLeaf", "0.0", 0)


@pytest.mark.parametrize(
    ("event", "entry"),
    [
        (NodeChanged(S, 1, Status.RUNNING, "sent"), LogEntry(S, Status.RUNNING, "drive", "")),
        (NodeChanged(S, 1, Status.FAILURE, "no"), LogEntry(S, Status.FAILURE, "drive", "no")),
        (
            NodeChanged(S, 1, Status.INVALID, "halted"),
            LogEntry(S, Status.INVALID, "drive", "halted"),
        ),
        (NodeChanged(S, 1, Status.INVALID, ""), None),
        (NodeChanged(S, 0, Status.RUNNING, ""), None),
        (NodeChanged(S, 2, Status.SUCCESS, "hi"), None),
        (NodeChanged(None, 1, Status.SUCCESS, ""), None),
        (LogLine(S, "hello"), LogEntry(S, None, "", "hello")),
        (RunStarted(S, "r", "m", (DRIVE,)), LogEntry(S, None, "m", "begins")),
        (
            StateChanged(S, "r", "m", "paused", "by hand"),
            LogEntry(S, None, "mission paused", "by hand"),
        ),
        (
            StateChanged(S, "r", "m", "paused", "paused on request", ("'drive'",)),
            LogEntry(S, None, "mission paused on request; still running: 'drive'", ""),
        ),
        (StateChanged(S, "", "", "idle", ""), None),
        (
            FaultChanged(S, 1, "lidar_blind", "begins", {"sectors": ((-20, 20), (160, -160))}),
            LogEntry(S, None, "", "fault 1 begins: lidar_blind sectors (-20, 20) (160, -160)"),
        ),
    ],
    ids=[
        "a leaf starts: what it says while it runs is in the tree",
        "a leaf ends",
        "a halted leaf that says something",
        "a halted leaf that says nothing",
        "a composite",
        "a log node",
        "a change from before the watcher",
        "words of the mission",
        "a mission begins",
        "a pause",
        "a pause with goals that run on",
        "an executive that is idle",
        "a fault, as faults are written",
    ],
)
def test_what_stands_in_the_log(event: Event, entry: LogEntry | None):
    """What follows from other lines is left out."""
    nodes = (NodeInfo("m", "Sequence", "0", 0), DRIVE, NodeInfo("log", "Log", "0.1", 0))
    mission = MissionState()
    mission.apply(RunStarted(S, "run", "m", nodes))
    assert mission.entry_of(event) == entry


def test_a_mission_ends_last():
    """What it says at that instant may come later; the next mission begins after that."""
    begin, again = Batch("one", (tree(run="one"),)), Batch("two", (tree(run="two"),))
    end = Batch("one", (StateChanged(S, "one", "m", "success", ""),))
    words = Batch("one", (LogLine(S, "done"),))
    assert in_order([begin, end, words, again]) == [begin, words, end, again]
    assert in_order([end, again]) == [end, again]


def test_the_nodes_of_a_mission_that_has_ended_are_as_they_ended() -> None:
    """A halt resets them; the failed and the halted ones of the last round stay visible."""
    executive, feed, mission = watched()
    executive.begin()
    executive.change(explore="running", look_around="running")
    executive.change(1.0, look_around="failure: aborted", repeat="running")
    executive.change(1.0, look_around="invalid", repeat="invalid: halted", explore="invalid")
    take_all(feed, executive)
    ends = [(mission.current(index).status, mission.current(index).message) for index in (1, 2)]
    assert ends == [(Status.INVALID, ""), (Status.INVALID, "halted")]
    mission.apply(StateChanged(3 * S, "run", "explore", "interrupted", "SIGINT"))
    ends = [(mission.current(index).status, mission.current(index).message) for index in (1, 2)]
    assert ends == [(Status.FAILURE, "aborted"), (Status.INVALID, "halted")]


def test_a_breakpoint_shows_its_node() -> None:
    """The node that it is before, not the last one that runs."""
    executive, feed, mission = watched()
    executive.begin()
    executive.change(explore="running", look_around="success", repeat="running")
    take_all(feed, executive)
    assert mission.focus == mission.tip == 2
    mission.apply(BreakpointsChanged(S, ("drive",)))
    mission.apply(StateChanged(3 * S, "run", "explore", "paused", "breakpoint at 'drive'"))
    assert mission.tree is not None
    assert mission.focus is not None
    assert mission.tree.nodes[mission.focus].name == "drive"


def test_a_run_that_succeeds_has_the_verdict_of_a_requirement_that_fails() -> None:
    """A mission that fails keeps its own."""
    executive, feed, mission = watched()
    executive.begin()
    take_all(feed, executive)
    for name, verdict in (("looks", "not exercised"), ("is slow", "violated"), ("rests", "holds")):
        mission.apply(requirement(name, verdict))
    assert mission.conclusion == ("running", "")
    mission.apply(StateChanged(3 * S, "run", "explore", "success", ""))
    assert mission.conclusion == ("violated", "'is slow'; the mission itself succeeded")
    assert mission.headline == "violated: 'is slow'; the mission itself succeeded"
    mission.apply(StateChanged(3 * S, "run", "explore", "failure", "drive aborted"))
    assert mission.conclusion == ("failure", "drive aborted")
