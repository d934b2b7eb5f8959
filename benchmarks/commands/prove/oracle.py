"""Random missions, proved and then run at random: does a run break what was proved?

Run it as: python benchmarks/commands/prove/oracle.py [--count 2000] [--runs 200]
    [--results oracle.jsonl]

Mission N follows from its number: any node, decorator, topic, list, draw, Python leaf, named tree,
service and requirement of the language, with up to two faults. It is proved. Then the tree, the
executive, the ledger and the monitors of runs run it, with servers that answer any values of their
types at any instants (``tests/commands/prove/oracle``, which shares no code with
``bt_mission.commands.prove``).
A finding is

- a property or a requirement that is ``proved`` and that a run breaks,
- a node that is ``never entered``, or a premise that is never met, in a run that has it,
- a counterexample of ``prove`` that its run on the stage does not show (``--confirm``: of every
  Kth mission), unless the proof says why it cannot be decided.

Each mission is one line of the results; a second run continues where the first was stopped. With
``--save``, a folder gets the smallest form of each mission that has a finding, and the run.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.measuring import CpuWatch, arguments, figure
from bt_mission.base.errors import BtMissionError
from bt_mission.commands.prove.confirm import confirmed
from bt_mission.commands.prove.proof import Proof, ProofOptions
from bt_mission.language.mission import Mission
from bt_mission.scenarios.runner import prepare_process, silence_logs
from bt_mission.sessions.load import load
from campaigns.trials import Line, carry_out, conclude, counted, missing
from tests.commands.prove.oracle.judge import MOST_STATES, try_mission
from tests.commands.prove.oracle.missions import random_mission
from tests.commands.prove.oracle.shrink import smallest

TO_SHRINK = 60
"""Runs of each smaller mission."""
HISTORY = 80
"""Lines of a run that are saved."""


def faults_of(number: int) -> int:
    """Return how many faults the runs of a mission have at most."""
    return Random(number).choice((0, 1, 1, 2))


def trial(number: int, runs: int, every: int, folder: Path | None) -> Line:
    """Prove and run a mission; return the line of its results."""
    data, text, mission = random_mission(number)
    faults = faults_of(number)
    watch = CpuWatch()
    try:
        tried = try_mission(mission, text, faults, runs)
    except Exception as error:  # noqa: BLE001 - this is looked for, too
        return {"number": number, "findings": [f"traceback: {error!r}"]}
    seconds = watch.elapsed_s
    findings = [f"{claim}: {defect.why}" for claim, defect in tried.defects.items()]
    spurious, undecided = list[str](), Counter[str]()
    if every and number % every == 0:
        spurious, undecided = _reruns(tried.proof, text, faults)
    if folder is not None:
        for claim in tried.defects:
            _save(folder / f"{number:04}-{_slug(claim)}", data, claim, faults, runs)
        for index, why in enumerate(spurious):
            place = folder / f"{number:04}-spurious-{index}"
            place.mkdir(parents=True, exist_ok=True)
            (place / "mission.yaml").write_text(text, encoding="utf-8")
            (place / "finding.txt").write_text(f"faults: {faults}\n{why}\n", encoding="utf-8")
    return {
        "number": number,
        "faults": faults,
        "exhaustive": tried.proof.exhaustive,
        "proved": len(tried.proof.proved),
        "runs": tried.runs,
        "void": dict(tried.void),
        "seconds": round(seconds, 2),
        "undecided": dict(undecided),
        "findings": findings + [f"spurious: {why.splitlines()[0]}" for why in spurious],
    }


def _reruns(proof: Proof, text: str, faults: int) -> tuple[list[str], Counter[str]]:
    """Run what a proof has found on the stage; return what is not seen, and why not decided."""
    spurious, undecided = list[str](), Counter[str]()
    with TemporaryDirectory() as name:
        path = Path(name) / "m.yaml"
        path.write_text(text, encoding="utf-8")
        mission: Mission = load(path)
        options = ProofOptions(faults=faults)
        try:
            for finding in confirmed(proof.findings, mission, options, Path(name)):
                stage = finding.stage
                if stage is None or stage.is_confirmed is None:
                    undecided[stage.why_not.partition(":")[0] if stage else "no run"] += 1
                elif not stage.is_confirmed:
                    scenario = Path(stage.scenario).read_text(encoding="utf-8")
                    spurious.append(f"{replace(finding, stage=None)}\n\n{scenario}")
        except BtMissionError as error:
            spurious.append(f"no scenario: {error}")
    return spurious, undecided


def _save(place: Path, data: dict[str, Any], claim: str, faults: int, runs: int) -> None:
    """Save the smallest form of a mission, and the run that breaks a claim."""
    text, faults, defect = smallest(data, claim, faults, max(runs, TO_SHRINK))
    if defect is None:
        return
    place.mkdir(parents=True, exist_ok=True)
    (place / "mission.yaml").write_text(text, encoding="utf-8")
    history = [*defect.history[:HISTORY], *(["..."] if len(defect.history) > HISTORY else [])]
    lines = [
        f"# bt-mission prove mission.yaml --faults {faults} --budget {MOST_STATES}",
        f"claim: {claim}",
        f"broken at: {defect.why}",
        f"run: World(mission, text, {defect.seed}, {faults})",
        *history,
    ]
    (place / "run.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _slug(claim: str) -> str:
    return claim.replace(": ", "-").replace(" ", "-")


def prepare() -> None:
    """Prepare a process of the campaign."""
    prepare_process()
    silence_logs()


def main() -> None:
    """Prove and run, and print what was found."""
    options = arguments(
        __doc__,
        count=2000,
        runs=200,
        confirm=(4, "run what is found in every Kth mission on the stage; 0 for none"),
        results=Path("oracle.jsonl"),
        save=(Path(), "a folder for missions with findings"),
        jobs=1,
    )
    folder = None if options.save == Path() else options.save
    work = partial(trial, runs=options.runs, every=options.confirm, folder=folder)
    todo = missing(options.results, options.count)
    lines = carry_out(work, todo, options.results, options.jobs, prepare)
    runs = sum(line.get("runs", 0) for line in lines)
    figure("runs a second", runs / max(0.001, sum(line.get("seconds", 0) for line in lines)))
    voids = sum((Counter(line.get("void", {})) for line in lines), Counter[str]())
    undecided = sum((Counter(line.get("undecided", {})) for line in lines), Counter[str]())
    conclude(
        lines,
        f"{len(lines)} missions, exhaustive: {counted(line.get('exhaustive') for line in lines)}",
        f"{runs} runs, void: {dict(voids)}",
        f"findings of prove that no run decides: {dict(undecided)}",
    )


if __name__ == "__main__":
    main()
