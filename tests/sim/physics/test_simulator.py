"""Another simulator in place of MuJoCo's steps: the model follows it, and mistakes have codes."""

from __future__ import annotations

import math
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.robots.model import load_robot
from sim.faults import FaultError
from sim.physics.prop_bodies import PropError
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.world import Spawn, World
from tests.support.simulated import two

STEP_NS = 50_000_000
WORLD = World(name="hall", size=(8, 8), spawn=Spawn(x=1.0, y=-1.0, yaw=90.0))
WAFFLE = load_robot("waffle")


class Gliding:
    """A robot that drives exactly as commanded, among walls 3 m away from it."""

    step_ns: Any = STEP_NS

    def __init__(self, *, world: World, robot: Any, start: Any, seed: int) -> None:
        assert (world, robot, seed) == (WORLD, WAFFLE, 5)
        self._start = start
        self.reset()

    def advance_to(self, time_ns: int, linear: float, angular: float) -> None:
        """Drive an arc for each step."""
        while self.time_ns < time_ns:
            self.time_ns += STEP_NS
            x, y, yaw = self.pose
            middle, way = yaw + angular * 0.025, linear * 0.05
            x, y = x + way * math.cos(middle), y + way * math.sin(middle)
            self.pose: Any = (x, y, yaw + angular * 0.05)

    def ranges(self) -> Any:
        """Return what it sees: walls, and nothing behind."""
        return [math.inf if 90 < ray < 270 else 3.0 for ray in range(360)]

    def reset(self) -> None:
        """Be at the start."""
        self.time_ns, self.pose = 0, self._start


def simulated(make: Any = Gliding, **changes: Any) -> Simulation:
    """Return a simulation with a simulator, some of whose members are others."""
    kind = type("Changed", (make,), changes) if changes else make
    return Simulation(WORLD, [RobotSpawn(WAFFLE)], seed=5, simulator=kind, props=1)


def drive(simulation: Simulation, seconds: float) -> None:
    """Drive an arc, with a command each 50 ms."""
    for _ in range(round(seconds * 20)):
        simulation.robots[0].command(0.2, 0.5)
        simulation.advance_to(simulation.time_ns + STEP_NS)


def test_the_model_follows_with_base_wheels_odometry_and_scan() -> None:
    """The ramp of the base's controller is before it; the lidar's limits and noise after it."""
    simulation = simulated()
    robot = simulation.robots[0]
    drive(simulation, 4.0)
    x, y, yaw = robot.pose
    assert robot.velocity == pytest.approx((0.2, 0.5), abs=1e-3)
    assert math.remainder(yaw - math.pi / 2 - 2.0, math.tau) == pytest.approx(0, abs=0.05)
    assert math.dist((x, y), (1.0, -1.0)) == pytest.approx(0.8 * math.sin(1) / 1, abs=0.02)
    odometry = robot.read_odometry()
    assert math.hypot(odometry.x, odometry.y) == pytest.approx(0.67, abs=0.03)
    assert odometry.angular == pytest.approx(0.5, abs=0.01)
    scan = robot.scan(0)
    assert scan[:90] == pytest.approx(3.0, abs=0.05)
    assert all(map(math.isinf, scan[100:260]))
    simulation.physics.reset()
    assert robot.pose == pytest.approx((1.0, -1.0, math.pi / 2))


ON_BODIES: dict[str, Any] = {
    "push": lambda robot: robot.push((1.0, 0.0), 1.0),
    "shove": lambda robot: robot.shove((1.0, 0.0)),
    "obstacle": lambda robot: robot.physics.props.place("box", 0, 0, size=(0.2, 0.2, 0.3)),
    "wheels": lambda robot: robot.faults.set("wheels", left_grip=0.1),
}


@pytest.mark.parametrize("what", ON_BODIES)
def test_what_acts_on_bodies_is_refused(what: str) -> None:
    """It would have no effect."""
    robot = simulated().robots[0]
    with pytest.raises((FaultError, PropError), match=r"simulator .*moves the robot"):
        ON_BODIES[what](robot)


def _raises(*_: Any) -> Any:
    raise RuntimeError("no battery")


def _goes_to(offset_ns: int | None) -> Any:
    """Advances to another time than the wanted one; None: to a time before the start."""
    return lambda it, t, *_: setattr(it, "time_ns", -1 if offset_ns is None else t + offset_ns)


def _stands_at(*pose: float) -> Any:
    return property(lambda _: pose, lambda *_: None)


OFF_START = "expected the start at (1, -1) m, 90 deg, got (0, 0) m, 0 deg"
LATE = "0.05 s after its start: its time is late: expected 50,000,000 ns, got 0 ns"
AHEAD = "its time is ahead: expected 50,000,000 ns, got 50,000,001 ns"
BACK = "its time went back: expected 50,000,000 ns, got -1 ns"


@pytest.mark.parametrize(
    ("name", "member", "code", "message"),
    [
        ("__init__", _raises, "BT-811", "raised TypeError: _raises() got an unexpected"),
        ("step_ns", 0.05, "BT-811", "step_ns must be a multiple of 5,000,000 ns, got 0.05"),
        ("step_ns", 7_000_000, "BT-811", "step_ns must be a multiple of 5,000,000 ns, got 7"),
        ("step_ns", 40_000_000, "BT-811", "40 ms does not fit odometry_rate: a period of 50 ms"),
        (
            "reset",
            lambda it: it.__dict__.update(time_ns=0, pose=(0, 0, 0)),
            "BT-812",
            OFF_START,
        ),
        ("advance_to", _goes_to(-STEP_NS), "BT-812", LATE),
        ("advance_to", _goes_to(1), "BT-812", AHEAD),
        ("advance_to", _goes_to(None), "BT-812", BACK),
        ("advance_to", _raises, "BT-812", "it raised RuntimeError: no battery (test_simulator."),
        ("pose", _stands_at(math.nan, 0, 0), "BT-812", "not finite"),
        ("pose", _stands_at(1, 2), "BT-812", "is not x, y and yaw"),
        ("ranges", lambda _: [1.0] * 359, "BT-812", "expected 360 ranges, got an array of (359,)"),
        ("ranges", lambda _: [1.0, -2.0] * 180, "BT-812", "range 1 is -2 m; expected 0 or more"),
        ("ranges", lambda _: [math.nan] * 360, "BT-812", "range 0 is nan m"),
        ("ranges", lambda _: "far", "BT-812", "ranges() returned no list of numbers"),
    ],
)
def test_a_mistake_of_a_simulator_has_a_code_and_says_what_was_expected(
    name: str, member: Any, code: str, message: str
) -> None:
    """It never is a traceback."""

    def steps_and_looks() -> None:
        simulation = simulated(**{name: member})
        drive(simulation, 0.05)
        simulation.robots[0].scan(0)

    with pytest.raises(BtMissionError) as refused:
        steps_and_looks()
    assert refused.value.code == code
    assert message in str(refused.value)


def test_a_class_without_the_members_and_a_second_robot_are_refused() -> None:
    """With what is missing."""
    with pytest.raises(BtMissionError, match=r"Fake has no step_ns, time_ns, pose, advance_to"):
        simulated(type("Fake", (), {"__init__": lambda _, **__: None}))
    with pytest.raises(BtMissionError, match="moves one robot, but there are 2"):
        Simulation(WORLD, two(WAFFLE), seed=5, simulator=Gliding)
