"""The ledger holds every goal until its server confirms the end."""

from __future__ import annotations

from typing import Any

from bt_mission.executive.goals.goal import GoalStatus, Phase
from bt_mission.executive.goals.ledger import Ledger

S = 1_000_000_000


def test_goal_ids_come_from_the_seed(server: Any) -> None:
    """The same seed gives the same UUIDs in the same order; another seed gives others."""
    ids = [
        [ledger.send(server, "leaf", {}, S).id for _ in range(3)]
        for ledger in (Ledger(7, 3 * S), Ledger(7, 3 * S), Ledger(8, 3 * S))
    ]
    assert ids[0] == ids[1]
    assert not set(ids[0]) & set(ids[2])
    assert len(set(ids[0])) == 3
    assert {goal_id[6] >> 4 for goal_id in ids[0]} == {8}, "UUID version of RFC 9562"


def test_a_refused_cancel_is_asked_again_each_second(server: Any) -> None:
    """An orphan whose server refuses is not forgotten within the grace period."""
    ledger = Ledger(1, 10 * S)
    goal = ledger.send(server, "leaf", {}, S)
    server.accept()
    ledger.release_goal(goal, 0)
    for second in range(1, 4):
        server.refuse_cancel()
        ledger.update(second * S - 1)
        assert len(server.cancels) == second
        ledger.update(second * S)
        assert len(server.cancels) == second + 1


def test_a_server_is_looked_for_once_at_each_instant(server: Any) -> None:
    """However many goals it holds; another instant, another look."""
    ledger = Ledger(1, 3 * S)
    assert ledger.is_there(server, S)
    server.ready = False
    assert ledger.is_there(server, S)
    assert not ledger.is_there(server, S + 1)


def test_handing_over_twice_is_the_same_as_once(server: Any) -> None:
    """One cancel request goes out."""
    ledger = Ledger(1, 3 * S)
    goal = ledger.send(server, "leaf", {}, S)
    server.accept()
    ledger.release_goal(goal, 0)
    ledger.release_goal(goal, S)
    assert len(server.cancels) == 1
    assert goal.orphaned_ns == 0


def test_a_goal_given_up_is_named_until_its_end_is_heard_after_all(server: Any) -> None:
    """The list of goals left behind tells the server, the goal and whose it was."""
    ledger = Ledger(1, 3 * S)
    goal = ledger.send(server, "look around", {}, S)
    server.accept()
    ledger.release_goal(goal, 0)
    ledger.update(3 * S)
    assert goal.phase is Phase.LOST
    assert ledger.is_settled
    assert ledger.describe_left_behind() == (f"/turn goal {goal.short_id} of 'look around' (lost)",)
    server.cancel()
    ledger.update(4 * S)
    assert ledger.describe_left_behind() == ()


def test_every_step_is_told_with_its_time(server: Any) -> None:
    """Sent, handed over, given up to the nanosecond, ended after all: for the trace."""
    reports: list[tuple[int, str]] = []
    ledger = Ledger(1, 3 * S, lambda time_ns, change, goal: reports.append((time_ns, change)))
    goal = ledger.send(server, "leaf", {}, S)
    server.accept()
    ledger.release_goal(goal, 2 * S)
    ledger.update(5 * S - 1)
    ledger.update(5 * S)
    server.cancel()
    ledger.update(6 * S)
    steps = [report for report in reports if report[1]]
    assert steps == [(S, "sent"), (2 * S, "released"), (5 * S, "abandoned"), (6 * S, "ended")]


def test_a_goal_that_is_heard_of_after_it_was_given_up_has_its_time_again(server: Any) -> None:
    """From then on, and it is named again if that passes, too."""
    ledger = Ledger(1, 3 * S)
    goal = ledger.send(server, "leaf", {}, S)
    ledger.release_goal(goal, 0)
    phases = []
    for moment, moves in ((3, server.accept), (20, None), (23 - 1e-9, None), (23, None)):
        ledger.update(round(moment * S))
        phases.append((str(goal.phase), ledger.is_settled))
        if moves:
            moves()
    assert server.cancels == [goal] * 3
    assert phases == [("lost", True), ("canceling", False), ("canceling", False), ("lost", True)]


def test_a_cancel_is_asked_again_until_it_is_answered(server: Any) -> None:
    """Each second: the first may have reached a server that has died since."""
    ledger = Ledger(1, 3 * S)
    goal = ledger.send(server, "leaf", {}, S)
    asked = []
    ledger.release_goal(goal, 0)
    for tenth in range(31):
        if tenth == 15:
            server.accept()
        ledger.update(tenth * S // 10)
        asked.append(len(server.cancels))
    changes = [n for n in range(1, 31) if asked[n] != asked[n - 1]]
    assert (asked[0], changes, goal.phase) == (1, [10, 15, 20], Phase.LOST)


def test_each_goal_has_the_grace_of_its_sender(server: Any) -> None:
    """The limit of the leaf, not one for all."""
    ledger = Ledger(1, 3 * S)
    patient = ledger.send(server, "patient", {}, S, grace_ns=10 * S)
    usual = ledger.send(server, "usual", {}, S)
    for goal in (patient, usual):
        ledger.release_goal(goal, 0)
    ledger.update(3 * S)
    assert (patient.phase, usual.phase) == (Phase.RECALLED, Phase.LOST)
    ledger.update(10 * S)
    assert patient.phase is Phase.LOST


def test_a_goal_of_another_process_is_asked_after_and_cancelled(server: Any) -> None:
    """What was asked of the server is not known; how the goal ends is."""
    ledger = Ledger(seed=1, grace_ns=3 * S)
    goal = ledger.recover_goal(b"\x01" * 16, server, "drive", now_ns=5 * S)
    assert (goal.phase, goal.request, goal.owner) == (Phase.CANCELING, None, "drive")
    assert (server.cancels, server.results_asked) == ([goal], [goal])
    goal.on_result(5, "partial")
    ledger.update(6 * S)
    assert (ledger.open_goals, goal.status) == ((), GoalStatus.CANCELED)
