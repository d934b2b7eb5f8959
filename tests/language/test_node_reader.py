"""Nodes, read one by one, and what is kept of those with faults."""

from bt_mission.core.diagnostics import in_order
from bt_mission.core.yaml.document import read_text
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.composites import SequenceNode


def read_node(text):
    """Return the reader and what it made of a node."""
    document = read_text(text, "n.yaml")
    reader = NodeReader(document)
    return reader, reader.node(document.data, ())


def test_sound_parts_of_a_node_are_kept():
    """A bad timeout does not hide the goal; a bad field does not hide the others."""
    reader, step = read_node("{turn: {angle: 9, angular_velocity: }, timeout: -1, name: x}")
    assert len(reader.diagnostics) == 2
    assert (step.sent, step.timeout, step.name) == ({"angle": 9}, None, "x")


def test_a_service_and_a_wait_for_a_message_are_steps_of_their_own():
    """With their limits and outputs."""
    reader, step = read_node(
        "{service: {name: stop, type: std_srvs/srv/Trigger}, outputs: {message: said}}"
    )
    assert reader.diagnostics == []
    assert (step.kind, step.ros_name, step.sent) == ("service", "stop", {})
    assert (step.timeout, step.server_timeout, step.outputs) == (5.0, 5.0, {"message": "said"})
    reader, step = read_node(
        "{wait_for: {topic: odom, type: nav_msgs/msg/Odometry, until: x > 1}, timeout: 2 * n}"
    )
    assert reader.diagnostics == []
    assert (step.kind, step.ros_name, step.condition.text) == ("wait_for", "odom", "x > 1")
    assert step.timeout.text == "2 * n"


def test_what_is_below_a_node_that_cannot_be_kept_is_read_all_the_same():
    """A repeat without a count still has a child with faults."""
    reader, step = read_node("{repeat: {}, do: {sequence: [{wait: 1}, {wait: -1}]}}")
    assert [fault.message for fault in in_order(reader.diagnostics)] == [
        "'count', 'while' or 'until' is missing",
        "expected seconds, 0 or more, got the number -1",
    ]
    assert isinstance(step, SequenceNode)


def test_outputs_of_nodes_with_faults_are_remembered():
    """So that no one says that nothing writes them."""
    reader, _ = read_node("{trun: {}, outputs: {angle: a, other: [b], third: c}}")
    assert reader.lost == {"a", "c"}
