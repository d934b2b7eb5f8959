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
    from bt_mission.search.search import SearchState
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
    if state.found:
        size = len(state.found.candidate.faults)
        faults = "1 fault" if size == 1 else f"{size} faults"
        return f"found; made smaller in {state.simplifying_runs} runs, now {faults}"
    margin = "" if state.smallest is None else f", {smallest(state.smallest)}"
    return f"{state.runs} of {budget} runs{margin}"


def smallest(found: tuple[float, str]) -> str:
    """Return the smallest margin in words."""
    share, name = found
    return f"smallest margin {share:.0%} of the usual one ('{name}')"


def tell(session: SearchSession, folder: Path, options: argparse.Namespace) -> int:
    """Write what was found, and say it; gives the exit code."""
    from bt_mission.search.result import write_found

    state = session.state
    files = None
    if state.found is not None:
        files = write_found(session.base, state.found, folder, runs_again=not state.is_interrupted)
    if options.json:
        print(json.dumps(_as_dict(session, files, options)))
    else:
        print("\n".join(_lines(session, files)))
    if state.is_interrupted:
        return INTERRUPTED
    return MISSION_FAILED if state.found else SUCCESS


def _as_dict(
    session: SearchSession, files: FoundFiles | None, options: argparse.Namespace
) -> dict[str, Any]:
    state = session.state
    told: dict[str, Any] = {
        "mission": session.base.mission.name,
        "searched_for": session.aim,
        "strategy": options.strategy,
        "search_seed": options.search_seed,
        "budget": options.budget,
        "runs": state.runs,
        "errors": state.errors,
        "interrupted": state.is_interrupted,
        "smallest_margin": None
        if state.smallest is None
        else {"share": state.smallest[0], "requirement": state.smallest[1]},
        "found": None,
    }
    if files is not None and state.found is not None:
        told["found"] = {
            "kind": state.found.failure.kind,
            "what": state.found.failure.what,
            "sentence": files.sentence,
            "faults": [one.text for one in state.found.candidate.faults],
            "simplifying_runs": state.simplifying_runs,
            "repeats": files.repeats,
            "trace_sha256": state.found.row.trace_sha256,
            "folder": str(files.folder),
            "scenario": str(files.scenario),
            "test": str(files.test),
            "recording": files.recording and str(files.recording),
            "report": files.report and str(files.report),
        }
    return told


def _lines(session: SearchSession, files: FoundFiles | None) -> list[str]:
    state = session.state
    told: list[str] = []
    errors = f"; {state.errors} could not run: {state.first_error}" if state.errors else ""
    if files is None:
        what = "interrupted" if state.is_interrupted else f"nothing found ({SOUGHT[session.aim]})"
        runs = "1 run" if state.runs == 1 else f"{state.runs} runs"
        told.append(f"{session.base.mission.name}: {what} in {runs}{errors}")
        if state.smallest is not None:
            told.append(f"  {smallest(state.smallest)}")
        return told
    told.append(f"{session.base.mission.name}: {files.sentence}")
    if state.runs == 1:
        told.append("  it breaks as it is, with nothing varied: there is nothing to search for")
    else:
        told.append(f"  found in {state.runs} runs, made small in {state.simplifying_runs}{errors}")
    if files.repeats is False:
        told.append("  the run of the file has another trace than the one of the search")
    told += [
        f"  {files.scenario}: bt-mission run repeats it",
        f"  {files.test}: fails until the mission is mended",
        f"  {files.recording}, {files.report}: the run"
        if files.recording
        else f"  interrupted, so not run again: bt-mission run {files.scenario} --record FILE.mcap",
    ]
    return told


SOUGHT = {
    "violated": "no violated requirement",
    "failed": "no mission that fails",
    "orphaned": "no orphaned goal",
    "collision": "no collision",
    "anything": "no violated requirement, failed mission, orphaned goal or collision",
}
