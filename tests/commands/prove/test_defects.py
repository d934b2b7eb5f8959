"""Planted defects of missions, and of the executive, are found by the property that they break."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.prove.answers import NAMES, parse_answers
from bt_mission.commands.prove.explorer import Bounds
from bt_mission.commands.prove.proof import USUAL_FAULTS, ProofOptions, prove
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.control import Timeout
from bt_mission.executive.behaviours.decorators import Repeat
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.leaves import Wait
from bt_mission.executive.cleanups import Cleanups
from bt_mission.executive.goals.attempt import Attempt
from bt_mission.executive.goals.goal import Goal, GoalStatus, GoalTrigger
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.sessions.load import load
from tests.support.planting import Plant, altered, given, instead
from tests.support.thorough import sample

MOST = Bounds(states=10_000)
"""No exploration here needs more."""


DEFECTS = read_text(Path(__file__).with_name("mission_defects.yaml").read_text()).data


@pytest.mark.parametrize("defect", sample(DEFECTS, 6), ids=[defect["what"] for defect in DEFECTS])
def test_a_defect_of_a_mission_is_found_until_it_is_mended(defect: dict[str, Any]) -> None:
    """By its property."""
    options = ProofOptions(defect.get("faults", USUAL_FAULTS), bounds=MOST)
    assert defect["mission"].count(defect["bad"]) == 1
    mended = defect["mission"].replace(defect["bad"], defect["good"])
    for mission, is_found in ((defect["mission"], True), (mended, False)):
        proof = prove(load(f"mission: m\n{mission}"), options)
        assert not any("budget" in why for why in proof.why_not)
        assert (defect["finds"] in {entry.property for entry in proof.findings}) is is_found


TURN = "{turn: {angle: 90}, timeout: 9}"
MOVE = "{move: {secs: 1, linear_velocity: 0.1}, timeout: 9}"
SWEEP = "{camera_sweep: {sweep_angle: 90, image_count: 2}, timeout: 9}"
SEQUENCE = f"tree:\n  sequence:\n    - {SWEEP}\n    - {TURN}\n"
HANDLED = f"tree:\n  fallback:\n    - {TURN}\n    - log: not done\n"
NEXT = f"tree:\n  sequence:\n    - fallback:\n        - {TURN}\n        - log: late\n    - {MOVE}\n"
TIDY = f"tree:\n  finally: {{timeout: 5}}\n  do: {TURN}\n  then: {{wait: 1}}\n"
CANCELED = f"""\
requirements:
  is cancelled in time: 'never outcome("turn") == "unconfirmed"'
tree: {TURN}
"""
HALTED = f"""\
tree:
  sequence:
    - parallel:
        - {MOVE}
        - wait: 3
      succeed_when: any
    - {TURN}
"""
STOPPING = f"""\
tree:
  sequence:
    - parallel:
        - {{move: {{secs: 1, linear_velocity: 0.1}}, timeout: 9, cancel_timeout: 20}}
        - wait: 3
      succeed_when: any
    - timeout: 5
      do: {TURN}
"""
PREFERRED = f"""\
follow:
  - {{topic: motors_on, type: std_msgs/msg/Bool, field: data, as: ready, initial: false}}
tree:
  timeout: 5
  do:
    fallback:
      - sequence:
          - check: ready
          - {TURN}
      - {{move: {{secs: 1, linear_velocity: 0.1}}, timeout: 9, cancel_timeout: 20}}
    memory: false
"""
AGAIN = """\
tree:
  fallback:
    - {turn: {angle: 90}, timeout: 9, name: first}
    - timeout: 1
      do: {turn: {angle: 45}, timeout: 9, name: second}
"""
TOLD = """\
tree:
  sequence:
    - {turn: {angle: 90}, timeout: 9, outputs: {angle_turned: angle}}
    - log: $angle
"""
WATCHED = """\
tree:
  fallback:
    - camera_sweep: {sweep_angle: 90, image_count: 8}
      cancel_when: current_image >= 5
      timeout: 60
    - log: enough
"""
AWAITED = """\
tree:
  fallback:
    - timeout: 5
      do:
        wait_for: {topic: motors_on, type: std_msgs/msg/Bool, until: data}
    - log: no message
"""


def only(*names: str) -> str:
    """Return the answers with these faults alone."""
    return ",".join(("usual", *(f"*:{name}" for name in NAMES if name not in names)))


def _forgets(self: Ledger, goal: Goal, _now_ns: int) -> None:
    """Drop a goal that is not wanted any more."""
    self._open.pop(goal.id, None)


def _drops(goal: Goal, self: Ledger, *_: object) -> Goal:
    """Do not keep a goal that was sent."""
    self._open.pop(goal.id, None)
    return goal


def _never_lost(event: GoalTrigger) -> tuple[GoalTrigger]:
    """Do not take a goal for lost once its grace is over."""
    return (GoalTrigger.UNWANTED if event is GoalTrigger.GIVEN_UP else event,)


def _cancels_nothing(self: Attempt, cause: object, text: str, now_ns: int) -> None:
    """Send no cancel request."""
    self._cause, self._cause_text, self._cancel_ns = cause, text, now_ns  # type: ignore[assignment]
    self._due_ns = now_ns


def _takes_aborted_for_done(self: Attempt, goal: Goal, now_ns: int) -> object:
    """Read an aborted goal as one that has succeeded."""
    goal.status = GoalStatus.SUCCEEDED if goal.status is GoalStatus.ABORTED else goal.status
    return READ_END(self, goal, now_ns)


READ_END = Attempt._read_end


def _counts_nothing(status: Status, self: Repeat) -> Status:
    """Forget that a round is done."""
    self._done = 0
    return Status.RUNNING if status is Status.SUCCESS else status


@dataclass(frozen=True)
class ExecutiveDefect:
    """A defect of the executive, and a mission in which it breaks a property."""

    what: str
    finds: str
    mission: str
    plant: Plant
    faults: int = 1
    answers: str = "usual"
    with_interrupts: bool = False

    def broken(self) -> set[str]:
        """Return the properties that are broken."""
        answers = parse_answers(self.answers)
        interrupts = self.with_interrupts
        options = ProofOptions(self.faults, answers, with_interrupts=interrupts, bounds=MOST)
        proof = prove(load(f"mission: m\n{self.mission}"), options)
        return {entry.property for entry in proof.findings}


EXECUTIVE_DEFECTS = [
    ExecutiveDefect(
        "the ledger drops a goal that is halted",
        "goals_accounted",
        HALTED,
        instead(Ledger, "release_goal", _forgets),
    ),
    ExecutiveDefect(
        "the ledger does not keep a goal that was sent",
        "goals_accounted",
        SEQUENCE,
        altered(Ledger, "send", _drops),
    ),
    ExecutiveDefect(
        "the ledger never gives a goal up", "ends", SEQUENCE, given(Goal, "on", _never_lost), 2
    ),
    ExecutiveDefect(
        "no cancel is sent at a limit",
        "requirement",
        CANCELED,
        instead(Attempt, "_cancel", _cancels_nothing),
        1,
        only("late"),
    ),
    ExecutiveDefect(
        "a halted leaf keeps its goal",
        "one_goal_at_the_base",
        HALTED,
        instead(ActionLeaf, "terminate", lambda *_: None),
        0,
    ),
    ExecutiveDefect(
        "a goal is sent beside one that has not ended",
        "one_goal_at_the_base",
        AGAIN,
        instead(Ledger, "awaited", lambda *_: ""),
        2,
        only("late", "refuse_cancel"),
    ),
    ExecutiveDefect(
        "a goal is sent while a halted one of another server is ending",
        "one_goal_at_the_base",
        STOPPING,
        instead(Ledger, "awaited", lambda *_: ""),
        1,
        only("refuse_cancel"),
    ),
    ExecutiveDefect(
        "a goal is sent before the cancel of the goal that it halts",
        "one_goal_at_the_base",
        PREFERRED,
        instead(ActionLeaf, "_halted_goals", lambda _: iter(())),
        1,
        only("refuse_cancel"),
    ),
    ExecutiveDefect(
        "a limit of a goal is not checked",
        "dead_node",
        HANDLED,
        instead(Attempt, "_check_limits", lambda *_: None),
        1,
        only("late"),
    ),
    ExecutiveDefect(
        "a condition on feedback is not checked",
        "dead_node",
        WATCHED,
        instead(Attempt, "_check_feedback", lambda *_: None),
        0,
        only(),
    ),
    ExecutiveDefect(
        "an aborted goal counts as done",
        "dead_node",
        HANDLED,
        instead(Attempt, "_read_end", _takes_aborted_for_done),
        1,
        only("abort"),
    ),
    ExecutiveDefect(
        "a result is not stored",
        "unset_variable",
        TOLD,
        instead(Evaluator, "store", lambda *_: None),
        0,
    ),
    ExecutiveDefect(
        "a round is not counted",
        "ends",
        f"tree:\n  repeat: {{count: 2}}\n  do: {TURN}\n",
        altered(Repeat, "_after_round", _counts_nothing),
        0,
    ),
    ExecutiveDefect(
        "a wait never ends",
        "ends",
        "tree: {wait: 1}\n",
        instead(Wait, "update", lambda _: Status.RUNNING),
        0,
    ),
    ExecutiveDefect(
        "a timeout is never over",
        "dead_node",
        AWAITED,
        instead(Timeout, "update", lambda self: self.decorated.status),
    ),
    ExecutiveDefect(
        "clean-ups are not ticked after a halt",
        "interrupt",
        TIDY,
        instead(Cleanups, "walk", lambda _: iter(())),
        0,
        with_interrupts=True,
    ),
    ExecutiveDefect(
        "the mission ends before its clean-ups",
        "interrupt",
        TIDY,
        instead(Cleanups, "is_pending", False),
        0,
        with_interrupts=True,
    ),
]


@pytest.mark.parametrize(
    "defect", sample(EXECUTIVE_DEFECTS, 3), ids=[defect.what for defect in EXECUTIVE_DEFECTS]
)
def test_a_defect_of_the_executive_is_found(
    defect: ExecutiveDefect, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same mission does not break the property without the defect."""
    assert defect.finds not in defect.broken()
    defect.plant(monkeypatch)
    assert defect.finds in defect.broken()
