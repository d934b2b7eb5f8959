"""Faults of the robot itself: sensors, wheels, motors, and what pushes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from bt_mission.core.errors import BtMissionError
from bt_mission.testing.errors import ScenarioError, no_such
from bt_mission.testing.faults.fault import Fault, FaultInstance, Maker

if TYPE_CHECKING:
    from bt_mission.testing.faults.fault import FaultStages

Side = Literal["left", "right", "both"]
Pair = tuple[float, float]


class RobotFaults(Maker):
    """Faults of the simulated robot: all others see of them what they do to its topics.

    A sensor's fault shows from its next measurement on, a wheel's from the next step of the
    physics. Of two that say something about the same figure, the later counts; when it ends, the
    other does again. A figure that cannot be is a ScenarioError when the fault begins.
    """

    def __init__(self, stages: FaultStages) -> None:
        super().__init__(stages)
        self._changes: list[tuple[FaultInstance, str, dict[str, Any]]] = []

    # ---- sensors -------------------------------------------------------------------------

    def lidar_noise(self, sigma: float, *, lasting: float | None = None) -> Fault:
        """Add normal noise of so many metres (1 sigma) to every distance, on top of its own."""
        return self._break("lidar_noise", "lidar", {"noise": sigma}, lasting, sigma=sigma)

    def lidar_bias(self, metres: float, *, lasting: float | None = None) -> Fault:
        """Add the same to every distance."""
        return self._break("lidar_bias", "lidar", {"bias": metres}, lasting, metres=metres)

    def lidar_blind(
        self, *sectors: Pair, share: float = 0.0, lasting: float | None = None
    ) -> Fault:
        """Lose rays, as where there is nothing.

        :param sectors: each from a bearing counter-clockwise to another, deg, left positive:
            (-20, 20) lies ahead, (160, -160) behind.
        :param share: of all rays, others in each scan.
        """
        changes: dict[str, Any] = {}
        if sectors:
            changes["sectors"] = sectors
        if share:
            changes["dropout"] = share
        if not changes:
            raise ScenarioError("lidar_blind: give sectors, such as (-20, 20), or a share")
        given = {"sectors": sectors or None, "share": share or None}
        return self._break("lidar_blind", "lidar", changes, lasting, **given)

    def lidar_frozen(self, *, lasting: float | None = None) -> Fault:
        """Repeat the last scan with fresh stamps."""
        return self._break("lidar_frozen", "lidar", {"frozen": True}, lasting)

    def lidar_dead(self, *, lasting: float | None = None) -> Fault:
        """Publish no scans."""
        return self._break("lidar_dead", "lidar", {"dead": True}, lasting)

    def odometry_error(
        self,
        *,
        left_radius: float = 0.0,
        right_radius: float = 0.0,
        separation: float = 0.0,
        lasting: float | None = None,
    ) -> Fault:
        """Reckon with wrong figures, each by its relative error: 0.1 is a tenth too large."""
        given = {
            "left_radius": left_radius or None,
            "right_radius": right_radius or None,
            "separation": separation or None,
        }
        changes = {f"{name}_error": value for name, value in given.items() if value is not None}
        if not changes:
            raise ScenarioError("odometry_error: give left_radius, right_radius or separation")
        return self._break("odometry_error", "odometry", changes, lasting, **given)

    def odometry_drift(
        self, ahead: float = 0.0, *, turn: float = 0.0, lasting: float | None = None
    ) -> Fault:
        """Reckon with a motion that is none: m/s ahead, deg/s to the left."""
        changes = {"drift": ahead, "turn_drift": turn}
        return self._break(
            "odometry_drift", "odometry", changes, lasting, ahead=ahead or None, turn=turn or None
        )

    def odometry_dead(self, *, lasting: float | None = None) -> Fault:
        """Publish no odometry, nor the transforms that come from it."""
        return self._break("odometry_dead", "odometry", {"dead": True}, lasting)

    def imu_dead(self, *, lasting: float | None = None) -> Fault:
        """Publish nothing of the IMU."""
        return self._break("imu_dead", "imu", {"dead": True}, lasting)

    def joints_dead(self, *, lasting: float | None = None) -> Fault:
        """Publish no joint states; odometry goes on."""
        return self._break("joints_dead", "joints", {"dead": True}, lasting)

    def camera_noise(self, sigma: float, *, lasting: float | None = None) -> Fault:
        """Add normal noise to each channel of each pixel, 1 sigma as a share of full scale."""
        return self._break("camera_noise", "camera", {"noise": sigma}, lasting, sigma=sigma)

    def camera_black(self, *, lasting: float | None = None) -> Fault:
        """Show nothing but black."""
        return self._break("camera_black", "camera", {"black": True}, lasting)

    def camera_frozen(self, *, lasting: float | None = None) -> Fault:
        """Repeat the last picture with fresh stamps."""
        return self._break("camera_frozen", "camera", {"frozen": True}, lasting)

    def camera_dead(self, *, lasting: float | None = None) -> Fault:
        """Publish no pictures."""
        return self._break("camera_dead", "camera", {"dead": True}, lasting)

    # ---- wheels and motors ---------------------------------------------------------------

    def slip_wheel(self, wheel: Side, grip: float = 0.05, *, lasting: float | None = None) -> Fault:
        """Let a wheel slip.

        :param wheel: left, right or both.
        :param grip: its coefficient of friction, 0 to 1.
        """
        changes = {f"{side}_grip": grip for side in _sides("slip_wheel", wheel)}
        return self._break("slip_wheel", "wheels", changes, lasting, wheel=wheel, grip=grip)

    def block_wheel(self, wheel: Side, *, lasting: float | None = None) -> Fault:
        """Block a wheel: left, right or both."""
        changes = {f"{side}_blocked": True for side in _sides("block_wheel", wheel)}
        return self._break("block_wheel", "wheels", changes, lasting, wheel=wheel)

    def motors_off(self, *, lasting: float | None = None) -> Fault:
        """Take the motors' power; the base rolls to rest."""

        def begin(fault: FaultInstance) -> None:
            robot = _robot(fault)
            robot.power_motors(on=False)
            fault.undo(lambda: robot.power_motors(on=True))

        return self._fault("motors_off", begin, lasting)

    def battery_charge(self, share: float) -> Fault:
        """Set the battery's charge, 0 to 1; empty, it takes the motors' power."""
        return self._stroke("battery_charge", "charge_battery", (share,), share=share)

    # ---- from outside --------------------------------------------------------------------

    def push(
        self,
        ahead: float = 0.0,
        left: float = 0.0,
        *,
        seconds: float = 0.2,
        torque: float = 0.0,
    ) -> Fault:
        """Push the base at its centre of mass; it stands against 6 N.

        :param ahead: N; ``left``, too.
        :param seconds: for so long.
        :param torque: N m, turns it to the left.
        """
        return self._stroke(
            "push",
            "push",
            ((ahead, left), seconds),
            {"torque": torque},
            ahead=ahead or None,
            left=left or None,
            seconds=seconds,
            torque=torque or None,
        )

    def shove(self, ahead: float = 0.0, left: float = 0.0, *, turn: float = 0.0) -> Fault:
        """Give the base a velocity at once, m/s, and a turn rate, rad/s to the left."""
        return self._stroke(
            "shove",
            "shove",
            ((ahead, left),),
            {"turn": turn},
            ahead=ahead or None,
            left=left or None,
            turn=turn or None,
        )

    # ---- inside --------------------------------------------------------------------------

    def _stroke(
        self,
        what: str,
        method: str,
        arguments: tuple[Any, ...],
        options: dict[str, Any] | None = None,
        **parameters: Any,
    ) -> Fault:
        def begin(fault: FaultInstance) -> None:
            try:
                getattr(_robot(fault), method)(*arguments, **(options or {}))
            except BtMissionError as error:
                raise ScenarioError(f"{what}: {error}") from error

        return self._fault(what, begin, **parameters)

    def _break(
        self,
        what: str,
        part: str,
        changes: dict[str, Any],
        lasting: float | None,
        **parameters: Any,
    ) -> Fault:
        def begin(fault: FaultInstance) -> None:
            faults = _robot(fault).faults
            try:
                faults.set(part, **changes)
            except BtMissionError as error:
                raise ScenarioError(f"{what}: {error}") from error
            change = (fault, part, changes)
            self._changes.append(change)

            def mend() -> None:
                self._changes.remove(change)
                faults.clear(part)
                for other, other_part, others in self._changes:
                    if other.run is fault.run and other_part == part:
                        faults.set(part, **others)

            fault.undo(mend)

        return self._fault(what, begin, lasting, **parameters)


def _robot(fault: FaultInstance) -> Any:
    return fault.run.stage.sim.simulation


def _sides(what: str, wheel: str) -> tuple[str, ...]:
    sides = {"left": ("left",), "right": ("right",), "both": ("left", "right")}
    if wheel not in sides:
        raise no_such(f"wheel for {what}", wheel, list(sides))
    return sides[wheel]
