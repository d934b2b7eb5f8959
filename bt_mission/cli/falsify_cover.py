"""``bt-mission falsify --cover``: what no run of a mission reaches."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from bt_mission.cli.exits import INTERRUPTED, SUCCESS

if TYPE_CHECKING:
    from bt_mission.search.cover import CoverSession, CoverState


def progress_line(state: CoverState, budget: int) -> str:
    """Return how far it is."""
    return f"{reached(state)} reached in {state.runs} of {budget} runs"


def reached(state: CoverState) -> str:
    """Return how much was reached."""
    return f"{len(state.record.reached)} of {len(state.record.names)} places"


def tell(session: CoverSession, options: argparse.Namespace) -> int:
    """Say what was reached, and what was not; gives the exit code."""
    state = session.state
    if options.json:
        print(json.dumps(_as_dict(session, options)))
    else:
        print("\n".join(_lines(session)))
    return INTERRUPTED if state.is_interrupted else SUCCESS


def _as_dict(session: CoverSession, options: argparse.Namespace) -> dict[str, Any]:
    state = session.state
    return {
        "mission": session.base.mission.name,
        "searched_for": "coverage",
        "strategy": options.strategy,
        "search_seed": options.search_seed,
        "budget": options.budget,
        "runs": state.runs,
        "errors": state.errors,
        "interrupted": state.is_interrupted,
        "places": len(state.record.names),
        "reached": list(state.record.reached),
        "missing": list(state.record.missing),
        "scenarios": [
            {
                "run": row.number,
                "seed": row.seed,
                "parameters": dict(row.parameters),
                "faults": list(row.faults),
                "reached_first": list(new),
            }
            for _, row, new in state.first
        ],
    }


def _lines(session: CoverSession) -> list[str]:
    state = session.state
    errors = f"; {state.errors} could not run: {state.first_error}" if state.errors else ""
    runs = "1 run" if state.runs == 1 else f"{state.runs} runs"
    told = [f"{session.base.mission.name}: {reached(state)} of the tree reached in {runs}{errors}"]
    for _, row, new in state.first[1:]:
        faults = "; ".join(row.faults) or "no fault"
        told.append(f"  {', '.join(new)}")
        told.append(f"    first with seed {row.seed}, {faults}")
    if state.record.missing:
        told.append("never reached:")
        told += [f"  {one}" for one in state.record.missing]
    return told
