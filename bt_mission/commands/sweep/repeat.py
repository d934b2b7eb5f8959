"""The origin of a sweep, kept beside its rows, and the command that runs a row again."""

from __future__ import annotations

import json
import shlex
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath
from typing import Any, Self

from pydantic import ConfigDict, TypeAdapter, ValidationError

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import within, write_file
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.commands.sweep.store import ResultStore
from bt_mission.scenarios.concrete.bundle import Bundle
from bt_mission.scenarios.concrete.concrete_scenario import concrete
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.scenarios.coverage.record import CoverageRecord
from bt_mission.scenarios.scenario import TIME_IS_UP

ORIGIN_KEY = "origin"
"""The key of the store's value."""

SCENARIOS = "scenarios"
"""The folder of the results for scenario files, with all that they need."""


@dataclass(frozen=True)
class RunOptions:
    """Options of `bt-mission run` that hold for every row."""

    set: dict[str, Any]
    fault: list[str]
    world: str | None
    robot: str | None


@dataclass(frozen=True)
class SweepOrigin:
    """The origin of a sweep: the places of its files, and their content.

    Attributes:
        path: The mission or the scenario as the user has named it.
        command: The line that has begun the sweep; empty where Python has.
        is_scenario: Is it a scenario rather than a mission?
        options: None where the options of `run` cannot say it.
        bundle: All files.
        places: What there is to reach in the mission.
    """

    __pydantic_config__ = ConfigDict(strict=True)

    path: str
    command: str
    is_scenario: bool
    options: RunOptions | None
    bundle: Bundle
    places: tuple[CoveragePlace, ...] = ()

    def save(self, store: ResultStore) -> None:
        """Keep it beside the rows."""
        store.set_value(ORIGIN_KEY, json.dumps(asdict(self), ensure_ascii=False))

    @classmethod
    def of(cls, store: ResultStore) -> Self | None:
        """Read the origin of results; None without one."""
        text = store.value(ORIGIN_KEY)
        try:
            return None if text is None else TypeAdapter(cls).validate_json(text)
        except ValidationError as error:
            what = "the files that the sweep was made from cannot be read"
            raise BtMissionError(
                f"{store.folder}: {what}: {error.errors()[0]['msg']}", code="BT-714"
            ) from None


def origin_of(plan: SweepPlan, command: str = "", path: str = "") -> SweepOrigin:
    """Return the origin of a plan.

    Args:
        command: The line that started the sweep.
        path: The user's name of the mission; if it is empty, its file.
    """
    base, changes = plan.base, plan.base.changes
    is_default = not changes.requirements and changes.limit is None
    faults = list(changes.faults)
    options = RunOptions(dict(changes.set), faults, changes.world, changes.robot)
    return SweepOrigin(
        path=path or str(base.path),
        command=command,
        is_scenario=base.is_scenario,
        options=options if is_default else None,
        bundle=base.bundle,
        places=CoverageRecord.of(base.mission).places,
    )


def resume_command(command: str) -> str:
    """Return the line that continues a sweep."""
    return command if not command or "--resume" in command.split() else f"{command} --resume"


class Repeater:
    """Returns the command that runs a row of results again.

    Args:
        store: The results.
    """

    def __init__(self, store: ResultStore) -> None:
        self._store = store
        self._about = store.about
        self.origin = SweepOrigin.of(store)

    def command(self, row: ScenarioRow) -> str:
        """Return a shell command that runs a row's scenario again."""
        words = self._options(row)
        if words is None:
            folder = self._store.folder
            made = shlex.join(["bt-mission", "sweep-report", str(folder), "--scenario", row.id])
            if self.origin is None:
                return made
            return f"{made} && {shlex.join(['bt-mission', 'run', str(self._path(row))])}"
        return shlex.join(["bt-mission", "run", *words])

    def _options(self, row: ScenarioRow) -> list[str] | None:
        """Return the words after `bt-mission run`; None if its options are not enough."""
        origin = self.origin
        if origin is None or origin.options is None or row.reason == TIME_IS_UP:
            return None
        given = asdict(origin.options)
        nature = self._about.scenario.get("nature")
        values = dict(given["set"])
        faults = [*given["fault"], *self._about.plans.get(row.plan, ())]
        for name, value in row.parameters.items():
            if name in ("world", "robot"):
                given[name] = value
            elif name.startswith("start."):
                return None
            else:
                values[name.removeprefix("inputs.")] = _as_text(value)
        if not all(isinstance(text, str) for text in faults):
            return None
        return [
            origin.path,
            "--seed",
            str(row.seed),
            *(word for name, value in values.items() for word in ("--set", f"{name}={value}")),
            *(word for name in ("world", "robot") for word in _option(name, given[name])),
            *(_option("nature", nature) if isinstance(nature, str) else ()),
            *(word for fault in faults for word in ("--fault", fault)),
        ]

    def write(self, row: ScenarioRow) -> Path:
        """Write the scenario of a row as a file among the results, with all that it needs.

        Raises:
            BtMissionError: Where the results do not hold what it was made from, or it cannot be
                written.
        """
        folder, about = self._store.folder, self._about
        if self.origin is None:
            raise BtMissionError(f"{folder}: contains no files of its mission", code="BT-714")
        bundle = self.origin.bundle
        try:
            scenario = concrete(
                about.scenario,
                bundle,
                row.parameters,
                number=row.number,
                seed=row.seed,
                faults=about.plans.get(row.plan, ()),
                plan=row.plan,
            )
        except KeyError as error:
            raise BtMissionError(
                f"{folder}: contains no world or robot {error}", code="BT-714"
            ) from None
        if scenario.id != row.id:
            raise BtMissionError(f"{folder}: the files of {row.id} have changed", code="BT-714")
        bundle.write_to(within(folder, SCENARIOS))
        path = self._path(row)
        remarks = [f"Scenario {row.number} of a sweep: {parameters_as_text(row)}."]
        if row.trace_sha256:
            remarks.append(f"Its trace was {row.trace_sha256}.")
        lines = "".join(f"# {escape_control(line)}\n" for line in remarks)
        data = {"scenario": scenario.data["scenario"], **scenario.data}
        write_file(path, lines + to_yaml(data))
        return path

    def _path(self, row: ScenarioRow) -> Path:
        assert self.origin is not None, "asked for where the files are known"
        beside = PurePosixPath(SCENARIOS, self.origin.bundle.mission)
        name = beside.with_name(f"{row.id}.scenario.yaml").as_posix()
        return within(self._store.folder, name)


def find_row(store: ResultStore, name: str) -> ScenarioRow:
    """Return the row of an id, of its first digits, or of a scenario's number.

    Raises:
        BtMissionError: No row matches, or several do.
    """
    rows = list(store.rows("id = ?", name))
    if not rows and name.isdecimal():
        rows = list(store.rows("number = ?", int(name)))
    if not rows and name.isalnum():
        rows = list(store.rows("substr(id, 1, ?) = ?", len(name), name))
    if len(rows) != 1:
        how = "several scenarios begin" if rows else "no scenario is called so or begins"
        raise BtMissionError(f"{store.folder}: {how} with '{name}'", code="BT-714")
    return rows[0]


def parameters_as_text(row: ScenarioRow) -> str:
    """Return the values of a row for people, with its seed and its plan of faults."""
    parts = [f"{name} {_as_text(value)}" for name, value in row.parameters.items()]
    parts.append(f"seed {row.seed}")
    if row.plan:
        parts.append(f"faults {row.plan}")
    return ", ".join(parts)


def _option(name: str, value: Any) -> list[str]:
    return [] if value is None else [f"--{name}", str(value)]


def _as_text(value: Any) -> str:
    """Return a value as `--set` takes it: a text as it is, anything else as YAML."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
