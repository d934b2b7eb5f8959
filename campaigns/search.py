"""Runs until `bt-mission falsify` finds a planted defect, for each strategy: a resumable campaign.

60 defects: 14 of the shipped scenarios and of rare moments that do not show at once
(`tests/support/planted_defects.py`, `campaigns/rare_defects.py`), 16 in short missions
(`campaigns/mission_defects.yaml`), and 30 by mutation, of missions and of the servers' methods
(`campaigns/mutants.py`). A find counts only where the mission without the defect stands the same
scenario, as with `--reference`. Mutants that break as they are are passed over; some of the others
may do the same as the original in every scenario, so no search can find all.

What is done is in the file, so a campaign that was ended goes on where it was.

Run it as: python campaigns/search.py [--seeds N] [--budget N] [--minutes N] [--only TEXT]
[--table] FILE.jsonl
"""

from __future__ import annotations

import argparse
import asyncio
import json
import statistics
import tempfile
import time
from collections.abc import AsyncGenerator, Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import pytest
import yaml
from mutants import mission_mutants, server_mutants
from rare_defects import RARE

from benchmarks.measuring import figure
from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.errors import BtMissionError
from bt_mission.core.yaml.document import read, read_text
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.scenarios.runner import silence_logs
from bt_mission.search.candidate import Candidate
from bt_mission.search.guide import Guide
from bt_mission.search.reference import Reference, load_reference
from bt_mission.search.session import SearchOptions, SearchSession, load_search
from bt_mission.search.strategies import STRATEGIES
from bt_mission.sweeps.base import BaseChanges
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.ranges import RangesFile
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.work import ScenarioWorker
from tests.support.planted_defects import DEFECTS
from tests.support.planting import Plant

MISSIONS: dict[str, Any] = yaml.safe_load(
    Path(__file__).with_name("mission_defects.yaml").read_text(encoding="utf-8")
)
BASES: dict[str, str] = MISSIONS["missions"]
SHIPPED = Path("missions/scenarios").resolve()
NO_CAMERA = Path("benchmarks/explore_no_camera.yaml").resolve()
LIMIT = "limit: 40\n"
AROUND = "obstacles: {ahead: -1.2..1.2}\n"
"""Ranges of missions that do not drive ahead."""

HIDDEN = (
    "does not look for room to turn",
    "stops 0.3 m late",
    "does not slow down before an obstacle",
    "looks at its first scan alone",
    "drives on blind",
    "is not held while the scan is old",
    "drives on without odometry",
    "backs up without a look behind",
)
"""Of the shipped scenarios' defects those that their missions do not show at once."""

MISSION_MUTANTS, SERVER_MUTANTS = 18, 12
MOST_TRIED = 60
"""Mutants that are looked at to find so many."""


def nothing(_: pytest.MonkeyPatch) -> None:
    """Plant no defect in the program: it is in the mission."""


@dataclass(frozen=True)
class Case:
    """A defect, and the mission or scenario in which it is searched for.

    Attributes:
        kind: Of the table.
        good: The same without the defect.
        plant: Plants a defect in the program while the mission runs, and not while `good` does.
        is_slow: A run takes a second or more.
    """

    kind: str
    what: str
    text: str
    good: str
    plant: Plant = nothing
    ranges: str = "{}"
    is_slow: bool = False


def cases() -> Iterator[Case]:
    """Yield all defects; those by mutation may be others than are tried in the end."""
    for written in MISSIONS["defects"]:
        good = BASES[written["mission"]]
        bad = good.replace(written["good"], written["bad"])
        yield Case("missions", written["what"], bad, good, ranges=LIMIT)
    for defect in RARE:
        yield Case(
            "rare moments",
            defect.what,
            defect.scenario,
            defect.scenario,
            defect.plant,
            defect.ranges,
        )
    for defect in DEFECTS:
        if defect.what in HIDDEN:
            text = stripped(defect.scenario)
            around = AROUND if defect.scenario in ("tight_turn", "back_up") else "{}"
            is_slow = defect.scenario not in ("tight_turn", "back_up")
            yield Case("shipped", defect.what, text, text, defect.plant, around, is_slow)


def mutants() -> Iterator[Case]:
    """Yield mutants that do not break as they are."""
    drawn = [(name, mission_mutants(text, 25)) for name, text in BASES.items()]
    of_missions = (
        Case("mission mutants", f"{name}: {what}", text, BASES[name], ranges=LIMIT)
        for name, texts in cycle(drawn)
        for what, text in islice(texts, 1)
    )
    names = cycle(("drive", "turns", "careful"))
    of_servers = (
        Case("server mutants", f"{name}: {what}", BASES[name], BASES[name], plant, LIMIT)
        for name, (what, plant) in zip(names, server_mutants(25), strict=False)
    )
    for mutants, wanted in ((of_missions, MISSION_MUTANTS), (of_servers, SERVER_MUTANTS)):
        alive = (mutant for mutant in islice(mutants, MOST_TRIED) if stands(mutant))
        yield from islice(alive, wanted)


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


class PlantedRunner:
    """Carries scenarios out with a defect."""

    def __init__(self, worker: ScenarioWorker, plant: Plant) -> None:
        self._worker = worker
        self._plant = plant

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        """Yield the row of each scenario."""
        for scenario in scenarios:
            with pytest.MonkeyPatch.context() as patch:
                self._plant(patch)
                row = self._worker.carry_out(scenario)
            yield row


def aim_of(case: Case) -> Any:
    """Return what is searched for."""
    return "violated" if case.kind in ("shipped", "rare moments") else "anything"


def written(case: Case, folder: Path) -> tuple[Path, Path]:
    """Write the mission or scenario of a case, and the good one."""
    end = ".scenario.yaml" if case.text.startswith("scenario:") else ".yaml"
    bad, good = folder / f"bad{end}", folder / f"good{end}"
    bad.write_text(case.text)
    good.write_text(case.good)
    return bad, good


def stands(case: Case) -> bool:
    """Tell whether a mutant succeeds as it is."""
    with tempfile.TemporaryDirectory() as folder:
        ranges = RangesFile(read_text(case.ranges))
        try:
            base = load_search(written(case, Path(folder))[0], BaseChanges(), ranges, aim_of(case))
        except BtMissionError:
            return False
        with ScenarioWorker(base.bundle) as worker, pytest.MonkeyPatch.context() as patch:
            case.plant(patch)
            row = worker.carry_out(Candidate(limit=ranges.ranges.limit).concrete(base, 0))
    return not row.is_error and not Guide("anything", row).failures(row)


def search(case: Case, strategy: str, seed: int, budget: int) -> dict[str, Any]:
    """Search for a defect once; gives what came of it."""
    ranges = RangesFile(read_text(case.ranges))
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        bad, good = written(case, Path(folder))
        base = load_search(bad, BaseChanges(), ranges, aim_of(case))
        sound = load_reference(good, base, ranges)
        options = SearchOptions(aim_of(case), budget, strategy, seed, 0)
        with ScenarioWorker(base.bundle) as worker, ScenarioWorker(sound.bundle) as other:
            reference = Reference(sound, other)
            session = SearchSession(base, ranges, options, lambda _: True, reference)
            asyncio.run(session.run(PlantedRunner(worker, case.plant)))
    state = session.state
    return {
        "kind": case.kind,
        "what": case.what,
        "strategy": strategy,
        "seed": seed,
        "budget": budget,
        "runs": state.runs if state.counterexamples else None,
        "unfair": state.unfair,
        "errors": state.errors,
        "faults": [fault.text for each in state.counterexamples for fault in each.candidate.faults],
        "cpu_s": round(time.process_time() - began, 2),
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Return the results as tables of Markdown: all searches, and the pairs by kind."""
    done = {(row["what"], row["strategy"], row["seed"]): row for row in rows if row["runs"] != 1}
    pairs = [
        (what, seed)
        for what, seed in dict.fromkeys((what, seed) for what, _, seed in done)
        if all((what, name, seed) in done for name in STRATEGIES)
    ]
    heads = [f"{each}: found" for each in STRATEGIES] + [f"{each}: runs" for each in STRATEGIES]
    lines = [
        f"| | searches of each | {' | '.join(heads)} |",
        "|---" * (2 + 2 * len(STRATEGIES)) + "|",
    ]

    def add(name: str, chosen: Callable[[dict[str, Any]], bool]) -> None:
        groups = [
            [
                done[what, strategy, seed]
                for what, seed in pairs
                if chosen(done[what, strategy, seed])
            ]
            for strategy in STRATEGIES
        ]
        if groups[0]:
            counts = [f"{sum(search['runs'] is not None for search in group)}" for group in groups]
            lines.append(
                f"| {name} | {len(groups[0])} | {' | '.join(counts)} | "
                f"{' | '.join(map(_spread, groups))} |"
            )

    for kind in dict.fromkeys(row["kind"] for row in rows):
        add(kind, lambda row, kind=kind: row["kind"] == kind)
    for seed in sorted({seed for _, seed in pairs}):
        add(f"all, search seed {seed}", lambda row, seed=seed: row["seed"] == seed)
    add("all", lambda _: True)
    first, second = STRATEGIES
    sooner = [0, 0, 0]
    for what, seed in pairs:
        runs, other = (_runs(done[what, name, seed]) for name in (first, second))
        sooner[0 if runs < other else 1 if other < runs else 2] += 1
    broken = {what for (what, _, _), row in done.items() if row["runs"]}
    names = dict.fromkeys(what for what, _ in pairs)
    never = [what for what in names if what not in broken]
    summary = (
        f"{len(names)} defects, {len(pairs)} pairs of searches: {first} sooner in {sooner[0]}, "
    )
    summary += f"{second} in {sooner[1]}, equal in {sooner[2]}. Never found: {len(never)}."
    return "\n".join([*lines, "", summary, *(f"- {what}" for what in never)])


def _runs(row: dict[str, Any]) -> int:
    return int(row["runs"] or row["budget"] + 1)


def _spread(group: list[dict[str, Any]]) -> str:
    """Return the median with the quartiles."""
    values = sorted(map(_runs, group))
    low, middle, high = statistics.quantiles(values, n=4) if len(values) > 1 else 3 * values
    return f"{middle:g} ({low:g} to {high:g})"


def main() -> None:
    """Search for every defect by every strategy; append what comes of each to a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--budget", type=int, default=150)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="of processor time")
    parser.add_argument("--only", default="", help="of the defects that are no mutants")
    parser.add_argument("--strategies", nargs="+", default=list(STRATEGIES))
    parser.add_argument("--table", action="store_true", help="print the table of what is there")
    options = parser.parse_args()
    rows = [json.loads(line) for line in options.file.open()] if options.file.exists() else []
    if options.table:
        print(table(rows))
        return
    prepare_middleware()
    silence_logs()
    known = {(known_row["what"], known_row["strategy"], known_row["seed"]) for known_row in rows}
    used_s = sum(known_row["cpu_s"] for known_row in rows)
    all_cases = [*cases(), *([] if options.only else mutants())]
    searches = [(seed, case) for seed in range(options.seeds) for case in all_cases]
    for seed, case in sorted(searches, key=lambda pair: pair[1].is_slow):
        for strategy in options.strategies:
            if (case.what, strategy, seed) in known or options.only not in case.what:
                continue
            if used_s > 60 * options.minutes:
                continue
            row = search(case, strategy, seed, options.budget)
            used_s += row["cpu_s"]
            with options.file.open("a") as file:
                file.write(json.dumps(row) + "\n")
            print(row, flush=True)
            rows.append(row)
    now = [present for present in rows if options.only in present["what"]]
    figure("runs until found", map(_runs, now))


if __name__ == "__main__":
    main()
