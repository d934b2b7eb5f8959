"""Runs until `bt-mission falsify` finds a planted defect, for each strategy.

The defects are those of the shipped scenarios (`tests/support/planted_defects.py`), without the
obstacles and faults that show them there, and some that need a rare moment
(`benchmarks/rare_defects.py`). A defect counts as found in a run that violates its requirement, in
a scenario in which it holds without the defect. What the strategy `random` finds is made small, and
its file is run once more.

Run it as: python benchmarks/search.py [--seeds N] [--budget N] [--only TEXT] [--table] FILE.jsonl
"""

from __future__ import annotations

import argparse
import asyncio
import json
import statistics
import tempfile
from collections.abc import AsyncGenerator, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from measuring import figure
from rare_defects import RARE
from rclpy.logging import LoggingSeverity, set_logger_level

from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.yaml.document import read, read_text
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario
from bt_mission.search.ranges import RangesFile
from bt_mission.search.result import scenario_data
from bt_mission.search.session import SearchOptions, SearchSession, load_search
from bt_mission.search.strategies import STRATEGIES
from bt_mission.sweeps.base import BaseChanges
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.row import RequirementMargin, ScenarioRow
from bt_mission.sweeps.work import ScenarioWorker
from tests.support.planted_defects import DEFECTS

SHIPPED = Path("missions/scenarios").resolve()
NO_CAMERA = Path("benchmarks/explore_no_camera.yaml").resolve()


@dataclass(frozen=True)
class Case:
    """A defect in a scenario that does not show it by what goes wrong there."""

    what: str
    text: str
    caught_by: str
    plant: Any
    ranges: str = "{}"


def cases() -> list[Case]:
    """Return all defects."""
    found = [
        Case(
            one.what,
            stripped(one.scenario),
            one.caught_by,
            one.plant,
            AROUND if one.scenario in ("tight_turn", "back_up") else "{}",
        )
        for one in DEFECTS
    ]
    return found + [Case(*(getattr(one, name) for name in NAMES)) for one in RARE]


AROUND = "obstacles: {ahead: -1.2..1.2}"
"""Ranges of missions that do not drive ahead."""

NAMES = ("what", "scenario", "caught_by", "plant", "ranges")


def stripped(name: str) -> str:
    """Return a shipped scenario without what goes wrong in it.

    Explorations are shorter, and draw no pictures.
    """
    data = dict(read(SHIPPED / f"{name}.scenario.yaml").data)
    for key in ("faults", "obstacles", "expect"):
        data.pop(key, None)
    if isinstance(data["mission"], str):
        data["mission"] = str((SHIPPED / data["mission"]).resolve())
        if "explore" in data["mission"]:
            data["mission"] = str(NO_CAMERA)
            data["inputs"] = {"legs": 2}
            data["requirements"] = {
                **data["requirements"],
                "touches nothing": "never collisions > 0",
            }
    return to_yaml(data)


class DefectRunner:
    """Carries scenarios out with a defect; what is violated without it as well does not count."""

    def __init__(self, worker: ScenarioWorker, case: Case) -> None:
        self._worker = worker
        self._case = case

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        """Yield the row of each scenario, with the one requirement that matters."""
        for one in scenarios:
            with pytest.MonkeyPatch.context() as patch:
                self._case.plant(patch)
                row = self._worker.carry_out(one)
            name = self._case.caught_by
            margin = row.requirements.get(name)
            if margin is not None and margin.verdict == "violated":
                healthy = self._worker.carry_out(one).requirements.get(name)
                if healthy is None or healthy.verdict == "violated":
                    margin = RequirementMargin("holds", 0.01, margin.unit, margin.at)
            yield replace(row, requirements={} if margin is None else {name: margin})


def search(case: Case, strategy: str, seed: int, budget: int, folder: Path) -> dict[str, Any]:
    """Search for a defect once; gives what came of it."""
    path = folder / "case.scenario.yaml"
    path.write_text(case.text)
    ranges = RangesFile(read_text(case.ranges))
    base = load_search(path, BaseChanges(), ranges, "violated")
    is_simplified = strategy == "random"
    options = SearchOptions("violated", budget, strategy, seed, 150 if is_simplified else 0)
    session = SearchSession(base, ranges, options, lambda _: True)
    with ScenarioWorker(base.bundle) as worker:
        asyncio.run(session.run(DefectRunner(worker, case)))
    state = session.state
    told: dict[str, Any] = {"what": case.what, "strategy": strategy, "seed": seed}
    told |= {"budget": budget, "runs": state.runs if state.found else None, "errors": state.errors}
    if state.found and is_simplified:
        file = folder / "elsewhere" / "found.scenario.yaml"
        file.parent.mkdir(exist_ok=True)
        file.write_text(to_yaml(scenario_data(base, state.found, file.parent)))
        with pytest.MonkeyPatch.context() as patch:
            case.plant(patch)
            result = run_scenario(load_scenario(file))
        told |= {
            "faults": [one.text for one in state.found.candidate.faults],
            "simplifying_runs": state.simplifying_runs,
            "repeats": result.report.trace_sha256 == state.found.row.trace_sha256,
            "fails": not result.passed,
        }
    return told


def table(rows: list[dict[str, Any]]) -> str:
    """Return the results as a table of Markdown."""
    names = list(dict.fromkeys(one["what"] for one in rows))
    lines = ["| defect | " + " | ".join(STRATEGIES) + " |", "|---|" + "---|" * len(STRATEGIES)]
    totals: dict[str, list[float]] = {name: [] for name in STRATEGIES}
    at_once = 0
    for name in names:
        of_one = [one for one in rows if one["what"] == name]
        if all(one["runs"] == 1 for one in of_one):
            at_once += 1
            continue
        cells = []
        for strategy in STRATEGIES:
            runs = [one for one in of_one if one["strategy"] == strategy]
            values = [one["runs"] or one["budget"] + 1 for one in runs]
            found = sum(one["runs"] is not None for one in runs)
            totals[strategy] += values
            middle = statistics.median(values) if values else 0
            if not runs:
                cells.append("")
                continue
            told = f"{middle:g}" if middle <= runs[0]["budget"] else f"> {runs[0]['budget']}"
            cells.append(f"{told} ({found} of {len(runs)})")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    middles = [f"{statistics.mean(values):.1f}" if values else "" for values in totals.values()]
    lines.append(f"| mean of all above, not found as {'budget + 1'} | {' | '.join(middles)} |")
    small = [one for one in rows if "faults" in one]
    few = sum(len(one["faults"]) <= 2 for one in small)
    same = sum(one["repeats"] for one in small)
    lines.append("")
    lines.append(
        f"{at_once} defects show in the first run. Made small: at most 2 faults in {few} of"
    )
    lines.append(f"{len(small)}, the same trace from the file in {same} of {len(small)}.")
    return "\n".join(lines)


def main() -> None:
    """Search for every defect by every strategy; append what comes of each to a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--budget", type=int, default=60)
    parser.add_argument("--only", default="")
    parser.add_argument("--strategies", nargs="+", default=list(STRATEGIES))
    parser.add_argument("--table", action="store_true", help="print the table of what is there")
    options = parser.parse_args()
    rows = [json.loads(one) for one in options.file.open()] if options.file.exists() else []
    if options.table:
        print(table(rows))
        return
    prepare_middleware()
    set_logger_level("", LoggingSeverity.FATAL)
    known = {(one["what"], one["strategy"], one["seed"]) for one in rows}
    at_once = {one["what"] for one in rows if one["runs"] == 1}
    for seed in range(options.seeds):
        for case in cases():
            for strategy in options.strategies:
                is_known = (case.what, strategy, seed) in known or case.what in at_once
                if is_known or options.only not in case.what:
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    row = search(case, strategy, seed, options.budget, Path(folder))
                if row["runs"] == 1:
                    at_once.add(case.what)  # nothing of it depends on strategy or seed
                with options.file.open("a") as file:
                    file.write(json.dumps(row) + "\n")
                print(row, flush=True)
                rows.append(row)
    now = [one for one in rows if options.only in one["what"]]
    figure("runs until found", (one["runs"] or one["budget"] + 1 for one in now))


if __name__ == "__main__":
    main()
