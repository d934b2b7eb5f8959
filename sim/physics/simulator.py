"""Another simulator in place of MuJoCo's steps: what it offers, and how the stage drives it.

It moves the base, and measures the distances of the lidar. MuJoCo's model of the same world
follows it step by step, so wheels, odometry, the other sensors, collisions, clearance, faults of
sensors, recordings and views work as ever. A simulator needs no ROS.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.base.errors import BtMissionError, described
from bt_mission.robots.drives import DifferentialDrive
from bt_mission.robots.model import RobotModel
from sim.physics.names import BASE, STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.world.world import World

Pose: TypeAlias = tuple[float, float, float]
"""x m, y m, yaw rad, in the map."""

TOUCHING_M = 0.001
"""A robot that is nearer than this to an obstacle touches it."""

_PLACE_M, _TURN_RAD = 0.001, 0.001
"""How far a simulator may start from the given start."""


class SimulatorError(BtMissionError):
    """A simulator cannot be used (BT-811), or does not do what it has to do (BT-812)."""

    code = "BT-811"


class Simulator(Protocol):
    """A robot in a world, moved by a program other than MuJoCo.

    Made once for each run, by ``CLASS(world=..., robot=..., start=..., seed=...)``: the `World`,
    the `RobotModel`, the pose of the start and the seed of the run. The same calls have to give the
    same values, so that runs repeat.
    """

    @property
    def step_ns(self) -> int:
        """The length of a step, ns: a multiple of 5 ms that divides the period of each sensor."""

    @property
    def time_ns(self) -> int:
        """The present time since the start, or since the last `reset`, ns."""

    @property
    def pose(self) -> Pose:
        """The present pose of the middle of the axle, on the floor."""

    def advance_to(self, time_ns: int, linear: float, angular: float) -> None:
        """Make the steps up to a time with a velocity, m/s ahead and rad/s to the left.

        The velocity is within the limits of the robot. A time is always a whole number of steps.
        """

    def ranges(self) -> Sequence[float]:
        """Return the lidar's exact distances now, m; inf where it sees nothing.

        As many as `robot.lidar.rays`, counter-clockwise by `robot.lidar.angles`, from the place and
        heading of the lidar. Noise and limits are applied later. It may be called several times at
        one instant.
        """

    def reset(self) -> None:
        """Be as at the start, at time 0."""


SimulatorFactory: TypeAlias = Callable[..., Simulator]


class FollowedSimulator:
    """A simulator, followed by the model: its base, its wheels, and the velocities of both.

    Args:
        make: Makes the simulator.
        world: The world.
        entrants: The robot, alone.
        seed: The seed of the run.

    Raises:
        SimulatorError: It cannot be made, or does not fit the robot.
    """

    def __init__(
        self, make: SimulatorFactory, world: World, entrants: Sequence[RobotSpawn], seed: int
    ) -> None:
        self.name = getattr(make, "__qualname__", None) or type(make).__name__
        if len(entrants) != 1:
            raise SimulatorError(
                f"the simulator {self.name} moves one robot, but there are {len(entrants)}"
            )
        (entrant,) = entrants
        spawn = entrant.spawn or world.spawn
        self._robot, self._prefix = entrant.robot, entrant.prefix
        self._start = (spawn.x, spawn.y, math.radians(spawn.yaw))
        try:
            self._simulator = make(world=world, robot=entrant.robot, start=self._start, seed=seed)
            missing = [name for name in _MEMBERS if not hasattr(self._simulator, name)]
            step_ns = None if missing else self._simulator.step_ns
        except Exception as error:
            raise SimulatorError(f"the simulator {self.name} raised {described(error)}") from error
        if missing:
            raise SimulatorError(f"the simulator {self.name} has no {', '.join(missing)}")
        if not isinstance(step_ns, int) or step_ns < STEP_NS or step_ns % STEP_NS:
            raise SimulatorError(
                f"the simulator {self.name}: step_ns must be a multiple of {STEP_NS:,} ns, got"
                f" {step_ns!r}"
            )
        for what, period_ns in periods_ns(entrant.robot).items():
            if period_ns % step_ns:
                raise SimulatorError(
                    f"the simulator {self.name}: a step of {step_ns / 1e6:g} ms does not fit"
                    f" {what}: a period of {period_ns / 1e6:g} ms"
                )
        self._step_ns = step_ns
        self._now_ns = 0
        self._pose = self._start
        self._commanded: Callable[[], tuple[float, float]] = lambda: (0.0, 0.0)

    def refusal(self, what: str) -> str:
        """Return why something that acts on bodies is not possible."""
        return f"the simulator {self.name} moves the robot, so {what} would have no effect"

    def follow(self, data: mujoco.MjData, commanded: Callable[[], tuple[float, float]]) -> None:
        """Begin to move the model by the commands of its robot."""
        joint = data.model.joint(self._prefix + BASE)
        wheels = 2 if isinstance(self._robot.drive, DifferentialDrive) else 0
        self._qpos = data.qpos[joint.qposadr[0] : joint.qposadr[0] + 7 + wheels]
        self._qvel = data.qvel[joint.dofadr[0] : joint.dofadr[0] + 6 + wheels]
        self._commanded = commanded

    def restart(self) -> None:
        """Put the simulator to its start.

        Raises:
            SimulatorError: It is elsewhere then, or at another time.
        """
        self._now_ns = 0
        self._call(self._simulator.reset)
        self._check_time(0, 0)
        x, y, yaw = self._pose = self._read_pose()
        x_0, y_0, yaw_0 = self._start
        turn = abs(math.remainder(yaw - yaw_0, math.tau))
        if math.hypot(x - x_0, y - y_0) > _PLACE_M or turn > _TURN_RAD:
            raise self._broken(f"expected the start at {_at(self._start)}, got {_at(self._pose)}")

    def step(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Take a step of the physics: time moves, and with each of its own steps the robot."""
        data.time += model.opt.timestep
        self._now_ns += STEP_NS
        if self._now_ns % self._step_ns:
            return
        before_ns = self._simulator.time_ns
        linear, angular = self._commanded()
        self._call(self._simulator.advance_to, self._now_ns, linear, angular)
        self._check_time(before_ns, self._now_ns)
        self._move(self._read_pose())
        mujoco.mj_forward(model, data)

    def ranges(self, rays: int) -> npt.NDArray[np.float64]:
        """Return this number of distances, m; inf where there is nothing.

        Raises:
            SimulatorError: They are not distances, or not as many as the lidar has.
        """
        try:
            measured = np.array(self._call(self._simulator.ranges), dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise self._broken("ranges() returned no list of numbers") from error
        wanted = self._robot.lidar.rays
        if measured.shape != (wanted,):
            raise self._broken(f"expected {wanted} ranges, got an array of {measured.shape}")
        if not (measured >= 0).all():
            wrong = int(np.argmin(measured >= 0))
            raise self._broken(
                f"range {wrong} is {measured[wrong]:g} m; expected 0 or more, or inf"
            )
        if rays != wanted:  # of a lidar whose turns vary
            measured = measured[(np.arange(rays) * wanted) // rays]
        return measured

    def _read_pose(self) -> Pose:
        try:
            x, y, yaw = map(float, self._call(lambda: self._simulator.pose))
        except (TypeError, ValueError) as error:
            raise self._broken("pose is not x, y and yaw") from error
        if not math.isfinite(x + y + yaw):
            raise self._broken(f"pose is not finite: {x:g}, {y:g}, {yaw:g}")
        return x, y, yaw

    def _move(self, pose: Pose) -> None:
        """Move the model there, with the velocity of this step; the wheels have rolled."""
        x, y, yaw = pose
        dx, dy = x - self._pose[0], y - self._pose[1]
        turned = math.remainder(yaw - self._pose[2], math.tau)
        middle = self._pose[2] + turned / 2
        ahead = dx * math.cos(middle) + dy * math.sin(middle)
        left = dy * math.cos(middle) - dx * math.sin(middle)
        qpos, qvel, seconds = self._qpos, self._qvel, self._step_ns / 1e9
        qpos[0], qpos[1] = x, y
        qpos[3:7] = math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)
        cos, sin = math.cos(yaw) / seconds, math.sin(yaw) / seconds
        qvel[:6] = ahead * cos - left * sin, ahead * sin + left * cos, 0, 0, 0, turned / seconds
        self._pose = pose
        drive = self._robot.drive
        if isinstance(drive, DifferentialDrive):  # the wheels of others follow from the velocity
            across = turned * drive.wheel_separation / 2
            rolled = np.array([ahead - across, ahead + across]) / drive.wheel_radius
            qpos[7:9] += rolled
            qvel[6:8] = rolled / seconds

    def _check_time(self, before_ns: int, expected_ns: int) -> None:
        now_ns = self._call(lambda: self._simulator.time_ns)
        if now_ns == expected_ns:
            return
        what = "is late" if now_ns < expected_ns else "is ahead"
        if now_ns < before_ns:
            what = "went back"
        raise self._broken(f"its time {what}: expected {expected_ns:,} ns, got {now_ns:,} ns")

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except Exception as error:
            raise self._broken(f"it raised {described(error)}") from error

    def _broken(self, why: str) -> SimulatorError:
        return SimulatorError(
            f"the simulator {self.name}, {self._now_ns / 1e9:g} s after its start: {why}",
            code="BT-812",
        )


_MEMBERS = ("step_ns", "time_ns", "pose", "advance_to", "ranges", "reset")


def periods_ns(robot: RobotModel) -> Mapping[str, int]:
    """Return the period of each sensor and of the odometry, ns, by the name of its rate."""
    return {".".join(path): round(1e9 / rate) for path, rate in robot.rates.items()}


def _at(pose: Pose) -> str:
    return f"({pose[0]:g}, {pose[1]:g}) m, {math.degrees(pose[2]):g} deg"
