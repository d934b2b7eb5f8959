"""Facts about the state that programs for Nav2 ask for."""

from __future__ import annotations

import pytest
import rclpy
from lifecycle_msgs.srv import GetState
from rclpy.context import Context
from rclpy.node import Node

from action_servers.server.node import ServerOptions, ServersNode
from action_servers.server.topics import answer_as_navigator
from bt_mission.virtual_time import VirtualTimeExecutor


@pytest.fixture
def context():
    """A context of its own."""
    made = Context()
    rclpy.init(context=made)
    yield made
    made.shutdown()


def state(context: Context, node: Node) -> str:
    """What a client hears."""
    client = Node("commander", context=context)
    executor = VirtualTimeExecutor(context=context)
    for one in (node, client):
        executor.add_node(one)
    asked = client.create_client(GetState, "bt_navigator/get_state").call_async(GetState.Request())
    executor.run_until_quiet()
    client.destroy_node()
    executor.shutdown()
    return str(asked.result().current_state.label)


@pytest.mark.parametrize(("is_ready", "label"), [(True, "active"), (False, "inactive")])
def test_navigation_is_active_when_it_has_all_that_it_needs(context, is_ready, label):
    """Programs wait for the word "active" before they send a goal."""
    node = Node("servers", context=context)
    answer_as_navigator(node, lambda: is_ready)
    assert state(context, node) == label
    node.destroy_node()


def test_servers_without_a_map_are_inactive(context, waffle, tmp_path):
    """A goal would be rejected."""
    node = ServersNode(waffle, ServerOptions(image_folder=tmp_path, context=context))
    assert state(context, node) == "inactive"
    node.destroy_node()
