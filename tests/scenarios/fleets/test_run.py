"""A fleet carried out by a program: what pytest asserts of it."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

import bt_mission
from bt_mission.base import files
from bt_mission.scenarios.fleets.report import FleetReport, RobotReport
from bt_mission.scenarios.fleets.run import run_fleet


def waiting(*waits_s: float, **changes: Any) -> FleetReport:
    """What two robots come to that only wait."""
    plan = bt_mission.load_fleet(files.find("missions", "fleets/two_wanderers.fleet.yaml"))
    missions = (
        bt_mission.load(f"mission: waits\ntree: {{wait: {wait_s}}}\n") for wait_s in waits_s
    )
    robots = tuple(
        dataclasses.replace(robot, mission=mission)
        for robot, mission in zip(plan.robots, missions, strict=True)
    )
    return run_fleet(dataclasses.replace(plan, robots=robots), **changes)


@pytest.fixture(scope="module")
def still() -> FleetReport:
    """What two robots come to with another seed than that of their file."""
    return waiting(0.1, 0.1, seed=3)


@pytest.mark.thorough
def test_the_seeds_of_the_missions_count_up_from_that_of_the_run(still: FleetReport) -> None:
    """The page of fleets shows what a run with the seed of its file comes to."""
    assert [robot.mission.seed for robot in still.robots] == [3, 4]
    assert (still.status, still.passed) == ("success", True)


@pytest.mark.thorough
def test_a_contact_of_two_robots_counts_once_and_apart(still: FleetReport) -> None:
    """Each robot has counted it; those with the world are what is left of its collisions."""

    def touching(robot_report: RobotReport, collisions: int, others: dict[str, int]) -> RobotReport:
        mission = dataclasses.replace(robot_report.mission, collisions=collisions)
        return dataclasses.replace(robot_report, mission=mission, collisions_with=others)

    first, second = still.robots
    report = dataclasses.replace(
        still,
        robots=(touching(first, 3, {"burger1": 2}), touching(second, 2, {"waffle1": 2})),
    )
    assert (report.collisions_with_world, report.collisions_among_robots) == (1, 2)
    assert "  collisions: 1 with the world, 2 among robots" in str(report).splitlines()
    reports: list[dict[str, Any]] = report.as_dict()["robots"]
    assert [robot["collisions"] for robot in reports] == [3, 2]
    assert [item["collisions_with_world"] for item in reports] == [1, 0]
    assert reports[0]["collisions_with_robots"] == {"burger1": 2}


@pytest.mark.parametrize(
    ("ends", "status"),
    [
        (("success", "success"), "success"),
        (("success", "failure"), "failure"),
        (("failure", "interrupted"), "interrupted"),
    ],
)
def test_the_status_is_that_of_the_worst_mission(
    still: FleetReport, ends: tuple[str, str], status: str
) -> None:
    """Success only where all have succeeded."""
    robots = tuple(
        dataclasses.replace(first, mission=dataclasses.replace(first.mission, status=end))
        for first, end in zip(still.robots, ends, strict=True)
    )
    assert dataclasses.replace(still, robots=robots).status == status


@pytest.mark.thorough
def test_the_real_time_factor_of_a_robot_is_that_of_its_own_mission() -> None:
    """One that has ended long before the others has not taken their wall time."""
    report = waiting(0.1, 60)
    first, second = (robot.mission for robot in report.robots)
    assert first.wall_s < second.wall_s / 2
    assert second.wall_s <= report.wall_s
