"""A mission on a running robot that is revised by `bt-mission revise` at random instants.

Run it as: python campaigns/attached_revisions.py [--count 50] [--results attached_revisions.jsonl]

Simulator, servers, executive and `revise` are processes of their own. A mission turns back and
forth; revision N follows from the number N alone. A mission takes ten revisions, and then ends.
Each revision is one line of the results. A finding is

- a revision that is neither applied nor refused with a reason,
- a mission that does not end with success and 0 goals orphaned,
- a goal that is sent before a goal that was released has ended, by the trace in the recording,
- a traceback.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path

from trials import Line, conclude, counted, live_robot, missing, write

from benchmarks.measuring import arguments
from bt_mission.base.wall_clock import rest
from bt_mission.recording.happenings import TraceLine, fold
from bt_mission.recording.reading import RecordedFile
from bt_mission.testing.live_graph import LiveGraph

EACH = 10
"""Revisions of one mission."""

LONGEST_S = 1.5
"""The longest time before the next revision, s."""

MISSION = """\
mission: turns
tree:
  sequence:
    - repeat: {{count: {rounds}}}
      do:
        sequence:
          - {{turn: {{angle: {first}}}, name: first, timeout: 20}}
{between}          - {{turn: {{angle: {second}}}, name: second, timeout: 20}}
"""
WRAPPED = """\
          - timeout: 9
            do: {move: {secs: 1, linear_velocity: 0.05}, name: between, timeout: 20}
"""
BETWEEN = (
    "",
    "          - {wait: 0.5, name: pause}\n",
    "          - {move: {secs: 1, linear_velocity: 0.05}, name: between, timeout: 20}\n",
    WRAPPED,
)


def version(number: int, *, rounds: int = 1000) -> str:
    """Return the version of a number."""
    draws = random.Random(number)
    first, second = draws.choice((60, 90, 120)), draws.choice((-60, -90))
    between = draws.choice(BETWEEN)
    return MISSION.format(rounds=rounds, first=first, second=second, between=between)


def early_goals(path: Path) -> list[str]:
    """Return goals in a recording that were sent while a released one had not ended.

    The end of a goal is noted at the end of the tick that has read it.
    """
    released: set[str] = set()
    sent: list[tuple[str, int, set[str]]] = []

    def take(_: int, happening: object) -> None:
        if not isinstance(happening, TraceLine) or not happening.name.startswith("goal "):
            return
        event = happening.fields
        match happening.name:
            case "goal sent" if released:
                sent.append((event["owner"], event["t"], set(released)))
            case "goal released":
                released.add(event["goal"])
            case "goal ended" | "goal abandoned":
                released.discard(event["goal"])
                for _, time_ns, live in sent:
                    if time_ns == event["t"]:
                        live.discard(event["goal"])

    fold(RecordedFile(path), take)
    return [f"{owner} at {time_ns / 1e9:.2f} s" for owner, time_ns, live in sent if live]


def revise(number: int, graph: LiveGraph, text: str) -> tuple[str, str]:
    """Send a version; return what came of it, and the finding."""
    path = graph.folder / f"version_{number}.yaml"
    path.write_text(text, encoding="utf-8")
    done = graph.start("revise", "bt_mission", str(path), "--json")
    code = done.wait(within=120.0)
    lines = done.output.strip().splitlines() or [""]
    if "Traceback" in done.output or code not in (0, 1):
        return "failed", f"exit code {code}: {lines[-3:]}"
    results = [json.loads(line) for line in lines if line.startswith("{")]
    if not results:
        return "failed", f"no result: {lines[-3:]}"
    (result,) = results
    came = "applied" if result["is_applied"] else f"refused: {result['reasons']}"
    return came, "" if (code == 0) == result["is_applied"] else f"exit code {code}, but {came}"


def mission(first: int, last: int, graph: LiveGraph) -> Iterator[Line]:
    """Run a mission with its revisions, the last of which ends it; yield a line for each."""
    draws, recording = random.Random(f"instants/{first}"), graph.folder / f"{first}.mcap"
    path = graph.folder / f"turns_{first}.yaml"
    path.write_text(version(first), encoding="utf-8")
    running = graph.run(path, "--editable", "--record", str(recording))
    running.until("first")
    for number in range(first + 1, last):
        rest(draws.uniform(0, LONGEST_S))
        came, finding = revise(number, graph, version(number))
        yield {"number": number - 1, "came": came, "findings": [finding] if finding else []}
    came, finding = revise(last, graph, version(last, rounds=1))
    running.wait(within=240.0)
    output = running.output
    if "Traceback" in output:
        finding = f"traceback: {output[-2000:]}"
    elif "turns: success" not in output or " 0 orphaned" not in output:
        finding = f"end: {output.strip().splitlines()[-3:]}"
    elif early := early_goals(recording):
        finding = f"early goals: {early}"
    yield {"number": last - 1, "came": came, "findings": [finding] if finding else []}


def main() -> None:
    """Run the campaign."""
    options = arguments(__doc__, count=50, results=Path("attached_revisions.jsonl"))
    done = options.count - len(missing(options.results, options.count))
    firsts = range(done, options.count, EACH)
    with live_robot() as graph:
        outcomes = (
            line
            for first in firsts
            for line in mission(first, min(first + EACH, options.count), graph)
        )
        lines = write(outcomes, options.results)
    came = counted(line["came"].partition(":")[0] for line in lines)
    conclude(lines, f"{len(lines)} revisions: {came}")


if __name__ == "__main__":
    main()
