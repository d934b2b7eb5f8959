"""A running mission continues with another version of itself, with every goal accounted for."""

from __future__ import annotations

import json
from typing import Any

import pytest

from bt_mission.executive.events.events import GoalChanged, NodeChanged, TreeRevised
from bt_mission.executive.revision import RevisionPlan
from bt_mission.sessions.load import load

HEAD = "mission: test\ntree:\n"
ROUND = """\
  sequence:
    - turn: {angle: 90}
      name: left
      timeout: 9
    - turn: {angle: 45}
      name: right
      timeout: 9
"""


@pytest.fixture
def started(play: Any) -> Any:
    """A mission whose first goal is accepted."""

    def start(tree: str, head: str = "mission: test") -> Any:
        run = play(tree, head)
        run.tick()
        for server in run.servers.values():
            if server.goals:
                server.accept()
        run.tick()
        return run

    return start


def names(nodes: Any) -> list[str]:
    """The names of revised nodes."""
    return [node.name for node in nodes]


def test_a_node_that_stays_keeps_its_goal(started: Any) -> None:
    """Its limits, too: a goal of 9 s that was sent at 1.05 s ends at 10.1 s."""
    run = started(ROUND)
    goal = run.turn.goal
    revision = run.revise(HEAD + ROUND + "    - log: done\n      name: said\n")
    assert revision.is_applied
    assert names(revision.new) == ["said"]
    assert (names(revision.gone), names(revision.changes)) == ([], [])
    assert revision.continues == ("left",)
    assert run.executive.ticks == 2
    run.tick()
    assert (run.turn.goal, run.turn.cancels, goal.is_live) == (goal, [], True)
    run.turn.succeed()
    run.tick()
    run.turn.accept()
    run.turn.succeed()
    run.tick(2)
    assert (run.status, run.logged, run.executive.goals_sent) == ("success", ["done"], 2)


def test_a_node_that_changes_starts_again_once_its_goal_has_ended(started: Any) -> None:
    """The goal is cancelled at once; the next one is sent only after the server has confirmed."""
    run = started(ROUND)
    first = run.turn.goal
    revision = run.revise(HEAD + ROUND.replace("angle: 90", "angle: 30"))
    assert [(node.name, node.change) for node in revision.changes] == [
        ("left", "angle 90 -> angle 30")
    ]
    assert (revision.cancels, revision.restarts, revision.continues) == (("left",), ("left",), ())
    assert len(run.turn.cancels) == 1
    run.tick(4)
    assert (run.turn.goal, run.executive.goals_sent) == (first, 1)
    run.turn.cancel()
    run.tick(2)
    assert (run.executive.goals_sent, run.turn.goal.request) == (2, {"angle": 30})
    assert run.statuses == "RRI"


def test_no_goal_goes_to_another_server_before_the_cancelled_one_has_ended(started: Any) -> None:
    """Two servers may drive the same base."""
    other = "action: {name: /other, type: bt_mission_interfaces/action/Turn, goal: {angle: 90}}"
    run = started(ROUND)
    revision = run.revise(HEAD + f"  sequence:\n    - {other}\n      timeout: 9\n")
    assert names(revision.gone) == ["left", "right"]
    run.tick(4)
    assert run.servers["/other"].goals == []
    assert run.root.children[0].feedback_message == "waiting for /turn of 'left' to free the base"
    run.turn.cancel()
    run.tick(2)
    assert len(run.servers["/other"].goals) == 1


def test_a_changed_leaf_may_keep_its_goal(started: Any) -> None:
    """It continues with what it read; the next start reads the new values."""
    tree = "  repeat: {count: 2}\n  do:\n    turn: {angle: 90}\n    name: left\n    timeout: 9\n"
    run = started(tree)
    revision = run.revise(HEAD + tree.replace("angle: 90", "angle: 30"), keep_goals=True)
    assert (revision.is_applied, revision.continues, revision.cancels) == (True, ("left",), ())
    assert run.turn.cancels == []
    run.turn.succeed()
    run.tick(2)
    assert [goal.request for goal in run.turn.goals] == [{"angle": 90}, {"angle": 30}]


def test_a_running_node_may_be_wrapped_and_unwrapped(started: Any) -> None:
    """Its goal continues below a limit that begins now, and without it."""
    wrapped = """\
  sequence:
    - timeout: 2
      do:
        turn: {angle: 90}
        name: left
        timeout: 9
    - turn: {angle: 45}
      name: right
      timeout: 9
"""
    run = started(ROUND)
    goal = run.turn.goal
    assert names(run.revise(HEAD + wrapped).new) == ["timeout"]
    run.tick(39)
    assert (run.turn.goal, run.turn.cancels) == (goal, [])
    assert names(run.revise(HEAD + ROUND).gone) == ["timeout"]
    run.tick(60)
    assert (run.turn.goal, run.turn.cancels, run.statuses) == (goal, [], "RRI")
    assert run.revise(HEAD + wrapped).is_applied
    run.tick(40)
    assert len(run.turn.cancels) == 1
    run.turn.cancel()
    run.tick()
    assert (run.status, run.executive.reason) == ("failure", "'timeout' not done within 2 s")


def test_what_has_run_does_not_run_again(started: Any) -> None:
    """A sequence continues behind the last node that is done, in the new order."""
    run = started("  sequence:\n    - log: one\n    - log: two\n" + ROUND[12:])
    assert run.logged == ["one", "two"]
    revision = run.revise(
        HEAD + "  sequence:\n    - log: two\n    - log: three\n    - log: one\n    - log: four\n"
    )
    assert names(revision.new) == ["log", "log"]
    run.turn.cancel()
    run.tick(2)
    assert (run.status, run.logged) == ("success", ["one", "two", "four"])


def test_a_sequence_whose_rest_is_gone_has_succeeded(started: Any) -> None:
    """And a fallback has failed."""
    run = started("  sequence:\n    - log: one\n" + ROUND[12:])
    assert run.revise(HEAD + "  sequence:\n    - log: one\n").is_applied
    run.turn.cancel()
    run.tick(2)
    assert (run.status, run.logged) == ("success", ["one"])


def test_a_limit_that_changes_counts_from_its_start(started: Any) -> None:
    """Ticks are at 1.05 s, 1.10 s, ...: a limit of 1 s that began at 1.05 s is over at 2.05 s."""
    tree = "  timeout: {0}\n  do:\n    turn: {{angle: 90}}\n    name: left\n    timeout: 99\n"
    run = started(tree.format(60))
    revision = run.revise(HEAD + tree.format(1))
    assert [node.change for node in revision.changes] == ["60 s -> 1 s"]
    assert revision.continues == ("left",)
    run.tick(18)
    assert (run.now_ns, run.turn.cancels) == (2_000_000_000, [])
    run.tick()
    assert len(run.turn.cancels) == 1


def test_the_clean_up_of_a_removed_part_runs(started: Any) -> None:
    """First the cancelled goal ends, then the clean-up runs, then the new part sends goals."""
    tree = """\
  finally: {timeout: 5}
  name: guarded
  do:
    turn: {angle: 90}
    name: left
    timeout: 9
  then: {action: {name: /home, type: bt_mission_interfaces/action/Turn, goal: {angle: 1}}}
"""
    run = started(tree)
    assert names(run.revise(HEAD + ROUND.replace("name: left", "name: other")).gone) == [
        "guarded",
        "left",
        "home",
    ]
    home = run.servers["/home"]
    run.tick(3)
    assert (len(run.turn.cancels), home.goals) == (1, [])
    run.turn.cancel()
    run.tick(2)
    assert (len(home.goals), run.executive.goals_sent) == (1, 2)
    home.accept()
    home.succeed()
    run.tick(3)
    assert (run.executive.goals_sent, run.turn.goal.request) == (3, {"angle": 90})


def test_a_clean_up_that_runs_does_not_change(started: Any) -> None:
    """It is refused, and nothing changes; a revision elsewhere is applied."""
    tree = """\
  sequence:
    - finally: {timeout: 5}
      name: guarded
      do: {log: body}
      then:
        turn: {angle: 90}
        name: home
        timeout: 9
    - log: after
"""
    run = started(tree)
    events: list[Any] = []
    run.executive.events.subscribe(events.append)
    revision = run.revise(HEAD + tree.replace("angle: 90", "angle: 30"))
    assert revision.reasons == (
        "the clean-up of 'guarded' is under way, and would change; wait until it has ended",
    )
    assert (events, run.turn.cancels, run.executive.revisions) == ([], [], 0)
    assert run.revise(HEAD + tree + "    - log: more\n").is_applied
    run.turn.succeed()
    run.tick(2)
    assert (run.status, run.logged) == ("success", ["body", "after", "more"])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (("mission: test", "mission: other"), "it is another mission: 'other' instead of 'test'"),
        (("seed: 1", "seed: 2"), "'seed' is fixed when a run begins: 1 -> 2"),
        (
            ("angle: 7", "angle: 8"),
            "the value of the input 'angle' is fixed when a run begins: 7 -> 8",
        ),
        (("world: home\n", ""), "'world' is fixed when a run begins: home -> none"),
    ],
)
def test_what_a_run_began_with_is_fixed(started: Any, change: tuple[str, str], reason: str) -> None:
    """A revision of it is refused with the reason, also in a dry run."""
    head = "mission: test\nworld: home\nseed: 1\ninputs: {angle: 7}\n"
    run = started(ROUND, head.rstrip())
    text = f"{head}tree:\n{ROUND}"
    assert run.revise(text, dry_run=True).reasons == ()
    for options in ({}, {"dry_run": True}):
        revision = run.revise(text.replace(*change), **options)
        assert (revision.is_applied, revision.reasons) == (False, (reason,))


def test_variables_and_new_inputs(started: Any) -> None:
    """Variables stay; new inputs have their values; what the new version lacks is gone."""
    head = "mission: test\ninputs: {speed: 1}"
    run = started("  sequence:\n    - set: {a: 1, b: 2}\n" + ROUND[12:], head)
    new = "mission: test\ninputs: {speed: 1, size: 3}\ntree:\n  sequence:\n    - set: {a: 1}\n"
    new += "      name: other\n" + ROUND[12:] + "    - log: a $a, size $size\n"
    assert run.revise(new).is_applied
    assert run.scope.values == {"speed": 1, "size": 3, "a": 1}


def test_a_dry_run_changes_nothing(started: Any) -> None:
    """It says what would happen; the trace has no line of it."""
    run = started(ROUND)
    before = run.trace.sha256
    revision = run.revise(HEAD + ROUND.replace("angle: 90", "angle: 30"), dry_run=True)
    assert (revision.is_applied, revision.reasons, revision.cancels) == (False, (), ("left",))
    assert (run.trace.sha256, run.turn.cancels, run.executive.revisions) == (before, [], 0)


def test_the_mission_may_be_ticked_between_the_steps_of_a_revision(started: Any) -> None:
    """The exchange takes over the state at that time, and the tree before is not touched."""
    run = started(ROUND)
    left, right = run.root.children
    limited = """\
    - timeout: 30
      do:
        turn: {angle: 45}
        name: right
        timeout: 9
"""
    version = load(HEAD + ROUND.partition("    - turn: {angle: 45}")[0] + limited)
    plan = RevisionPlan(run.executive, run, run.mission, version)
    plan.build(lambda _: None)
    assert (left.parent, right.parent) == (run.root, run.root)
    assert plan.preview().continues == ("left",)
    run.turn.succeed()
    run.tick()
    run.turn.accept()
    goal = run.turn.goal
    currents = [plan.is_current]
    revision = plan.apply(lambda _: None, lambda _: None)
    assert (revision.is_applied, revision.continues, revision.cancels) == (True, ("right",), ())
    assert [*currents, plan.is_current] == [True, False]
    assert [node.name for node in run.executive.nodes] == ["test", "left", "timeout", "right"]
    assert [node.status.value for node in run.executive.nodes] == [
        "RUNNING",
        "SUCCESS",
        "RUNNING",
        "RUNNING",
    ]
    assert (right.parent.name, run.turn.goal, run.turn.cancels) == ("timeout", goal, [])
    run.turn.succeed()
    run.tick()
    assert run.executive.is_done


def test_a_mission_that_has_ended_cannot_change(started: Any) -> None:
    """Nor one at a breakpoint, which holds a tick."""
    run = started(ROUND)
    run.executive.breakpoints.add("right")
    run.turn.succeed()
    run.tick()
    (reason,) = run.revise(HEAD + ROUND, dry_run=True).reasons
    assert reason == "a breakpoint holds the mission within a tick; step or resume it first"
    run.executive.interrupt("enough")
    run.tick()
    (reason,) = run.revise(HEAD + ROUND).reasons
    assert reason == "the mission is interrupted: only a running mission can change"


def test_the_event_has_the_tree_and_what_was_kept(started: Any) -> None:
    """Trace and state continue with the indices of the new tree."""
    run = started(ROUND)
    events: list[Any] = []
    run.executive.events.subscribe(events.append)
    log = "    - log: first\n      name: first\n"
    run.revise(HEAD + ROUND.replace("sequence:\n", f"sequence:\n{log}").replace("45", "60"))
    (event,) = events
    assert isinstance(event, TreeRevised)
    assert [node.name for node in event.nodes] == ["test", "first", "left", "right"]
    assert (event.kept, event.number) == ((0, -1, 1, 2), 1)
    state = run.executive.mission_state
    assert [status.value for status in state.statuses] == [
        "RUNNING",
        "INVALID",
        "RUNNING",
        "INVALID",
    ]
    line = json.loads(run.trace.newest[-1])
    assert (line["event"], line["kept"], line["t"]) == ("revised", [0, -1, 1, 2], run.now_ns)
    run.turn.succeed()
    run.tick()
    changed = [event.node for event in events if isinstance(event, NodeChanged)]
    assert changed == [2, 3]
    assert json.loads(run.trace.newest[-2])["node"] == "right"


def test_every_goal_is_accounted_for_at_the_end(started: Any) -> None:
    """A server that never confirms the cancel is waited for, for the grace period."""
    run = started(ROUND)
    assert run.revise(HEAD + ROUND.replace("angle: 90", "angle: 30")).is_applied
    run.tick(59)
    assert run.executive.goals_sent == 1
    ended: list[Any] = []
    run.executive.events.subscribe(ended.append, GoalChanged)
    run.tick(2)
    assert [event.change for event in ended] == ["abandoned", "sent"]
    assert run.executive.goals_left_behind[0].endswith("of 'left' (lost)")


def test_a_named_tree_continues_with_its_variables(started: Any) -> None:
    """The goal within it continues, and its variables stay apart from those of the mission."""
    tree = """\
  tree: look
  name: looked
"""
    head = """\
mission: test
trees:
  look:
    inputs: {size: 3}
    do:
      sequence:
        - set: {far: size + 1}
        - turn: {angle: 90}
          name: left
          timeout: 9
        - log: far $far
"""
    run = started(tree, head.rstrip())
    goal = run.turn.goal
    new = head.replace("log: far $far", "log: so far $far, size $size") + "tree:\n" + tree
    revision = run.revise(new)
    assert (revision.is_applied, revision.continues) == (True, ("left",))
    assert (run.turn.goal, run.turn.cancels) == (goal, [])
    run.turn.succeed()
    run.tick()
    assert (run.status, run.logged) == ("success", ["so far 4, size 3"])


def test_what_is_not_below_a_change_keeps_its_nodes(started: Any) -> None:
    """They stay in the tree after a dry run, and at another place with their rounds and values."""
    loop = """\
    - repeat: {count: 2}
      do:
        sequence:
          - turn: {angle: 90}
            name: left
            timeout: 9
          - log: round $size
"""
    head = "mission: test\ninputs: {size: 3}"
    run = started("  parallel:\n" + loop + "    - wait: 60\n", head)
    run.turn.succeed()
    run.tick(2)
    run.turn.accept()
    kept, parents = run.executive.nodes, [node.parent for node in run.executive.nodes]
    new = head + "\ntree:\n  parallel:\n    - log: first\n" + loop + "    - wait: 60\n"
    assert run.revise(new, dry_run=True).continues == ("left",)
    assert [node.parent for node in kept] == parents
    assert run.revise(new).continues == ("left",)
    root, first, *others = run.executive.nodes
    assert (first.name, others) == ("log", list(kept[1:]))
    assert [child.parent for child in root.children] == [root] * 3
    assert [node.parent for node in others[1:4]] == [others[0], others[1], others[1]]
    run.tick()
    run.turn.succeed()
    run.tick()
    assert run.logged == ["round 3", "first", "round 3"]
    assert (others[0].status.name, len(run.turn.requests)) == ("SUCCESS", 2)


def test_a_paused_mission_may_change(started: Any) -> None:
    """A kept goal continues in the pause; the leaves that were stopped start after it."""
    run = started(ROUND)
    run.executive.pause("paused on request", keep_goals=True)
    assert run.revise(HEAD + ROUND + "    - log: done\n").continues == ("left",)
    run.executive.pause("paused on request")
    assert len(run.turn.cancels) == 1
    revision = run.revise(HEAD + ROUND.replace("angle: 90", "angle: 30"))
    assert (revision.is_applied, revision.cancels) == (True, ())
    run.turn.cancel()
    run.tick(5)
    assert run.executive.goals_sent == 1
    run.executive.resume()
    run.tick()
    assert (run.executive.goals_sent, run.turn.requests[-1]) == (2, {"angle": 30})


def test_a_variable_that_follows_a_topic(play: Any) -> None:
    """It stays, or needs an initial value; what is not followed any more has no value."""
    follow = "follow:\n  - {{topic: {0}, type: std_msgs/msg/Float64, field: data, as: {1}{2}}}\n"
    head = "mission: test\n" + follow.format("charge", "charge", "")
    wait = "  sequence:\n    - wait: 60\n"
    run = play(wait, head.rstrip())
    run.executive.tick()
    run.topics["charge"].publish(data=0.5)
    run.tick()
    other = follow.format("load", "load", "")
    (reason,) = run.revise("mission: test\n" + other + "tree:\n" + wait).reasons
    assert reason == (
        "'load' would follow a topic from now on, and could be read before its first message: "
        "give it an 'initial' value"
    )
    assert run.revise(head + "tree:\n" + wait + "    - log: done\n").is_applied
    assert (run.scope.values, len(run.topics["charge"].listeners)) == ({"charge": 0.5}, 1)
    other = follow.format("load", "load", ", initial: 2.0")
    assert run.revise("mission: test\n" + other + "tree:\n" + wait).is_applied
    assert (run.scope.values, run.topics["charge"].listeners) == ({"load": 2.0}, [])


def test_a_parallel_waits_for_what_has_not_ended(started: Any) -> None:
    """A child that has ended does not run again, also if it changes; a new one runs."""
    tree = "  parallel:\n    - log: one\n      name: first\n    - turn: {angle: 90}\n"
    tree += "      name: left\n      timeout: 9\n"
    run = started(tree)
    assert run.logged == ["one"]
    new = tree.replace("log: one", "log: two") + "    - log: three\n"
    assert run.revise(HEAD + new).is_applied
    run.tick()
    assert run.logged == ["one", "three"]
    run.turn.succeed()
    run.tick()
    assert run.status == "success"


def test_what_a_revision_cannot_build_changes_nothing(started: Any) -> None:
    """A behaviour whose constructor raises is the reason; the running leaf keeps its parent."""
    run = started(ROUND)
    text = HEAD + ROUND + "    - python: tests.support.hand:Hand\n"
    left = run.root.children[0]
    (reason,) = run.revise(text).reasons
    assert "tests.support.hand" in reason
    assert (left.parent, run.executive.revisions, run.turn.cancels) == (run.root, 0, [])
    run.turn.succeed()
    assert run.tick() == "RSR"
