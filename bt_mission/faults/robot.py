"""Faults of the robot itself: sensors, wheels, motors, and what pushes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from bt_mission.faults.errors import ScenarioError, no_such
from bt_mission.faults.fault import Begin, FaultInstance
from bt_mission.faults.maker import Maker, makes_fault, mistakes_of_test
from bt_mission.faults.parameters import (
    Degrees,
    DegreesPerSecond,
    Metres,
    MetresPerSecond,
    NewtonMetres,
    Newtons,
    RadiansPerSecond,
    Seconds,
)

Side = Literal["left", "right", "both"]
Sector = tuple[Degrees, Degrees]


class RobotFaults(Maker):
    """Faults of the simulated robot: all others see of them what they do to its topics.

    A sensor's fault shows from its next measurement on, a wheel's from the next step of the
    physics. Of two that say something about the same figure, the later counts; when it ends, the
    other does again. A figure that cannot be is a ScenarioError when the fault begins.
    """

    # ---- sensors -------------------------------------------------------------------------

    @makes_fault
    def lidar_noise(self, sigma: Metres, *, lasting: Seconds | None = None) -> Begin:
        """Add normal noise of so many metres (1 sigma) to every distance, on top of its own."""
        return _broken("lidar", noise=sigma)

    @makes_fault
    def lidar_bias(self, metres: Metres, *, lasting: Seconds | None = None) -> Begin:
        """Add the same to every distance."""
        return _broken("lidar", bias=metres)

    @makes_fault
    def lidar_blind(
        self, *sectors: Sector, share: float = 0.0, lasting: Seconds | None = None
    ) -> Begin:
        """Lose rays, as where there is nothing.

        Args:
            sectors: Each from a bearing counter-clockwise to another, deg, left positive: (-20, 20)
                lies ahead, (160, -160) behind.
            share: Of all rays, others in each scan.
        """
        changes: dict[str, Any] = {}
        if sectors:
            changes["sectors"] = sectors
        if share:
            changes["dropout"] = share
        if not changes:
            raise ScenarioError("lidar_blind: give sectors, such as (-20, 20), or a share")
        return _broken("lidar", **changes)

    @makes_fault
    def lidar_frozen(self, *, lasting: Seconds | None = None) -> Begin:
        """Repeat the last scan with fresh stamps."""
        return _broken("lidar", frozen=True)

    @makes_fault
    def lidar_dead(self, *, lasting: Seconds | None = None) -> Begin:
        """Publish no scans."""
        return _broken("lidar", dead=True)

    @makes_fault
    def odometry_error(
        self,
        *,
        left_radius: float = 0.0,
        right_radius: float = 0.0,
        separation: float = 0.0,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Reckon with wrong figures, each by its relative error: 0.1 is a tenth too large."""
        given = {"left_radius": left_radius, "right_radius": right_radius, "separation": separation}
        changes = {f"{name}_error": value for name, value in given.items() if value}
        if not changes:
            raise ScenarioError("odometry_error: give left_radius, right_radius or separation")
        return _broken("odometry", **changes)

    @makes_fault
    def odometry_drift(
        self,
        ahead: MetresPerSecond = 0.0,
        *,
        turn: DegreesPerSecond = 0.0,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Reckon with a motion that is none: m/s ahead, deg/s to the left."""
        return _broken("odometry", drift=ahead, turn_drift=turn)

    @makes_fault
    def odometry_dead(self, *, lasting: Seconds | None = None) -> Begin:
        """Publish no odometry, nor the transforms that come from it."""
        return _broken("odometry", dead=True)

    @makes_fault
    def imu_dead(self, *, lasting: Seconds | None = None) -> Begin:
        """Publish nothing of the IMU."""
        return _broken("imu", dead=True)

    @makes_fault
    def joints_dead(self, *, lasting: Seconds | None = None) -> Begin:
        """Publish no joint states; odometry goes on."""
        return _broken("joints", dead=True)

    @makes_fault
    def camera_noise(self, sigma: float, *, lasting: Seconds | None = None) -> Begin:
        """Add normal noise to each channel of each pixel, 1 sigma as a share of full scale."""
        return _broken("camera", noise=sigma)

    @makes_fault
    def camera_black(self, *, lasting: Seconds | None = None) -> Begin:
        """Show nothing but black."""
        return _broken("camera", black=True)

    @makes_fault
    def camera_frozen(self, *, lasting: Seconds | None = None) -> Begin:
        """Repeat the last picture with fresh stamps."""
        return _broken("camera", frozen=True)

    @makes_fault
    def camera_dead(self, *, lasting: Seconds | None = None) -> Begin:
        """Publish no pictures."""
        return _broken("camera", dead=True)

    # ---- wheels and motors ---------------------------------------------------------------

    @makes_fault
    def slip_wheel(
        self, wheel: Side, grip: float = 0.05, *, lasting: Seconds | None = None
    ) -> Begin:
        """Let a wheel slip.

        Args:
            wheel: Left, right or both.
            grip: Its coefficient of friction, 0 to 1.
        """
        return _broken("wheels", **{f"{side}_grip": grip for side in _sides("slip_wheel", wheel)})

    @makes_fault
    def block_wheel(self, wheel: Side, *, lasting: Seconds | None = None) -> Begin:
        """Block a wheel: left, right or both."""
        sides = _sides("block_wheel", wheel)
        return _broken("wheels", **{f"{side}_blocked": True for side in sides})

    @makes_fault
    def motors_off(self, *, lasting: Seconds | None = None) -> Begin:
        """Take the motors' power; the base rolls to rest."""

        def begin(fault: FaultInstance) -> None:
            robot = _robot(fault)
            robot.power_motors(on=False)
            fault.undo(lambda: robot.power_motors(on=True))

        return begin

    @makes_fault
    def battery_charge(self, share: float) -> Begin:
        """Set the battery's charge, 0 to 1; empty, it takes the motors' power."""
        return _at_once(lambda robot: robot.charge_battery(share))

    # ---- from outside --------------------------------------------------------------------

    @makes_fault
    def push(
        self,
        ahead: Newtons = 0.0,
        left: Newtons = 0.0,
        *,
        seconds: Seconds = 0.2,
        torque: NewtonMetres = 0.0,
    ) -> Begin:
        """Push the base at its centre of mass; it stands against 6 N.

        Args:
            ahead: N; ``left``, too.
            seconds: For so long.
            torque: N m, turns it to the left.
        """
        return _at_once(lambda robot: robot.push((ahead, left), seconds, torque=torque))

    @makes_fault
    def shove(
        self,
        ahead: MetresPerSecond = 0.0,
        left: MetresPerSecond = 0.0,
        *,
        turn: RadiansPerSecond = 0.0,
    ) -> Begin:
        """Give the base a velocity at once, m/s, and a turn rate, rad/s to the left."""
        return _at_once(lambda robot: robot.shove((ahead, left), turn=turn))


@dataclass(frozen=True, eq=False)
class Breakage:
    """Breaks a part of the robot; where it ends, what earlier and later faults say counts again."""

    part: str
    changes: Mapping[str, Any]

    def __call__(self, fault: FaultInstance) -> None:
        """Begin."""
        faults = _robot(fault).faults
        with mistakes_of_test(fault.fault.what):
            faults.set(self.part, **self.changes)
        fault.made = self

        def mend() -> None:
            faults.clear(self.part)
            others = (one.made for one in fault.run.faults if one.ended_ns is None)
            for other in others:
                if isinstance(other, Breakage) and other.part == self.part and other is not self:
                    faults.set(self.part, **other.changes)

        fault.undo(mend)


def _broken(part: str, **changes: Any) -> Begin:
    return Breakage(part, changes)


def _at_once(act: Callable[[Any], None]) -> Begin:
    """Give what happens to the robot once."""

    def begin(fault: FaultInstance) -> None:
        with mistakes_of_test(fault.fault.what):
            act(_robot(fault))

    return begin


def _robot(fault: FaultInstance) -> Any:
    return fault.run.robot_run.robot


def _sides(what: str, wheel: str) -> tuple[str, ...]:
    sides = {"left": ("left",), "right": ("right",), "both": ("left", "right")}
    if wheel not in sides:
        raise no_such(f"wheel for {what}", wheel, list(sides))
    return sides[wheel]
