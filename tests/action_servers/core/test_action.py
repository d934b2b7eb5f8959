"""Which goals the servers refuse, in which words: limits, needs and tunings of each declaration."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from action_servers.core.action import Action, Misfit, ServerContext, action
from action_servers.core.limits import NumberLimit, faults
from action_servers.core.maneuver import (
    ErrorCode,
    Finished,
    Grid,
    JointReadings,
    Observation,
    Refusal,
    Scan,
    stale,
)
from action_servers.mapping.node import MapperTuning
from bt_mission.base.actions import declared
from bt_mission.base.geometry import Pose2D
from bt_mission.base.parameters import specs
from bt_mission.robots.model import load_robot
from tests.support.fake_robot import in_the_open
from tests.support.served import SERVED, goal
from tests.support.thorough import sample

SCAN = Scan(10.0, 0.0, math.tau / 4, 0.12, 3.5, np.full(4, np.inf, dtype=np.float32))
JOINTS = JointReadings(10.0, dict.fromkeys(load_robot("waffle_arm").moved_joints, 0.0), {}, {})
READY = Observation(
    10.0,
    odom=Pose2D(0.5, 0.0, 0.0),
    odom_stamp_s=10.0,
    scan=SCAN,
    map_pose=Pose2D(0.0, 0.0, 0.0),
    grid=Grid(0.05, -2.0, -2.0, np.zeros((80, 80), dtype=np.int8)),
    joints=JOINTS,
)
NO_SCAN = "no scan has arrived yet; is the robot running?"
NO_ODOMETRY = "no odometry has arrived yet; is the robot running?"
WAFFLE, WITH_ARM = load_robot("waffle"), load_robot("waffle_arm")


class Camera:
    """A camera that a node publishes, or none does."""

    topic = "/camera/image_raw"

    def __init__(self, *, is_sent: bool = True) -> None:
        self.is_sent = is_sent

    def user(self) -> Any:
        """Return a switch."""
        return SimpleNamespace(on=lambda: None, off=lambda: None)


def context(**changes: Any) -> ServerContext:
    """The servers of a Waffle, with changes."""
    usual: dict[str, Any] = {
        "robot": WAFFLE,
        "tuning": lambda defaults: defaults,
        "camera": Camera(),
        "image_folder": Path("images"),
        "publish": lambda *_: None,
        "joints": SimpleNamespace(send=lambda *_: None),
    }
    return ServerContext(**usual | changes)


def planned(name: str, message: Any = None, now: Observation = READY, **changes: Any) -> Any:
    """What becomes of a goal."""
    message = goal(name) if message is None else message
    if action(name).part:
        changes = {"robot": WITH_ARM, **changes}
    return action(name).planned(message, now, context(**changes))


@pytest.mark.parametrize("name", declared())
def test_the_example_becomes_a_maneuver(name):
    """Which drives where the action does."""
    assert planned(name).needs_base is action(name).moves_base


@pytest.mark.parametrize("name", declared())
def test_every_goal_outside_the_limits_is_refused(name):
    """With the field and the value."""
    fields = [limit.field for limit in SERVED[name].limits(WITH_ARM)]
    for bad in SERVED[name].bad_goals(WITH_ARM):
        refused = planned(name, bad)
        assert isinstance(refused, Refusal)
        assert refused.reason.startswith((*fields, "no such colour"))


@pytest.mark.parametrize(
    ("name", "changes", "reason"),
    [
        ("turn", {"angle": 3601.0}, "angle must be from -3600 to 3600 deg, got 3601"),
        (
            "turn",
            {"angular_velocity": 1.9},
            "angular_velocity must be from 0.05 to 1.82 rad/s, got 1.9",
        ),
        (
            "explore_forward",
            {"stopping_distance": 0.04},
            "stopping_distance must be from 0.05 to 3.367 m, got 0.04",
        ),
        (
            "camera_sweep",
            {"sweep_angle": 0.0},
            "sweep_angle must be above 0 and at most 180 deg, got 0",
        ),
        ("find_colour", {"colour": "bleu"}, "no such colour 'bleu' (known: red, yellow, green, "),
        ("backup", {"speed": 0.5}, "speed must be from -0.26 to 0.26 m/s, got 0.5"),
    ],
)
def test_a_refusal_says_what_was_expected_and_what_was_got(name, changes, reason):
    """By the words of the limit."""
    assert planned(name, goal(name, **changes)).reason.startswith(reason)


def test_the_limit_of_the_robot_is_allowed_as_float32():
    """1.82 arrives as 1.8200000525; more than rounding is refused."""
    fastest = float(np.float32(1.82))
    assert fastest > 1.82
    assert not isinstance(planned("turn", goal("turn", angular_velocity=fastest)), Refusal)
    assert isinstance(planned("turn", goal("turn", angular_velocity=1.8201)), Refusal)


@pytest.mark.parametrize("name", sample(declared(), 4))
@pytest.mark.parametrize(
    ("need", "changes", "reason"),
    [
        ("odometry", {"odom": None}, NO_ODOMETRY),
        ("odometry", {"odom_stamp_s": 8.0}, "no odometry for 1 s: the last is 2.00 s old"),
        (
            "odometry",
            {"odom_stamp_s": 12.0},
            "the last odometry is stamped 2.00 s in the future; do the clocks agree?",
        ),
        ("scan", {"scan": None}, NO_SCAN),
        (
            "scan",
            {"scan": replace(SCAN, stamp_s=8.0)},
            "no scan for 1 s: the last is 2.00 s old",
        ),
        (
            "map",
            {"grid": None},
            "no map has arrived yet; is something publishing the topic map?",
        ),
        (
            "map",
            {"grid": Grid(0.05, 0.0, 0.0, np.zeros((0, 0), dtype=np.int8))},
            "the map has no cells",
        ),
        (
            "map",
            {"map_pose": None},
            "the robot's place on the map is not known yet; is something publishing map to odom?",
        ),
        (
            "arm",
            {"joints": None},
            "no joint_states has arrived yet; is the robot running?",
        ),
        (
            "gripper",
            {"joints": replace(JOINTS, stamp_s=8.0)},
            "no joint_states for 1 s: the last is 2.00 s old",
        ),
    ],
)
def test_a_goal_is_refused_without_what_the_action_needs(name, need, changes, reason):
    """A goal of an action that waits, or does not need it, is not."""
    refused = planned(name, now=replace(READY, **changes))
    is_needed = need in action(name).needs or (action(name).part and "joints" in changes)
    if is_needed and not action(name).waits:
        assert refused == Refusal(reason)
    else:
        assert not isinstance(refused, Refusal)


@pytest.mark.parametrize("name", [name for name in declared() if action(name).needs_camera])
def test_pictures_need_a_camera(name):
    """Of the robot, and a node that publishes its pictures."""
    burger = load_robot("burger")
    assert planned(name, robot=burger) == Refusal("the robot 'burger' has no camera")
    assert planned(name, camera=Camera(is_sent=False)) == Refusal(
        "nobody publishes /camera/image_raw"
    )


@pytest.mark.parametrize("name", [name for name in declared() if action(name).part])
def test_a_part_is_one_of_the_robot(name):
    """A Waffle has neither an arm nor a gripper."""
    reason = f"the robot 'waffle' has no {action(name).part}"
    assert planned(name, robot=WAFFLE) == Refusal(reason)


@pytest.mark.parametrize(
    ("name", "x", "y", "speed", "code"),
    [
        ("drive_on_heading", 0.3, 0.0, -0.1, 724),
        ("drive_on_heading", -0.3, 0.0, 0.1, 724),
        ("drive_on_heading", 0.0, 0.0, 0.1, 724),
        ("drive_on_heading", 0.3, 0.1, 0.1, 724),
        ("drive_on_heading", -0.3, 0.0, 0.0, 724),
        ("backup", 0.3, 1.0, 0.1, 713),
        ("backup", 0.3, 0.0, 0.0, 713),
    ],
)
def test_a_misfit_is_accepted_and_aborted_with_its_code(name, x, y, speed, code):
    """As by Nav2, also without sensors; and not one with a target that is not finite."""
    message = goal(name, speed=speed)
    message.target.x, message.target.y = x, y
    misfit = planned(name, message, now=Observation(10.0))
    assert isinstance(misfit, Misfit)
    end = misfit.step(READY)
    assert isinstance(end, Finished)
    assert (end.status, end.error_code, bool(end.reason)) == ("aborted", code, True)
    assert (misfit.needs_base, misfit.feedback(), misfit.result()) == (False, None, {})
    message.target.z = math.nan
    assert planned(name, message) == Refusal("target must be finite")


def test_a_plan_asks_for_what_there_is():
    """The error names the parameters that a plan can have."""
    strange = Action(
        name="a", type="a/action/A", needs=(), plan=lambda _goal, _now, weather: Refusal(weather)
    )
    with pytest.raises(TypeError, match="the plan of a asks for weather; there are: robot, tuning"):
        strange.planned(None, READY, context())


@pytest.mark.parametrize("stamp", [9.0, 9.1, 11.0])
def test_a_second_is_fresh(stamp):
    """Either way: clocks of two machines differ a little."""
    assert stale(replace(in_the_open(stamp), time_s=10.0)) is None


def test_of_two_missing_sensors_odometry_is_told():
    """One reason at a time."""
    assert stale(Observation(10.0)) == Finished("aborted", ErrorCode.NO_ODOMETRY, NO_ODOMETRY)


LIMIT = NumberLimit(field="time", low=1, high=5, unit="s", source="", zero="the default")


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (LIMIT, "from 1 to 5 s"),
        (replace(LIMIT, low=0, above=True), "above 0 and at most 5 s"),
        (replace(LIMIT, low=0, high=math.inf), "0 s or more"),
    ],
)
def test_a_limit_has_words(limit, words):
    """What is accepted."""
    assert limit.words == words


@pytest.mark.parametrize("value", [0.0, 1.0, 5.0])
def test_both_limits_and_a_zero_with_a_meaning_are_accepted(value):
    """Beside the range, only 0."""
    assert LIMIT.fault(value) is None


@pytest.mark.parametrize("value", [0.5, 0.999, 5.001, math.nan, math.inf, -math.inf, 1e300])
def test_what_is_outside_is_told_with_limits_and_unit(value):
    """Expected and got, in one line."""
    assert LIMIT.fault(value) == f"time must be from 1 to 5 s, got {value:g}"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, -1e-9])
def test_a_limit_without_an_end_takes_only_numbers(value):
    """NaN is not less than 0 either."""
    fault = replace(LIMIT, low=0, high=math.inf, zero="").fault(value)
    assert fault == f"time must be 0 s or more, got {value:g}"


def numbers(message: Any, *path: str | int) -> Iterator[tuple[str | int, ...]]:
    """Yield the way to each float of a message."""
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if kind in ("float", "double"):
            yield (*path, name)
        elif "/" in kind:
            parts = value if kind.startswith("sequence") else [value]
            for index, part in enumerate(parts):
                yield from numbers(part, *path, name, *([index] if parts is value else []))


@pytest.mark.parametrize("name", sample(declared(), 3))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_number_of_a_goal_is_other_than_finite(name, value):
    """Of NaN and a limit, `min` and `max` would make full speed."""
    for path in numbers(goal(name)):
        message = part = goal(name)
        for key in path[:-1]:
            part = part[key] if isinstance(key, int) else getattr(part, key)
        setattr(part, str(path[-1]), value)
        assert isinstance(planned(name, message), Refusal | Misfit), path


def test_a_duration_counts_in_seconds():
    """As a message has it."""
    limit = replace(LIMIT, low=0, high=math.inf)
    goal = SimpleNamespace(time=SimpleNamespace(sec=-2, nanosec=500_000_000))
    assert list(faults(goal, (limit,))) == ["time must be 0 s or more, got -1.5"]


TUNINGS: tuple[Any, ...] = (
    MapperTuning,
    *dict.fromkeys(type(action(name).tuning) for name in declared()),
)


@pytest.mark.parametrize(
    ("tunings", "name"), [(tunings, field.name) for tunings in TUNINGS for field in fields(tunings)]
)
def test_each_tuning_has_a_range_that_its_default_lies_in_and_a_description(tunings, name):
    """Which says the unit, where there is one."""
    _, allowed = specs(tunings)[name]
    assert allowed.low <= getattr(tunings(), name) <= allowed.high
    assert allowed.description.endswith(".")
