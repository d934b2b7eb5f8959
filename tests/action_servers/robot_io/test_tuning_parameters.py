"""Facts about the tuning of the servers, and what is declared of it."""

from __future__ import annotations

import pytest
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.parameter import Parameter

from action_servers.core.action import action
from action_servers.robot_io.messages import generated_type
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.base.actions import declared
from bt_mission.base.parameters import specs


def planned(node, name, **fields):
    """What becomes of a goal."""
    (action,) = [first._action for first in node._adapters if first._action.name == name]
    goal = generated_type(action.type).Goal(**fields)
    return action.planned(goal, node._sensors.observe(), node._context_of_plans)


@pytest.fixture
def make_node(waffle, tmp_path, context):
    """Make a node: `make_node(**parameters)`."""
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


def test_each_tuning_is_a_parameter_with_description_and_range(make_node):
    """May be set while the node runs, unless it is fixed, and then is refused with what to do."""
    node = make_node()
    for tuning in {
        type(each): each for each in (action(name).tuning for name in declared())
    }.values():
        for attribute, (name, allowed) in specs(tuning).items():
            described, default = node.describe_parameter(name), getattr(tuning, attribute)
            assert described.description == allowed.description
            for number in described.floating_point_range or described.integer_range:
                assert (number.from_value, number.to_value) == (allowed.low, allowed.high)
            assert node.get_parameter(name).value == default
            (answer,) = node.set_parameters([Parameter(name, value=default)])
            assert answer.successful == (not allowed.is_fixed)
            assert ("restart it with --ros-args -p" in answer.reason) == allowed.is_fixed


def test_a_value_out_of_its_range_is_refused(make_node):
    """Before any action is offered."""
    with pytest.raises(InvalidParameterValueException, match="sensor_timeout"):
        make_node(sensor_timeout=60.0)
    with pytest.raises(InvalidParameterTypeException, match="pictures"):
        make_node(pictures=2.5)
    with pytest.raises(InvalidParameterValueException, match="replace or refuse"):
        make_node(on_new_goal="wait")


def test_a_tuning_reaches_the_maneuvers_and_holds_from_the_next_goal_on(make_node):
    """The limit of a move is the one that was set; one out of its range leaves it as it was."""
    node = make_node(duration_limit=7)

    def refusal() -> str:
        return str(planned(node, "move", secs=4000).reason)

    assert refusal() == "secs must be from 1 to 7 s, got 4000"
    (answer,) = node.set_parameters([Parameter("duration_limit", value=0)])
    assert not answer.successful
    assert "out of range" in answer.reason
    assert refusal() == "secs must be from 1 to 7 s, got 4000"
    (answer,) = node.set_parameters([Parameter("duration_limit", value=1200)])
    assert answer.successful
    assert refusal() == "secs must be from 1 to 1200 s, got 4000"


def test_several_fixed_and_free_parameters_are_set_together_or_not_at_all(make_node):
    """The reason names the fixed one."""
    node = make_node()
    both = [Parameter("pictures", value=9), Parameter("control_rate", value=10.0)]
    answer = node.set_parameters_atomically(both)
    assert not answer.successful
    assert answer.reason == (
        "control_rate is read only when the node starts; restart it with "
        "--ros-args -p control_rate:=10.0"
    )
    assert node.get_parameter("pictures").value == 60


@pytest.mark.parametrize("name", ["executive_lease", "executive_timeout"])
def test_how_long_an_executive_may_be_late_is_fixed(waffle, tmp_path, context, name):
    """The middleware takes the lease when the servers start."""
    node = ServersNode(waffle, ServerOptions(image_folder=tmp_path, context=context))
    (answer,) = node.set_parameters([Parameter(name, value=3.0)])
    assert not answer.successful
    assert answer.reason == (
        f"{name} is read only when the node starts; restart it with --ros-args -p {name}:=3.0"
    )
    node.destroy_node()


def test_a_tuning_of_navigation_reaches_its_maneuvers(make_node):
    """A pose in a wall is given up after the patience that was set."""
    node = make_node(**{"navigation.patience": 2.5, "frontiers.map_wait": 1.5})
    explore = planned(node, "explore_frontiers")
    assert explore.surroundings.tuning.patience == 2.5
    assert explore._tuning.map_wait == 1.5
