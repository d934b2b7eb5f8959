"""The base's own control: limits, ramp, and the stop when commands stop coming."""

import math

import pytest

from bt_mission.core.robot.model import load_robot
from sim.robot.drive import DifferentialController

STEP_S = 0.005
WAFFLE = load_robot("waffle")


def drive() -> DifferentialController:
    """A Waffle's drive at rest, with command_timeout_factor enough for what follows."""
    return DifferentialController(WAFFLE, STEP_S, command_timeout_factor=10.0)


def run(drive: DifferentialController, steps: int, time_ns: int = 0) -> None:
    """Let so many steps of 5 ms pass."""
    for step in range(steps):
        now_ns = time_ns + step * 5_000_000
        if now_ns >= drive.due_ns:
            drive.step(now_ns)


def test_nothing_is_due_before_the_first_command():
    """At rest the wheels need not be told anything."""
    assert drive().due_ns == math.inf


def test_speed_is_ramped_at_the_limit_of_the_model():
    """1.0 m/s^2 makes 0.005 m/s a step; 0.2 m/s is reached after 40 steps, exactly."""
    base = drive()
    base.command(0.2, 0.0, 0)
    run(base, 39)
    assert base.linear == pytest.approx(0.195)
    run(base, 1)
    assert base.linear == 0.2
    assert base.due_ns == 2_000_000_000


def test_turning_is_ramped_too():
    """6.97 rad/s^2 makes 0.03485 rad/s a step."""
    base = drive()
    base.command(0.0, -1.0, 0)
    run(base, 10)
    assert base.angular == pytest.approx(-0.3485)


@pytest.mark.parametrize("sign", [1, -1])
def test_commands_are_clipped_to_the_limits_of_the_model(sign):
    """0.26 m/s and 1.82 rad/s are the most a Waffle does, either way."""
    base = drive()
    base.command(sign * 5.0, sign * 9.0, 0)
    run(base, 90)
    assert (base.linear, base.angular) == (sign * 0.26, sign * 1.82)


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_a_velocity_that_is_not_finite_is_refused(bad):
    """The last command stays."""
    base = drive()
    base.command(0.1, 0.0, 0)
    with pytest.raises(ValueError, match="expected a finite velocity"):
        base.command(bad, 0.0, 0)
    run(base, 90)
    assert base.linear == 0.1


@pytest.mark.parametrize("command_timeout_factor", [1, 10])
def test_a_command_holds_for_the_command_timeout_exactly(command_timeout_factor):
    """The step that begins 0.2 s after it is the first that slows down; ten times that, if told."""
    base = DifferentialController(WAFFLE, STEP_S, command_timeout_factor=command_timeout_factor)
    base.command(0.2, 0.0, 1_000_000_000)
    run(base, 40 * command_timeout_factor, 1_000_000_000)
    assert base.linear == 0.2
    end_ns = 1_000_000_000 + command_timeout_factor * 200_000_000
    assert base.due_ns == end_ns
    base.step(end_ns)
    assert base.linear == pytest.approx(0.195)


def test_it_comes_to_rest_and_stays_there():
    """Once stopped, nothing more is due."""
    base = drive()
    base.command(0.2, 1.0, 0)
    run(base, 600)
    assert (base.linear, base.angular) == (0.0, 0.0)
    assert base.due_ns == math.inf


def test_wheels_turn_at_the_speed_of_their_rims():
    """Straight on both alike; turning left the right wheel ahead, by the separation."""
    base = drive()
    base.command(0.2, 0.0, 0)
    run(base, 39)
    assert base.step(0) == pytest.approx((0.2 / 0.033, 0.2 / 0.033))
    base.command(0.0, 1.0, 0)
    for _ in range(100):
        left, right = base.step(0)
    assert (left, right) == pytest.approx((-0.1435 / 0.033, 0.1435 / 0.033))
