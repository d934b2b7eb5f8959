"""Facts about the tuning of the servers, and what is declared of it."""

from __future__ import annotations

from dataclasses import fields

import pytest
import rclpy
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.parameter import Parameter

from action_servers.node import ServersNode
from action_servers.tuning import RANGES, TUNING, Tuning


@pytest.fixture
def make_node(waffle, tmp_path):
    """Make a node: `make_node(**parameters)`."""
    context = rclpy.Context()
    rclpy.init(context=context)
    made = []

    def make(**parameters):
        made.append(
            ServersNode(
                waffle, image_folder=tmp_path, lean=True, context=context, parameters=parameters
            )
        )
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()
    context.shutdown()


def test_each_tuning_is_a_parameter_with_description_and_range(make_node):
    """Read when the node is made, and fixed from then on."""
    node = make_node()
    for name in (one.name for one in fields(Tuning)):
        described = node.describe_parameter(name)
        (allowed,) = described.floating_point_range or described.integer_range
        assert described.description == RANGES[name].description
        assert (allowed.from_value, allowed.to_value) == (RANGES[name].low, RANGES[name].high)
        assert node.get_parameter(name).value == getattr(TUNING, name)
        (answer,) = node.set_parameters([Parameter(name, value=getattr(TUNING, name))])
        assert not answer.successful


def test_a_value_out_of_its_range_is_refused(make_node):
    """Before any action is offered."""
    with pytest.raises(InvalidParameterValueException, match="sensor_timeout"):
        make_node(sensor_timeout=60.0)
    with pytest.raises(InvalidParameterTypeException, match="pictures"):
        make_node(pictures=2.5)
    with pytest.raises(InvalidParameterValueException, match="replace or refuse"):
        make_node(on_new_goal="wait")


def test_a_tuning_reaches_the_maneuvers(make_node, waffle):
    """The limit of a move is the one that was set."""
    node = make_node(duration_limit=7)
    (move,) = [one for one in node._adapters if one._action.name == "move"]
    planned = move._action.plan(move._action.type.Goal(secs=8), node._sensors.observe())
    assert planned.reason == "secs must be from 1 to 7 s, got 8"
