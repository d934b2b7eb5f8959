"""Nodes of a stage make nothing that its executor does not serve."""

from __future__ import annotations

import pytest
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from std_msgs.msg import String

from bt_mission.ros.observable_publisher import ObservableNode


@pytest.fixture
def node(context):
    """A node of a stage."""
    made = ObservableNode(
        "observable", context=context, enable_rosout=False, start_parameter_services=False
    )
    yield made
    made.destroy_node()


def test_there_are_no_handlers_of_events(node):
    """Rclpy would make two for each."""
    assert node.create_publisher(String, "a", 10).event_handlers == []
    assert node.create_subscription(String, "a", lambda _: None, 10).event_handlers == []


def test_handlers_that_are_asked_for_are_made(node):
    """Whoever wants to hear of events does."""
    lost = PublisherEventCallbacks(liveliness=lambda _: None, use_default_callbacks=False)
    result = SubscriptionEventCallbacks(liveliness=lambda _: None, use_default_callbacks=False)
    assert len(node.create_publisher(String, "a", 10, event_callbacks=lost).event_handlers) == 1
    subscription = node.create_subscription(String, "a", lambda _: None, 10, event_callbacks=result)
    assert len(subscription.event_handlers) == 1
