"""Facts about the state that programs for Nav2 ask for."""

from __future__ import annotations

import pytest
from lifecycle_msgs.srv import GetState

from action_servers.server.node import ServerOptions, ServersNode
from action_servers.server.topics import answer_as_navigator
from tests.support.rig import Rig


def state(rig: Rig) -> str:
    """What a client hears."""
    client = rig.node("commander").create_client(GetState, "bt_navigator/get_state")
    asked = client.call_async(GetState.Request())
    rig.settle(asked.done)
    return str(asked.result().current_state.label)


@pytest.mark.parametrize(("is_ready", "label"), [(True, "active"), (False, "inactive")])
def test_navigation_is_active_when_it_has_all_that_it_needs(rig, is_ready, label):
    """Programs wait for the word "active" before they send a goal."""
    answer_as_navigator(rig.node("servers"), lambda: is_ready)
    assert state(rig) == label


def test_servers_without_a_map_are_inactive(rig, waffle, tmp_path):
    """A goal would be rejected."""
    rig.add(ServersNode(waffle, ServerOptions(image_folder=tmp_path, context=rig.context)))
    assert state(rig) == "inactive"
