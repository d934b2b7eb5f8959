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

import argparse
import json
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from campaign import AT_ONCE, RAISED, pending

from benchmarks.measuring import CpuWatch, figure
from bt_mission.core.actions import moved_part
from bt_mission.core.draws import Draws, SeededDraws, maybe, number, one_of
from bt_mission.core.errors import BtMissionError
from bt_mission.events.events import Event, GoalChanged, TreeRevised
from bt_mission.faults import FAULTS
from bt_mission.faults.drawing import drawn_faults
from bt_mission.goals.goal import Goal
from bt_mission.goals.ledger import WANTED
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load
from bt_mission.testing import ScenarioError
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.scenarios import DrawnScenario, as_text
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.run import NeverHeldError, Run
from bt_mission.testing.stages import Stages

MOST_REVISIONS = 6
MOST_EDITS = 3
LAST_S = 9.0
"""The latest instant of a revision, s."""

_DRAWN = tuple(
    name for name in FAULTS if name != "kill_server" and "leaf" not in FAULTS[name].parameters
)
"""Leaves have other names in every mission; a dead server ends no goal."""

Node = dict[str, Any]


@dataclass
class Outcome:
    """The outcome of a scenario."""

    number: int
    status: str = ""
    reason: str = ""
    virtual_s: float = 0.0
    cpu_s: float = 0.0
    goals: int = 0
    faults: int = 0
    applied: int = 0
    refused: list[str] = field(default_factory=list)
    continued: int = 0
    canceled: int = 0
    trace: str = ""
    findings: list[str] = field(default_factory=list)


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
    faults = drawn_faults(draws, _DRAWN) if maybe(draws, 2) else ()
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


def _revise(text: str, outcome: Outcome, run: Run) -> None:
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


def carry_out(seed: int) -> Outcome:
    """Run a scenario twice. Return its outcome."""
    watch = CpuWatch()
    outcome, again = _run(seed), _run(seed)
    if outcome.trace != again.trace:
        outcome.findings.append(f"another trace: {outcome.status} and {again.status}")
    outcome.cpu_s = round(watch.elapsed_s, 2)
    return outcome


def _run(seed: int) -> Outcome:
    drawn, versions = scenario(seed)
    outcome = Outcome(seed, faults=len(drawn.faults))
    with tempfile.TemporaryDirectory() as folder:
        stages = Stages(Path(folder))
        try:
            _play(drawn, versions, stages, outcome)
            stages.close()
        except Exception as error:  # noqa: BLE001 - as within the run
            outcome.findings.append(f"traceback at the end: {error!r}")
    return outcome


def _play(
    drawn: DrawnScenario, versions: list[tuple[float, str]], stages: Stages, outcome: Outcome
) -> None:
    run, statuses = None, list[str]()
    try:
        run = drawn.on(stages)
        run.stage.offer_all()
        statuses = [
            topic
            for topic, _ in run.stage.node.get_topic_names_and_types()
            if topic.endswith("/_action/status")
        ]
        run.record(*statuses)
        Watch(run, outcome.findings)
        for at_s, text in versions:
            run.at(at_s, partial(_revise, text, outcome))
        run.until_done()
    except NeverHeldError:
        outcome.findings.append("hang")
    except ScenarioError as error:  # a fault could not begin: a mistake of the draw, not a finding
        outcome.reason = f"{type(error).__name__}: {error}".splitlines()[0]
    except Exception as error:  # noqa: BLE001 - this is what is looked for
        if RAISED not in str(error):
            outcome.findings.append("traceback: " + traceback.format_exc(limit=-6))
    if run is None:
        return
    outcome.virtual_s, outcome.goals = round(run.t, 2), len(run.goals)
    outcome.status, outcome.trace = run.status, run.stage.trace.sha256
    outcome.reason = outcome.reason or run.reason
    if "callback failed" in run.reason and RAISED not in run.reason:
        outcome.findings.append(f"traceback: {run.reason}")
    if run.is_done:
        going = [
            bytes(status.goal_info.goal_id.uuid).hex()
            for topic in statuses
            for status in (run.topic(topic).last.status_list if len(run.topic(topic)) else ())
            if status.status in (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)
        ]
        if len(going) > run.report.goals_left_behind:
            outcome.findings.append(f"orphaned goals: {going} are worked on, none is named")


def main() -> None:
    """Run the campaign."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000)
    parser.add_argument("--results", type=Path, default=Path("revisions.jsonl"))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--show", type=int, metavar="N", help="print scenario N, and run nothing")
    options = parser.parse_args()
    if options.show is not None:
        drawn, versions = scenario(options.show)
        print(repr(drawn), *(f"\n# at {at_s} s\n{text}" for at_s, text in versions))
        return
    options.results.touch()
    todo = pending(options.results, options.count)
    with (
        options.results.open("a") as results,
        get_context("spawn").Pool(options.jobs, maxtasksperchild=AT_ONCE) as pool,
    ):
        for outcome in pool.imap_unordered(carry_out, todo):
            results.write(json.dumps(asdict(outcome)) + "\n")
            results.flush()
            if outcome.findings:
                print(f"{outcome.number}: {outcome.findings}", flush=True)
    lines = [json.loads(line) for line in options.results.read_text().splitlines()]
    print(summary(lines))
    figure("findings", sum(len(line["findings"]) for line in lines))


def summary(lines: list[dict[str, Any]]) -> str:
    """Return the figures of a campaign, in a few lines."""
    total = {
        name: sum(line[name] for line in lines)
        for name in ("applied", "continued", "canceled", "goals", "faults", "virtual_s", "cpu_s")
    }
    kinds = Counter(finding.partition(":")[0] for line in lines for finding in line["findings"])
    refused = Counter(reason.partition(":")[0][:60] for line in lines for reason in line["refused"])
    states = Counter(line["status"] or "not run" for line in lines)
    return (
        f"{len(lines)} scenarios, each twice, {total['virtual_s']:.0f} s of virtual time, "
        f"{total['cpu_s']:.0f} s of CPU time; ended: {dict(states)}\n"
        f"{total['applied']} revisions applied, {sum(refused.values())} refused: "
        f"{total['continued']} goals continued, {total['canceled']} were canceled; "
        f"{total['goals']} goals, {total['faults']} faults\n"
        f"refused: {dict(refused)}\nfindings: {dict(kinds) or 'none'}"
    )


if __name__ == "__main__":
    main()
