"""Workers, scheduler and client of a sweep are killed at random: is a row lost, doubled or another?

Round after round, all rows are compared with those of a loop in one process.
Run it as: python benchmarks/commands/sweep/sweep_kills.py [--rounds N] [--count N]
"""

from __future__ import annotations

import random
import tempfile
from pathlib import Path

from benchmarks.measuring import arguments, figure
from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.scenarios.runner import ScenarioProcess, prepare_process
from tests.commands.sweep.killed_sweep import KilledSweep

MISSION = """\
mission: turn
world: empty_arena
tree:
  turn: {angle: "uniform(20, 60)"}
"""
VICTIMS = ("worker", "worker", "nanny", "scheduler", "client")


def is_equal(number: int, count: int, most_kills: int) -> bool:
    """Kill at random in one sweep; return whether it has the rows of a loop in one process."""
    draws = random.Random(f"kills/{number}")
    victims = [draws.choice(VICTIMS) for _ in range(draws.randint(min(1, most_kills), most_kills))]
    with tempfile.TemporaryDirectory() as folder:
        mission = Path(folder) / "turn.yaml"
        mission.write_text(MISSION, encoding="utf-8")
        sweep = KilledSweep(Path(folder), mission, ("--seeds", str(count)), draws)
        rows = sweep.run(victims)
        plan = SweepPlan(load_base(mission, BaseChanges()), seeds=range(count))
        with ScenarioWorker(plan.base.bundle, ScenarioProcess().run) as alone:
            serial = [alone.carry_out(scenario) for scenario in plan.scenarios()]
    both = [[(row.id, row.trace_sha256) for row in some] for some in (rows, serial)]
    same = both[0] == both[1]
    print(f"round {number}: killed {', '.join(sweep.killed)}: {'equal' if same else 'WRONG'}")
    return same


def main() -> None:
    """Run the rounds."""
    options = arguments(
        __doc__, rounds=20, count=(16, "scenarios of a sweep"), most_kills=(4, "in a round")
    )
    prepare_process()
    rounds = [
        is_equal(number, options.count, options.most_kills) for number in range(options.rounds)
    ]
    figure("rounds with lost, doubled or different rows", rounds.count(False))


if __name__ == "__main__":
    main()
