"""The governor: every twist that a maneuver wants passes it on its way to the base.

It checks, in this order: are the senses fresh; does another reason hold the base; is a bumper
pressed, or a cliff, where it drives; can the hull stop before everything in the scan along this
twist, turning included; does a moving obstacle approach on a collision course. The wanted twist is
first limited to the robot's own limits and to the speed limit, so that each check is about a twist
that the base can drive. The result is that twist, a slower one on the same arc, zero, or, while a
goal drives, a twist away from a moving obstacle; and the reason.

The motions of a car: what it cannot drive becomes arcs that it can.

A car turns only while it drives. A turn on the spot becomes a turn in several strokes: ahead on the
sharpest arc, then back on the opposite one, both of which turn the base to the same side. A
stroke ends where the governor sees no room, or after :data:`STROKE_RAD`, so that the base stays
near its place. An arc that is too sharp becomes the sharpest one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from action_servers.core.clearance import (
    STROKE_M,
    Footprint,
    footprint,
    free_angle,
    free_distance,
    free_slide,
    into_frame,
    obstacle_points,
    out_of_frame,
    pose_at,
)
from action_servers.core.drive_limits import speed_to_stop_in
from action_servers.core.give_way import GiveWay, grown
from action_servers.core.grid import Floats
from action_servers.core.limits import SLOWEST_DRIVE, SLOWEST_TURN
from action_servers.core.maneuver import ZERO, ErrorCode, Held, Observation, Reason, Scan, stale
from action_servers.core.progress import Progress
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.base.geometry import Pose2D, Twist2D, wrap
from bt_mission.robots.model import RobotModel

STROKE_RAD = 0.4
"""The turn of one stroke: with an arc of 0.74 m, the base stays within 0.3 m of its place."""

_AGAIN_S = 0.3
"""A turn that pauses for longer begins with a stroke ahead again."""


class Steering:
    """Replaces the twists that a car cannot drive. A step calls :meth:`arc` once."""

    def __init__(self, robot: RobotModel) -> None:
        self._sharpest = robot.drive.max_curvature
        self._fastest = robot.max_linear_velocity
        self._direction = 1.0
        self._began: float | None = None
        self._last_s = -math.inf

    def arc(self, wanted: Twist2D, now: Observation) -> Twist2D:
        """Return a twist that the car can drive instead of a wanted one."""
        linear, angular = wanted.linear, wanted.angular
        if linear or not angular:
            most = self._sharpest * abs(linear)
            if abs(angular) <= most:
                return Twist2D(linear, angular)
            return Twist2D(linear, math.copysign(most, angular))
        yaw = 0.0 if now.odom is None else now.odom.yaw
        if now.time_s - self._last_s > _AGAIN_S:
            self._direction, self._began = 1.0, None
        self._last_s = now.time_s
        if self._began is None:
            self._began = yaw
        elif abs(wrap(yaw - self._began)) >= STROKE_RAD:
            self.reverse(now)
        return self._stroke(angular, now.speed_limit)

    def reverse(self, now: Observation) -> None:
        """Begin a stroke in the other direction."""
        self._direction, self._began = -self._direction, 0.0 if now.odom is None else now.odom.yaw

    def _stroke(self, angular: float, speed_limit: float) -> Twist2D:
        speed = min(abs(angular) / self._sharpest, self._fastest, speed_limit)
        return Twist2D(self._direction * speed, math.copysign(speed * self._sharpest, angular))


_GENTLE = 0.5
"""Share of what the base can brake by that is counted on, so that it follows with ease."""

_SEEN_M = 0.3
"""The longest drive from one scan to the next, m; no scan is older than `hold_after`."""

_COMES = "something comes at the robot"
_LOGGED = (Reason.NO_ODOMETRY, Reason.NO_SCAN)


@dataclass(slots=True)
class Allowed:
    """The twist that is commanded, and why it differs from the wanted one, if it does."""

    twist: Twist2D
    held_by: Reason | None = None


class Governor:
    """Decides which part of a wanted twist reaches the base; `tuning` is for goals from now on.

    A step begins with :meth:`look` and, unless the goal ends, ends with :meth:`allow`.
    """

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self.tuning = tuning
        self.is_held = False
        """Whether the base must stand for another reason: an executive is late."""
        self.give_way = GiveWay(robot, tuning)
        self._robot = robot
        self._fastest, self._sharpest = robot.max_linear_velocity, robot.max_angular_velocity
        self._room = Room(robot)
        self._wide_room = Room(robot, STROKE_M)
        is_car = math.isfinite(robot.drive.max_curvature)
        self._steering = Steering(robot) if is_car else None
        self._in_room = self._room.allow
        if is_car or robot.drive.slide_velocity or not robot.sees_behind:
            self._in_room = self._allow_motion
        self.notes: list[str] = []
        """Notes to log for this goal, each once; the caller that logs them clears the list."""
        self.begin()

    def begin(self) -> None:
        """Begin a goal that drives."""
        self._tuning = self.tuning
        self._room.tuning = self._wide_room.tuning = self._tuning
        self._progress = Progress(self._robot, self._tuning.blocked_after)
        self._commanded = ZERO
        self._held: Held | None = None
        self._is_blind = False
        self._noted: set[Reason] = set()
        self._hold_after_s = min(self._tuning.hold_after, self._tuning.sensor_timeout)
        self.notes.clear()
        self.give_way.begin(self._tuning)

    def look(self, now: Observation) -> Observation:
        """Handle an observation; return it with what holds the base, for the maneuver."""
        gives_way = not self.is_held and self.give_way.look(now)
        watched = ZERO if self.give_way.is_active else self._commanded
        fault = self._progress.fault(now, watched)
        missing = stale(now, self._hold_after_s)
        self._is_blind = self.is_held or missing is not None
        if missing is not None:
            self._hold(now, Reason[ErrorCode(missing.error_code).name], missing.reason, ZERO)
        elif self.is_held:
            self._hold(now, Reason.EXECUTIVE, "the executive is late", ZERO)
        elif fault is not None:
            self._hold(now, Reason.BASE, fault, self._commanded)
        elif gives_way:
            self._hold(now, Reason.MOVING, _COMES, self._commanded)
        elif self._held is not None and self._held.by is not Reason.OBSTACLE:
            self._held = None
        return now if self._held is None else replace(now, held=self._held)

    def allow(self, wanted: Twist2D, now: Observation) -> Allowed:
        """Return what to command for the next control step."""
        if self._is_blind:
            self._commanded = ZERO
            return Allowed(ZERO, now.held_by)
        linear, angular = wanted.linear, wanted.angular
        fastest, sharpest = self._fastest, self._sharpest
        if not (-fastest <= linear <= fastest and -sharpest <= angular <= sharpest):
            linear = max(-fastest, min(linear, fastest))
            wanted = Twist2D(linear, max(-sharpest, min(angular, sharpest)), wanted.lateral)
        if now.speed_limit < math.inf:
            speed = math.hypot(linear, wanted.lateral)
            if speed > now.speed_limit:
                wanted = _scaled(wanted, now.speed_limit / speed)
        hazard = None
        if now.hazards:
            hazard = next((each for each in now.hazards if each.is_towards(wanted)), None)
        if hazard is not None:
            twist, obstacle = ZERO, hazard.words
        else:
            twist, obstacle = self._in_room(wanted, now)
        self._commanded = self.give_way.command(now, twist)
        if self.give_way.times or self.give_way.is_trapped:
            self.notes += self.give_way.notes()
        if self._commanded is not twist:
            self._hold(now, Reason.MOVING, _COMES, self._commanded)
        elif obstacle:
            self._hold(now, Reason.OBSTACLE, obstacle, twist)
        else:
            self._held = None
        return Allowed(self._commanded, None if self._held is None else self._held.by)

    def _allow_motion(self, wanted: Twist2D, now: Observation) -> tuple[Twist2D, str]:
        """Return the twist of a base that is a car, slides, or is blind behind; and the obstacle.

        A turn of a car has two strokes to try: those that keep a wide margin first.
        """
        steering = self._steering
        if steering is None:
            most = self._robot.drive.slide_velocity
            lateral = max(-most, min(wanted.lateral, most))
            return self._allow_seen(Twist2D(wanted.linear, wanted.angular, lateral), now)
        arc = steering.arc(wanted, now)
        if wanted.linear or not wanted.angular:
            return self._allow_seen(arc, now)
        other = Twist2D(-arc.linear, arc.angular)
        for room in (self._wide_room, self._room):
            for stroke in (arc, other):
                twist, obstacle = self._allow_seen(stroke, now, room)
                if twist != ZERO:
                    if stroke is other:
                        steering.reverse(now)
                    return twist, obstacle
        return twist, obstacle

    def _allow_seen(
        self, wanted: Twist2D, now: Observation, room: Room | None = None
    ) -> tuple[Twist2D, str]:
        """Return the twist that the room allows, never towards what no lidar looks at."""
        if wanted.linear < 0.0 and not self._robot.sees_behind:
            return ZERO, "the lidars do not see all of the ground behind"
        room = room or self._room
        return room.slide(wanted, now) if wanted.lateral else room.allow(wanted, now)

    def _hold(self, now: Observation, by: Reason, words: str, twist: Twist2D) -> None:
        held = self._held
        goes_on = held is not None and held.by is by and held.is_standing == (twist == ZERO)
        since_s = held.since_s if held is not None and goes_on else now.time_s
        self._held = Held(by, words, twist, since_s)
        if by in _LOGGED and by not in self._noted:
            self._noted.add(by)
            self.notes.append(f"the base is held: {words}")


def _slowed(wanted: Twist2D, speed: float, allowed: float, slowest: float) -> Twist2D:
    """Return a twist at the allowed speed instead of its own; zero below the slowest."""
    if allowed < min(slowest, speed):
        return ZERO
    return _scaled(wanted, min(1.0, allowed / speed))


def _scaled(twist: Twist2D, share: float) -> Twist2D:
    return Twist2D(twist.linear * share, twist.angular * share, twist.lateral * share)


class Room:
    """The free space that the newest scan leaves to the hull, updated by odometry between scans.

    The base needs the distance until it stands: as it drives until the next command takes effect,
    then braking at half of its deceleration, then a margin. The hull is grown by `wider` metres.
    """

    def __init__(self, robot: RobotModel, wider: float = 0.0) -> None:
        self.tuning = TUNING
        self._robot = robot
        self._body = grown(footprint(robot), wider)
        self._scan: Scan | None = None
        self._seen: Floats = np.empty((2, 0))
        self._points: Floats | None = None
        self._at = Pose2D(0.0, 0.0, 0.0)
        self._nearest = math.inf
        self._longest_stop_s = 1.0 + max(
            robot.max_linear_velocity / robot.max_linear_acceleration,
            robot.max_angular_velocity / robot.max_angular_acceleration,
        )

    def allow(self, wanted: Twist2D, now: Observation) -> tuple[Twist2D, str]:
        """Return the fastest twist on the wanted arc, and the obstacle, or ""."""
        linear, angular = abs(wanted.linear), abs(wanted.angular)
        if (not linear and not angular) or now.scan is None or now.odom is None:
            return wanted, ""
        if angular and 0.0 < linear < SLOWEST_DRIVE:
            # The base is nearly standing: it moves less than 3 mm until it stands.
            ahead, words = self.allow(Twist2D(wanted.linear, 0.0), now)
            turned, or_words = self.allow(Twist2D(0.0, wanted.angular), now)
            return Twist2D(ahead.linear, turned.angular), words or or_words
        if now.scan is not self._scan:
            self._take(now, now.scan)
        robot = self._robot
        delay_s = 1.0 / robot.control_rate + max(0.0, now.time_s - now.odom_stamp_s)
        turn_s = angular / robot.max_angular_acceleration
        turns = not linear
        if turns:
            margin = math.radians(self.tuning.turn_margin)
            needed = angular * (delay_s + turn_s) + margin
        else:
            margin = self.tuning.stop_margin
            braking_s = max(linear / robot.max_linear_acceleration, turn_s)
            needed = linear * (delay_s + braking_s) + margin
        gone = math.hypot(now.odom.x - self._at.x, now.odom.y - self._at.y)
        if self._nearest - gone > self._body.turning_radius + (0.0 if turns else needed):
            return wanted, ""
        points = into_frame(now.odom, self._near())
        if turns:
            room = free_angle(points, self._body, math.copysign(needed, wanted.angular))
            speed, slowest, braking = angular, SLOWEST_TURN, robot.max_angular_acceleration
            words = f"no room to turn {'left' if wanted.angular > 0.0 else 'right'}"
        else:
            curvature = wanted.angular / wanted.linear
            room = free_distance(
                points, self._body, curvature, math.copysign(needed, wanted.linear)
            )
            speed, slowest, braking = linear, SLOWEST_DRIVE, linear / braking_s
            side = "ahead" if wanted.linear > 0.0 else "behind"
            words = f"an obstacle is in the way, {side}"
        if room >= needed:
            return wanted, ""
        allowed = speed_to_stop_in(room - margin, deceleration=_GENTLE * braking, delay_s=delay_s)
        return _slowed(wanted, speed, allowed, slowest), words

    def slide(self, wanted: Twist2D, now: Observation) -> tuple[Twist2D, str]:
        """Return the fastest slide in the wanted direction; it turns only if the circle is free.

        While it turns, the hull is taken for the circle that it sweeps.
        """
        if now.scan is None or now.odom is None:
            return wanted, ""
        if now.scan is not self._scan:
            self._take(now, now.scan)
        robot, body = self._robot, self._body
        speed = math.hypot(wanted.linear, wanted.lateral)
        delay_s = 1.0 / robot.control_rate + max(0.0, now.time_s - now.odom_stamp_s)
        margin = self.tuning.stop_margin
        needed = speed * (delay_s + speed / robot.max_linear_acceleration) + margin
        points = into_frame(now.odom, self._near())
        if wanted.angular:
            radius = body.turning_radius
            body = Footprint(radius, -radius, radius, radius)
        direction = math.atan2(wanted.lateral, wanted.linear)
        room = free_slide(points, body, direction, needed)
        if room >= needed:
            return wanted, ""
        deceleration = _GENTLE * robot.max_linear_acceleration
        allowed = speed_to_stop_in(room - margin, deceleration=deceleration, delay_s=delay_s)
        return _slowed(wanted, speed, allowed, SLOWEST_DRIVE), "an obstacle is in the way, aside"

    def _take(self, now: Observation, scan: Scan) -> None:
        self._scan, self._points = scan, None
        self._seen = obstacle_points(scan, self._robot.lidar)
        x, y = self._seen
        self._nearest = float(np.minimum.reduce(np.hypot(x, y), initial=math.inf))
        self._at = pose_at(now, scan.stamp_s)

    def _near(self) -> Floats:
        """Return what the scan hit within reach, in the odometry frame."""
        if self._points is not None:
            return self._points
        reach = self._robot.max_linear_velocity * self._longest_stop_s + self.tuning.stop_margin
        x, y = self._seen
        near = np.hypot(x, y) < self._body.turning_radius + reach + _SEEN_M
        self._points = out_of_frame(self._at, self._seen[:, near].T)
        return self._points
