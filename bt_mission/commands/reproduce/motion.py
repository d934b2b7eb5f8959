"""Faults that the motion shows: wheels, motors, odometry, and what pushes the robot.

Four accounts of the motion are compared: what was commanded, how the wheels turn by their encoders
(`joint_states`), what odometry says, and how the robot moves on the map. Wheels that do not follow
commands are blocked or have no power. Odometry that differs from the wheels is wrong. A robot that
moves other than its wheels slips, if it moves less, or is pushed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bt_mission.commands.reproduce.diagnosed import DiagnosedFault, fault_at
from bt_mission.commands.reproduce.evidence import Evidence, Floats, Path2D
from bt_mission.commands.reproduce.matching import is_seen
from bt_mission.commands.reproduce.silences import spans_where
from bt_mission.robots.drives import DifferentialDrive
from bt_mission.robots.model import RobotModel
from bt_mission.scenarios.faults.planned import PlannedFault
from sim.physics.pushes import STRONGEST

STEP_S = 0.05
MOST_WORN = 0.1
"""Wheels that are usually larger or smaller by a smaller share are worn."""
LEAST_V, LEAST_W = 0.006, 0.03
"""m/s and rad/s by which odometry differs from the wheels."""
SLIP_V, SLIP_W = 0.04, 0.15
"""m/s and rad/s by which the robot moves other than its wheels."""
SIDEWAYS = 0.03
MOMENT = 1.3
"""The sum of these three, as shares of their limits, that counts in a single sample."""
FEW_SAMPLES, OFTEN, OFTEN_SHARE, MUCH_LARGER = 2, 3, 0.2, 4.0
"""Jumps of at most two samples are corrections if a run has three, and one in five seconds."""
IMPULSE_S = 1.0
"""Longer is no push."""
PUSH_RISES_S = 0.12
STANDS_N = 6.0
"""A push of less moves nothing."""
STANDING_RAD_S, TURNING_RAD_S = 0.1, 0.9
SETTLED = 12
"""Samples before and after a span whose place is compared."""
LEAST_DRIFT, BEYOND_NOISE = (0.004, 0.006), 3.0
"""M and rad of the best localisation, and how many times the noise a fault has to be."""
FEW_DRIFTS = 10
WELL_PLACED_M = 0.02
GRIPS = (0.0, 0.02, 0.05, 0.1, 0.2)


@dataclass(frozen=True)
class MotionAccounts:
    """The accounts of the motion at the same instants, 20 Hz; NaN where one is missing."""

    times: Floats
    command_v: Floats
    command_w: Floats
    odom_v: Floats
    odom_w: Floats
    wheel_left: Floats
    wheel_right: Floats
    joint_v: Floats
    joint_w: Floats
    ahead: Floats
    left: Floats
    turn: Floats


def separation_of(robot: RobotModel) -> float:
    """Return the distance of the wheels, m; of other kinds of base, the width of the hull."""
    base = robot.drive
    return (
        base.wheel_separation if isinstance(base, DifferentialDrive) else 2 * robot.hull.half_width
    )


def motion_of(evidence: Evidence, robot: RobotModel) -> MotionAccounts:
    """Return the accounts of the motion.

    Odometry is the mean of an interval, wheels are of an instant, so two of these are averaged.
    """
    times = np.arange(0.0, max(evidence.end_s, STEP_S), STEP_S)
    base = robot.drive
    radius = base.wheel_radius
    # The wheels of other kinds of base do not have two speeds.
    wheels = evidence.wheels if isinstance(base, DifferentialDrive) else evidence.wheels[:0]
    separation = separation_of(robot)
    left, right = _at(wheels, 1, times), _at(wheels, 2, times)
    mean_left = (left + _at(wheels, 1, times - STEP_S)) / 2
    mean_right = (right + _at(wheels, 2, times - STEP_S)) / 2
    if evidence.is_localised and len(evidence.track) > 4:
        x, y, yaw = evidence.track.at(times)
        x0, y0, yaw0 = evidence.track.at(times - STEP_S)
        dx, dy, middle = (x - x0) / STEP_S, (y - y0) / STEP_S, (yaw + yaw0) / 2
        ahead = np.cos(middle) * dx + np.sin(middle) * dy
        aside = np.cos(middle) * dy - np.sin(middle) * dx
        turn = (yaw - yaw0) / STEP_S
    else:
        ahead = aside = turn = np.full(len(times), np.nan)
    return MotionAccounts(
        times=times,
        command_v=_held(evidence.commands, 1, times),
        command_w=_held(evidence.commands, 2, times),
        odom_v=_at(evidence.odometry, 4, times),
        odom_w=_at(evidence.odometry, 5, times),
        wheel_left=left,
        wheel_right=right,
        joint_v=radius * (mean_left + mean_right) / 2,
        joint_w=radius * (mean_right - mean_left) / separation,
        ahead=ahead,
        left=aside,
        turn=turn,
    )


def _at(table: Floats, column: int, times: Floats) -> Floats:
    """Return a column at times, NaN where the nearest samples are far."""
    if len(table) < 2:
        return np.full(len(times), np.nan)
    values = np.interp(times, table[:, 0], table[:, column])
    after = np.clip(np.searchsorted(table[:, 0], times - 1e-6), 0, len(table) - 1)
    before = np.maximum(after - 1, 0)
    gap = np.minimum(np.abs(table[after, 0] - times), np.abs(table[before, 0] - times))
    values[gap > 3 * STEP_S] = np.nan
    return values


def _held(table: Floats, column: int, times: Floats) -> Floats:
    """Return the newest value of a column at times; 0 without one for half a second."""
    if not len(table):
        return np.full(len(times), np.nan)
    number = np.searchsorted(table[:, 0], times + 1e-6) - 1
    values = np.where(number >= 0, table[np.maximum(number, 0), column], 0.0)
    age = times - table[np.maximum(number, 0), 0]
    return np.where(age > 0.5, 0.0, values)


def motion_faults(
    evidence: Evidence, robot: RobotModel, others: Sequence[DiagnosedFault], fit: Floats
) -> Iterator[DiagnosedFault]:
    """Yield faults of wheels, motors and odometry, and pushes.

    Args:
        others: Faults that are known, such as silences of odometry.
        fit: Times, s, with how far scans are from the world, m.
    """
    motion = motion_of(evidence, robot)
    stopped = list(_not_turning(evidence, robot, motion))
    yield from stopped
    yield from _wrong_odometry(robot, motion)
    known = [(fault.start - 0.15, (fault.end or evidence.end_s) + 0.3) for fault in stopped]
    known += [
        (fault.start - 0.1, (fault.end or evidence.end_s) + 0.3)
        for fault in others
        if fault.name in ("odometry_dead", "drop")
    ]
    driven = _driven(motion)
    for fault in _slips(robot, motion, known, fit):
        if is_seen(evidence, fault.start, fault.end or evidence.end_s, driven):
            yield fault


# ---- motors and blocked wheels ---------------------------------------------------------------


def _not_turning(
    evidence: Evidence, robot: RobotModel, motion: MotionAccounts
) -> Iterator[DiagnosedFault]:
    """Yield the spans in which wheels do not follow what is commanded."""
    off = _motors_off_by_goals(evidence)
    if off is not None:
        yield off
    if not isinstance(robot.drive, DifferentialDrive):
        return
    half = separation_of(robot) / 2
    wheels = (
        ("left", motion.wheel_left, (motion.command_v - half * motion.command_w)),
        ("right", motion.wheel_right, (motion.command_v + half * motion.command_w)),
    )
    spans: dict[str, list[tuple[float, float]]] = {}
    for side, turning, wanted in wheels:
        reference = turning
        if np.isnan(turning).all():
            sign = -1 if side == "left" else 1
            reference = (motion.odom_v + sign * half * motion.odom_w) / robot.drive.wheel_radius
        stands = np.abs(reference) < STANDING_RAD_S
        asked = np.abs(wanted) / robot.drive.wheel_radius > TURNING_RAD_S
        before = np.concatenate((np.zeros(4, np.bool_), asked[:-4]))
        spans[side] = spans_where(motion.times, stands & asked & before, 4, gap_s=0.3)
    for begin, end in spans["left"]:
        other = next((span for span in spans["right"] if _overlap(span, (begin, end))), None)
        yield _blocked(motion, "left" if other is None else "both", begin, end, off)
    for begin, end in spans["right"]:
        if not any(_overlap(span, (begin, end)) for span in spans["left"]):
            yield _blocked(motion, "right", begin, end, off)


def _motors_off_by_goals(evidence: Evidence) -> DiagnosedFault | None:
    for goal in evidence.goals:
        text = str((goal.result or {}).get("error_msg", ""))
        if "motors off" in text and goal.end_ns is not None:
            at = evidence.since_start(goal.served_end_ns or goal.end_ns) - STEP_S
            empty = evidence.battery[evidence.battery[:, 0] <= at + 0.1]
            if len(empty) and empty[-1, 1] < 0.5:
                return None  # the battery explains it
            return DiagnosedFault(
                fault_at(at, "motors_off"),
                f"{goal.action} ends with '{text}'",
                0.9,
                round(at, 2),
            )
    return None


def _overlap(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] < b[1] + 0.1 and b[0] < a[1] + 0.1


def _blocked(
    motion: MotionAccounts, wheel: str, begin: float, end: float, off: DiagnosedFault | None
) -> DiagnosedFault:
    start = begin
    index = round(begin / STEP_S)
    turning = np.abs(motion.wheel_left) + np.abs(motion.wheel_right)
    while index > 0 and turning[index - 1] < 2 * STANDING_RAD_S and begin - start < 0.3:
        index -= 1
        start = motion.times[index]
    lasting = None if end >= motion.times[-1] - 0.15 else end - start + STEP_S
    blocked = fault_at(start - STEP_S, "block_wheel", wheel, lasting=lasting)
    unpowered = fault_at(start - STEP_S, "motors_off", lasting=lasting)
    words = "neither wheel turns" if wheel == "both" else f"the {wheel} wheel does not turn"
    is_off = off is not None and wheel == "both"
    return DiagnosedFault(
        unpowered if is_off else blocked,
        f"{words}, as commands ask for",
        0.7 if wheel == "both" else 0.9,
        round(start - STEP_S, 2),
        None if lasting is None else round(end, 2),
        (unpowered,) if wheel == "both" and not is_off else (),
    )


# ---- odometry --------------------------------------------------------------------------------


def _wrong_odometry(robot: RobotModel, motion: MotionAccounts) -> Iterator[DiagnosedFault]:
    """Yield spans in which odometry differs from the wheels."""
    has_wheels = not np.isnan(motion.joint_v).all()
    v, w = (motion.joint_v, motion.joint_w) if has_wheels else (motion.ahead, motion.turn)
    v, w = _scaled(v, motion.odom_v), _scaled(w, motion.odom_w)
    dv, dw = motion.odom_v - v, motion.odom_w - w
    if np.isnan(dv).all():
        return
    usual_v = 4 * float(np.nanmedian(np.abs(dv))) + LEAST_V
    usual_w = 4 * float(np.nanmedian(np.abs(dw))) + LEAST_W
    if usual_v > 0.03 or usual_w > 0.15:  # wrong more than half of the time, or noisy
        usual_v, usual_w = (LEAST_V * 2, LEAST_W * 2) if has_wheels else (0.05, 0.2)
    with np.errstate(invalid="ignore"):
        differs = (np.abs(dv) > usual_v) | (np.abs(dw) > usual_w)
    for begin, end in spans_where(motion.times, differs, 7, gap_s=0.5):
        inside = (motion.times >= begin + STEP_S) & (motion.times <= end) & ~np.isnan(dv)
        if inside.sum() < 5:
            continue
        yield from _odometry_fault(robot, motion, (v, w), inside, begin, end)


def _scaled(wheels: Floats, odometry: Floats) -> Floats:
    """Return what odometry makes of wheels that are not exactly as large as it assumes."""
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = (odometry / wheels)[np.abs(wheels) > 0.05]
    shares = shares[np.isfinite(shares)]
    share = float(np.median(shares)) if len(shares) > 9 else 1.0
    return wheels * share if abs(share - 1) < MOST_WORN else wheels


def _odometry_fault(
    robot: RobotModel,
    motion: MotionAccounts,
    reference: tuple[Floats, Floats],
    inside: np.ndarray,
    begin: float,
    end: float,
) -> Iterator[DiagnosedFault]:
    half = separation_of(robot) / 2
    v, w = reference[0][inside], reference[1][inside]
    odom_v, odom_w = motion.odom_v[inside], motion.odom_w[inside]
    drift = float(np.median(odom_v - v)), float(np.median(odom_w - w))
    left, right = v - half * w, v + half * w
    models: list[tuple[float, PlannedFault]] = []
    start = begin - STEP_S
    lasting = None if end >= motion.times[-1] - 0.15 else end - begin + STEP_S

    def rms(model_v: Floats, model_w: Floats) -> float:
        return float(np.sqrt(np.mean((odom_v - model_v) ** 2 + (half * (odom_w - model_w)) ** 2)))

    ahead, turn = round(drift[0], 2), round(math.degrees(drift[1]))
    if ahead or turn:
        models.append(
            (
                rms(v + drift[0], w + drift[1]),
                fault_at(start, "odometry_drift", ahead, turn=float(turn), lasting=lasting),
            )
        )
    for name, share_left, share_right, share_separation in (
        ("left_radius", 1, 0, 0),
        ("right_radius", 0, 1, 0),
        ("separation", 0, 0, 1),
    ):
        error = _fitted_error(odom_v, odom_w, left, right, half, name)
        if error is None or abs(error) < 0.02 or abs(error) > 0.5:
            continue
        made_left, made_right = left * (1 + share_left * error), right * (1 + share_right * error)
        model_v = (made_left + made_right) / 2
        model_w = (made_right - made_left) / (2 * half * (1 + share_separation * error))
        models.append(
            (
                rms(model_v, model_w),
                fault_at(start, "odometry_error", lasting=lasting, **{name: round(error, 2)}),
            )
        )
    if not models:
        return
    models.sort(key=lambda model: model[0])
    without = rms(v, w)
    if without < 1.5 * models[0][0]:
        return  # neither explains it
    best, fault = models[0]
    others = [other for _, other in models[1:2]]
    ratio = best / max(models[1][0], 1e-9) if len(models) > 1 else 0.5
    yield DiagnosedFault(
        fault,
        f"odometry differs from the wheels by {drift[0]:+.2g} m/s and "
        f"{math.degrees(drift[1]):+.2g} deg/s",
        0.95 if ratio < 0.6 else 0.6,
        round(start, 2),
        None if lasting is None else round(end, 2),
        others,
    )


def _fitted_error(
    odom_v: Floats, odom_w: Floats, left: Floats, right: Floats, half: float, name: str
) -> float | None:
    """Return the relative error of a parameter of odometry (least squares)."""
    odom_left, odom_right = odom_v - half * odom_w, odom_v + half * odom_w
    if name == "separation":
        w = (right - left) / (2 * half)
        scale = float(np.dot(w, odom_w)) / max(float(np.dot(w, w)), 1e-12)
        return None if scale < 0.1 or float(np.abs(w).max()) < 0.05 else 1 / scale - 1
    true, got = (left, odom_left) if name == "left_radius" else (right, odom_right)
    if float(np.abs(true).max()) < 0.02:
        return None
    return float(np.dot(true, got)) / max(float(np.dot(true, true)), 1e-12) - 1


# ---- slip and pushes -------------------------------------------------------------------------


def _by_wheels(motion: MotionAccounts) -> tuple[Floats, Floats]:
    """Return the speed, m/s, and the turn rate, rad/s, by the wheels; else by odometry."""
    has_wheels = not np.isnan(motion.joint_v).all()
    return (motion.joint_v, motion.joint_w) if has_wheels else (motion.odom_v, motion.odom_w)


def _driven(motion: MotionAccounts) -> Path2D:
    """Return the path that the wheels alone give."""
    v, w = map(np.nan_to_num, _by_wheels(motion))
    yaw = np.cumsum(w) * STEP_S
    middle = yaw - w * STEP_S / 2
    x, y = np.cumsum(v * np.cos(middle)) * STEP_S, np.cumsum(v * np.sin(middle)) * STEP_S
    return Path2D(motion.times, x, y, yaw, "wheels")


def _slips(
    robot: RobotModel, motion: MotionAccounts, known: Sequence[tuple[float, float]], fit: Floats
) -> Iterator[DiagnosedFault]:
    """Yield spans in which the robot moves other than its wheels turn, and stays there."""
    v, w = _by_wheels(motion)
    dv, dw = motion.ahead - v, motion.turn - w
    with np.errstate(invalid="ignore"):
        differs = (np.abs(dv) > SLIP_V) | (np.abs(dw) > SLIP_W) | (np.abs(motion.left) > SIDEWAYS)
    with np.errstate(invalid="ignore"):
        size = np.abs(dv) / SLIP_V + np.abs(dw) / SLIP_W + np.abs(motion.left) / SIDEWAYS
    spans = spans_where(motion.times, differs, 1, gap_s=0.2)
    drift = Drift.of(dv, motion.left, dw)
    noise = drift.noise(motion.times, spans)
    for begin, end in _beyond_corrections(motion, spans, differs, size):
        if not drift.is_beyond(noise, begin, end) or not _fits(fit, begin, end):
            continue
        if end - begin < STEP_S / 2 and size[round(begin / STEP_S)] < MOMENT:
            continue
        if any(low < begin < high for low, high in known) or begin < 2 * STEP_S:
            continue
        inside = (motion.times >= begin) & (motion.times <= end)
        force = np.hypot(dv[inside], motion.left[inside]) + 0.1 * np.abs(dw[inside])
        is_moment = end - begin < 2.5 * STEP_S
        if is_moment or (end - begin < IMPULSE_S and _is_impulse(motion, inside, dv, dw)):
            yield _impulse(robot, motion, end, inside, force)
        elif end - begin >= 0.25 and _goes_on(inside, dv, dw):
            yield _slip(motion, begin, end, inside, dv, dw)


@dataclass(frozen=True)
class Drift:
    """By how much the place differs from what the wheels say: sums over time, 20 Hz, m and rad."""

    ahead: Floats
    left: Floats
    turn: Floats

    @classmethod
    def of(cls, ahead: Floats, left: Floats, turn: Floats) -> Drift:
        """Return the sums of velocities."""
        return cls(*(np.cumsum(np.nan_to_num(each)) * STEP_S for each in (ahead, left, turn)))

    def over(self, begin: float, end: float) -> tuple[float, float]:
        """Return by how much it has changed from before a span to after it, m and rad.

        Medians, so that a place that is corrected soon after does not count.
        """
        first, last = round(begin / STEP_S), round(end / STEP_S) + 1
        before = slice(max(first - SETTLED, 0), max(first, 1))
        after = slice(min(last, len(self.turn) - 1), last + SETTLED)
        change = [
            float(np.median(each[after]) - np.median(each[before]))
            for each in (self.ahead, self.left, self.turn)
        ]
        return math.hypot(change[0], change[1]), abs(change[2])

    def noise(self, times: Floats, spans: Sequence[tuple[float, float]]) -> tuple[float, float]:
        """Return what it usually changes by, m and rad, away from the spans in question."""
        margin = SETTLED * STEP_S
        starts = np.arange(margin, max(times[-1] - margin, margin + STEP_S), 4 * STEP_S)
        away = [
            start
            for start in starts
            if all(end + margin < start or start + margin < begin for begin, end in spans)
        ]
        if len(away) < FEW_DRIFTS and len(spans) < OFTEN:
            return LEAST_DRIFT
        # Where nothing is quiet, what is in question is itself the noise.
        quiet = away if len(away) >= FEW_DRIFTS else list(starts)
        changes = np.array([self.over(start, start) for start in quiet])
        move, turn = np.percentile(changes, 90, axis=0)
        return max(float(move), LEAST_DRIFT[0]), max(float(turn), LEAST_DRIFT[1])

    def is_beyond(self, noise: tuple[float, float], begin: float, end: float) -> bool:
        """Return whether a span changes it by more than noise."""
        move, turn = self.over(begin, end)
        return move > BEYOND_NOISE * noise[0] or turn > BEYOND_NOISE * noise[1]


def _fits(fit: Floats, begin: float, end: float) -> bool:
    """Return whether scans fit the world both before and after a span, as they usually do.

    A localiser that is wrong, or corrects itself, moves the robot on the map alone.
    """
    if len(fit) < 4:
        return True
    usual = float(np.percentile(fit[:, 1], 25))
    for low, high in ((begin - 0.6, begin), (end + STEP_S, end + 0.7)):
        near = fit[(fit[:, 0] >= low) & (fit[:, 0] <= high), 1]
        if len(near) and float(np.median(near)) > 2 * usual + WELL_PLACED_M:
            return False
    return True


def _beyond_corrections(
    motion: MotionAccounts,
    spans: Sequence[tuple[float, float]],
    differs: npt.NDArray[np.bool_],
    size: Floats,
) -> list[tuple[float, float]]:
    """Return the spans that are not corrections of the place on the map.

    A localiser that corrects the place often moves the robot on the map at single instants. Only a
    much larger jump, or a motion that goes on, is one of the robot.
    """
    number = [slice(round(a / STEP_S), round(b / STEP_S) + 1) for a, b in spans]
    jumps = [size[part].max() for part in number if differs[part].sum() <= FEW_SAMPLES]
    if len(jumps) < OFTEN or len(jumps) < OFTEN_SHARE * motion.times[-1]:
        return list(spans)
    usual = float(np.median(jumps))
    return [
        span
        for span, part in zip(spans, number, strict=True)
        if size[part].max() > MUCH_LARGER * usual
        or (differs[part].mean() > 0.8 and differs[part].sum() > 2 * FEW_SAMPLES)
    ]


def _goes_on(inside: np.ndarray, dv: Floats, dw: Floats) -> bool:
    """Return whether the robot moves other than its wheels during most of a span."""
    ahead, turn = (abs(float(np.nanmedian(each[inside]))) for each in (dv, dw))
    return ahead > SLIP_V / 4 or turn > SLIP_W / 3


def _is_impulse(motion: MotionAccounts, inside: np.ndarray, dv: Floats, dw: Floats) -> bool:
    """Return whether the base is moved from outside: aside, or faster than its wheels."""
    speed = np.abs(motion.ahead[inside]) - np.abs(motion.ahead[inside] - dv[inside])
    sideways = float(np.nanmax(np.abs(motion.left[inside])))
    return bool(sideways > SIDEWAYS or np.nanmax(speed) > SLIP_V or np.nanmax(np.abs(dw)) > 0.6)


def _impulse(
    robot: RobotModel,
    motion: MotionAccounts,
    end: float,
    inside: np.ndarray,
    force: Floats,
) -> DiagnosedFault:
    numbers = np.flatnonzero(inside)
    first, peak = numbers[0], numbers[int(np.nanargmax(force))]
    rise = float(motion.times[peak] - motion.times[first]) + STEP_S
    before = max(first - 1, 0)
    start = float(motion.times[before])
    change_v = float(motion.ahead[peak] - motion.ahead[before])
    change_left = float(motion.left[peak] - motion.left[before])
    why = (
        f"the base moves by {change_v:+.2g} m/s ahead and {change_left:+.2g} m/s to the left "
        "within a moment, without its wheels"
    )
    pushes = [_push(robot, start, change_v, change_left, rise, scale) for scale in (1, 0.8, 1.25)]
    shoves = [_shove(motion, start, first, scale) for scale in (1.0, 1.5, 2.5, 4.0)]
    is_push = rise > PUSH_RISES_S
    several = [*pushes, *shoves] if is_push else [*shoves, *pushes]
    return DiagnosedFault(several[0], why, 0.8, round(start, 2), round(end, 2), several[1:])


def _push(
    robot: RobotModel, start: float, ahead: float, left: float, rise: float, scale: float
) -> PlannedFault:
    mass = robot.base_mass
    size = math.hypot(ahead, left)
    newton = min((STANDS_N + mass * 1.5 * size / max(rise, STEP_S)) * scale, STRONGEST)
    share = newton / max(size, 1e-6)
    along, aside = (math.trunc(10 * share * part) / 10 for part in (ahead, left))
    return fault_at(start, "push", along, aside)


def _shove(motion: MotionAccounts, start: float, first: int, scale: float) -> PlannedFault:
    ahead, left = float(motion.ahead[first]), float(motion.left[first])
    before = max(first - 1, 0)
    turn = float(motion.turn[first])
    turn += (scale - 1) * (turn - float(motion.turn[before]))
    ahead += (scale - 1) * (ahead - float(motion.ahead[before]))
    return fault_at(start, "shove", round(ahead, 2), round(left * scale, 2), turn=round(turn, 2))


def _slip(
    motion: MotionAccounts, begin: float, end: float, inside: np.ndarray, dv: Floats, dw: Floats
) -> DiagnosedFault:
    turned = float(np.nanmedian(dw[inside]))
    ahead = float(np.nanmedian(dv[inside]))
    direction = 1 if float(np.nanmedian(motion.joint_v[inside])) >= 0 else -1
    side = "both"
    if abs(turned) > SLIP_W / 2 and abs(ahead) > 0.01:
        side = "left" if turned * direction > 0 else "right"
    start = begin - 2 * STEP_S
    lasting = None if end >= motion.times[-1] - 0.15 else end - start
    sides = dict.fromkeys((side, "left", "right", "both"))
    several = [
        fault_at(start, "slip_wheel", each, grip, lasting=lasting)
        for each in sides
        for grip in (GRIPS[2], *GRIPS)
    ]
    return DiagnosedFault(
        several[0],
        f"the robot moves {ahead:+.2g} m/s and {math.degrees(turned):+.2g} deg/s other than its "
        "wheels turn",
        0.8,
        round(start, 2),
        None if lasting is None else round(end, 2),
        several[1:],
    )
