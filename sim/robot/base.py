"""The base of a simulated robot: from commands to motion, and from wheels to odometry.

A differential base rolls on its two wheels: only their contact with the floor moves it. The other
kinds would need wheels that scrub, or rollers, whose contacts cost several times as much and are
less exact. A planar base stands on supports without friction instead. Three servos of limited
force, that of its tyres, drive it at the velocity that its wheels' kinematics allow, and the angles
of the wheels follow from its true motion. So walls, pushes, slippery floor and a switched-off motor
act on it as on wheels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from bt_mission.robots.drives import AckermannDrive, OmnidirectionalDrive, SkidSteerDrive
from bt_mission.robots.model import RobotModel
from sim.faults import WheelFaults
from sim.physics.names import BASE, GEARS, GRIP, PUSH, SERVOS, STEP_NS, WHEELS
from sim.physics.physics import Physics
from sim.physics.wheels import Wheels
from sim.robot.drive import DifferentialController, PlanarController
from sim.sensors.odometry import Encoders, Odometry, OdometryFaults, PlanarOdometry

Before: TypeAlias = Callable[[int], None]
Twist: TypeAlias = tuple[float, float, float]
"""m/s ahead, m/s to the left, rad/s to the left."""


class DifferentialBase:
    """Two wheels in the physics, turned by velocity servos."""

    is_continuous = False
    """Whether it acts at every step of the physics, not only when a command is due."""

    def __init__(self, physics: Physics, robot: RobotModel, seed: int, prefix: str) -> None:
        model, data = physics.model, physics.data
        joint = model.joint(prefix + BASE)
        self.robot = robot
        self.velocities = _velocities(model, int(joint.dofadr[0]))
        """The number of those of the base and of all its joints, in the physics."""
        self.joints = tuple(f"{name}_joint" for name in robot.drive.names)
        """The names of its joints in `joint_states`."""
        turning = [model.joint(prefix + name) for name in WHEELS]
        self._angles = data.qpos[_pair(*(int(wheel.qposadr[0]) for wheel in turning))]
        self._speeds = data.qvel[_pair(*(int(wheel.dofadr[0]) for wheel in turning))]
        self._wheels = Wheels(model, physics.grip, prefix)
        motor = model.actuator(prefix + WHEELS[0]).id
        self._ctrl = data.ctrl[_pair(motor, model.actuator(prefix + WHEELS[1]).id)]
        self._options = model.opt
        self._motor_bit = 1 << int(model.actuator_group[motor])
        self._encoders = Encoders(robot.sensors.odometry.slip, seed, prefix)
        self.controller = DifferentialController(robot, STEP_NS / 1e9)
        self.odometry = Odometry(robot)

    def set_faults(self, faults: WheelFaults) -> None:
        """Replace the faults of the wheels."""
        self._wheels.set_faults(faults)

    def restart(self) -> None:
        """Count the wheels' turns from here on."""
        self._encoders.start(*self._angles.tolist())

    def new_controller(self, factor: float) -> None:
        """Forget all commands; the next ones hold for `factor` times the command timeout."""
        self.controller = DifferentialController(
            self.robot, STEP_NS / 1e9, command_timeout_factor=factor
        )

    def switch(self, *, on: bool) -> None:
        """Give or take the motors' power."""
        self.controller.switch(on=on)
        self._ctrl[:] = 0.0
        if on:
            self._options.disableactuator &= ~self._motor_bit
        else:
            self._options.disableactuator |= self._motor_bit
        self._wheels.power(on=on)

    def before(self, acting: list[Any], push: Before) -> Before:
        """Return the function to call before each step of the physics, with its beginning, ns.

        While there are `acting` pushes, it also calls `push`.
        """
        drive, ctrl = self.controller, self._ctrl

        def before(now_ns: int) -> None:
            if now_ns >= drive.due_ns:
                ctrl[:] = drive.step(now_ns)
            if acting:
                push(now_ns)

        return before

    @property
    def wheels(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Angles (rad, since the start) and speeds (rad/s) of the joints."""
        left, right = self._angles.tolist()
        left_speed, right_speed = self._speeds.tolist()
        return self._encoders.angles(left, right), (left_speed, right_speed)

    def read(self, time_ns: int, faults: OdometryFaults) -> float:
        """Update the odometry; return how far all wheels have turned together, rad."""
        angles = self._angles.tolist()
        turned = self._encoders.read(*angles)
        left, right = self._encoders.angles(*angles)
        self.odometry.read(left, right, time_ns, faults)
        return turned

    def reset_odometry(self) -> None:
        """Reckon from here on."""
        self.odometry = Odometry(self.robot)


class PlanarBase:
    """Three servos of limited force, for velocity ahead, to the left, and of turning."""

    is_continuous = True

    def __init__(self, physics: Physics, robot: RobotModel, seed: int, prefix: str) -> None:
        model, data = physics.model, physics.data
        joint = model.joint(prefix + BASE)
        self.robot = robot
        self.velocities = _velocities(model, int(joint.dofadr[0]))
        """The number of those of the base and of all its joints, in the physics."""
        names = [f"{name}_joint" for name in robot.drive.names]
        self._is_car = isinstance(robot.drive, AckermannDrive)
        if self._is_car:
            names += ["front_left_steering_joint", "front_right_steering_joint"]
        self.joints = tuple(names)
        """The names of its joints in `joint_states`."""
        self._qpos = data.qpos[joint.qposadr[0] : joint.qposadr[0] + 7]
        self._qvel = data.qvel[joint.dofadr[0] : joint.dofadr[0] + 6]
        servo = model.actuator(prefix + SERVOS[0]).id
        self._ctrl = data.ctrl[servo : servo + 3]
        self._force = model.actuator_forcerange[servo : servo + 3]
        self._gains = model.actuator_gainprm[servo : servo + 3, 0].tolist()
        self._weight = 9.81 * robot.base_mass
        self._arm = max(math.hypot(*place) for place in robot.drive.places)
        self._rows = wheel_rows(robot)
        self._each_row = self._rows.tolist()
        self._lefts = np.array([y > 0 for _, y in robot.drive.places])
        self._turned = [0.0, 0.0, 0.0]
        """The way of the wheels ahead and to the left, m, and their turn, rad."""
        self._twist: Twist = (0.0, 0.0, 0.0)
        self._floor = physics.grip
        self._patches = physics.world.slippery
        self._faults = WheelFaults()
        self._is_blocked = False
        self._powered = True
        self._passive = GEARS * self._weight
        self._floor_grip = self._grip = GRIP[0]
        self._encoders = Encoders(robot.sensors.odometry.slip, seed, prefix, len(self._rows))
        self.controller = PlanarController(robot, STEP_NS / 1e9)
        self.odometry = PlanarOdometry(robot, self._rows)

    def set_faults(self, faults: WheelFaults) -> None:
        """Replace the faults of the wheels: of those of a side together."""
        self._faults = faults
        self._is_blocked = faults.left_blocked or faults.right_blocked
        self._limit(GRIP[0])
        self.controller.due_ns = 0

    def restart(self) -> None:
        """Count the wheels' turns from here on."""
        self._turned[:] = self._twist = (0.0, 0.0, 0.0)
        self._limit(GRIP[0])
        self._encoders.start(*self._rotations(self._turned))

    def new_controller(self, factor: float) -> None:
        """Forget all commands; the next ones hold for `factor` times the command timeout."""
        self.controller = PlanarController(self.robot, STEP_NS / 1e9, command_timeout_factor=factor)

    def switch(self, *, on: bool) -> None:
        """Give or take the motors' power; without it, gears brake the wheels."""
        self.controller.switch(on=on)
        self._powered = on
        self._limit(GRIP[0])

    def before(self, acting: list[Any], push: Before) -> Before:
        """Return the function to call before each step of the physics, with its beginning, ns.

        While there are `acting` pushes, it also calls `push`.
        """
        controller, ctrl, turned = self.controller, self._ctrl, self._turned
        qpos, qvel, patches = self._qpos, self._qvel, self._patches
        step_s, slides = STEP_NS / 1e9, self.robot.drive.slide_velocity > 0
        last: Twist | None = None

        def before(now_ns: int) -> None:
            nonlocal last
            wanted = controller.move(now_ns)
            if self._is_blocked:
                wanted = self._blocked(wanted)
            x, y, _, qw, qx, qy, qz = qpos.tolist()
            vx, vy, _, _, _, rate = qvel.tolist()
            cos, sin = 1 - 2 * (qy * qy + qz * qz), 2 * (qw * qz + qx * qy)
            twist = cos * vx + sin * vy, cos * vy - sin * vx if slides else 0.0, rate
            if patches and (floor := self._floor.at(x, y)) != self._floor_grip:
                self._limit(floor)
            if self._grip < PUSH:
                twist = self._slipping(twist, wanted)
            if wanted is not last:
                ctrl[:] = last = wanted
            ahead, left, turn = twist
            turned[0] += ahead * step_s
            turned[1] += left * step_s
            turned[2] += turn * step_s
            self._twist = twist
            if acting:
                push(now_ns)

        return before

    def _slipping(self, twist: Twist, wanted: Twist) -> Twist:
        """Return the motion of wheels, which turn as commanded where they lose their grip."""
        if not self._powered:
            return twist
        forces = self._force[:, 1].tolist()
        ahead, left, turn = (
            command if abs(command - now) * gain > force else now
            for now, command, gain, force in zip(twist, wanted, self._gains, forces, strict=True)
        )
        return ahead, left, turn

    def _limit(self, floor: float) -> None:
        """Set the forces of the servos: of motors and tyres, or of gears without power.

        `floor` is the grip of the floor, which faults of the wheels lower.
        """
        self._floor_grip = floor
        self._grip = grip = min(floor, self._faults.left_grip, self._faults.right_grip)
        tyres = min(grip, GRIP[0]) * self._weight
        along = min(tyres, PUSH * self._weight if self._powered else self._passive)
        slides = self.robot.drive.slide_velocity > 0
        turning = tyres if self._is_car else along
        self._force[:, 1] = along, along if slides else tyres, turning * self._arm
        self._force[:, 0] = -self._force[:, 1]

    def _blocked(self, wanted: Twist) -> Twist:
        """Return the motion that is left of a wanted one with the wheels of a side blocked."""
        if self._is_car:
            return 0.0, 0.0, 0.0
        turned = self._rows @ np.array(wanted)
        faults = self._faults
        turned[self._lefts & faults.left_blocked] = 0.0
        turned[~self._lefts & faults.right_blocked] = 0.0
        left = np.linalg.pinv(self._rows) @ turned
        return float(left[0]), float(left[1]), float(left[2])

    @property
    def wheels(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Angles (rad, since the start) and speeds (rad/s) of the joints; of steering, angles."""
        angles = self._encoders.angles(*self._rotations(self._turned))
        speeds = self._rotations(self._twist)
        if self._is_car:
            drive: Any = self.robot.drive
            angle = self.controller.steering
            inner = [
                math.atan2(
                    math.sin(angle) * drive.wheelbase,
                    math.cos(angle) * drive.wheelbase - math.sin(angle) * side,
                )
                for side in (drive.wheel_y, -drive.wheel_y)
            ]
            return (*angles, *inner), (*speeds, 0.0, 0.0)
        return angles, speeds

    def read(self, time_ns: int, faults: OdometryFaults) -> float:
        """Update the odometry; return how far all wheels have turned together, rad."""
        now = self._rotations(self._turned)
        turned = self._encoders.read(*now)
        self.odometry.read(self._encoders.angles(*now), time_ns, faults)
        return turned

    def _rotations(self, motion: Sequence[float]) -> tuple[float, ...]:
        """Return what a motion of the base turns each wheel by."""
        ahead, left, turn = motion
        return tuple(a * ahead + b * left + c * turn for a, b, c in self._each_row)

    def reset_odometry(self) -> None:
        """Reckon from here on."""
        self.odometry = PlanarOdometry(self.robot, self._rows)


def _velocities(model: Any, first: int) -> int:
    """Return how many velocities of the physics move with the first one of a base."""
    return int((model.dof_treeid == model.dof_treeid[first]).sum())


def _pair(left: int, right: int) -> slice:
    """Return what selects two numbers of an array, as a view on it."""
    stop = right + (1 if right > left else -1)
    return slice(left, None if stop < 0 else stop, right - left)


def wheel_rows(robot: RobotModel) -> npt.NDArray[np.float64]:
    """Return the rotation of each wheel (rad/s) per velocity: m/s ahead and to the left, rad/s.

    The front wheels of a car turn as if they looked ahead: by 1 / cos of the steering too slowly.
    """
    drive = robot.drive
    if isinstance(drive, OmnidirectionalDrive):
        return np.array([wheel.row(drive.wheel_radius) for wheel in drive.wheels])
    half = drive.wheel_separation / 2 if isinstance(drive, SkidSteerDrive) else None
    return (
        np.array([(1.0, 0.0, -(math.copysign(half, y) if half else y)) for _, y in drive.places])
        / drive.wheel_radius
    )


def base_of(
    physics: Physics, robot: RobotModel, seed: int, prefix: str
) -> DifferentialBase | PlanarBase:
    """Return the base of a robot."""
    kind = DifferentialBase if robot.drive.kind == "differential" else PlanarBase
    return kind(physics, robot, seed, prefix)
