"""Tunings, and the pilot's rule for a new goal, as declared ROS parameters."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterValueException
from rclpy.node import Node

from action_servers.core.tuning import Range, ranges

T = TypeVar("T")

OnNewGoal: TypeAlias = Literal["replace", "refuse"]

ON_NEW_GOAL = "on_new_goal"
ON_NEW_GOAL_CHOICES: tuple[OnNewGoal, ...] = ("replace", "refuse")


def declare_tuning(node: Node, tunings: type[T], prefix: str = "") -> T:
    """Declare every field of a class of tunings on a node, and return their values, which stay.

    `prefix` comes before each name, such as `navigation.`. Raises InvalidParameterTypeException or
    InvalidParameterValueException for an override of another type or out of its range.
    """
    defaults = tunings()
    values = {
        name: node.declare_parameter(
            prefix + name, getattr(defaults, name), _descriptor(allowed, getattr(defaults, name))
        ).value
        for name, allowed in ranges(tunings).items()
    }
    return tunings(**values)


def _descriptor(allowed: Range, default: Any) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(description=allowed.description, read_only=True)
    if isinstance(default, bool):
        return descriptor
    if isinstance(default, int):
        low, high = int(allowed.low), int(allowed.high)
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=1)]
    else:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(allowed.low), to_value=float(allowed.high))
        ]
    return descriptor


def declare_on_new_goal(node: Node) -> OnNewGoal:
    """Declare the rule for a goal that comes while another one drives, and return it."""
    choices = " or ".join(ON_NEW_GOAL_CHOICES)
    value = node.declare_parameter(
        ON_NEW_GOAL,
        ON_NEW_GOAL_CHOICES[0],
        ParameterDescriptor(
            description="What a goal does that comes while another one drives: replace it, which "
            "ends aborted, or be refused itself.",
            additional_constraints=choices,
            read_only=True,
        ),
    ).value
    for choice in ON_NEW_GOAL_CHOICES:
        if value == choice:
            return choice
    raise InvalidParameterValueException(
        ON_NEW_GOAL, value, f"{ON_NEW_GOAL} must be {choices}, got {value!r}"
    )
