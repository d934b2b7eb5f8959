"""Facts about the type of command that a robot is found to listen for."""

from __future__ import annotations

import pytest

from action_servers.robot_io.command_types import PLAIN, STAMPED, Listeners


@pytest.mark.parametrize("result", [STAMPED, PLAIN])
def test_the_type_is_the_one_that_is_listened_for(result):
    """By one robot, or by several listeners alike."""
    listeners = Listeners("/cmd_vel")
    assert listeners.type is None
    assert listeners.look([result, result]) is None
    assert listeners.type == result


def test_nobody_listens():
    """The reason names the topic; the type stays open."""
    listeners = Listeners("/cmd_vel")
    assert listeners.look([]) == "/cmd_vel has no subscriber; is the robot's bringup running?"
    assert listeners.type is None


def test_both_types_at_once_are_a_fault():
    """One of the two would not hear, whichever is sent."""
    listeners = Listeners("/cmd_vel")
    reason = listeners.look([PLAIN, STAMPED])
    assert reason is not None
    assert reason.startswith("both TwistStamped and Twist are listened for on /cmd_vel")
    assert listeners.type is None


def test_another_type_is_a_fault():
    """Somebody takes the topic for something else."""
    reason = Listeners("/cmd_vel").look(["std_msgs/msg/String"])
    assert (
        reason == "/cmd_vel must be TwistStamped or Twist, but std_msgs/msg/String is listened for"
    )


def test_a_type_that_changes_later_is_a_fault_until_it_changes_back():
    """As when the robot is started anew with another parameter."""
    listeners = Listeners("/cmd_vel")
    assert listeners.look([STAMPED]) is None
    reason = listeners.look([PLAIN])
    assert reason is not None
    assert reason.startswith("/cmd_vel is subscribed as Twist, but TwistStamped is sent")
    assert listeners.type == STAMPED
    assert listeners.look([STAMPED]) is None


def test_a_settled_type_that_is_not_listened_for_is_a_fault():
    """A parameter says plain, the robot takes stamped."""
    listeners = Listeners("/cmd_vel", "plain")
    assert listeners.type == PLAIN
    assert listeners.look([STAMPED]) is not None
    assert listeners.look([PLAIN]) is None
