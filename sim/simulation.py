"""One robot in one world, moved by physics alone: what the ROS node is a thin layer over.

Pure: no ROS and no wall clock. Time is counted in nanoseconds and moves in steps of 5 ms. The
same world, robot, seed and commands give the same readings, bit for bit, on one version of
MuJoCo and one processor architecture.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.common.errors import BtMissionError
from bt_mission.common.robot import RobotModel
from sim.contacts import Collision, Contacts
from sim.drive import Drive
from sim.imu import Imu, Inertial
from sim.lidar import Lidar
from sim.model import compile_model
from sim.names import STEP_NS, TOUCH
from sim.odometry import Odometry
from sim.world import World

_SETTLING_STEPS = 40

_STRIDE = 0.005
"""Metres. The way is measured in chords of this length, so that trembling against a wall is none:
5 mm on an arc of 0.1 m come out 0.01 % short."""


class SpawnError(BtMissionError):
    """The robot does not fit where the world wants it to start."""


class Simulation:
    """Owns the MuJoCo model and its state, and speaks the robot's words.

    `seed` decides all sensor noise. `start_ns` is the first instant: above 0, which ROS takes
    for "not set". Raises SpawnError.
    """

    def __init__(
        self, world: World, robot: RobotModel, *, seed: int, start_ns: int = 1_000_000_000
    ) -> None:
        self.world = world
        self.robot = robot
        self.time_ns = start_ns
        self.collisions = 0
        """How often the robot came into contact with an obstacle."""
        self.model = compile_model(world, robot)
        self.data = mujoco.MjData(self.model)
        self.odometry = Odometry(robot)
        self._drive = Drive(robot, STEP_NS / 1e9)
        self._contacts = Contacts(self.model)
        self._touch = int(self.model.sensor(TOUCH).adr[0])
        self._new_collisions: list[Collision] = []
        self._settle()
        self._lidar = Lidar(self.model, robot, seed)
        self._imu = Imu(self.model, robot, seed, math.radians(world.spawn.yaw))
        self._wheels_at_start = self.data.qpos[7:9].tolist()
        self._read_odometry()
        self._way = 0.0
        self._milestone = self.pose[:2]

    # ---- driving -------------------------------------------------------------------------

    def command(self, linear: float, angular: float) -> None:
        """Ask for a velocity, m/s and rad/s; it holds for the robot's command timeout.

        Raises ValueError where one of them is not finite; the last command then stays.
        """
        self._drive.command(linear, angular, self.time_ns)

    @property
    def commanded(self) -> tuple[float, float]:
        """The velocity that the base now asks of its wheels, after limits and ramp."""
        return self._drive.linear, self._drive.angular

    def advance_to(self, time_ns: int) -> None:
        """Step the physics up to `time_ns`, a whole number of steps from now.

        Raises ValueError where that time is past, or lies between two steps.
        """
        steps, rest = divmod(time_ns - self.time_ns, STEP_NS)
        if steps < 0 or rest:
            raise ValueError(
                f"cannot advance from {self.time_ns} ns to {time_ns} ns: expected a later time,"
                f" a multiple of {STEP_NS} ns away"
            )
        model, data, drive, step = self.model, self.data, self._drive, mujoco.mj_step
        qpos, sensordata, touch = data.qpos, data.sensordata, self._touch
        x, y = self._milestone
        for now in range(self.time_ns, time_ns, STEP_NS):
            if drive.due(now):
                data.ctrl[:] = drive.step()
            step(model, data)
            if sensordata[touch]:
                self._collide(now)
            dx, dy = float(qpos[0]) - x, float(qpos[1]) - y
            if dx * dx + dy * dy > _STRIDE**2:
                self._way += math.hypot(dx, dy)
                x, y = x + dx, y + dy
        self._milestone = x, y
        self.time_ns = time_ns
        if steps:
            # What was computed within a step is that of its beginning.
            mujoco.mj_kinematics(model, data)

    # ---- the truth -----------------------------------------------------------------------

    @property
    def pose(self) -> tuple[float, float, float]:
        """True pose of `base_footprint` in the map: x m, y m, yaw rad."""
        x, y, _, qw, qx, qy, qz = self.data.qpos[:7].tolist()
        return x, y, math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))

    @property
    def velocity(self) -> tuple[float, float]:
        """True velocity of the base: ahead m/s, left turn rad/s."""
        vx, vy, *_, turn = self.data.qvel[:6].tolist()
        _, _, yaw = self.pose
        return vx * math.cos(yaw) + vy * math.sin(yaw), turn

    @property
    def distance_travelled(self) -> float:
        """Length of the way of the axle's middle, m, as it truly was."""
        x, y, _ = self.pose
        return self._way + math.dist(self._milestone, (x, y))

    def take_collisions(self) -> list[Collision]:
        """Return the collisions since the last call, in the order of their onset."""
        taken, self._new_collisions = self._new_collisions, []
        return taken

    # ---- what the robot knows ------------------------------------------------------------

    @property
    def wheels(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Angles (rad, since the start) and speeds (rad/s) of the left and the right wheel."""
        left, right = self.data.qpos[7:9].tolist()
        left_0, right_0 = self._wheels_at_start
        left_speed, right_speed = self.data.qvel[6:8].tolist()
        return (left - left_0, right - right_0), (left_speed, right_speed)

    def read_odometry(self) -> Odometry:
        """Return odometry, brought up to now."""
        self._read_odometry()
        return self.odometry

    def scan(
        self, index: int, out: npt.NDArray[np.float32] | None = None
    ) -> npt.NDArray[np.float32]:
        """Return the lidar's ranges now, m; `index` counts its measurements (noise)."""
        return self._lidar.measure(self.data, index, out)

    def inertial(self, index: int) -> Inertial:
        """Return the IMU's reading now; `index` counts its measurements (noise)."""
        return self._imu.measure(self.data, index)

    # ---- inside --------------------------------------------------------------------------

    def _read_odometry(self) -> None:
        left, right = self.wheels[0]
        self.odometry.read(left, right, self.time_ns)

    def _settle(self) -> None:
        """Let the springs of wheels and casters find their rest before time begins."""
        model, data = self.model, self.data
        mujoco.mj_forward(model, data)
        if data.sensordata[self._touch]:
            spawn, touched = self.world.spawn, Contacts(model).look(data, 0)
            names = ", ".join(sorted(f"'{collision.obstacle}'" for collision in touched))
            raise SpawnError(
                f"world {self.world.name}: a {self.robot.name} does not fit at the spawn"
                f" ({spawn.x:g}, {spawn.y:g}, {spawn.yaw:g} deg): it touches {names};"
                " move the spawn, or make room"
            )
        mujoco.mj_step(model, data, nstep=_SETTLING_STEPS)
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)

    def _collide(self, now_ns: int) -> None:
        begun = self._contacts.look(self.data, now_ns)
        self.collisions += len(begun)
        self._new_collisions += begun
