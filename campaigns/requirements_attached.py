"""The same requirements on the stage and attached: verdicts and margins beside each other.

The mission runs once on the stage, and once by `bt-mission run --attach` against a simulator and
servers in processes of their own, on a clock that goes as fast as the machine lets it with
`--speed`. Exit code 1 where a verdict differs though both know the signals.

    python campaigns/requirements_attached.py [--speed 2] [explore patrol]
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.measuring import figure
from bt_mission.testing.live_graph import LiveGraph, command, own_domain

REQUIREMENTS = """\
requirements:
  keeps its distance: always clearance > 0.10
  sees its distance: always scan_clearance > 0.14
  is never hit: never collisions > 0
  gets on: 'eventually within 200 s: succeeded("{first}")'
  is in order: 'whenever running("{later}"): previously succeeded("{first}")'
  stops when blind: {{whenever: age("scan") > 0.5, then: speed < 0.01, within: 0.6}}
  is slow: always speed < 0.3
  turns slowly: always abs(turn_rate) < 2
  comes far: eventually distance > 1
"""
MISSIONS = {
    "short": ("benchmarks/short.yaml", "empty_arena", {"first": "drive", "later": "turn"}),
    "explore": ("explore", "dqn_stage4", {"first": "look around", "later": "drive"}),
    "patrol": ("patrol", "nav_arena", {"first": "visit the zones", "later": "log"}),
}
NAMES = ("mission", "requirement", "stage", "attached", "margin", "attached", "unit")


def result(output: str) -> list[dict[str, Any]]:
    """Return the requirements in what `run --json` has printed."""
    start = max(output.find("{\n"), output.find("{"))
    if start < 0:
        raise SystemExit(f"the run has not reported:\n{output}")
    found: list[dict[str, Any]] = json.JSONDecoder().raw_decode(output[start:])[0]["requirements"]
    return found


def attached(run_options: tuple[str, ...], world: str, folder: Path, pace: str) -> str:
    """Return what `run --attach --json` prints."""
    with own_domain(folder) as domain_id:
        graph = LiveGraph(folder, domain_id)
        try:
            graph.robot(world, "waffle", "--speed", pace)
            run = graph.start("run", *run_options, "--attach")
            run.wait(within=900)
            return run.output
        finally:
            graph.close()


def main() -> int:
    """Run, and print the table; gives the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("missions", nargs="*", default=["explore", "patrol"], help="or short")
    parser.add_argument("--speed", default="1", help="of the simulator")
    options = parser.parse_args()
    rows, differ = [NAMES], 0
    for mission in options.missions:
        file, world, nodes = MISSIONS[mission]
        with TemporaryDirectory() as name:
            folder = Path(name)
            require = folder / "require.yaml"
            require.write_text(REQUIREMENTS.format(**nodes), encoding="utf-8")
            run = (file, "--json", "--require", str(require))
            arguments = command("run", *run)
            stage = subprocess.run(arguments, capture_output=True, text=True, check=False)  # noqa: S603 - our own command
            live = attached(run, world, folder, options.speed)
        for one, other in zip(result(stage.stdout), result(live), strict=True):
            assert one["name"] == other["name"]
            known = other["verdict"] != "unknown"
            differ += known and one["verdict"] != other["verdict"]
            rows.append(
                (
                    mission,
                    one["name"],
                    one["verdict"],
                    other["verdict"] + "".join(f" ({by})" for by in other["sources"]),
                    _number(one["margin"]),
                    _number(other["margin"]),
                    one["unit"],
                )
            )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)))
    figure("verdicts that differ", differ)
    return int(differ > 0)


def _number(margin: float | None) -> str:
    return "" if margin is None else f"{margin:.4f}"


if __name__ == "__main__":
    sys.exit(main())
