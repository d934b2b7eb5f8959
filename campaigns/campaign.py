"""Thousands of faulted missions on the stage: what goes wrong is found, and can be repeated.

Run it as: python campaigns/campaign.py [--count 10000] [--results campaign.jsonl] [--jobs 2]

Scenario N follows from the number N alone: a drawn or a shipped mission, a drawn or a shipped
world, a seed, and up to five of all faults of the test fixture. Each scenario is one line of the
results; a second run continues where the first was stopped. A finding is

- a hang: the mission does not end within 600 s of virtual time,
- a traceback: an exception that no fault has raised,
- a goal that a server still carries out, by its own status topic, and that the run's end does not
  name as orphaned (not looked at where a server was killed),
- a collision with something that stands still, though every fault was one that the servers can
  notice (lidar, odometry and wheels tell them nothing false, the base receives no old commands
  with fresh stamps, and nobody pushes or places obstacles).

``--show N`` prints scenario N as a test that repeats it.
"""

from __future__ import annotations

import tempfile
import traceback
from dataclasses import dataclass, field
from pathlib import Path

from action_msgs.msg import GoalStatus
from trials import Line, carry_out, conclude, counted, missing

from benchmarks.measuring import CpuWatch, arguments
from bt_mission.base.files import names
from bt_mission.scenarios.draws import SeededDraws, maybe, one_of
from bt_mission.scenarios.faults import FAULTS, PlannedFault
from bt_mission.scenarios.faults.drawing import drawn_faults
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

RAISED = "made by a fault"
DRAWN = tuple(name for name in FAULTS if "leaf" not in FAULTS[name].parameters)
"""Leaves have other names in every mission."""


@dataclass
class Outcome:
    """The outcome of a scenario."""

    number: int
    faults: list[str]
    mission: str = "drawn"
    world: str = "drawn"
    status: str = ""
    reason: str = ""
    virtual_s: float = 0.0
    cpu_s: float = 0.0
    goals: int = 0
    collisions: int = 0
    orphaned: int = 0
    trace: str = ""
    findings: list[str] = field(default_factory=list)


def play(drawn: DrawnScenario, outcome: Outcome) -> None:
    """Run a scenario on a stage, and note what was found."""
    watch = CpuWatch()
    with tempfile.TemporaryDirectory() as folder:
        stages = Stages(Path(folder))
        try:
            _play(drawn, stages, outcome)
            stages.close()
        except Exception as error:  # noqa: BLE001 - as within the run
            outcome.findings.append(f"traceback at the end: {error!r}")
        outcome.orphaned = len(stages.left_behind)
    outcome.cpu_s = round(watch.elapsed_s, 2)


def _play(drawn: DrawnScenario, stages: Stages, outcome: Outcome) -> None:
    run, statuses = None, list[str]()
    try:
        run = drawn.on(stages)
        run.stage.offer_all()
        topics = [topic for topic, _ in run.stage.node.get_topic_names_and_types()]
        statuses = [topic for topic in topics if topic.endswith("/_action/status")]
        run.record(*statuses, "collisions")
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


def scenario(number: int) -> DrawnScenario:
    """Return everything that derives from a number."""
    draws = SeededDraws(f"campaign/{number}")
    mission = one_of(draws, names("missions")) if maybe(draws, 3) else as_text(drawn_mission(draws))
    world = one_of(draws, names("worlds")) if maybe(draws, 2) else as_text(drawn_world(draws))
    return DrawnScenario(mission, world, draws.whole(0, 999), drawn_faults(draws, DRAWN))


def trial(number: int) -> Outcome:
    """Run a scenario. Return its outcome."""
    drawn = scenario(number)
    outcome = Outcome(number, [fault.name for fault in drawn.faults])
    if "\n" not in drawn.mission:
        outcome.mission = drawn.mission
    if "\n" not in drawn.world:
        outcome.world = drawn.world
    play(drawn, outcome)
    return outcome


def summary(lines: list[Line]) -> str:
    """Return the figures of a campaign on the stage, in a few lines."""
    virtual, cpu = (sum(line[name] for line in lines) for name in ("virtual_s", "cpu_s"))
    return (
        f"{len(lines)} scenarios, {virtual / 3600:.1f} h of virtual time in {cpu / 3600:.2f} h "
        f"of CPU time ({virtual / max(cpu, 1e-9):.0f} x)\n"
        f"ended: {counted(line['status'] or 'not run' for line in lines)}\n"
        f"faults: {sum(len(line['faults']) for line in lines)}"
    )


def main() -> None:
    """Run the campaign."""
    options = arguments(
        __doc__,
        count=10_000,
        results=Path("campaign.jsonl"),
        jobs=2,
        show=(None, "print scenario N, and run nothing"),
    )
    if options.show is not None:
        print(repr(scenario(options.show)))
        return
    todo = missing(options.results, options.count)
    lines = carry_out(trial, todo, options.results, options.jobs)
    conclude(lines, summary(lines))


if __name__ == "__main__":
    main()
