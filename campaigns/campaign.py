"""Thousands of faulted missions on the stage: what goes wrong is found, and can be repeated.

Run it as: python campaigns/campaign.py [--count 10000] [--results campaign.jsonl] [--jobs 2]

Scenario N follows from the number N alone: a drawn or a shipped mission, a drawn or a shipped
world, a seed, and up to five of all faults of the test fixture. Each scenario is one line of the
results; a second run goes on where the first was stopped. A finding is

- a hang: the mission does not end within 600 s of virtual time,
- a traceback: an exception that no fault has raised,
- a goal that a server still carries out, by its own status topic, and that the run's end does not
  name as orphaned (not looked at where a server was killed),
- a collision with something that stands still, though every fault was one that the servers can
  notice (they are told nothing false by lidar, odometry or wheels, the base is told no old commands
  with fresh stamps, and nobody pushes or places obstacles).

``--show N`` prints scenario N as a test that repeats it.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from multiprocessing import get_context
from pathlib import Path

from action_msgs.msg import GoalStatus

from benchmarks.measuring import CpuWatch, figure
from bt_mission.core.draws import SeededDraws, maybe, one_of
from bt_mission.core.files import names
from bt_mission.faults import FAULTS, PlannedFault
from bt_mission.faults.drawing import drawn_faults
from bt_mission.testing import ScenarioError
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.scenarios import DrawnScenario, as_text
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.run import NeverHeldError
from bt_mission.testing.stages import Stages

DECEIVING = {
    *("lidar_noise", "lidar_bias", "lidar_blind", "lidar_frozen"),
    *("odometry_error", "odometry_drift", "slip_wheel", "block_wheel"),
    *("push", "shove", "spawn_box", "spawn_cylinder", "move_box", "jump_clock"),
}
"""Faults that the servers cannot notice in time: a collision after them is not a finding."""

MISSIONS = names("missions")
WORLDS = names("worlds")
RAISED = "made by a fault"
AT_ONCE = 200
"""Scenarios of a process before it is replaced, which bounds its memory."""


@dataclass
class Outcome:
    """The outcome of a scenario."""

    number: int
    mission: str
    world: str
    faults: list[str]
    status: str = ""
    reason: str = ""
    virtual_s: float = 0.0
    cpu_s: float = 0.0
    collisions: int = 0
    orphaned: int = 0
    findings: list[str] = field(default_factory=list)


_DRAWN = tuple(name for name in FAULTS if "leaf" not in FAULTS[name].parameters)
"""Leaves have other names in every mission."""


def scenario(number: int) -> DrawnScenario:
    """Return everything that derives from a number."""
    draws = SeededDraws(f"campaign/{number}")
    mission = one_of(draws, MISSIONS) if maybe(draws, 3) else as_text(drawn_mission(draws))
    world = one_of(draws, WORLDS) if maybe(draws, 2) else as_text(drawn_world(draws))
    return DrawnScenario(mission, world, draws.whole(0, 999), drawn_faults(draws, _DRAWN))


def carry_out(number: int) -> Outcome:
    """Run a scenario. Return its outcome."""
    drawn = scenario(number)
    outcome = Outcome(
        number,
        drawn.mission if "\n" not in drawn.mission else "drawn",
        drawn.world if "\n" not in drawn.world else "drawn",
        [fault.name for fault in drawn.faults],
    )
    watch = CpuWatch()
    with tempfile.TemporaryDirectory() as folder:
        stages = Stages(Path(folder))
        try:
            _watch(drawn, stages, outcome)
            stages.close()
        except Exception as error:  # noqa: BLE001 - as within the run
            outcome.findings.append(f"traceback at the end: {error!r}")
        outcome.orphaned = len(stages.left_behind)
    outcome.cpu_s = round(watch.elapsed_s, 2)
    return outcome


def _watch(drawn: DrawnScenario, stages: Stages, outcome: Outcome) -> None:
    run, statuses = None, list[str]()
    try:
        run = drawn.on(stages)
        run.stage.offer_all()
        statuses = [
            topic
            for topic, _ in run.stage.node.get_topic_names_and_types()
            if topic.endswith("/_action/status")
        ]
        run.record(*statuses, "collisions")
        run.until_done()
    except NeverHeldError:
        outcome.findings.append("hang")
    except ScenarioError as error:  # a fault could not begin: a mistake of the draw, not a finding
        outcome.reason = f"{type(error).__name__}: {error}".splitlines()[0]
    except Exception as error:  # noqa: BLE001 - this is what is looked for
        if RAISED not in str(error):
            outcome.findings.append("traceback: " + traceback.format_exc(limit=-3))
    if run is None:
        return
    outcome.virtual_s = round(run.t, 2)
    outcome.status = run.status
    outcome.reason = outcome.reason or run.reason
    struck = [message.obstacle for message in run.topic("collisions")]
    outcome.collisions = len(struck)
    moving = {mover.name for mover in run.stage.sim.physics.world.moving}
    if not any(map(_deceives, drawn.faults)):
        outcome.findings += [f"collision: {name}" for name in struck if name not in moving]
    if run.is_done and "kill_server" not in outcome.faults:  # a dead server's message
        going = [
            bytes(status.goal_info.goal_id.uuid).hex()
            for topic in statuses
            for status in (run.topic(topic).last.status_list if len(run.topic(topic)) else ())
            if status.status in (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)
        ]
        if len(going) > run.report.goals_left_behind:
            outcome.findings.append(f"orphaned goals: {going} are carried out, none is named")


def _deceives(fault: PlannedFault) -> bool:
    """Return whether a fault sends wrong data: old messages with fresh stamps, or commands."""
    return fault.name in DECEIVING or bool(fault.arguments.get("fresh_stamps"))


def pending(path: Path, count: int) -> Iterator[int]:
    """Yield the numbers without a line in the results."""
    done = {json.loads(line)["number"] for line in path.read_text().splitlines()}
    return (number for number in range(count) if number not in done)


def main() -> None:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--results", type=Path, default=Path("campaign.jsonl"))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--show", type=int, metavar="N", help="print scenario N, and run nothing")
    options = parser.parse_args()
    if options.show is not None:
        print(repr(scenario(options.show)))
        return
    options.results.touch()
    todo = pending(options.results, options.count)
    with (
        options.results.open("a") as results,
        get_context("spawn").Pool(options.jobs, maxtasksperchild=AT_ONCE) as pool,
    ):
        for done, outcome in enumerate(pool.imap_unordered(carry_out, todo), 1):
            results.write(json.dumps(asdict(outcome)) + "\n")
            results.flush()
            if outcome.findings:
                print(f"{outcome.number}: {outcome.findings}", flush=True)
            if not done % AT_ONCE:
                print(f"{done} more of {options.count}", flush=True)
    print(summary(options.results))
    lines = [json.loads(line) for line in options.results.read_text().splitlines()]
    figure("findings", sum(len(line["findings"]) for line in lines))


def summary(path: Path) -> str:
    """Return the figures of a campaign, in a few lines."""
    results = [json.loads(line) for line in path.read_text().splitlines()]
    kinds = Counter(finding.partition(":")[0] for line in results for finding in line["findings"])
    states = Counter(line["status"] or "not run" for line in results)
    virtual, cpu = (sum(line[name] for line in results) for name in ("virtual_s", "cpu_s"))
    return (
        f"{len(results)} scenarios, {virtual / 3600:.1f} h of virtual time in {cpu / 3600:.2f} h "
        f"of CPU time ({virtual / max(cpu, 1e-9):.0f} x)\n"
        f"ended: {dict(states)}\n"
        f"faults: {sum(len(line['faults']) for line in results)}\n"
        f"findings: {dict(kinds) or 'none'}"
    )


if __name__ == "__main__":
    main()
