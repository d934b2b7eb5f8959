"""How one row of a sweep is carried out again: a line for the shell, or a scenario file."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from bt_mission.core.output import write_file
from bt_mission.core.text import escape_control
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.scenarios.scenario import TIME_IS_UP
from bt_mission.sweeps.concrete import ConcreteScenario, varied
from bt_mission.sweeps.folder import StoreError, within
from bt_mission.sweeps.origin import SweepOrigin
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.store import ResultStore

SCENARIOS = "scenarios"
"""The folder of the results for scenario files, with all that they need."""


class Repeater:
    """Says for each row of results how it is carried out again.

    Args:
        store: The results.
    """

    def __init__(self, store: ResultStore) -> None:
        self._store = store
        self._about = store.about
        self.origin = SweepOrigin.of(store)

    def command(self, row: ScenarioRow) -> str:
        """Return a line for the shell that carries a row's scenario out again."""
        words = self._options(row)
        if words is None:
            folder = self._store.folder
            made = shlex.join(["bt-mission", "sweep-report", str(folder), "--scenario", row.id])
            if self.origin is None:
                return made
            return f"{made} && {shlex.join(['bt-mission', 'run', str(self._path(row))])}"
        return shlex.join(["bt-mission", "run", *words])

    def _options(self, row: ScenarioRow) -> list[str] | None:
        """The words after `bt-mission run`; None where its options cannot say it all."""
        origin = self.origin
        if origin is None or origin.options is None or row.reason == TIME_IS_UP:
            return None
        given = dict(origin.options)
        nature = self._about["scenario"].get("nature")
        values = dict(given["set"])
        faults = [*given["fault"], *self._about.get("plans", {}).get(row.plan, ())]
        for name, value in row.parameters.items():
            if name in ("world", "robot"):
                given[name] = value
            elif name.startswith("start."):
                return None
            else:
                values[name.removeprefix("inputs.")] = _as_text(value)
        if not all(isinstance(one, str) for one in faults):
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

    def scenario(self, row: ScenarioRow) -> ConcreteScenario:
        """Return the scenario of a row, with the names of the bundle.

        Raises:
            StoreError: Where the results do not hold what it was made from.
        """
        if self.origin is None:
            raise StoreError(f"{self._store.folder}: holds no files of its mission")
        bundle = self.origin.bundle
        try:
            data = varied(self._about["scenario"], row.parameters, bundle)
        except KeyError as error:
            raise StoreError(f"{self._store.folder}: holds no world or robot {error}") from None
        data["seed"] = row.seed
        if more := self._about.get("plans", {}).get(row.plan, ()):
            data["faults"] = [*data.get("faults", ()), *more]
        made = ConcreteScenario(row.number, data, row.parameters, row.plan, bundle.digest)
        if made.id != row.id:
            raise StoreError(f"{self._store.folder}: what {row.id} was made from has changed")
        return made

    def write(self, row: ScenarioRow) -> Path:
        """Write the scenario of a row as a file among the results, with all that it needs.

        Raises:
            BtMissionError: Where it is not known, or cannot be written.
        """
        scenario = self.scenario(row)
        assert self.origin is not None, "the scenario has come from it"
        bundle = self.origin.bundle
        bundle.write_to(within(self._store.folder, SCENARIOS))
        path = self._path(row)
        remarks = "".join(f"# {escape_control(line)}\n" for line in self._remarks(row))
        data = {"scenario": scenario.data["scenario"], **scenario.data}
        write_file(path, remarks + to_yaml(data))
        return path

    def _path(self, row: ScenarioRow) -> Path:
        assert self.origin is not None, "asked for where the files are known"
        beside = PurePosixPath(SCENARIOS, self.origin.bundle.mission)
        name = beside.with_name(f"{row.id}.scenario.yaml").as_posix()
        return within(self._store.folder, name)

    def _remarks(self, row: ScenarioRow) -> Iterator[str]:
        yield f"Scenario {row.number} of a sweep: {told_parameters(row) or f'seed {row.seed}'}."
        if row.trace_sha256:
            yield f"Its trace was {row.trace_sha256}."


def find_row(store: ResultStore, name: str) -> ScenarioRow:
    """Return the row of an id, of its first digits, or of a scenario's number.

    Raises:
        StoreError: Where there is none, or several.
    """
    found = list(store.rows("id = ?", name))
    if not found and name.isdecimal():
        found = list(store.rows("number = ?", int(name)))
    if not found and name.isalnum():
        found = list(store.rows("substr(id, 1, ?) = ?", len(name), name))
    if len(found) != 1:
        how = "several scenarios begin" if found else "no scenario is called so or begins"
        raise StoreError(f"{store.folder}: {how} with '{name}'")
    return found[0]


def told_parameters(row: ScenarioRow) -> str:
    """Return the values of a row for people, with its seed and its plan of faults."""
    parts = [f"{name} {_as_text(value)}" for name, value in row.parameters.items()]
    parts.append(f"seed {row.seed}")
    if row.plan:
        parts.append(f"faults {row.plan}")
    return ", ".join(parts)


def _option(name: str, value: Any) -> list[str]:
    return [] if value is None else [f"--{name}", str(value)]


def _as_text(value: Any) -> str:
    """Return a value as `--set` takes it: a text as it is, all else as YAML reads it."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
