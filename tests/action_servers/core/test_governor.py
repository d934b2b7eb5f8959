"""Facts about what of a wanted twist reaches the base."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from action_servers.core.governor import Allowed, Governor
from action_servers.core.maneuver import ZERO, Hazard, Observation, Reason
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.model import load_robot
from tests.support.fake_robot import in_the_open
from tests.support.thorough import sample

FULL = Twist2D(0.26, 0.0)


class Wants:
    """A maneuver that wants one twist for ever, and looks at nothing."""

    needs_base = True

    def __init__(self, twist: Twist2D) -> None:
        self.twist = twist
        self.seen: list[Observation] = []

    def step(self, now: Observation) -> Twist2D:
        self.seen.append(now)
        return self.twist


def asked(governor: Governor, wanted: Twist2D, now: Observation) -> Allowed:
    """What one control step comes to."""
    return governor.allow(wanted, governor.look(now))


def test_in_the_open_every_twist_passes_within_the_limits(robot):
    """Forwards, backwards, along arcs and on the spot."""
    governor = Governor(robot)
    fastest, sharpest = robot.max_linear_velocity, robot.max_angular_velocity
    for linear in (-fastest, 0.0, 0.005, fastest):
        for angular in (-sharpest, 0.0, sharpest):
            wanted = Twist2D(linear, angular)
            assert asked(governor, wanted, in_the_open(1.0)) == Allowed(wanted)
    assert asked(governor, Twist2D(9.0, -9.0), in_the_open(1.0)) == Allowed(
        Twist2D(fastest, -sharpest)
    )


def test_no_twist_is_faster_than_the_speed_limit_and_each_keeps_its_arc(robot):
    """Also one that slides; a turn on the spot has no speed."""
    governor, now = Governor(robot), dataclasses.replace(in_the_open(1.0), speed_limit=0.1)
    for wanted, expected in [
        (Twist2D(0.2, 0.4), Twist2D(0.1, 0.2)),
        (Twist2D(-0.2, 0.4), Twist2D(-0.1, 0.2)),
        (Twist2D(0.05, 0.4), Twist2D(0.05, 0.4)),
        (Twist2D(0.0, 1.0), Twist2D(0.0, 1.0)),
    ]:
        assert asked(governor, wanted, now) == Allowed(expected)
    slides, car = (Governor(load_robot(name)) for name in ("rosbot", "f1tenth"))
    assert asked(slides, Twist2D(0.12, 0.0, 0.16), now) == Allowed(Twist2D(0.06, 0.0, 0.08))
    stroke = asked(car, Twist2D(0.0, 0.6), now).twist
    assert stroke.linear == 0.1


@pytest.mark.parametrize(
    ("twist", "wall"),
    sample(
        [
            (Twist2D(0.26, 0.0), (0.6, -2.0, 0.6, 2.0)),
            (Twist2D(0.22, 0.0), (0.6, -0.5, 1.6, 0.5)),
            (Twist2D(-0.22, 0.0), (-0.6, -2.0, -0.6, 2.0)),
            (Twist2D(0.22, 0.4), (0.5, -2.0, 0.5, 2.0)),
            (Twist2D(0.2, -0.7), (-2.0, -0.45, 2.0, -0.45)),
            (Twist2D(-0.2, 0.7), (-0.35, -2.0, -0.35, 2.0)),
            (Twist2D(0.01, 1.5), (-2.0, 0.17, 2.0, 0.17)),
            (Twist2D(0.009, 0.02), (0.12, -2.0, 0.12, 2.0)),
            (Twist2D(0.0, 1.82), (-0.16, 0.17, -0.1, 0.17)),
            (Twist2D(0.0, -1.82), (-0.16, 0.17, -0.1, 0.17)),
        ],
        3,
    ),
)
def test_a_maneuver_that_looks_at_nothing_touches_nothing(fake, robot, twist, wall):
    """Whatever it wants: the base is slowed down, stands before the obstacle, and stays there."""
    base, wants = fake(robot, [wall]), Wants(twist)
    x1, y1, x2, y2 = wall
    points = np.stack([np.linspace(x1, x2, 400), np.linspace(y1, y2, 400)], axis=1)
    for _ in range(300):
        base.step(wants.step)
        assert least_gap(base, points) > 0.005
    if robot.name == "waffle":
        held = base.governor.look(base.observe()).held
        assert (held.by, held.twist) == (Reason.OBSTACLE, ZERO)
        assert held.since_s < base.time_s - 1.0
        assert base.linear == base.angular == 0.0


def least_gap(base: Any, points: Any) -> float:
    """How far the nearest point is from the hull's rectangle within its circle, m."""
    hull = base.robot.hull
    cosine, sine = math.cos(base.yaw), math.sin(base.yaw)
    x, y = points[:, 0] - base.x, points[:, 1] - base.y
    ahead, left = cosine * x + sine * y, cosine * y - sine * x
    depth = np.minimum(
        np.minimum(np.minimum(hull.front - ahead, ahead - hull.rear), hull.half_width - abs(left)),
        base.robot.turning_radius - np.hypot(x, y),
    )
    return -float(depth.max())


def test_it_slows_down_along_the_arc_that_is_wanted(fake, waffle):
    """So that a slowed robot is where a fast one would have been."""
    base = fake(waffle, [(waffle.hull.front + 0.09, -0.3, waffle.hull.front + 0.09, 0.3)])
    allowed = asked(Governor(waffle), Twist2D(0.26, 0.13), base.observe())
    assert allowed.held_by is Reason.OBSTACLE
    assert 0.0 < allowed.twist.linear < 0.26
    assert allowed.twist.angular / allowed.twist.linear == pytest.approx(0.5)


def test_between_two_scans_it_counts_on_with_odometry(fake, waffle):
    """The same scan, 0.2 m farther on."""
    base, governor = fake(waffle, [(0.35, -1.0, 0.35, 1.0)]), Governor(waffle)
    now = base.observe()
    assert asked(governor, FULL, now) == Allowed(FULL)
    nearer = dataclasses.replace(
        now, time_s=now.time_s + 0.4, odom=Pose2D(0.2, 0.0, 0.0), odom_stamp_s=now.time_s + 0.4
    )
    slowed = asked(governor, FULL, nearer)
    assert slowed.held_by is Reason.OBSTACLE
    assert slowed.twist.linear < 0.26


def test_the_maneuver_learns_at_its_next_step_what_holds_the_base(fake, waffle):
    """And since when; nothing once the way is free."""
    base, wants = fake(waffle, [(0.1, -1.0, 0.1, 1.0)]), Wants(FULL)
    for _ in range(3):
        base.step(wants.step)
    wants.twist = Twist2D(-0.1, 0.0)
    base.step(wants.step)
    base.step(wants.step)
    held = [now.held and (now.held.words, now.held.since_s) for now in wants.seen]
    blocked = ("an obstacle is in the way, ahead", 10.0)
    assert held == [None, blocked, blocked, blocked, None]


@pytest.mark.parametrize("lost", ["scan", "odometry"])
def test_the_base_is_held_while_a_sensor_is_old(waffle, lost):
    """From an age of 0.6 s on, or never seen; a newer message lets it go on; logged once a goal."""
    governor = Governor(waffle)
    reason = Reason.NO_SCAN if lost == "scan" else Reason.NO_ODOMETRY
    for age_s, is_held in ((0.5, False), (0.6, False), (0.65, True), (0.95, True), (0.0, False)):
        now = in_the_open(10.0)
        late: Any = {"time_s": 10.0 + age_s, "odom_stamp_s": 10.0 + age_s}
        if lost == "odometry":
            late["odom_stamp_s"] = 10.0
        assert now.scan is not None
        late["scan"] = dataclasses.replace(
            now.scan, stamp_s=10.0 if lost == "scan" else 10.0 + age_s
        )
        allowed = asked(governor, FULL, dataclasses.replace(now, **late))
        assert allowed == (Allowed(ZERO, reason) if is_held else Allowed(FULL))
    assert governor.notes == [f"the base is held: no {lost} for 0.6 s: the last is 0.65 s old"]
    nothing = {"scan": {"scan": None}, "odometry": {"odom": None}}[lost]
    assert asked(governor, FULL, in_the_open(11.0, **nothing)) == Allowed(ZERO, reason)


def test_a_base_that_does_not_follow_is_named(fake, waffle):
    """After 2 s; the command goes on, as it may follow again."""
    base, wants = fake(waffle), Wants(FULL)
    base.stuck = True
    for _ in range(42):
        base.step(wants.step)
    named = [now.held_by for now in wants.seen]
    assert named == [None] * 40 + [Reason.BASE] * 2
    assert base.twists == [FULL] * 42


def test_a_new_goal_begins_with_a_clean_slate(fake, waffle):
    """Neither what held the last one, nor how long it got nowhere."""
    base, wants = fake(waffle), Wants(FULL)
    base.stuck = True
    for _ in range(42):
        base.step(wants.step)
    base.governor.begin()
    wants.seen.clear()
    base.step(wants.step)
    assert wants.seen[0].held is None


AHEAD = Hazard(0.3, "the bumper left is pressed")
BEHIND = Hazard(math.pi, "the cliff sensor rear sees no floor")


@pytest.mark.parametrize(
    ("hazards", "wanted", "passes"),
    [
        ((AHEAD,), Twist2D(0.1, 0.0), False),
        ((AHEAD,), Twist2D(0.1, 0.5), False),
        ((AHEAD,), Twist2D(-0.1, 0.0), True),
        ((AHEAD,), Twist2D(0.0, 0.5), True),
        ((BEHIND,), Twist2D(0.1, 0.0), True),
        ((BEHIND, AHEAD), Twist2D(-0.1, 0.0), False),
    ],
)
def test_a_bumper_or_a_cliff_stops_what_drives_towards_it(robot, hazards, wanted, passes):
    """The way back and turns on the spot stay free; the reason is the text of the sensor."""
    governor = Governor(robot)
    allowed = asked(governor, wanted, in_the_open(1.0, hazards=hazards))
    assert allowed == (Allowed(wanted) if passes else Allowed(ZERO, Reason.OBSTACLE))
    held = governor.look(in_the_open(1.05)).held
    assert (held is None) is passes
    assert held is None or held.words == hazards[0].words


def test_a_slide_is_stopped_by_a_hazard_at_its_side():
    """And only by one at that side."""
    slider = load_robot("rosbot")
    for bearing, passes in ((math.pi / 2, False), (-math.pi / 2, True)):
        hazards = (Hazard(bearing, "the bumper is pressed"),)
        wanted = Twist2D(0.0, 0.0, 0.2)
        allowed = asked(Governor(slider), wanted, in_the_open(1.0, hazards=hazards))
        assert (allowed.twist == wanted) is passes
