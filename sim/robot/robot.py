"""One robot in the physics: its commands, its readings, and the truth about it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from bt_mission.robots.model import RobotModel
from sim.faults import FaultError, PartFaults, RobotFaultState, WheelFaults
from sim.physics.clearance import Clearance, robot_gauge
from sim.physics.contacts import Collision, Contacts
from sim.physics.history import Reviewer, SimulationState, pose_of, velocity_of
from sim.physics.names import BASE
from sim.physics.physics import Physics, StepHooks
from sim.physics.pushes import Frame, Pushes
from sim.physics.spawn import RobotSpawn
from sim.robot import fit
from sim.robot.base import Before, base_of
from sim.robot.description import SENSORS, sensors_of
from sim.robot.joints import JointServos
from sim.robot.links import Links
from sim.robot.localization import Localization, LocalizationError
from sim.sensors.battery import Battery, BatterySensor
from sim.sensors.lidar import LidarSensor
from sim.sensors.odometry import NO_ODOMETRY_FAULTS, JointFaults, Odometry, PlanarOdometry
from sim.sensors.sensor import Mount, Sensor

PARTS: Mapping[str, PartFaults] = {
    **{kind.name: kind.breaks for kind in SENSORS},
    "odometry": NO_ODOMETRY_FAULTS,
    "joints": JointFaults(),
    "wheels": WheelFaults(),
}
"""The parts of a robot that can have faults, each without one."""

S = TypeVar("S", bound=Sensor)

_STRIDE = 0.005
"""Metres. The path is measured in chords of this length, so that trembling against a wall does not
count: 5 mm on an arc of 0.1 m are 0.01 % too short.
"""

_ALWAYS = (True,)


class SimulatedRobot:
    """A robot of a simulation. `seed` decides all its sensor noise.

    It is made before time starts; `restart` starts it.
    """

    def __init__(self, physics: Physics, entrant: RobotSpawn, *, seed: int) -> None:
        self.physics = physics
        self.name = entrant.name
        self.seed = seed
        self.prefix = prefix = entrant.prefix
        self.robot: RobotModel = entrant.robot
        self.collisions = 0
        """The number of collisions with an obstacle or another robot."""
        self.collisions_with = Counter[str]()
        """The number of collisions with each other robot, by its name."""
        model, data = physics.model, physics.data
        joint = model.joint(prefix + BASE)
        self._base = base_of(physics, self.robot, seed, prefix)
        self.servos = JointServos(physics, self.robot, prefix) if self.robot.moved_joints else None
        """Of arm and gripper, if there are any."""
        self.links = Links(physics, self.robot, prefix) if self.robot.moved_joints else None
        """The links that arm and gripper move."""
        self._qpos = data.qpos[joint.qposadr[0] : joint.qposadr[0] + self._base.velocities + 1]
        self._qvel = data.qvel[joint.dofadr[0] : joint.dofadr[0] + self._base.velocities]
        self._pushes = Pushes(model, data, prefix)
        present = sensors_of(self.robot)
        lacks = {
            kind.name: f"a {self.robot.name} has no {kind.name}"
            for kind in SENSORS
            if kind not in present
        }
        if physics.has_simulator:
            lacks["wheels"] = "another simulator moves the robot, which has no wheels to break"
        parts = {**PARTS, **{kind.name: kind.breaks for kind in present}}
        self.faults = RobotFaultState(parts, self._base.set_faults, lacks)
        """The present faults."""
        self._contacts = Contacts(model, physics.names, prefix)
        self._new_collisions: list[Collision] = []
        self._gauge = robot_gauge(model, physics.names, prefix)
        spawn = entrant.spawn or physics.world.spawn
        if outside := fit.off_floor(physics.world, entrant, spawn):
            raise outside
        if touched := self._contacts.touched(data):
            raise fit.no_room_at_start(physics.world, entrant, spawn, touched)
        start_yaw = math.radians(spawn.yaw)
        mount = Mount(physics, self.robot, prefix, seed, start_yaw, self.faults)
        self.sensors = tuple(kind(mount) for kind in present)
        """In the order in which they measure at one instant."""
        self._lidar, self._battery = self.sensor(LidarSensor), self.sensor(BatterySensor)
        self.command_timeout_factor = 1.0
        self.localization = Localization(None, seed, entrant.name)
        self.motors_on = True
        self._way = self._rest_z = 0.0
        self._milestone = (spawn.x, spawn.y)

    def restart(self) -> None:
        """Restore the state at the start, where the physics has been put. Counts stay."""
        self.faults.clear()
        self._pushes.forget()
        for sensor in self.sensors:
            sensor.restart()
        self._base.restart()
        if self.servos is not None:
            self.servos.restart()
        self._milestone = self.pose[:2]
        self._rest_z = float(self._qpos[2])
        self._base.new_controller(self.command_timeout_factor)
        self._contacts.forget()
        self.localization.restart()
        self._switch_motors(on=True)
        self.reset_odometry()

    def sensor(self, kind: type[S]) -> S:
        """Return the robot's sensor of a kind. Raises StopIteration without one."""
        return next(sensor for sensor in self.sensors if isinstance(sensor, kind))

    @property
    def battery(self) -> Battery:
        """The battery."""
        return self._battery.battery

    def scale_command_timeout(self, factor: float) -> None:
        """Let the next commands hold for `factor` times the robot's command timeout."""
        self.command_timeout_factor = factor
        self._base.controller.command_timeout_factor = factor

    def live_with(self, nature: Mapping[str, float]) -> None:
        """Have sensors, wheels and localization be as a nature has them.

        Args:
            nature: Values by the names of :data:`bt_mission.base.nature.QUANTITIES`.
        """
        radius, difference = nature["wheel_radius"] / 100, nature["wheel_difference"] / 100
        self.faults.set_usual(
            "odometry",
            left_radius_error=radius + difference / 2,
            right_radius_error=radius - difference / 2,
        )
        grip = nature["wheel_grip"]
        self.faults.set_usual("wheels", left_grip=grip, right_grip=grip)
        self.faults.set_usual(
            "lidar",
            noise=nature["lidar_noise"],
            bias=nature["lidar_bias"],
            dropout=nature["lidar_dropout"] / 100,
        )
        error = LocalizationError(
            nature["localization_error"],
            math.radians(nature["localization_yaw_error"]),
            nature["localization_jumps"] / 60,
            nature["localization_jump"],
        )
        is_exact = error == LocalizationError()
        self.localization = Localization(None if is_exact else error, self.seed, self.name)

    @property
    def command_timeout_s(self) -> float:
        """The time for which a command holds, s."""
        return self._base.controller.timeout_s

    # ---- driving -------------------------------------------------------------------------

    def command(
        self, linear: float, angular: float, stamp_ns: int = 0, lateral: float = 0.0
    ) -> float:
        """Command a velocity, m/s and rad/s; it holds for the robot's command timeout.

        `lateral` is a velocity to the left, for a base that slides.

        The timeout counts from the stamp, so that a delay does not prolong it. Without a stamp (0),
        or with one of the future, as from another clock, it counts from now.

        Returns the age of the command, s. Raises ValueError if a velocity is not finite; the last
        command then stays. While the motors are off, a command is ignored.
        """
        now_ns = self.physics.time_ns
        commanded_ns = stamp_ns if 0 < stamp_ns < now_ns else now_ns
        self._base.controller.command(linear, angular, commanded_ns, lateral)
        return (now_ns - commanded_ns) / 1e9

    @property
    def commanded(self) -> tuple[float, float]:
        """The velocity that the base now commands to its wheels, after limits and ramp."""
        return self._base.controller.linear, self._base.controller.angular

    def power_motors(self, *, on: bool) -> bool:
        """Switch the motors; without power the base rolls to rest.

        Return False if the battery is empty.
        """
        if on and self.battery.is_empty:
            return False
        if on != self.motors_on:
            self._switch_motors(on=on)
        return True

    def step_hooks(self) -> StepHooks:
        """Return the functions to call at a step of the physics."""
        qpos = self._qpos
        x, y = self._milestone
        pushes = self._pushes

        def push(now_ns: int) -> None:
            pushes.apply(now_ns, self.pose[2])

        before = self._before(self._base.before(pushes.acting, push))

        def after() -> None:
            nonlocal x, y
            dx, dy = float(qpos[0]) - x, float(qpos[1]) - y
            if dx * dx + dy * dy > _STRIDE**2:
                self._way += math.hypot(dx, dy)
                x, y = self._milestone = x + dx, y + dy

        is_continuous = self._base.is_continuous or self.servos is not None
        acting = _ALWAYS if is_continuous else pushes.acting
        return StepHooks(before, after, self._base.controller, acting)

    def _before(self, base: Before) -> Before:
        """Return what is called before each step: servos of joints, if any, and the base."""
        servos = self.servos
        if servos is None:
            return base

        def before(now_ns: int) -> None:
            servos.step()
            base(now_ns)

        return before

    def look_for_collisions(self, now_ns: int) -> None:
        """Count what begins to be touched by now."""
        begun = self._contacts.look(self.physics.data, now_ns)
        self.collisions += len(begun)
        self.collisions_with.update(contact.obstacle for contact in begun if contact.is_robot)
        self._new_collisions += begun

    # ---- from outside --------------------------------------------------------------------

    def push(
        self,
        force: tuple[float, float],
        seconds: float,
        *,
        torque: float = 0.0,
        frame: Frame = "robot",
    ) -> None:
        """Push the base, at its centre of mass, with a force (N) for a time from now on.

        The force is ahead and to the left, or along x and y of the map; `torque` (N m) turns it to
        the left. Several add up. Raises FaultError for values that are not finite, or beyond 50 N
        and 5 N m.
        """
        self._refuse("a push")
        self._pushes.add(force, torque, frame, seconds, self.physics.time_ns)

    def shove(
        self, velocity: tuple[float, float], *, turn: float = 0.0, frame: Frame = "robot"
    ) -> None:
        """Give the base a velocity (m/s) and a turn rate (rad/s, left positive) at once.

        Axes as with a push. Its wheels turn as before, so grip soon brakes it. Raises FaultError
        for values that are not finite, or beyond 5 m/s and 10 rad/s.
        """
        self._refuse("a shove")
        self._pushes.shove(velocity, turn, frame, self.pose[2])

    def put(
        self, pose: tuple[float, float, float], velocity: tuple[float, float, float] = (0, 0, 0)
    ) -> None:
        """Put the base elsewhere at once, upright: x m, y m, yaw rad, in the map.

        It continues at a velocity along x and y of the map (m/s) and a turn rate (rad/s). Neither
        its odometry nor the distance travelled changes. Raises SpawnError if it does not fit.
        """
        (x, y, yaw), (vx, vy, turn) = pose, velocity
        before = self._qpos.copy(), self._qvel.copy()
        self._qpos[:7] = x, y, self._rest_z, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)
        self._qvel[:] = 0.0
        self._qvel[[0, 1, 5]] = vx, vy, turn
        self.physics.put_in_place()
        room = self.clearance(within=0.0)
        if room.distance < -fit.TOUCHING:
            self._qpos[:], self._qvel[:] = before
            self.physics.put_in_place()
            raise fit.no_room(self.robot.name, pose, room.obstacle)
        self._way += math.dist(self._milestone, before[0][:2])
        self._milestone = x, y
        self.physics.ask_hooks()

    def charge_battery(self, share: float) -> None:
        """Set the battery's charge, 0 to 1; an empty one cuts the motors' power.

        Raises FaultError for an invalid charge.
        """
        self.battery.charge_to(share)

    # ---- the truth -----------------------------------------------------------------------

    @property
    def pose(self) -> tuple[float, float, float]:
        """True pose of `base_footprint` in the map: x m, y m, yaw rad."""
        return pose_of(self._qpos)

    @property
    def velocity(self) -> tuple[float, float]:
        """True velocity of the base: ahead m/s, left turn rad/s."""
        return velocity_of(self._qpos, self._qvel)

    @property
    def map_velocity(self) -> tuple[float, float, float]:
        """True velocity along x and y of the map, m/s, and left turn, rad/s."""
        vx, vy, *_, turn = self._qvel[:6].tolist()
        return vx, vy, turn

    @property
    def distance_travelled(self) -> float:
        """True length of the path of the axle's middle, m."""
        return self._way + math.dist(self._milestone, self._qpos[:2].tolist())

    def take_collisions(self) -> list[Collision]:
        """Return the collisions since the last call, in the order of their onset."""
        taken, self._new_collisions = self._new_collisions, []
        return taken

    def clearance(self, within: float = math.inf) -> Clearance:
        """Return the present clearance between the robot and everything that it could touch.

        Obstacles at `within` m or more are ignored.
        """
        return self._gauge.measure(self.physics.data, within)

    def clearance_at_least(self) -> float:
        """Return a lower bound (m) of the clearance now, at a small part of its cost."""
        return self._gauge.at_least(self.physics.data)

    def record(self) -> SimulationState:
        """Return what the whole simulation is like now, for a reviewer. Costs microseconds."""
        return self.physics.record()

    def review(self) -> Reviewer:
        """Return the evaluation of recorded states for this robot. It has a separate model."""
        return Reviewer(self.physics.model, self.prefix)

    # ---- odometry and sensors -------------------------------------------------------------

    @property
    def joints(self) -> tuple[str, ...]:
        """The names of all joints: of wheels, of steering, of arm and gripper."""
        return self._base.joints + (() if self.servos is None else self.servos.names)

    @property
    def wheels(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Angles (rad, since the start) and speeds (rad/s) of the joints."""
        return self._base.wheels

    @property
    def joint_numbers(self) -> tuple[float, ...]:
        """Angles and speeds of `joints`, and with an arm or a gripper the forces of all."""
        angles, speeds = self._base.wheels
        if self.servos is None:
            return (*angles, *speeds)
        own = self.servos.readings
        without_force = (0.0,) * len(angles)
        return (
            *(*angles, *own["position"]),
            *(*speeds, *own["velocity"]),
            *(*without_force, *own["effort"]),
        )

    @property
    def odometry(self) -> Odometry | PlanarOdometry:
        """The odometry as it was last read."""
        return self._base.odometry

    def read_odometry(self) -> Odometry | PlanarOdometry:
        """Return odometry, updated to now, and update the battery."""
        time_ns = self.physics.time_ns
        base = self._base
        if time_ns != base.odometry.time_ns:
            turned = base.read(time_ns, self.faults.now["odometry"])
            battery = self._battery.battery
            battery.use(time_ns, turned if self.motors_on else 0.0)
            if self.motors_on and battery.is_empty:
                self._switch_motors(on=False)
        return base.odometry

    def reset_odometry(self) -> None:
        """Reckon from here on: pose (0, 0, 0)."""
        self._base.reset_odometry()
        self.read_odometry()

    def scan(self, index: int) -> npt.NDArray[np.float32]:
        """Return the lidar's ranges now, m; `index` counts its measurements (noise)."""
        return self._lidar.scan(index)

    def look_around(self) -> npt.NDArray[np.float32]:
        """Return the lidar's ranges now, m, for a viewer: the measurements stay as they are."""
        return self._lidar.look()

    # ---- inside --------------------------------------------------------------------------

    def _refuse(self, what: str) -> None:
        simulator = self.physics.simulator
        if simulator is not None:
            raise FaultError(simulator.refusal(what))

    def _switch_motors(self, *, on: bool) -> None:
        self.motors_on = on
        self._base.switch(on=on)
