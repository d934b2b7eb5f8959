"""Results of a sweep for tests, made without a simulation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bt_mission.commands.sweep.repeat import RunOptions, SweepOrigin
from bt_mission.commands.sweep.store import ResultStore, SweepAbout
from bt_mission.scenarios.concrete.bundle import Bundle
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.coverage.places import CoveragePlace
from tests.support.rows import failed, margin, row

BUNDLE = Bundle(
    {
        "missions/go.yaml": "mission: go\ntree:\n  log: here\n",
        "worlds/hall.yaml": "world: hall\n",
        "robots/waffle.yaml": "robot: waffle\n",
    },
    "missions/go.yaml",
    {"mine/hall.yaml": "hall"},
    {"waffle": "waffle"},
)
ABOUT = SweepAbout(
    mission="go",
    mission_hash=BUNDLE.digest,
    scenario={"scenario": "go", "mission": "go.yaml", "robot": "waffle"},
    vary=["speed=0.1,0.2", "world=hall,yard"],
    seeds="0..9",
    plans={"none": [], "lost": ["at 2.0: drop scan lasting 2"]},
    scenarios=80,
)
PLACES = (
    CoveragePlace(
        "", "0", "go", "sequence", 1, 1, {"reached": 0, "outcome success": 0, "outcome failure": 0}
    ),
    CoveragePlace("", "0.0", "log", "log", 2, 3, {"reached": 0}),
)


def origin(**changes: Any) -> SweepOrigin:
    """What the sweep was made from."""
    given: dict[str, Any] = {
        "path": "mine/go.yaml",
        "command": "bt-mission sweep mine/go.yaml --seeds 10 --vary speed=0.1,0.2",
        "is_scenario": False,
        "options": RunOptions({}, [], None, None),
        "bundle": BUNDLE,
        "places": PLACES,
        **changes,
    }
    return SweepOrigin(**given)


def some_rows() -> Iterable[ScenarioRow]:
    """Rows of two speeds, two worlds, two plans and ten seeds."""
    number = 0
    for seed in range(10):
        for speed in (0.1, 0.2):
            for world in ("hall", "yard"):
                for plan in ("none", "lost"):
                    fails = plan == "lost" and (speed > 0.15 or seed == 3)
                    yield (failed if fails else row)(
                        number,
                        seed=seed,
                        parameters={"speed": speed, "world": world},
                        plan=plan,
                        virtual_s=20 + seed,
                        requirements={"keeps clear": margin(0.01 * seed - 0.005 * fails)},
                        coverage="d" if fails else "b",
                        versions="abc",
                    )
                    number += 1


@pytest.fixture
def results(tmp_path: Path) -> ResultStore:
    """Results in a folder, open for reading."""
    return write_results(tmp_path / "results", some_rows(), origin())


def write_results(
    folder: Path, rows: Iterable[ScenarioRow], made_from: SweepOrigin | None, **about: Any
) -> ResultStore:
    """Write results; return them open for reading."""
    with ResultStore.create(folder, replace(ABOUT, **about)) as store:
        if made_from is not None:
            made_from.save(store)
        store.set_value("versions abc", "bt-mission 1.2.3, mujoco 4.0")
        for added in rows:
            store.add(added)
    return ResultStore.read(folder)
