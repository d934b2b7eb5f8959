"""Which actions an executor knows to be served, without asking the graph."""

from __future__ import annotations

from typing import Any

from bt_mission_interfaces.action import Turn
from rclpy.action import ActionServer


def test_an_action_of_a_node_that_is_served_is_offered(rig: Any) -> None:
    """By its full name, until its server or its node is gone; a change is not known at once."""
    node = rig.node("server")
    server = ActionServer(node, Turn, "turn", lambda _: Turn.Result())
    assert not rig.clock.offers("/turn")
    rig.clock.run_until_quiet()
    assert [rig.clock.offers(name) for name in ("/turn", "turn", "/spin")] == [
        True,
        False,
        False,
    ]
    server.destroy()
    assert not rig.clock.offers("/turn")
    rig.clock.run_until_quiet()
    assert not rig.clock.offers("/turn")
    ActionServer(node, Turn, "turn", lambda _: Turn.Result())
    rig.clock.run_until_quiet()
    rig.clock.remove_node(node)
    rig.clock.run_until_quiet()
    assert not rig.clock.offers("/turn")
