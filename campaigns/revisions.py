"""Missions that are revised at random instants while they drive, with faults, on the stage.

Run it as: python campaigns/revisions.py [--count 1000] [--results revisions.jsonl] [--jobs 1]

Scenario N follows from the number N alone: a drawn mission and world, a seed, up to five faults,
and up to six revisions at random instants. A revision changes, adds, removes, moves, wraps or
unwraps some nodes of the newest version. Each scenario runs twice and is one line of the results;
a second run continues where the first was stopped. A finding is

- a traceback, or a mission that does not end within 600 s of virtual time,
- a goal that a server still works on, and that the run's end does not name as orphaned,
- two goals on the base that are both wanted, or a goal that is sent to any server before a goal
  that a revision has released has ended,
- a revision that was refused, and that has changed something,
- a second run with another trace.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from campaign import DRAWN, RAISED, Outcome, play, summary
from trials import carry_out, conclude, counted, missing

from benchmarks.measuring import arguments
from bt_mission.base.actions import moved_part
from bt_mission.base.errors import BtMissionError
from bt_mission.executive.events.events import Event, GoalChanged, TreeRevised
from bt_mission.executive.goals.goal import Goal
from bt_mission.executive.goals.ledger import WANTED
from bt_mission.language.mission import Mission
from bt_mission.scenarios.draws import Draws, SeededDraws, maybe, number, one_of
from bt_mission.scenarios.faults.drawing import drawn_faults
from bt_mission.sessions.load import load
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.scenarios import DrawnScenario, as_text
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.run import Run

MOST_REVISIONS = 6
MOST_EDITS = 3
LAST_S = 9.0
"""The latest instant of a revision, s."""

FAULTS = tuple(name for name in DRAWN if name != "kill_server")
"""A dead server ends no goal."""

Node = dict[str, Any]


@dataclass
class Revised(Outcome):
    """The outcome of a scenario with revisions."""

    applied: int = 0
    refused: list[str] = field(default_factory=list)
    continued: int = 0
    canceled: int = 0


# ---- missions that change ----------------------------------------------------------------------


def places(node: Node) -> list[tuple[Any, Any]]:
    """Return each place of a node below this one: its list or mapping, and the key.

    Those directly in a parallel are left out: a second node there could drive the base, too.
    """
    boxes: list[tuple[Any, Any]] = []
    for key in ("sequence", "fallback", "choose"):
        if isinstance(node.get(key), list):
            boxes += [(node[key], index) for index in range(len(node[key]))]
    boxes += [(node, key) for key in ("do", "then", "else", "invert") if key in node]
    inside = [*(box[key] for box, key in boxes), *node.get("parallel", ())]
    return boxes + [place for child in inside for place in places(child)]


def named(node: Node, draws: Draws, numbers: Counter[str]) -> Node:
    """Give some nodes names, by which they are found after a move."""
    for box, key in places(node):
        if maybe(draws, 2):
            numbers["name"] += 1
            box[key].setdefault("name", f"node {numbers['name']}")
    return node


def drawn_part(draws: Draws, numbers: Counter[str]) -> Node:
    """Draw a node with everything below it."""
    part: Node = one_of(draws, drawn_mission(draws)["tree"]["sequence"][1:])
    return named(part, draws, numbers)


def _replace(draws: Draws, box: Any, key: Any, numbers: Counter[str]) -> None:
    name = box[key].get("name")
    box[key] = drawn_part(draws, numbers)
    if name and maybe(draws, 2):
        box[key]["name"] = name


def _limit(draws: Draws, box: Any, key: Any, _: Counter[str]) -> None:
    for limit in ("timeout", "wait"):
        if isinstance(box[key].get(limit), int | float):
            box[key][limit] = number(draws, 1, 12, 0.5)


def _insert(draws: Draws, box: Any, key: Any, numbers: Counter[str]) -> None:
    if isinstance(box, list):
        box.insert(key, drawn_part(draws, numbers))


def _remove(_: Draws, box: Any, key: Any, __: Counter[str]) -> None:
    if isinstance(box, list) and len(box) > 1:
        del box[key]


def _move(draws: Draws, box: Any, key: Any, _: Counter[str]) -> None:
    if isinstance(box, list):
        box.insert(draws.whole(0, len(box) - 1), box.pop(key))


def _wrap(draws: Draws, box: Any, key: Any, _: Counter[str]) -> None:
    inside = box[key]
    box[key] = one_of(
        draws,
        [
            {"timeout": number(draws, 1, 20, 1), "do": inside},
            {"guard": "n < 50", "do": inside},
            {"force": "success", "do": inside},
            {"retry": {"attempts": 2}, "do": inside},
            {"invert": {"invert": inside}},
            {"finally": {"timeout": 5}, "do": inside, "then": {"wait": 0.5}},
            {
                "finally": {"timeout": 9},
                "do": inside,
                "then": {"turn": {"angle": 15}, "timeout": 8},
            },
            {"sequence": [inside]},
            {"repeat": {"count": 2}, "do": inside},
        ],
    )


def _unwrap(_: Draws, box: Any, key: Any, __: Counter[str]) -> None:
    for inner in ("do", "invert"):
        if inner in box[key] and "for_each" not in box[key]:
            box[key] = box[key][inner]
            return


EDITS: tuple[Callable[[Draws, Any, Any, Counter[str]], None], ...] = (
    _replace,
    _limit,
    _limit,
    _insert,
    _remove,
    _move,
    _wrap,
    _wrap,
    _unwrap,
)


def edited(mission: Node, draws: Draws, numbers: Counter[str]) -> Node:
    """Return another version of a mission."""
    other: Node = json.loads(json.dumps(mission))
    for _ in range(draws.whole(1, MOST_EDITS)):
        box, key = one_of(draws, places(other["tree"]))
        one_of(draws, EDITS)(draws, box, key, numbers)
    return other


def scenario(seed: int) -> tuple[DrawnScenario, list[tuple[float, str]]]:
    """Return everything that derives from a number: a scenario, and versions with their times."""
    draws, numbers = SeededDraws(f"revisions/{seed}"), Counter[str]()
    mission = drawn_mission(draws)
    named(mission["tree"], draws, numbers)
    version, versions, at_s = mission, [], 0.0
    for _ in range(draws.whole(1, MOST_REVISIONS)):
        version = edited(version, draws, numbers)
        at_s += number(draws, 0.05, LAST_S / MOST_REVISIONS, 0.01)
        versions.append((round(at_s, 3), as_text(version)))
    world = as_text(drawn_world(draws))
    faults = drawn_faults(draws, FAULTS) if maybe(draws, 2) else ()
    return DrawnScenario(as_text(mission), world, draws.whole(0, 999), faults), versions


# ---- what is looked for ------------------------------------------------------------------------


class Watch:
    """Looks at every goal that is sent, for what must not happen."""

    def __init__(self, run: Run, findings: list[str]) -> None:
        self._findings = findings
        self._run = run
        self._ledger = run.stage.runner.ledger
        self._released: list[Goal] = []
        """Goals that were not wanted any more at a revision."""
        run.stage.executive.events.subscribe(self._take, GoalChanged, TreeRevised)

    def _take(self, event: Event) -> None:
        goals = self._ledger.open_goals
        if isinstance(event, TreeRevised):
            self._released = [goal for goal in goals if goal.orphaned_ns is not None]
            return
        if not isinstance(event, GoalChanged) or event.change != "sent":
            return
        if early := [goal.owner for goal in self._released if goal.is_live]:
            self._findings.append(f"early goal: {event.owner} at {self._run.t} s before {early}")
        wanted = [
            goal.owner
            for goal in goals
            if moved_part(goal.goal_client.name) == "base" and goal.phase in WANTED
        ]
        if len(wanted) > 1:
            self._findings.append(f"two goals on the base: {wanted} at {self._run.t} s")


def _revise(text: str, outcome: Revised, run: Run) -> None:
    """Apply a version, unless the mission has ended."""
    executive = run.stage.executive
    try:
        mission: Mission = load(text)
    except BtMissionError:
        return  # the draw is no valid mission
    nodes, before = executive.nodes, run.stage.trace.sha256
    revision = run.stage.runner.revise(mission)
    if revision.is_applied:
        outcome.applied += 1
        outcome.continued += len(revision.continues)
        outcome.canceled += len(revision.cancels)
        return
    outcome.refused += revision.reasons
    if executive.nodes is not nodes or run.stage.trace.sha256 != before:
        outcome.findings.append(f"a refused revision has changed something: {revision.reasons}")


def trial(seed: int) -> Revised:
    """Run a scenario twice. Return its outcome."""
    outcome, again = _run(seed), _run(seed)
    if outcome.trace != again.trace:
        outcome.findings.append(f"another trace: {outcome.status} and {again.status}")
    outcome.cpu_s += again.cpu_s
    return outcome


def _run(seed: int) -> Revised:
    drawn, versions = scenario(seed)
    outcome = Revised(seed, [fault.name for fault in drawn.faults])

    def begin(run: Run) -> None:
        Watch(run, outcome.findings)
        for at_s, text in versions:
            run.at(at_s, partial(_revise, text, outcome))

    play(drawn, outcome, begin)
    if "callback failed" in outcome.reason and RAISED not in outcome.reason:
        outcome.findings.append(f"traceback: {outcome.reason}")
    return outcome


def main() -> None:
    """Run the campaign."""
    options = arguments(
        __doc__,
        count=1_000,
        results=Path("revisions.jsonl"),
        jobs=1,
        show=(None, "print scenario N, and run nothing"),
    )
    if options.show is not None:
        drawn, versions = scenario(options.show)
        print(repr(drawn), *(f"\n# at {at_s} s\n{text}" for at_s, text in versions))
        return
    todo = missing(options.results, options.count)
    lines = carry_out(trial, todo, options.results, options.jobs)
    total = {
        name: sum(line[name] for line in lines)
        for name in ("applied", "continued", "canceled", "goals")
    }
    refused = counted(reason.partition(":")[0][:60] for line in lines for reason in line["refused"])
    conclude(
        lines,
        summary(lines),
        f"each twice; {total['applied']} revisions applied, {sum(refused.values())} refused: "
        f"{total['continued']} goals continued, {total['canceled']} were canceled; "
        f"{total['goals']} goals",
        f"refused: {refused}",
    )


if __name__ == "__main__":
    main()
