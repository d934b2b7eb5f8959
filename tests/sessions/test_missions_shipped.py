"""The missions that are shipped do what their descriptions say, by the true pose."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from bt_mission.base.files import find, names
from bt_mission.robots.model import load_robot
from sim.world.loader import load_world
from tests.support.paths import path_length
from tests.support.thorough import sample

CONTROL_STEP_S = 0.05
EACH_TIME = ("explore",)
"""Without `--thorough`; the other strategies of exploration are in test_exploration.py."""


WITH_MORE: dict[str, Callable[[Any, Path], None]] = {}
"""What the descriptions of some missions say besides."""


def says(check: Callable[[Any, Path], None]) -> Callable[[Any, Path], None]:
    """Check the run of the mission that the name of the function begins with."""
    WITH_MORE[check.__name__.partition("_")[0]] = check
    return check


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in EACH_TIME else pytest.mark.thorough)
        for name in names("missions")
    ],
)
def test_each_mission_succeeds_without_collision_and_leaves_no_goal_behind(
    stage: Any, name: str, tmp_path: Path
) -> None:
    """As shipped, on its own world, robot and seed; and as its description says."""
    run = stage.run(name)
    run.until_done()
    assert (run.status, run.reason) == ("success", "")
    assert run.report.goals_left_behind == 0
    assert run.stage.runs[0].collisions == 0
    WITH_MORE.get(name, lambda *_: None)(run, tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", sample([1, 2, 3], every=3))
def test_no_leg_of_explore_is_longer_than_two_metres_and_the_way_to_stop(
    stage: Any, seed: int
) -> None:
    """A leg is cancelled at the first feedback over 2 m; one control step and braking follow."""
    run = stage.run("explore", seed=seed, world="empty_arena")
    run.until_done()
    assert run.status == "success"
    drives = [e for e in run.events("status") if e["node"] == "drive"]
    legs = [
        path_length(run, start["t"], end["t"])
        for start, end in zip(drives[::2], drives[1::2], strict=True)
    ]
    assert len(legs) == 6
    speed = 0.2
    braking = speed**2 / (2 * load_robot("waffle").max_linear_acceleration)
    assert max(legs) <= 2.0 + speed * CONTROL_STEP_S + braking
    assert any(leg > 1.95 for leg in legs), "no leg was long enough to be cut"


@says
def explore_takes_five_pictures(run: Any, _: Path) -> None:
    """The sweep of eight is cancelled after the fifth picture, and those five stay on disk."""
    (end,) = [
        e for e in run.events("status") if e["node"] == "look around" and e["status"] == "SUCCESS"
    ]
    assert end["message"].startswith("canceled by condition: current_image >= 5")


@says
def patrol_visits_the_four_zones(run: Any, _: Path) -> None:
    """Within 0.25 m of each zone's centre, in the order A, B, C, D, by the true pose."""
    poses = run.events("pose")
    visits = []
    for zone in load_world("nav_arena").zones:
        nearest, when = min((math.hypot(p["x"] - zone.x, p["y"] - zone.y), p["t"]) for p in poses)
        assert nearest <= 0.25, f"zone {zone.name}: {nearest:.3f} m"
        visits.append((when, zone.name))
    assert [name for _, name in sorted(visits)] == ["A", "B", "C", "D"]


def test_a_speed_limit_holds_for_each_goal_of_a_faster_robot(stage: Any) -> None:
    """From its message to the next; 0 ends it. The requirement reads the same input."""
    run = stage.run(
        """\
mission: at a speed
world: empty_arena
robot: rosbot
inputs: {top_speed: 0.2}
requirements:
  keeps to it: 'whenever running("in town"): abs(speed) <= $top_speed + 0.005'
  drives at it: 'eventually (running("in town") and speed > $top_speed - 0.005)'
  is faster without it: 'eventually (running("beyond") and speed > 0.45)'
tree:
  sequence:
    - publish:
        topic: speed_limit
        type: nav2_msgs/msg/SpeedLimit
        message: {speed_limit: $top_speed}
    - sequence:
        - navigate_to_pose: {pose: [0.7, 0, 0]}
          timeout: 20
        - drive_on_heading: {target: [0.3, 0, 0], speed: 0.4}
          timeout: 20
      name: in town
    - publish: {topic: speed_limit, type: nav2_msgs/msg/SpeedLimit, message: {}}
    - navigate_to_pose: {pose: [-0.7, 0, 0]}
      name: beyond
      timeout: 20
"""
    )
    run.until_done()
    assert (run.status, run.reason) == ("success", "")


@says
def sweep_writes_its_pictures(_: Any, tmp_path: Path) -> None:
    """Six PNG files that can be opened, that differ, in one folder of their own."""
    pictures = sorted(tmp_path.glob("run_001/*/*.png"))
    assert len(pictures) == 6
    contents = set()
    for picture in pictures:
        with Image.open(picture) as image:
            assert image.size == (320, 240)
            contents.add(image.tobytes())
    assert len(contents) == 6


@says
def square_ends_where_it_began(run: Any, _: Path) -> None:
    """Four sides of a metre: the robot is back within 0.1 m and 5 degrees."""
    first, (x, y, yaw) = run.events("pose")[0], run.pose
    assert math.hypot(x - first["x"], y - first["y"]) < 0.1
    assert abs(math.remainder(yaw - first["yaw"], 2 * math.pi)) < math.radians(5)
    assert run.stage.runs[0].distance_travelled_m == pytest.approx(4.0, abs=0.15)


# ---- a cube is fetched: where it ends, what happens without it, and twice ----------------------

CUBE = find("worlds", "fetch_arena").read_text(encoding="utf-8")


def fetched(stage: Any, world: str = CUBE) -> tuple[Any, tuple[float, float, float] | None]:
    """Run the mission to its end; return the run and the place of the cube."""
    run = stage.run("fetch", world=world)
    run.until_done()
    return run, run.stage.sim.physics.objects.get("cube")


def pauses(run: Any) -> list[str]:
    """Return what the mission logged."""
    return [event["text"] for event in run.events("log")]


@pytest.mark.thorough
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


@pytest.mark.thorough
def test_a_gripper_that_closes_on_nothing_searches_further(stage: Any) -> None:
    """The cube lies 6 cm further than the mission takes it: the third attempt holds it."""
    run, cube = fetched(stage, CUBE.replace("x: 1.0, y: 0.0, size", "x: 1.06, y: 0.0, size"))
    assert run.status == "success"
    assert cube == pytest.approx((0.13, 0.0, 0.015), abs=0.015)
    assert len([line for line in pauses(run) if "closed on nothing" in line]) == 2


@pytest.mark.thorough
def test_without_a_cube_the_mission_fails_and_leaves_no_goal(stage: Any) -> None:
    """After three attempts, with the arm up and the gripper open."""
    run, _ = fetched(stage, CUBE[: CUBE.index("objects:")])
    assert (run.status, run.report.goals_left_behind) == ("failure", 0)
    assert len([line for line in pauses(run) if "closed on nothing" in line]) == 3
    joints = run.stage.sim.robots[0].servos.readings["position"]
    assert joints[-1] == pytest.approx(0.019, abs=1e-3)
    assert joints[1] == pytest.approx(0.577, abs=0.03)
