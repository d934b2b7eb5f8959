"""What a sweep was made from: kept beside its rows, so that each of them can be repeated."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

from pydantic import BaseModel, ValidationError

from bt_mission.coverage.places import CoveragePlace
from bt_mission.coverage.record import CoverageRecord
from bt_mission.sweeps.bundle import Bundle
from bt_mission.sweeps.folder import StoreError
from bt_mission.sweeps.plan import SweepPlan
from bt_mission.sweeps.store import ResultStore

ORIGIN_KEY = "origin"
"""The key of the store's value."""


@dataclass(frozen=True)
class SweepOrigin:
    """What is known of a sweep besides what it is: where its files were, and all that they held.

    Attributes:
        path: The mission or the scenario as the user has named it.
        command: The line that has begun the sweep; empty where Python has.
        is_scenario: Is it a scenario rather than a mission?
        options: What `bt-mission run` must be told for every row: ``set``, ``fault``, ``world`` and
            ``robot``. None where its options cannot say it.
        bundle: All files.
        places: What there is to reach in the mission.
    """

    path: str
    command: str
    is_scenario: bool
    options: Mapping[str, Any] | None
    bundle: Bundle
    places: tuple[CoveragePlace, ...] = field(default=())

    def save(self, store: ResultStore) -> None:
        """Keep it beside the rows."""
        store.set_value(ORIGIN_KEY, json.dumps(asdict(self), ensure_ascii=False))

    @classmethod
    def of(cls, store: ResultStore) -> Self | None:
        """Read that of results; None where they have none."""
        text = store.value(ORIGIN_KEY)
        if text is None:
            return None
        try:
            found = _Origin.model_validate_json(text, strict=True).model_dump()
        except ValidationError as error:
            what = (
                f"the files that the sweep was made from cannot be read: {error.errors()[0]['msg']}"
            )
            raise StoreError(f"{store.folder}: {what}") from None
        found["bundle"] = Bundle(**found["bundle"])
        found["places"] = tuple(CoveragePlace(**one) for one in found["places"])
        return cls(**found)


class _Bundle(BaseModel):
    """Of a :class:`Bundle`, as it is written."""

    files: dict[str, str]
    mission: str
    worlds: dict[str, str]
    robots: dict[str, str]
    folder: str


class _Options(BaseModel):
    """Of the options of a :class:`SweepOrigin`, as they are written."""

    set: dict[str, Any]
    fault: list[str]
    world: str | None
    robot: str | None


class _Origin(BaseModel):
    """Of a :class:`SweepOrigin`, as it is written."""

    path: str
    command: str
    is_scenario: bool
    options: _Options | None
    bundle: _Bundle
    places: tuple[CoveragePlace, ...]


def origin_of(plan: SweepPlan, command: str = "", path: str = "") -> SweepOrigin:
    """Return what a plan was made from.

    Args:
        command: The line that has begun the sweep.
        path: What the user has called the mission; where it is empty, its file.
    """
    base, changes = plan.base, plan.base.changes
    options: dict[str, Any] | None = {
        "set": dict(changes.set),
        "fault": list(changes.faults),
        "world": changes.world,
        "robot": changes.robot,
    }
    if changes.requirements or changes.limit is not None:
        options = None
    return SweepOrigin(
        path=path or str(base.path),
        command=command,
        is_scenario=base.is_scenario,
        options=options,
        bundle=base.bundle,
        places=CoverageRecord.of(base.mission).places,
    )


def resume_command(command: str) -> str:
    """Return the line that goes on with a sweep."""
    words: Sequence[str] = command.split()
    return command if not command or "--resume" in words else f"{command} --resume"
