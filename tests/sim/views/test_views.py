"""What people see of a simulation."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import numpy as np
import pytest

from bt_mission.robots.model import load_robot
from sim.robot.robot import SimulatedRobot
from sim.sensors.canvas import NoCameraError
from sim.views.views import WorldViews
from sim.world.world import World
from tests.support.simulated import alone, wait

Look = Callable[..., tuple[SimulatedRobot, WorldViews]]
RED = {"name": "red", "x": 1.0, "y": 1.0, "radius": 0.2, "height": 0.5, "colour": "red"}


@pytest.fixture
def look() -> Iterator[Look]:
    """A simulation in a world of these fields, and views of it; skips where there is no EGL."""
    with ExitStack() as stack:

        def look(robot: str = "waffle", **fields: object) -> tuple[SimulatedRobot, WorldViews]:
            world = World.model_validate({"name": "test", "size": [4, 4], **fields})
            simulation = alone(world, load_robot(robot), seed=1)
            try:
                views = WorldViews(simulation, above=(420, 420), ahead=(320, 240))
            except NoCameraError as error:
                pytest.skip(str(error))
            stack.callback(views.close)
            return simulation, views

        yield look


def picture_of(views: WorldViews) -> np.ndarray:
    """The whole picture from above, as it is now."""
    picture = views.still.copy()
    for patch in views.moving():
        patch.paint(picture)
    return picture


def redness(picture: np.ndarray) -> np.ndarray:
    """Where it is red."""
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    return (red > 90) & (green < red / 2) & (blue < red / 2)


def middle_of(mask: np.ndarray) -> tuple[float, float]:
    """The middle of what is marked: from the left, from the top."""
    rows, columns = np.nonzero(mask)
    return (columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2


@pytest.mark.egl
def test_the_picture_is_a_map(look):
    """A pillar stands where `pixel` says; right is x, up is y."""
    _, views = look(cylinders=[RED])
    u, v = views.pixel(1.0, 1.0)
    assert (u, v) == pytest.approx((310, 110))  # 100 pixels a metre, a margin of 0.1 m
    assert middle_of(redness(views.still)) == pytest.approx((u, v), abs=1.5)


@pytest.mark.egl
def test_the_robot_is_drawn_where_it_is(look):
    """After it has driven, it has moved, and is nowhere else."""
    simulation, views = look()
    before = picture_of(views)
    for _ in range(20):
        simulation.command(0.2, 0.0)
        wait(simulation, 0.05)
    views.look()
    after = picture_of(views)
    x, y, _ = simulation.pose
    assert x > 0.1
    robot = np.abs(after.astype(int) - views.still).max(axis=2) > 100
    middle, across = middle_of(robot)
    at = views.pixel(x, y)
    assert (middle, across) == pytest.approx((at[0] - 6, at[1]), abs=4)  # its body lies behind
    assert not np.array_equal(before, after)


@pytest.mark.egl
def test_what_moves_is_no_part_of_what_stands_still(look):
    """It is a patch, over which it has gone later."""
    moving = {**RED, "motion": {"through": [[-1.0, 1.0]], "speed": 0.5}}
    simulation, views = look(cylinders=[moving])
    assert not redness(views.still).any()
    wait(simulation, 2.0)
    views.look()
    assert middle_of(redness(picture_of(views))) == pytest.approx(views.pixel(0.0, 1.0), abs=2)


@pytest.mark.egl
def test_shadows_fall_to_the_upper_right(look):
    """Of what stands, drawn by MuJoCo, and of what moves, from its outline: alike."""
    at = (slice(90, 110), slice(315, 325))  # 0.6 m above and 0.3 m beside what stands there
    places = {"x": 1.0, "y": 0.8, "height": 1.0}
    stands, moves = (
        picture_of(look(cylinders=[{**RED, **places, **motion}])[1])
        for motion in ({}, {"motion": {"around": [0, 0], "period": 100000}})
    )
    lit = picture_of(look()[1])
    for picture in (stands, moves):
        assert picture[at].mean() < 0.75 * lit[at].mean()
    assert stands[at].mean() == pytest.approx(moves[at].mean(), abs=8)


@pytest.mark.egl
@pytest.mark.parametrize(("robot", "x", "y"), [("waffle", 1.5, -0.047), ("burger", 0.6, 0.0)])
def test_what_stands_ahead_is_in_the_middle_of_the_picture_ahead(look, robot, x, y):
    """A robot without a camera is seen from behind: it is there itself, below the middle."""
    _, views = look(robot, cylinders=[{**RED, "x": x, "y": y}])
    picture = views.ahead()
    assert middle_of(redness(picture))[0] == pytest.approx(160, abs=3)
    assert (picture[120:200, 130:190].max(axis=2).min() < 60) == (robot == "burger")


@pytest.mark.egl
def test_the_lidar_sees_the_walls(look):
    """Its points lie on what it meets."""
    _, views = look(walls=[{"from": [1.5, -2], "to": [1.5, 2]}])
    points = views.seen()
    ahead = points[np.abs(points[:, 1]) < 0.3]
    assert ahead[:, 0].max() == pytest.approx(1.45, abs=0.1)


@pytest.mark.egl
def test_the_simulation_does_not_notice(look):
    """It goes on as one that nobody looks at, bit for bit."""
    ends = []
    for watched in (True, False):
        simulation, views = look(cylinders=[RED])
        for _ in range(20):
            simulation.command(0.2, 0.5)
            wait(simulation, 0.05)
            if watched:
                views.look()
                views.moving(), views.ahead(), views.seen()
        ends.append((simulation.record(), simulation.scan(0).tobytes()))
    assert ends[0] == ends[1]
