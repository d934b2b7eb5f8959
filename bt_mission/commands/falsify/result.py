"""The results of a search: a sentence and a folder with the files of each counterexample."""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Any

from bt_mission.base.files import Kind, find, folders
from bt_mission.base.output import make_folder_of, write_file
from bt_mission.base.text import seconds
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.cli.recorded_scenario import record_scenario
from bt_mission.commands.falsify.candidate import Candidate, given_world
from bt_mission.commands.falsify.guide import FoundFailure, is_hidden
from bt_mission.commands.falsify.search import Counterexample
from bt_mission.executive.report import Report
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.faults.planned import Beginning, PlannedFault, Value, WhenTrue
from bt_mission.scenarios.faults.world import OBSTACLES
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.writer import mission_as_data
from bt_mission.views.web.report.page import write_report


@dataclass(frozen=True)
class CounterexampleFiles:
    """The files of a counterexample.

    Attributes:
        recording: The recording of a run of the scenario from its file; None without a run.
        report: The report of the recording.
        sentence: The failure as a sentence.
        repeats: Whether the trace of that run is that of the search; None without a run.
    """

    folder: Path
    scenario: Path
    recording: Path | None
    report: Path | None
    sentence: str
    repeats: bool | None


def write_all(
    base: BaseScenario,
    counterexamples: Sequence[Counterexample],
    folder: Path,
    *,
    runs_again: bool = True,
) -> list[CounterexampleFiles]:
    """Write counterexamples into a folder, each under a unique name, and run each again from there.

    Args:
        runs_again: Run each again. Without that there are no recordings. A run may take minutes.

    Raises:
        BtMissionError: A file cannot be written.
    """
    written: dict[str, CounterexampleFiles] = {}
    for counterexample in counterexamples:
        stem = _name(counterexample.failure)
        others = (f"{stem}_{number}" for number in count(2))
        name = next(name for name in chain([stem], others) if name not in written)
        written[name] = _write_found(base, counterexample, folder, name, runs_again=runs_again)
    return list(written.values())


def _write_found(
    base: BaseScenario, counterexample: Counterexample, folder: Path, name: str, *, runs_again: bool
) -> CounterexampleFiles:
    scenario = folder / f"{name}.scenario.yaml"
    make_folder_of(scenario)
    recording, page = folder / f"{name}.mcap", folder / f"{name}.html"
    text = to_yaml(scenario_data(base, counterexample, folder))
    write_file(scenario, text)
    report = record_scenario(load_scenario(scenario), recording).report if runs_again else None
    summary = sentence(counterexample.failure, report, counterexample.candidate)
    full = textwrap.fill(f"{summary[0].upper()}{summary[1:]}.", 90, break_on_hyphens=False)
    head = f"{textwrap.indent(full, '# ')}\n#\n#   bt-mission run {scenario}\n\n"
    write_file(scenario, head + text)
    if report is None:
        return CounterexampleFiles(folder, scenario, None, None, summary, None)
    write_report(recording, page)
    is_same = report.trace_sha256 == counterexample.row.trace_sha256
    return CounterexampleFiles(folder, scenario, recording, page, summary, is_same)


def scenario_data(
    base: BaseScenario, counterexample: Counterexample, folder: Path
) -> dict[str, Any]:
    """Return the content of the scenario's file; paths are relative to its folder."""
    made = dict(counterexample.candidate.concrete(base, 0).data)
    of_mission = _mission(base, counterexample, made, folder)
    for key in ("mission", "world", "robot", "inputs", "expect"):
        made.pop(key, None)
    given = made.pop("requirements", {})
    requirements = {name: requirement for name, requirement in given.items() if not is_hidden(name)}
    name = f"{base.mission.name}: {_phrase(counterexample.failure)}"
    head = {"scenario": name[:200], **of_mission}
    if counterexample.candidate.seed is None and "seed" not in base.data:
        made.pop("seed")  # the mission has it
    if counterexample.row.outcome != "interrupted" and "limit" not in base.data:
        made.pop("limit", None)  # the run ends without a limit
    rest = {key: value for key, value in made.items() if key not in ("scenario", "description")}
    data = {**head, **rest}
    if requirements:
        data["requirements"] = requirements
    data["expect"] = _expected(counterexample)
    return data


# ---- the scenario's file ---------------------------------------------------------------------


def _mission(
    base: BaseScenario, counterexample: Counterexample, made: dict[str, Any], folder: Path
) -> dict[str, Any]:
    """Return mission, world, robot and inputs where they differ from the mission."""
    values = counterexample.candidate.values
    inputs = {
        **base.mission.inputs,
        **{name: value for name, value in values.items() if name in base.mission.inputs},
    }
    mission = replace(base.mission, inputs=inputs)
    data: dict[str, Any]
    if isinstance(made.get("mission"), dict):
        data = {"mission": made["mission"]}
        for key in ("robot", "inputs"):
            if made.get(key):
                data[key] = made[key]
        if data.get("robot") in (None, made["mission"].get("robot", "waffle")):
            data.pop("robot", None)
    else:
        data = mission_as_data(mission, folder)
        data.pop("world", None)
        data["mission"] = _by_name("missions", Path(base.mission.file), data["mission"])
    world = made.get("world")
    if isinstance(world, dict):
        data["world"] = world
    elif isinstance(world, str):
        given = given_world(base, world)
        file = find("worlds", given, near=base.mission.file)
        if given != _own_world(base):
            relative = Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
            data["world"] = _by_name("worlds", file, relative)
    return data


def _own_world(base: BaseScenario) -> str | None:
    """Return the world of the mission's file."""
    document = base.mission.document
    head = document.data if isinstance(document.data, dict) else {}
    world = head.get("world")
    return world if isinstance(world, str) else None


def _by_name(kind: Kind, file: Path, relative: str) -> str:
    """Return the name of a file that is installed with bt-mission, or else its path."""
    return file.stem if file.resolve().parent == folders(kind)[-1].resolve() else relative


def _expected(counterexample: Counterexample) -> dict[str, Any]:
    """Return the expectation: for other failures, any end."""
    row, failure = counterexample.row, counterexample.failure
    if failure.kind == "failed":
        return {"outcome": "success"}
    expected: dict[str, Any] = {"outcome": "any"}
    if failure.kind == "collision":
        expected["collisions"] = 0
    if failure.kind != "orphaned" and row.orphaned_goals:
        expected["orphaned_goals"] = "any"
    return expected


def _phrase(failure: FoundFailure) -> str:
    match failure.kind:
        case "violated":
            return f"violates '{failure.what}'"
        case "collision":
            return "touches something"
        case "orphaned":
            return "orphans a goal"
    return f"fails in '{failure.what}'"


def _name(failure: FoundFailure) -> str:
    text = failure.what if failure.kind == "violated" else f"{failure.kind} {failure.what}"
    words = re.findall(r"[a-z0-9]+", text.lower()) or [failure.kind]
    return "_".join(words)[:60].rstrip("_")


# ---- the sentence ----------------------------------------------------------------------------


def sentence(failure: FoundFailure, report: Report | None, candidate: Candidate) -> str:
    """Return the failure and its conditions as a sentence.

    Args:
        report: The report of the run; None omits its facts, such as the margin.
        candidate: The differences from the mission as it is.
    """
    return " ".join([_what(failure, report), *_when(candidate)])


def _what(failure: FoundFailure, report: Report | None) -> str:
    match failure.kind:
        case "violated":
            results = () if report is None else report.requirements
            outcomes = (result.outcome for result in results if result.name == failure.what)
            return f"requirement '{failure.what}' is {next(outcomes, 'violated')}"
        case "collision":
            count = 1 if report is None else report.collisions or 0
            return f"the robot touches something{'' if count == 1 else f' {count} times'}"
        case "orphaned":
            if report is None:
                return "a goal is orphaned"
            count = report.goals_left_behind
            goals = "a goal is" if count == 1 else f"{count} goals are"
            return f"{goals} orphaned: no server confirms the end"
    if report is None:
        return f"the mission fails in '{failure.what}'"
    if report.status == "interrupted":
        return f"the mission has not ended at {report.virtual_s:g} s"
    leaf = f": '{report.failure.nodes[-1]}' fails" if report.failure else ""
    reason = (report.reason.splitlines() or ["no reason"])[0]
    return f"the mission fails at {seconds(report.virtual_s)}{leaf} ({reason})"


def _when(candidate: Candidate) -> list[str]:
    """Return the conditions; without any, the mission breaks as it is."""
    faults = [_fault(fault) for fault in candidate.faults]
    others = [f"{name}={value}" for name, value in _others(candidate.values).items()]
    if candidate.seed is not None:
        others.append(f"seed {candidate.seed}")
    if not faults and not others:
        return ["without any fault"]
    parts = [f"when {_listed(faults)}"] if faults else []
    return [*parts, f"with {_listed(others)}"] if others else parts


def _others(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with the start as one place."""
    place = [values[f"start.{axis}"] for axis in ("x", "y", "yaw") if f"start.{axis}" in values]
    rest = {name: value for name, value in values.items() if not name.startswith("start.")}
    return (
        {**rest, "start": f"({', '.join(f'{coordinate:g}' for coordinate in place)})"}
        if place
        else rest
    )


def _fault(fault: PlannedFault) -> str:
    at = _beginning(fault.begins)
    if fault.name in OBSTACLES and "ahead" in fault.arguments:
        what = "a box" if fault.name == "spawn_box" else "a cylinder"
        return f"{what} appears {_place(fault.arguments)} {at}"
    if fault.name == "move_box" and "ahead" in fault.arguments:
        speed = fault.arguments.get("speed", 0.5)
        return f"it moves at {speed:g} m/s to {_place(fault.arguments)} {at}"
    call = fault.call.partition(" lasting ")[0]
    lasting = "" if fault.lasting is None else f" for {fault.lasting:g} s"
    return f"'{call}' begins {at}{lasting}"


def _beginning(begins: Beginning) -> str:
    if isinstance(begins, WhenTrue):
        held = f" for {begins.held_s:g} s" if begins.held_s else ""
        return f"once {begins.condition.text}{held}"
    return f"at {begins.time_s:g} s"


def _place(arguments: Mapping[str, Value]) -> str:
    ahead, left = arguments["ahead"], arguments.get("left", 0.0)
    assert isinstance(ahead, int | float), "it is a length"
    assert isinstance(left, int | float), "it is a length"
    where = f"{abs(ahead):g} m {'ahead' if ahead >= 0 else 'behind'}"
    if left:
        where += f" and {abs(left):g} m to the {'left' if left > 0 else 'right'}"
    return where


def _listed(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
