"""What a search has found, as a folder: a scenario, its test, its recording and its report."""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Any

from bt_mission.core.files import Kind, find, folders
from bt_mission.core.output import cannot_write, write_file
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.writer import mission_as_data
from bt_mission.search.guide import Failure, is_hidden
from bt_mission.search.search import Found
from bt_mission.search.sentence import sentence
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.recording import record_scenario, write_page_of

TEST = '''"""{sentence}

Found by bt-mission falsify; it passes once the mission is fixed. To look at it:
bt-mission run {file}
"""

from pathlib import Path

import bt_mission


def test_{name}():
    scenario = Path(__file__).with_name("{file}")
    result = bt_mission.run_scenario(scenario)
    assert result.passed, str(result)
'''


@dataclass(frozen=True)
class FoundFiles:
    """What was written of a find.

    Attributes:
        recording: Of a run of the scenario from its file; None where it was not run again.
        report: The page of the recording.
        sentence: What breaks.
        repeats: Is the trace of that run the one of the search? None where it was not run again.
    """

    folder: Path
    scenario: Path
    test: Path
    recording: Path | None
    report: Path | None
    sentence: str
    repeats: bool | None


def write_all(
    base: BaseScenario, found: Sequence[Found], folder: Path, *, runs_again: bool = True
) -> list[FoundFiles]:
    """Write finds into a folder, each under a name of its own, and run each once more from there.

    Args:
        runs_again: Without that there are no recordings. A run may take minutes.

    Raises:
        BtMissionError: When one cannot be written.
    """
    written: dict[str, FoundFiles] = {}
    for one in found:
        stem = _name(one.failure)
        others = (f"{stem}_{number}" for number in count(2))
        name = next(name for name in chain([stem], others) if name not in written)
        written[name] = write_found(base, one, folder, name, runs_again=runs_again)
    return list(written.values())


def write_found(
    base: BaseScenario, found: Found, folder: Path, name: str, *, runs_again: bool = True
) -> FoundFiles:
    """Write a find into a folder, and run it once more from there.

    Args:
        name: Of its files.
        runs_again: As of `write_all`.

    Raises:
        BtMissionError: When it cannot be written.
    """
    scenario = folder / f"{name}.scenario.yaml"
    test = folder / f"test_{name}.py"
    recording, page = folder / f"{name}.mcap", folder / f"{name}.html"
    data = scenario_data(base, found, folder)
    _write(scenario, to_yaml(data))
    report = record_scenario(load_scenario(scenario), recording) if runs_again else None
    told = sentence(found.failure, report, found.candidate)
    full = textwrap.fill(f"{told[0].upper()}{told[1:]}.", 90, break_on_hyphens=False)
    head = f"{textwrap.indent(full, '# ')}\n#\n#   bt-mission run {scenario}\n\n"
    _write(scenario, head + to_yaml(data))
    quoted = full.replace("\\", "\\\\").replace('"', "'")
    _write(test, TEST.format(sentence=quoted, name=name, file=scenario.name))
    if report is None:
        return FoundFiles(folder, scenario, test, None, None, told, None)
    write_page_of(recording, page)
    is_same = report.trace_sha256 == found.row.trace_sha256
    return FoundFiles(folder, scenario, test, recording, page, told, is_same)


def scenario_data(base: BaseScenario, found: Found, folder: Path) -> dict[str, Any]:
    """Return what stands in the file of the scenario; paths are relative to its folder."""
    made = dict(found.candidate.concrete(base, 0).data)
    of_mission = _mission(base, found, folder)
    for key in ("mission", "world", "robot", "inputs", "expect"):
        made.pop(key, None)
    given = made.pop("requirements", {})
    requirements = {name: one for name, one in given.items() if not is_hidden(name)}
    name = f"{base.mission.name}: {_phrase(found.failure)}"
    head = {"scenario": name[:200], **of_mission}
    if found.candidate.seed is None and "seed" not in base.data:
        made.pop("seed")  # the mission says it
    if found.row.outcome != "interrupted" and "limit" not in base.data:
        made.pop("limit", None)  # the run ends by itself
    rest = {key: one for key, one in made.items() if key not in ("scenario", "description")}
    data = {**head, **rest}
    if requirements:
        data["requirements"] = requirements
    data["expect"] = _expected(found)
    return data


# ---- the scenario's file ---------------------------------------------------------------------


def _mission(base: BaseScenario, found: Found, folder: Path) -> dict[str, Any]:
    """Return mission, world, robot and inputs, as far as they are not what the mission says."""
    values = found.candidate.values
    inputs = {
        **base.mission.inputs,
        **{one: value for one, value in values.items() if one in base.mission.inputs},
    }
    made = found.candidate.concrete(base, 0).data
    mission = replace(base.mission, inputs=inputs)
    told: dict[str, Any]
    if isinstance(made.get("mission"), dict):
        told = {"mission": made["mission"]}
        for key in ("robot", "inputs"):
            if made.get(key):
                told[key] = made[key]
        if told.get("robot") in (None, made["mission"].get("robot", "waffle")):
            told.pop("robot", None)
    else:
        told = mission_as_data(mission, folder)
        told.pop("world", None)
        told["mission"] = _by_name("missions", Path(base.mission.file), told["mission"])
    world = made.get("world")
    if isinstance(world, dict):
        told["world"] = world
    elif isinstance(world, str):
        given = next(path for path, name in base.bundle.worlds.items() if name == world)
        file = find("worlds", given, near=base.mission.file)
        if given != _own_world(base):
            relative = Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
            told["world"] = _by_name("worlds", file, relative)
    return told


def _own_world(base: BaseScenario) -> str | None:
    """Return the world that the mission itself says."""
    document = base.mission.document
    head = document.data if isinstance(document.data, dict) else {}
    found = head.get("world")
    return found if isinstance(found, str) else None


def _by_name(kind: Kind, file: Path, relative: str) -> str:
    """Return the name of a file that is installed with bt-mission, or else its path."""
    return file.stem if file.resolve().parent == folders(kind)[-1].resolve() else relative


def _expected(found: Found) -> dict[str, Any]:
    """Return what should hold: of all else any end will do."""
    row, failure = found.row, found.failure
    if failure.kind == "failed":
        return {"outcome": "success"}
    expected: dict[str, Any] = {"outcome": "any"}
    if failure.kind == "collision":
        expected["collisions"] = 0
    if failure.kind != "orphaned" and row.orphaned_goals:
        expected["orphaned_goals"] = "any"
    return expected


def _phrase(failure: Failure) -> str:
    match failure.kind:
        case "violated":
            return f"violates '{failure.what}'"
        case "collision":
            return "touches something"
        case "orphaned":
            return "orphans a goal"
    return f"fails in '{failure.what}'"


def _name(failure: Failure) -> str:
    text = failure.what if failure.kind == "violated" else f"{failure.kind} {failure.what}"
    words = re.findall(r"[a-z0-9]+", text.lower()) or [failure.kind]
    return "_".join(words)[:60].rstrip("_")


def _write(path: Path, text: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path, error) from error
    write_file(path, text)
