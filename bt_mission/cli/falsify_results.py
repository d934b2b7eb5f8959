"""What ``bt-mission falsify`` says: how far it is, and what it has found."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS

if TYPE_CHECKING:
    from bt_mission.search.result import FoundFiles
    from bt_mission.search.search import Found, SearchState
    from bt_mission.search.session import SearchSession
    from bt_mission.sweeps.row import ScenarioRow


def warn_of(as_it_is: ScenarioRow) -> None:
    """Warn of a mission that does not succeed with nothing varied."""
    if as_it_is.outcome != "success":
        end = f"{as_it_is.outcome}: {as_it_is.reason}" if as_it_is.reason else as_it_is.outcome
        print(
            f"as it is, with nothing varied, the mission ends in {end}; --find failed tells of it "
            "at once",
            file=sys.stderr,
        )


def progress_line(state: SearchState, budget: int) -> str:
    """Return how far a search is."""
    if state.simplifying_runs:
        faults = ", ".join(str(len(one.candidate.faults)) for one in state.found)
        return f"found; minimized in {state.simplifying_runs} runs, faults left: {faults}"
    margin = "" if state.smallest is None else f", {smallest(state.smallest)}"
    causes = f", causes found: {len(state.found)}" if state.found else ""
    return f"{state.runs} of {budget} runs{causes}{margin}"


def smallest(found: tuple[float, str]) -> str:
    """Return the smallest margin in words."""
    share, name = found
    return f"smallest margin {share:.0%} of the usual one ('{name}')"


def tell(session: SearchSession, folder: Path, options: argparse.Namespace) -> int:
    """Write what was found, and say it; gives the exit code."""
    from bt_mission.search.result import write_all

    state = session.state
    files = write_all(session.base, state.found, folder, runs_again=not state.is_interrupted)
    if options.json:
        print(json.dumps(_as_dict(session, files, options)))
    else:
        print("\n".join(_lines(session, files)))
    if state.is_interrupted:
        return INTERRUPTED
    return MISSION_FAILED if state.found else SUCCESS


def _as_dict(
    session: SearchSession, files: list[FoundFiles], options: argparse.Namespace
) -> dict[str, Any]:
    state = session.state
    return {
        "mission": session.base.mission.name,
        "searched_for": session.aim,
        "strategy": options.strategy,
        "search_seed": options.search_seed,
        "budget": options.budget,
        "runs": state.runs,
        "errors": state.errors,
        "outside_assumptions": state.outside,
        "broke_the_reference": state.unfair,
        "simplifying_runs": state.simplifying_runs,
        "interrupted": state.is_interrupted,
        "smallest_margin": None
        if state.smallest is None
        else {"share": state.smallest[0], "requirement": state.smallest[1]},
        "found": [_find_as_dict(*one) for one in zip(state.found, files, strict=True)],
    }


def _find_as_dict(found: Found, files: FoundFiles) -> dict[str, Any]:
    return {
        "kind": found.failure.kind,
        "what": found.failure.what,
        "node": found.failure.node,
        "reason": found.failure.reason,
        "runs": found.runs,
        "sentence": files.sentence,
        "faults": [one.text for one in found.candidate.faults],
        "repeats": files.repeats,
        "trace_sha256": found.row.trace_sha256,
        "folder": str(files.folder),
        "scenario": str(files.scenario),
        "test": str(files.test),
        "recording": files.recording and str(files.recording),
        "report": files.report and str(files.report),
    }


def _lines(session: SearchSession, files: list[FoundFiles]) -> list[str]:
    state = session.state
    told: list[str] = []
    name = session.base.mission.name
    notes = f"; {state.errors} could not run: {state.first_error}" if state.errors else ""
    if state.outside:
        notes += f"; {state.outside} did not keep to the assumptions"
    if state.unfair:
        notes += f"; {state.unfair} broke the reference, too"
    runs = "1 run" if state.runs == 1 else f"{state.runs} runs"
    if not files:
        what = "interrupted" if state.is_interrupted else f"nothing found ({SOUGHT[session.aim]})"
        told.append(f"{name}: {what} in {runs}{notes}")
        if state.smallest is not None:
            told.append(f"  {smallest(state.smallest)}")
        return told
    if state.runs == 1:
        told.append(f"{name}: {files[0].sentence}")
        told.append("  it breaks as it is, with nothing varied: there is nothing to search for")
        return told + _files_of(files[0])
    effort = f"found after {runs}, minimized in {state.simplifying_runs}{notes}"
    if len(files) == 1:
        return [f"{name}: {files[0].sentence}", f"  {effort}", *_files_of(files[0])]
    told.append(f"{name}: {len(files)} causes {effort}")
    for number, (found, one) in enumerate(zip(state.found, files, strict=True), 1):
        times = "1 run" if found.runs == 1 else f"{found.runs} runs"
        told += [f"{number}. {one.sentence} ({times})", *_files_of(one)]
    return told


def _files_of(files: FoundFiles) -> list[str]:
    told = []
    if files.repeats is False:
        told.append("  the run of the file has another trace than the one of the search")
    return [
        *told,
        f"  {files.scenario}: bt-mission run repeats it",
        f"  {files.test}: fails until the mission is fixed",
        f"  {files.recording}, {files.report}: the run"
        if files.recording
        else f"  interrupted, so not run again: bt-mission run {files.scenario} --record FILE.mcap",
    ]


SOUGHT = {
    "violated": "no violated requirement",
    "failed": "no mission that fails",
    "orphaned": "no orphaned goal",
    "collision": "no collision",
    "anything": "no violated requirement, failed mission, orphaned goal or collision",
}
