"""Nodes, read one by one, and what is kept of those with faults."""

import pytest

from bt_mission.core.diagnostics import in_order
from bt_mission.core.yaml.document import read_text
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.composites import SequenceNode


def read_node(text):
    """Return the reader and what it made of a node."""
    document = read_text(text, "n.yaml")
    reader = NodeReader(document)
    return reader, reader.node(document.data, ())


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("wait", "expected a node such as 'wait: 2.0', got string 'wait'", "write 'wait: ...'"),
        (
            "[wait]",
            "expected a node such as 'wait: 2.0', got a list of 1",
            "put 'sequence:' before the list, to run its nodes one after another",
        ),
        ("{}", "expected a node such as 'wait: 2.0', got an empty mapping", None),
        (
            "{turn: {}, wait: 1}",
            "two kinds in one node: 'turn' and 'wait'",
            "make each an item of its own, with '- ' before it",
        ),
        (
            "{turn: {}, repeat: 3}",
            "two kinds in one node: 'turn' and 'repeat'",
            "make 'repeat' an item of its own, and put 'turn' under its 'do'",
        ),
        (
            "{else if: x > 1}",
            "unknown node type 'else if'",
            "write 'else:' beside 'when', with a 'when' of its own below it",
        ),
        (
            "{name: x, trun: {}}",
            (
                "unknown node type 'trun' (nearest: turn, tree, retry; the reference of the "
                "mission language has them all)"
            ),
            "did you mean 'turn'?",
        ),
        (
            "{name: x}",
            "no type of node beside 'name'",
            "'name' is a modifier: it stands beside the type of its node",
        ),
        (
            "{wait: 1, nam: x}",
            "no modifier 'nam' for wait (it takes: name)",
            "did you mean 'name'?",
        ),
        ("{repeat: {count: 1}}", "'do' is missing", None),
        (
            "{repeat: {}, do: {wait: 1}}",
            "'count', 'while' or 'until' is missing",
            "write 'repeat: {count: 3}'",
        ),
        (
            "{repeat: 3, do: {wait: 1}}",
            "expected a mapping, got the number 3",
            "write 'repeat: {count: 3}'",
        ),
        (
            "{sequence: {wait: 1}}",
            "expected a list, got a mapping with wait",
            "put '- ' before each node, and indent what belongs to it",
        ),
        ("{turn: }", "expected a mapping, got nothing", "write 'turn: {angle: ...}'"),
        ("{turn: {}, timeout: }", "expected seconds above 0, got nothing", None),
        ("{turn: {}, timeout: [1]}", "expected seconds above 0, got a list of 1", None),
        ("{turn: {}, timeout: true}", "expected seconds above 0, got true", None),
        ("{log: 5}", "expected a string, got the number 5", None),
        ("{wait: 1, name: 5}", "expected a string, got the number 5", None),
        (
            "{turn: {}, cancel_when: true}",
            "expected a condition such as 'current_image >= 5', got true",
            None,
        ),
        (
            "{turn: {}, server_timeout: $limit}",
            "expected seconds above 0, got string '$limit'",
            None,
        ),
        (
            "{turn: {}, outputs: {angle turned: x}}",
            "expected the name of a result field, got string 'angle turned'",
            None,
        ),
        (
            "{turn: {}, outputs: {angle_turned: 5}}",
            "expected a name of letters, digits and '_', got the number 5",
            None,
        ),
        (
            "{turn: {}, outputs: {angle_turned: pi}}",
            "'pi' is a word of the expression language, so no variable",
            None,
        ),
        (
            "{wait_for: {topic: a, type: a/msg/B, until: 5}}",
            "expected a condition such as 'percentage < 20', got the number 5",
            None,
        ),
        (
            "{service: {name: a, type: a/srv/B, request: {b: }}}",
            "expected a value, got nothing",
            None,
        ),
        ("{turn: {angle: }}", "expected a value, got nothing", None),
        (
            "{action: {name: /go/, type: a/action/B}}",
            "expected the name of an action such as /turn, got string '/go/'",
            None,
        ),
    ],
)
def test_a_node_with_a_fault_gets_one_message(text, message, hint):
    """Plain words, the valid names, the nearest of them."""
    reader, _ = read_node(text)
    assert [(fault.message, fault.hint) for fault in reader.faults] == [(message, hint)]


def test_sound_parts_of_a_node_are_kept():
    """A bad timeout does not hide the goal; a bad field does not hide the others."""
    reader, step = read_node("{turn: {angle: 9, angular_velocity: }, timeout: -1, name: x}")
    assert len(reader.faults) == 2
    assert (step.sent, step.timeout, step.name) == ({"angle": 9}, None, "x")


def test_a_service_and_a_wait_for_a_message_are_steps_of_their_own():
    """With their limits and outputs."""
    reader, step = read_node(
        "{service: {name: stop, type: std_srvs/srv/Trigger}, outputs: {message: said}}"
    )
    assert reader.faults == []
    assert (step.kind, step.ros_name, step.sent) == ("service", "stop", {})
    assert (step.timeout, step.server_timeout, step.outputs) == (5.0, 5.0, {"message": "said"})
    reader, step = read_node(
        "{wait_for: {topic: odom, type: nav_msgs/msg/Odometry, until: x > 1}, timeout: 2 * n}"
    )
    assert reader.faults == []
    assert (step.kind, step.ros_name, step.condition.text) == ("wait_for", "odom", "x > 1")
    assert step.timeout.text == "2 * n"


def test_what_is_below_a_node_that_cannot_be_kept_is_read_all_the_same():
    """A repeat without a count still has a child with faults."""
    reader, step = read_node("{repeat: {}, do: {sequence: [{wait: 1}, {wait: -1}]}}")
    assert [fault.message for fault in in_order(reader.faults)] == [
        "'count', 'while' or 'until' is missing",
        "expected seconds, 0 or more, got the number -1",
    ]
    assert isinstance(step, SequenceNode)


def test_outputs_of_nodes_with_faults_are_remembered():
    """So that no one says that nothing writes them."""
    reader, _ = read_node("{trun: {}, outputs: {angle: a, other: [b], third: c}}")
    assert reader.lost == {"a", "c"}
