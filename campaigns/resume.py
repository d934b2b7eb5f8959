"""A mission killed (kill -9) at random instants and resumed from its journal.

Run it as: python campaigns/resume.py [--count 200] [--results resume.jsonl]

Simulator and servers are processes of their own that run all the time. The instant of trial N
follows from the number N: it is uniform over the time that the mission takes, from the moment that
its journal exists. Each trial is one line of the results; a second run continues where the first
was stopped. A finding is

- a mission that is not resumed to success with 0 goals orphaned, or resumed after its success,
- a leg that is driven by neither process, or one that the first had finished before and is repeated
  (but for the leg of the tick in which it died),
- a traceback.
"""

from __future__ import annotations

import random
import re
from contextlib import suppress
from pathlib import Path

from trials import Line, conclude, counted, live_robot, missing, write

from benchmarks.measuring import arguments
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.live_graph import LiveGraph, Process

LEGS = 3
MISSION = f"""\
mission: legs
requirements:
  slow: always speed < 1
tree:
  sequence:
    - set: {{n: 0}}
    - repeat: {{count: {LEGS}}}
      do:
        sequence:
          - set: {{n: n + 1}}
          - {{turn: {{angle: "uniform(10, 20)"}}, timeout: 20}}
          - parallel: [{{wait: "uniform(0.1, 0.5)"}}, {{sequence: [{{wait: 0.1}}, {{wait: 0.1}}]}}]
          - log: leg $n
"""
LOOK_S = 0.01
LEG = re.compile(r"leg (\d)$", re.MULTILINE)
NO_JOURNAL = "there is no journal to resume from"


def runs_for(process: Process, journal: Path, seconds: float) -> float:
    """Let a process run for some seconds from when its journal exists; return how long it did."""
    watch: Stopwatch | None = None
    while process.code is None:
        if watch is None and journal.exists():
            watch = Stopwatch()
        if watch is not None and watch.elapsed_s >= seconds:
            break
        left_s = LOOK_S if watch is None else seconds - watch.elapsed_s
        with suppress(ScenarioError):  # it has not ended yet
            process.wait(within=max(0.0, min(LOOK_S, left_s)))
    return watch.elapsed_s if watch else 0.0


def trial(number: int, graph: LiveGraph, lasts_s: float) -> Line:
    """Kill a mission and resume it; return what came of it."""
    kill_s = random.Random(number).uniform(0, lasts_s)
    came, finding = killed(number, graph, kill_s)
    print(f"{number}: killed after {kill_s:.2f} of {lasts_s:.1f} s: {came}", flush=True)
    findings = [finding] if finding else []
    return {"number": number, "killed_s": round(kill_s, 3), "came": came, "findings": findings}


def killed(number: int, graph: LiveGraph, kill_s: float) -> tuple[str, str]:
    """Kill a mission at an instant and resume it; return what came of it, and the finding."""
    mission, journal = graph.folder / "legs.yaml", graph.folder / f"{number}.journal"
    options = ("--seed", str(number), "--journal", str(journal))
    first = graph.run(mission, *options)
    runs_for(first, journal, kill_s)
    first.kill()
    second = graph.run(mission, *options, "--resume")
    second.wait(within=120.0)
    before, after = LEG.findall(first.output), LEG.findall(second.output)
    lines = second.output.strip().splitlines() or [""]
    if "Traceback" in first.output + second.output:
        return "failed", f"traceback: {second.output}"
    if NO_JOURNAL in second.output and not before:
        return "killed before the first transaction", ""
    if "legs: success" in first.output or len(before) == LEGS:
        is_right = second.code == 2 and "this mission has ended: success" in second.output
        is_right = is_right or (second.code == 0 and not set(after) - {str(LEGS)})
        return "killed at its end", "" if is_right else f"end: {lines[-1]}"
    legs = [*before, *after]
    expected = [str(leg + 1) for leg in range(LEGS)]
    is_whole = legs == expected or (after[:1] == before[-1:] and [*before, *after[1:]] == expected)
    is_right = second.code == 0 and "legs: success" in second.output
    if not is_right or " 0 orphaned" not in second.output or not is_whole:
        return "failed", f"legs {before} {after}: {lines[-3:]}"
    return "resumed", ""


def main() -> None:
    """Run the campaign."""
    options = arguments(__doc__, count=200, results=Path("resume.jsonl"))
    with live_robot() as graph:
        mission, whole = graph.folder / "legs.yaml", graph.folder / "whole.journal"
        mission.write_text(MISSION, encoding="utf-8")
        lasts_s = runs_for(graph.run(mission, "--journal", str(whole)), whole, 60.0)
        todo = missing(options.results, options.count)
        lines = write((trial(number, graph, lasts_s) for number in todo), options.results)
    conclude(lines, f"{len(lines)} kills: {counted(line['came'] for line in lines)}")


if __name__ == "__main__":
    main()
