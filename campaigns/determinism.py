"""Do the same inputs give the same trace? Drawn missions, worlds and faults, each run twice.

Run it as: python campaigns/determinism.py [--count 500] [--python PATH]

The two runs of a scenario are in different processes, with another hash seed of Python, another
environment and another folder, and something else on the second core while the second runs.
`--python` names another interpreter with bt-mission, such as one of another version of Python, for
the second run.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
from contextlib import closing
from pathlib import Path
from typing import Any

from benchmarks.measuring import arguments, figure

BATCH = 25
"""Scenarios that one process runs."""


def run_batch(first: int, last: int) -> None:
    """Print a line of JSON for each scenario: its seed, its end, its trace's hash."""
    from bt_mission.scenarios.draws import SeededDraws  # noqa: PLC0415 - in the child only
    from bt_mission.testing.generators.scenarios import drawn_scenario  # noqa: PLC0415
    from bt_mission.testing.stages import Stages  # noqa: PLC0415

    for seed in range(first, last):
        scenario = drawn_scenario(SeededDraws(seed))
        with tempfile.TemporaryDirectory() as folder, closing(Stages(Path(folder))) as stages:
            run = scenario.on(stages)
            run.until_done()
        hashes = {
            "seed": seed,
            "end": run.status,
            "s": run.t,
            "goals": len(run.goals),
            "faults": len(scenario.faults),
            "collisions": run.now.collisions,
            "trace": run.stage.trace.sha256,
        }
        print(json.dumps(hashes), flush=True)


def keep_a_core_busy() -> None:
    """Compute until it is ended."""
    while True:
        sum(range(10_000))


def own_environment() -> dict[str, str]:
    """Return this process's environment, without that of the ROS wheels of its interpreter.

    Another interpreter would look for its libraries among those, and not find them.
    """
    variables = {key: value for key, value in os.environ.items() if not key.startswith("_ROS_")}
    paths = variables.pop("LD_LIBRARY_PATH", "").split(os.pathsep)
    own = [path for path in paths if path and not path.startswith(sys.prefix)]
    return variables | ({"LD_LIBRARY_PATH": os.pathsep.join(own)} if own else {})


def batch(python: str, first: int, last: int, variables: dict[str, str]) -> list[dict[str, Any]]:
    """Run scenarios in a separate process."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(  # noqa: S603 - our own script
            [python, str(Path(__file__).resolve()), "--batch", str(first), str(last)],
            cwd=folder,
            env=own_environment() | variables,
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode:
        sys.exit(f"{python} ended with {done.returncode}:\n{done.stderr[-2000:]}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def main() -> int:
    """Compare; the exit code is 1 if a trace differs."""
    options = arguments(
        __doc__,
        count=(500, "scenarios"),
        python=(sys.executable, "interpreter of the second run"),
        batch=([0, 0], "run these scenarios, as a process of this script"),
    )
    if any(options.batch):
        run_batch(*options.batch)
        return 0
    lines, differ = [], []
    for first in range(0, options.count, BATCH):
        last = min(first + BATCH, options.count)
        here = batch(sys.executable, first, last, {"PYTHONHASHSEED": "1"})
        busy = multiprocessing.Process(target=keep_a_core_busy, daemon=True)
        busy.start()
        variables = {"PYTHONHASHSEED": str(first + 2), "PADDING": "x" * 9999}
        there = batch(options.python, first, last, variables)
        busy.kill()
        busy.join()
        lines += here
        pairs = zip(here, there, strict=True)
        differ += [mine["seed"] for mine, other in pairs if mine != other]
        print(f"\r{last} of {options.count}, {len(differ)} differ", end="", file=sys.stderr)
    print(file=sys.stderr)
    figure("traces that differ", len(differ))
    seconds, goals, faults = (sum(line[key] for line in lines) for key in ("s", "goals", "faults"))
    print(
        f"{options.count} scenarios, {seconds:.0f} virtual s, {goals} goals, {faults} faults, "
        f"{sum(line['end'] == 'success' for line in lines)} missions succeeded: "
        f"{len(differ)} traces differ{f': seeds {differ}' if differ else ''}"
    )
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
