"""Facts about the tuning of the servers, and what is declared of it."""

from __future__ import annotations

import pytest
import rclpy
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.parameter import Parameter

from action_servers.core.parameters import specs
from action_servers.core.tuning import FrontierTuning, NavigationTuning, Tuning
from action_servers.server.node import ServerOptions, ServersNode

TUNINGS = (("", Tuning), ("navigation.", NavigationTuning), ("frontiers.", FrontierTuning))


@pytest.fixture
def make_node(waffle, tmp_path):
    """Make a node: `make_node(**parameters)`."""
    context = rclpy.Context()
    rclpy.init(context=context)
    made = []

    def make(**parameters):
        made.append(
            ServersNode(
                waffle,
                ServerOptions(
                    image_folder=tmp_path, lean=True, context=context, parameters=parameters
                ),
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
    for prefix, tunings in TUNINGS:
        for name, (_, allowed) in specs(tunings).items():
            described, default = node.describe_parameter(prefix + name), getattr(tunings(), name)
            assert described.description == allowed.description
            for declared in described.floating_point_range or described.integer_range:
                assert (declared.from_value, declared.to_value) == (allowed.low, allowed.high)
            assert node.get_parameter(prefix + name).value == default
            (answer,) = node.set_parameters([Parameter(prefix + name, value=default)])
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


def test_a_tuning_of_navigation_reaches_its_maneuvers(make_node):
    """A pose in a wall is given up after the patience that was set."""
    node = make_node(**{"navigation.patience": 2.5, "frontiers.map_wait": 1.5})
    (explore,) = [one for one in node._adapters if one._action.name == "explore_frontiers"]
    planned = explore._action.plan(explore._action.type.Goal(), node._sensors.observe())
    assert planned.surroundings.tuning.patience == 2.5
    assert planned._tuning.map_wait == 1.5
