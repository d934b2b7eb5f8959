"""Checks of the robot's state when a goal arrives; a refusal names what was expected."""

from __future__ import annotations

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import Finished, Observation, Refusal
from action_servers.core.tuning import TUNING


def refusal(*faults: str | None, unready: Finished | None = None) -> Refusal | None:
    """Return why a goal is refused, or None: its first error, else what is not ready."""
    reasons = (*faults, None if unready is None else unready.reason)
    return next((Refusal(reason) for reason in reasons if reason is not None), None)


def missing(now: Observation) -> str | None:
    """Return what navigation needs and has not received yet, or None."""
    if now.grid is None:
        return "no map has arrived yet; is something publishing the topic map?"
    if now.grid.cells.size == 0:
        return "the map has no cells"
    if now.map_pose is None:
        return "the robot's place on the map is not known yet; is something publishing map to odom?"
    if now.scan is None:
        return "no scan has arrived yet; is the robot running?"
    return None


def stale(now: Observation, limit_s: float = TUNING.sensor_timeout) -> Finished | None:
    """Return the end of a goal that drives without fresh scan, guards and odometry, or None.

    A stamp from the future is as invalid as an old one: both mean that clocks differ.
    """
    if now.odom is not None and now.scan is not None:
        ages = now.time_s - now.odom_stamp_s, now.time_s - now.scan.stamp_s
        if -limit_s <= ages[0] <= limit_s and -limit_s <= ages[1] <= limit_s:
            return _ended_by(silent_guard(now, limit_s)) if now.guards else None
    finished = stale_odometry(now, limit_s)
    if finished is not None:
        return finished
    scan_stamp = None if now.scan is None else now.scan.stamp_s
    return _ended_by(overdue("scan", scan_stamp, now.time_s, limit_s))


def silent_guard(now: Observation, limit_s: float) -> str | None:
    """Return which bumper or cliff sensor is silent, or None."""
    for guard in now.guards:
        limit = max(limit_s, guard.patience_s)
        reason = overdue(guard.topic, guard.stamp_s, now.time_s, limit)
        if reason is not None:
            return reason
    return None


def _ended_by(reason: str | None) -> Finished | None:
    return None if reason is None else Finished("aborted", ErrorCode.NO_SCAN, reason)


def stale_odometry(now: Observation, limit_s: float = TUNING.sensor_timeout) -> Finished | None:
    """Return the end of a goal that needs only fresh odometry, or None."""
    stamp_s = None if now.odom is None else now.odom_stamp_s
    reason = overdue("odometry", stamp_s, now.time_s, limit_s)
    return None if reason is None else Finished("aborted", ErrorCode.NO_ODOMETRY, reason)


def stale_joints(now: Observation, limit_s: float = TUNING.sensor_timeout) -> str | None:
    """Return why arm and gripper cannot be moved: their joints are not known; or None."""
    stamp_s = None if now.joints is None else now.joints.stamp_s
    return overdue("joint_states", stamp_s, now.time_s, limit_s)


def overdue(what: str, stamp_s: float | None, time_s: float, limit_s: float) -> str | None:
    """Return why a stamp is older than a limit, s, or from the future; None if it is neither."""
    if stamp_s is None:
        return f"no {what} has arrived yet; is the robot running?"
    age = time_s - stamp_s
    if age > limit_s:
        return f"no {what} for {limit_s:g} s: the last is {age:.2f} s old"
    if age < -limit_s:
        return f"the last {what} is stamped {-age:.2f} s in the future; do the clocks agree?"
    return None
