"""Whatever an XML file says that a mission cannot is an error at its place, all of them at once."""

from pathlib import Path

import pytest

from bt_mission.btcpp.document import HEAD, document_of
from bt_mission.btcpp.node_reader import STAND_IN
from bt_mission.core.diagnostics import InputError
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

EVERYTHING = Path(__file__).parent / "everything.xml"


def in_tree(nodes, models="", root='BTCPP_format="4"'):
    """Return a file with a tree of these nodes: they stand in line 2, from column 23 on."""
    models = f"<TreeNodesModel>{models}</TreeNodesModel>" if models else ""
    return f'<root {root}>\n<BehaviorTree ID="m">{nodes}</BehaviorTree>\n{models}</root>'


def faults_of(text):
    """Return the faults of a text: line, column, message and hint."""
    with pytest.raises(InputError) as caught:
        document_of(text, "m.xml")
    assert all(fault.source for fault in caught.value.faults)
    return [(one.line, one.column, one.message, one.hint) for one in caught.value.faults]


def test_every_element_has_its_counterpart():
    """In one file that loads without a fault; what it warns of points into it."""
    mission, faults = examine(EVERYTHING)
    assert mission is not None
    assert [(fault.line, fault.severity) for fault in faults] == [
        (21, "warning"),
        (68, "warning"),
        (69, "warning"),
    ]
    kinds = {step.kind for tree in mission.all_trees for step in tree.body.walk()}
    assert kinds == {
        *("sequence", "fallback", "parallel", "repeat", "retry", "timeout", "invert", "force"),
        *("guard", "when", "check", "set", "wait", "log"),
        *("action", "service", "wait_for", "publish", "tree"),
    }


ONE = "<AlwaysSuccess/>"
INSTEAD_OF_SKIPPING = (
    "it is read below a Sequence or Fallback that has a child without it; else write "
    '<Precondition if=... else="SUCCESS">'
)
MEANT = "did you mean 'Sequence'?"


@pytest.mark.parametrize(
    ("nodes", "expected"),
    [
        ("", (2, 2, "expected 1 node in <BehaviorTree>, got 0", None)),
        (ONE * 2, (2, 2, "expected 1 node in <BehaviorTree>, got 2", None)),
        ("<Sequence/>", (2, 23, "<Sequence> has nothing in it", None)),
        ("<Inverter/>", (2, 23, "expected 1 node in <Inverter>, got 0", None)),
        (f"<Sequence>hm{ONE}</Sequence>", (2, 23, "a loose text in <Sequence>: 'hm'", None)),
        ("<Action/>", (2, 23, "<Action> does not say which: the attribute 'ID' is missing", None)),
        (
            "<Seqence/>",
            (2, 23, "the node 'Seqence' has no counterpart", f"{MEANT} {STAND_IN}"),
        ),
        (
            '<Control ID="Switch3"/>',
            (
                2,
                34,
                "the node 'Switch3' has no counterpart",
                "write an IfThenElse for each case",
            ),
        ),
        (
            f'<Repeat num_cycles="-1">{ONE}</Repeat>',
            (
                2,
                41,
                "expected an integer of at least 1, or a variable '{name}', got '-1'",
                "for ever has no counterpart; give a number",
            ),
        ),
        (
            f'<Sequence memory="false">{ONE}</Sequence>',
            (2, 32, "no attribute 'memory' for Sequence (it takes: name)", None),
        ),
        (
            f'<Sequence _skipIf="x">{ONE}</Sequence>',
            (
                2,
                32,
                "the attribute '_skipIf' has no counterpart",
                INSTEAD_OF_SKIPPING,
            ),
        ),
        (
            f'<Parallel success_count="2">{ONE * 3}</Parallel>',
            (2, 46, "expected 1 or -1 (all), got '2'", None),
        ),
        ("<log/>", (2, 23, "the attribute 'message' is missing", None)),
        (
            '<log message="x" mesage="y"/>',
            (
                2,
                39,
                "no attribute 'mesage' for log (it takes: message, name)",
                "did you mean 'message'?",
            ),
        ),
        (
            '<turn out_angle="x"/>',
            (2, 38, "expected a variable such as '{name}', got 'x'", None),
        ),
        (
            '<turn angle="1" goal__angle="2"/>',
            (2, 38, "the field 'angle' is given twice", None),
        ),
        (
            '<turn angle="[1, 2"/>',
            (
                2,
                35,
                "this list is opened with '[' and never closed with ']'",
                "a list is written as in YAML, such as [1.0, 0.5, 90]",
            ),
        ),
        (
            f'<turn {"__".join("a" * 3000)}="1"/>',
            (
                *(2, 28),
                (
                    f"no attribute '{'a__' * 19}...' for turn (it takes: fields of the goal, "
                    "timeout, cancel_when, on_cancel, server_timeout, acceptance_timeout, "
                    "feedback_timeout, cancel_timeout, out_FIELD, name)"
                ),
                None,
            ),
        ),
        (
            '<SubTree ID="x"/>',
            (2, 34, "no tree is called 'x' (trees: m)", None),
        ),
        (
            '<ScriptCondition code="a &gt; b ? 1 : 2"/>',
            (
                2,
                54,
                "'?' has no counterpart in our expressions",
                "use a leaf 'check' or 'set', whose are ours",
            ),
        ),
        (
            f'<IfThenElse><log message="x"/>{ONE * 2}</IfThenElse>',
            (
                2,
                35,
                "expected a ScriptCondition without a name here",
                "only a condition on variables decides between nodes",
            ),
        ),
        (
            f'<Precondition if="a" else="RUNNING">{ONE}</Precondition>',
            (2, 48, "expected SUCCESS or FAILURE, got 'RUNNING'", None),
        ),
    ],
)
def test_a_node_without_a_counterpart_is_an_error_at_its_place(nodes, expected):
    """With what to write instead, where that is known."""
    assert faults_of(in_tree(nodes)) == [expected]


def test_all_faults_are_found_at_once():
    """Also below and beside nodes that are unknown."""
    found = faults_of(in_tree("<Sequence><Foo><log/></Foo><Repeat/></Sequence>"))
    assert [fault[2] for fault in found] == [
        "the node 'Foo' has no counterpart",
        "the attribute 'message' is missing",
        "the attribute 'num_cycles' is missing",
        "expected 1 node in <Repeat>, got 0",
    ]


@pytest.mark.parametrize(
    ("models", "messages"),
    [
        ('<input_port name="x" type="int"/>', ["the input 'x' of the mission needs a default"]),
        (
            '<input_port name="x" type="int" default="1.5"/>',
            ["expected a value of the type int, got '1.5'"],
        ),
        (
            '<inout_port name="x"/>',
            ["expected input_port, output_port or MetadataFields, got <inout_port>"],
        ),
        (
            '<output_port name="x" type="int"/>',
            ["a mission gives no outputs, such as 'x'"],
        ),
        (
            '<MetadataFields><Metadata wrld="x"/></MetadataFields>',
            [f"no attribute 'wrld' for Metadata (it takes: {', '.join(HEAD)})"],
        ),
    ],
)
def test_the_ports_of_a_tree_are_read_strictly(models, messages):
    """A port has a name and a type; an input of the mission has a default."""
    found = faults_of(in_tree(ONE, f'<SubTree ID="m">{models}</SubTree>'))
    assert [fault[2] for fault in found] == messages


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<tree/>", (1, 2, 'expected <root BTCPP_format="4">, got <tree>')),
        (in_tree(ONE, root='BTCPP_format="3"'), (1, 20, "expected format 4, got '3'")),
        (
            in_tree(ONE, root=""),
            (1, 2, "the attribute 'BTCPP_format' is missing; format 4 is read"),
        ),
        (
            in_tree(ONE, root='BTCPP_format="4" main_tree_to_execute="x"'),
            (1, 45, "no tree is called 'x' (trees: m)"),
        ),
        ('<root BTCPP_format="4"/>', (1, 2, "no <BehaviorTree> is in this file")),
        (
            in_tree(ONE).replace("</root>", '<include path="x.xml"/></root>'),
            (3, 15, "a mission in a text has no folder to include files from"),
        ),
        (
            in_tree(ONE).replace("</root>", "<include/></root>"),
            (3, 2, "the attribute 'path' is missing"),
        ),
        (
            in_tree(ONE).replace("</root>", '<include path="x.xml" ros_pkg="no_pkg"/></root>'),
            (3, 15, "no ROS package 'no_pkg' is installed"),
        ),
        (
            in_tree(ONE).replace('ID="m"', 'ID="Root"'),
            (2, 18, "BehaviorTree.CPP has a node 'Root', so no tree has that ID"),
        ),
        (
            in_tree(ONE).replace('ID="m"', 'ID="Sequence"'),
            (2, 18, "BehaviorTree.CPP has a node 'Sequence', so no tree has that ID"),
        ),
        (
            in_tree(ONE).replace("</root>", f'<BehaviorTree ID="n">{ONE}</BehaviorTree></root>'),
            (1, 2, "which of the trees is the mission? (m, n)"),
        ),
        (
            in_tree(ONE).replace("</root>", f'<BehaviorTree ID="m">{ONE}</BehaviorTree></root>'),
            (3, 18, "there is a tree 'm' already"),
        ),
    ],
)
def test_the_file_around_the_trees_is_read_strictly(text, expected):
    """The format, the main tree, and nothing that would be left out."""
    assert [fault[:3] for fault in faults_of(text)] == [expected]


def test_faults_of_the_mission_point_into_the_xml_file(tmp_path):
    """As deep as into an expression within an attribute."""
    path = tmp_path / "m.xml"
    path.write_text(in_tree('<turn angle="90 + $step" timeout="0"/>'), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(path)
    assert [str(fault).splitlines()[0] for fault in caught.value.faults] == [
        f"{path}:2:40: error: '$step' is an undefined variable (defined: none)",
        f"{path}:2:55: error: expected seconds above 0, got the number 0",
    ]


def test_what_is_nested_too_deeply_for_yaml_is_refused():
    """So that what is read can be written as YAML."""
    leaf = '<turn angle="[[[[1]]]]"/>'
    deep = "<Sequence>" * 97 + leaf + "</Sequence>" * 97
    other = f'<BehaviorTree ID="n">{deep}</BehaviorTree></root>'
    text = in_tree("<SubTree ID='n'/>").replace("</root>", other)
    (fault,) = faults_of(text.replace('"4"', '"4" main_tree_to_execute="m"'))
    assert fault == (3, 1006, "nested too deeply; at most 200 levels of YAML are read", None)


def test_the_only_tree_needs_no_id(tmp_path):
    """The mission has the name of the file; among several trees each needs its own."""
    tree = f"<BehaviorTree>{ONE}</BehaviorTree>"
    path = tmp_path / "two_legs.xml"
    path.write_text(f'<root BTCPP_format="4">{tree}</root>')
    assert load(path).name == "two_legs"
    assert faults_of(f'<root BTCPP_format="4">{tree}{tree}</root>')[0][:3] == (
        *(1, 25),
        "the attribute 'ID' is missing",
    )


def test_the_mission_is_the_tree_that_no_other_uses():
    """Where 'main_tree_to_execute' does not say another; it needs to be the only such tree."""
    part = f'<BehaviorTree ID="part">{ONE}</BehaviorTree>'
    whole = '<BehaviorTree ID="whole"><Sequence><SubTree ID="part"/></Sequence></BehaviorTree>'
    document = document_of(f'<root BTCPP_format="4">{part}{whole}</root>')
    assert document.data["mission"] == "whole"
    root = '<root BTCPP_format="4" main_tree_to_execute="part">'
    assert document_of(f"{root}{part}{whole}</root>").data["mission"] == "part"
