"""The mission that fetches a cube: where the cube ends, what happens without it, and twice."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.core.files import find

WORLD = find("worlds", "fetch_arena").read_text(encoding="utf-8")
GRIPPER = "gripper_controller/gripper_cmd"


def fetched(stage: Any, world: str = WORLD) -> tuple[Any, tuple[float, float, float] | None]:
    """Run the mission to its end; return the run and the place of the cube."""
    run = stage.run("fetch", world=world)
    run.until_done()
    return run, run.stage.sim.physics.objects.get("cube")


def pauses(run: Any) -> list[str]:
    """Return what the mission logged."""
    return [event["text"] for event in run.events("log")]


def test_the_cube_is_laid_down_at_home_twice_the_same(stage: Any) -> None:
    """On the mark, upright, without a collision; both runs have one trace."""
    runs = [fetched(stage) for _ in range(2)]
    for run, cube in runs:
        assert (run.status, run.report.goals_left_behind) == ("success", 0)
        assert cube == pytest.approx((0.13, 0.0, 0.015), abs=0.01)
        assert run.stage.runs[0].collisions == 0
    (first, _), (second, _) = runs
    assert first.report.trace_sha256 == second.report.trace_sha256
    assert runs[0][1] == runs[1][1]


def test_a_gripper_that_closes_on_nothing_searches_further(stage: Any) -> None:
    """The cube lies 6 cm further than the mission takes it: the third attempt holds it."""
    run, cube = fetched(stage, WORLD.replace("x: 1.0, y: 0.0, size", "x: 1.06, y: 0.0, size"))
    assert run.status == "success"
    assert cube == pytest.approx((0.13, 0.0, 0.015), abs=0.015)
    assert len([line for line in pauses(run) if "closed on nothing" in line]) == 2


def test_without_a_cube_the_mission_fails_and_leaves_no_goal(stage: Any) -> None:
    """After three attempts, with the arm up and the gripper open."""
    run, _ = fetched(stage, WORLD[: WORLD.index("objects:")])
    assert (run.status, run.report.goals_left_behind) == ("failure", 0)
    assert len([line for line in pauses(run) if "closed on nothing" in line]) == 3
    joints = run.stage.sim.robots[0].servos.readings["position"]
    assert joints[-1] == pytest.approx(0.019, abs=1e-3)
    assert joints[1] == pytest.approx(0.577, abs=0.03)
