"""What every driving maneuver watches: sensors, odometry, its way, and a base that obeys."""

from __future__ import annotations

import math
from dataclasses import dataclass

from action_servers.core.checks import stale
from action_servers.core.clearance import Points, obstacle_points
from action_servers.core.drive_limits import speed_to_stop_in
from action_servers.core.guard import footprint, free_angle, free_distance
from action_servers.core.limits import SLOWEST_DRIVE, SLOWEST_TURN
from action_servers.core.maneuver import ZERO, ErrorCode, Finished, Observation, Scan
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.core.geometry import Pose2D, Twist2D
from bt_mission.core.robot.model import RobotModel


@dataclass(slots=True)
class Odometer:
    """Adds up odometry poses.

    `max_linear` (m/s) and `max_angular` (rad/s) are the limits of the robot: a step between two
    poses that would need more than twice as much is a jump (odometry was reset), no motion.

    `distance` is the length of the path in metres; `yaw` is the rotation in radians, left
    positive and not wrapped, so that two turns are 4 pi. `aside` is the part of `distance` on
    which the base gave way, and `aside_ahead` the same with what was driven backwards negative.
    """

    max_linear: float
    max_angular: float
    distance: float = 0.0
    yaw: float = 0.0
    aside: float = 0.0
    aside_ahead: float = 0.0
    _last: Pose2D | None = None
    _stamp_s: float = 0.0

    def update(self, now: Observation) -> str | None:
        """Take in the newest pose; return what is wrong with it, or None."""
        pose = now.odom
        if pose is None or (self._last is not None and now.odom_stamp_s == self._stamp_s):
            return None
        last, self._last = self._last, pose
        elapsed = now.odom_stamp_s - self._stamp_s
        self._stamp_s = now.odom_stamp_s
        if last is None:
            return None
        moved = math.hypot(pose.x - last.x, pose.y - last.y)
        turned = math.remainder(pose.yaw - last.yaw, math.tau)
        if moved > 2.0 * self.max_linear * elapsed + 0.05:
            return f"odometry jumped by {moved:.2f} m in {elapsed:.3f} s; was it reset?"
        if abs(turned) > 2.0 * self.max_angular * elapsed + 0.1:
            degrees = math.degrees(turned)
            return f"odometry jumped by {degrees:.0f} deg in {elapsed:.3f} s; was it reset?"
        self.distance += moved
        if now.gives_way:
            ahead = math.cos(pose.yaw) * (pose.x - last.x) + math.sin(pose.yaw) * (pose.y - last.y)
            self.aside += moved
            self.aside_ahead += math.copysign(moved, ahead)
        self.yaw += turned
        return None


ARRIVED_WITHIN = 0.003
"""Metres before the place to stop at which the robot is told to stop."""


class DriveGuard:
    """The guard of one driving maneuver.

    Every step begins with :meth:`fault` and ends with :meth:`command` or :meth:`rest`.
    """

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self._tuning = tuning
        self._robot = robot
        self._odometer = Odometer(robot.max_linear_velocity, robot.max_angular_velocity)
        self._progress = (
            ProgressWatch("m/s", tuning.blocked_after),
            ProgressWatch("rad/s", tuning.blocked_after),
        )
        self._course = CourseWatch(tuning.blocked_after)
        self._resting_since_s: float | None = None

    @property
    def distance(self) -> float:
        """Length of the path driven, metres."""
        return self._odometer.distance

    @property
    def yaw(self) -> float:
        """Rotation made, radians, left positive, not wrapped."""
        return self._odometer.yaw

    def advance(self, direction: float) -> float:
        """Return the way made in a direction (1 ahead, -1 back), metres.

        It is the distance, but for what the base gave way: that counts by where it led.
        """
        odometer = self._odometer
        return odometer.distance - odometer.aside + direction * odometer.aside_ahead

    def fault(self, now: Observation) -> Finished | None:
        """Take in an observation; return how the goal ends if it cannot be driven by."""
        finished = stale(now, self._tuning.sensor_timeout)
        if finished is not None:
            return finished
        jump = self._odometer.update(now)
        return None if jump is None else Finished("aborted", ErrorCode.NO_ODOMETRY, jump)

    def speed_ahead(self, now: Observation, remaining: float, most: float) -> float:
        """Return the speed, up to `most` m/s, that lets the base stand in `remaining` metres."""
        within = self._braking(now, remaining, self._robot.max_linear_acceleration)
        return min(most, max(SLOWEST_DRIVE, within))

    def rate_towards(self, now: Observation, remaining: float, most: float) -> float:
        """Return the rate, up to `most` rad/s, that lets the base stand in `remaining` radians."""
        within = self._braking(now, remaining, self._robot.max_angular_acceleration)
        return min(most, max(SLOWEST_TURN, within))

    def delay_s(self, now: Observation) -> float:
        """Return the time until the next command takes effect, seen from the odometry at hand."""
        return 1.0 / self._robot.control_rate + max(0.0, now.time_s - now.odom_stamp_s)

    def _braking(self, now: Observation, remaining: float, acceleration: float) -> float:
        # Half of what the base can do, so that it follows the slowing down with ease.
        gentle = 0.5 * acceleration
        return speed_to_stop_in(remaining, deceleration=gentle, delay_s=self.delay_s(now))

    def command(self, now: Observation, twist: Twist2D) -> Twist2D | Finished:
        """Return the velocity, or the end of the goal when the base does not follow.

        Without a recent scan and odometry the base is held, so that it stands by the time at which
        they are given up (:meth:`fault`). A base that the pilot holds is not expected to follow.
        """
        self._resting_since_s = None
        if now.is_held or self._age_s(now) > self._tuning.hold_after:
            twist = ZERO
        linear, angular = self._progress
        blocked = linear.update(now.time_s, self.distance, twist.linear) or angular.update(
            now.time_s, self.yaw, twist.angular
        )
        return blocked or self._course.update(now, twist) or twist

    def _age_s(self, now: Observation) -> float:
        scan_s = now.time_s if now.scan is None else now.scan.stamp_s
        return now.time_s - min(scan_s, now.odom_stamp_s)

    def rest(self, now: Observation) -> Twist2D | None:
        """Return zero velocity until the base stands, then None."""
        if self._resting_since_s is None:
            self._resting_since_s = now.time_s
        velocity = now.velocity
        stands = (
            velocity is not None
            and abs(velocity.linear) < self._tuning.rest_linear
            and abs(velocity.angular) < self._tuning.rest_angular
        )
        settled = now.time_s - self._resting_since_s >= self._tuning.settle_limit
        return None if stands or settled else ZERO


@dataclass(slots=True)
class ProgressWatch:
    """Notices a base that does less than a tenth of what it is told, for `patience_s` on end.

    Works alike for metres and for radians; `unit` is that of the speed.
    """

    unit: str
    patience_s: float = TUNING.blocked_after
    _since_s: float | None = None
    _mark: float = 0.0

    def update(self, time_s: float, done: float, speed: float) -> Finished | None:
        """Take in what is done so far and the speed commanded; return the end when blocked."""
        enough = 0.1 * abs(speed) * self.patience_s
        if self._since_s is None or speed == 0.0 or abs(done - self._mark) >= enough:
            self._since_s, self._mark = time_s, done
            return None
        if time_s - self._since_s < self.patience_s:
            return None
        reason = (
            f"blocked: commanded {speed:.2f} {self.unit}, no progress for {self.patience_s:g} s; "
            "the base is held, or refuses commands as late"
        )
        return Finished("aborted", ErrorCode.BLOCKED, reason)


ASTRAY_RATE = 0.25
"""rad/s. An uneven floor turns a base that drives straight on by less, one wheel alone by more."""


@dataclass(slots=True)
class CourseWatch:
    """Notices a base that turns though it is told to drive straight, for `patience_s` on end.

    One wheel is blocked, or slips: the base goes round in circles, and makes way all the same.
    """

    patience_s: float = TUNING.blocked_after
    _since_s: float | None = None

    def update(self, now: Observation, twist: Twist2D) -> Finished | None:
        """Take in what odometry says and what is commanded; return the end when astray."""
        is_straight = twist.linear != 0.0 and twist.angular == 0.0
        if not is_straight or now.velocity is None or abs(now.velocity.angular) < ASTRAY_RATE:
            self._since_s = None
            return None
        if self._since_s is None:
            self._since_s = now.time_s
        if now.time_s - self._since_s < self.patience_s:
            return None
        reason = (
            f"astray: commanded straight on, turning at {now.velocity.angular:.2f} rad/s "
            f"for {self.patience_s:g} s; does a wheel block or slip?"
        )
        return Finished("aborted", ErrorCode.BLOCKED, reason)


_CREEP = 1e-6


class Way:
    """The room that the newest scan leaves to the hull.

    What is needed is the way until the base stands: at the velocity until the next command takes
    effect, counted from the scan, then braking at half of what the base can do, then a margin.
    """

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self._robot = robot
        self._tuning = tuning
        self._body = footprint(robot)
        self._scan: Scan | None = None
        self._points: Points | None = None

    def blocked(self, now: Observation, twist: Twist2D) -> str | None:
        """Return what is wrong with driving on at `twist`, or None when the way is free."""
        scan = now.scan
        if scan is None:
            return "nothing is seen of the way"
        points = self._look(scan)
        delay_s = 1.0 / self._robot.control_rate + max(0.0, now.time_s - scan.stamp_s)
        if abs(twist.linear) > _CREEP:
            braking_s = abs(twist.linear) / self._robot.max_linear_acceleration
            needed = abs(twist.linear) * (delay_s + braking_s) + self._tuning.stop_margin
            horizon = math.copysign(needed, twist.linear)
            room = free_distance(points, self._body, twist.angular / twist.linear, horizon)
            side = "ahead" if twist.linear > 0.0 else "behind"
            return None if room >= needed else f"an obstacle stands in the way, {side}"
        braking_s = abs(twist.angular) / self._robot.max_angular_acceleration
        needed = abs(twist.angular) * (delay_s + braking_s)
        needed += math.radians(self._tuning.turn_margin)
        room = free_angle(points, self._body, math.copysign(needed, twist.angular))
        side = "left" if twist.angular > 0.0 else "right"
        return None if room >= needed else f"no room to turn {side}"

    def _look(self, scan: Scan) -> Points:
        if scan is not self._scan or self._points is None:
            self._scan = scan
            self._points = obstacle_points(scan, self._robot.lidar).T
        return self._points
