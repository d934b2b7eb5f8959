"""Whatever an XML file says that a mission cannot is an error at its place, all of them at once."""

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.mission_writer import mission_xml
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
    assert all(fault.source for fault in caught.value.diagnostics)
    return [
        (diagnostic.line, diagnostic.column, diagnostic.message, diagnostic.hint)
        for diagnostic in caught.value.diagnostics
    ]


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


def test_diagnostics_of_the_mission_point_into_the_xml_file(tmp_path):
    """As deep as into an expression within an attribute."""
    path = tmp_path / "m.xml"
    path.write_text(in_tree('<turn angle="90 + $step" timeout="0"/>'), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(path)
    assert [str(fault).splitlines()[0] for fault in caught.value.diagnostics] == [
        f"{path}:2:40: error: '$step' is an undefined variable (defined: none) [BT-402]",
        f"{path}:2:55: error: expected seconds above 0, got the number 0 [BT-302]",
    ]


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ('<spin spin_dist="1.57" timeout="9"/>', ("BT-502", "did you mean 'target_yaw'?")),
        ('<turn angle="90"/>', ("BT-234", """add 'timeout="SECONDS"'""")),
    ],
)
def test_hints_are_written_as_in_xml(tmp_path, node, expected):
    """The limit of a goal is an attribute; a port of Nav2 leads to the field that it sets."""
    path = tmp_path / "m.xml"
    path.write_text(in_tree(node), encoding="utf-8")
    _, (diagnostic,) = examine(path)
    assert (diagnostic.code, diagnostic.hint) == expected


def test_what_is_nested_too_deeply_for_yaml_is_refused():
    """So that what is read can be written as YAML."""
    leaf = '<turn angle="[[[[1]]]]"/>'
    deep = "<Sequence>" * 97 + leaf + "</Sequence>" * 97
    other = f'<BehaviorTree ID="n">{deep}</BehaviorTree></root>'
    text = in_tree("<SubTree ID='n'/>").replace("</root>", other)
    (fault,) = faults_of(text.replace('"4"', '"4" main_tree_to_execute="m"'))
    assert fault == (3, 1006, "nested too deeply; the limit is 200 levels of YAML", None)


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


def with_part(nodes, part, ports):
    """Return a file with a tree `m`, in lines 2 and 3, and a tree `part` with ports."""
    return (
        '<root BTCPP_format="4" main_tree_to_execute="m">\n<BehaviorTree ID="m"><Sequence>\n'
        f"{nodes}"
        f'</Sequence></BehaviorTree><BehaviorTree ID="part"><Sequence>\n{part}'
        f'</Sequence></BehaviorTree><TreeNodesModel><SubTree ID="part">{ports}</SubTree>'
        "</TreeNodesModel></root>"
    )


SET_N, SET_X = '<Script code="n := 3"/>', '<Script code="x := 1"/>'
LOOP = '<Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat>'
TRY = f'<RetryUntilSuccessful num_attempts="{{n}}">{ONE}</RetryUntilSuccessful>'
USE = '<SubTree ID="part" _autoremap="1"/>'
IN, OUT = '<input_port name="n" type="int"/>', '<output_port name="x" type="int"/>'
READS_X = '<ScriptCondition code="x == 1"/>'
WHILE = "can change while the node runs, by the node in line"


@pytest.mark.parametrize(
    ("nodes", "part", "ports", "expected"),
    [
        (f"{SET_N}{LOOP}{SET_N}", ONE, "", []),
        (f'{SET_N}<Repeat num_cycles="{{n}}">{SET_N}</Repeat>', ONE, "", [(3, 43, f"{WHILE} 3")]),
        (
            f"{SET_N}<Parallel>{SET_N}{TRY}</Parallel>",
            *(ONE, "", [(3, 92, f"{WHILE} 3")]),
        ),
        (f'{SET_N}<SubTree ID="part" n="{{n}}"/>{SET_N}', LOOP, IN, []),
        (
            f'{SET_N}<Parallel>\n{SET_N}<SubTree ID="part" n="{{n}}"/></Parallel>',
            *(LOOP, IN, [(5, 20, f"{WHILE} 4")]),
        ),
        (
            f'{SET_N}<SubTree ID="part" n="{{n}}" x="{{n}}"/>',
            *(f"{LOOP}{SET_X}", f"{IN}{OUT}", [(3, 53, "'n' and 'x' of the tree 'part' are the")]),
        ),
        ('<SubTree ID="part" _autoremap="true"/>', SET_X + READS_X, "", []),
        (f'<SubTree ID="part" _autoremap="true"/>{READS_X}', SET_X, OUT, []),
        (
            f'{SET_X}<SubTree ID="part" _autoremap="true"/>{READS_X}',
            *('<Script code="x := 2"/>', "", [(3, 43, "'_autoremap' shares 'x' with the caller")]),
        ),
        (
            f"<Parallel>{USE}{USE}</Parallel>",
            *(SET_X, "", [(3, 30, "'_autoremap' shares 'x'"), (3, 65, "'_autoremap' shares 'x'")]),
        ),
        (
            '<SubTree ID="part" _autoremap="true"/>',
            *(READS_X, "", [(3, 20, "'_autoremap' shares 'x' with the caller, but the tree")]),
        ),
    ],
)
def test_what_changes_in_btcpp_while_a_node_runs(nodes, part, ports, expected):
    """Is live here, too, or refused; where copying makes no difference, it is accepted."""
    try:
        load(document_of(with_part(nodes, part, ports), "m.xml"))
        faults: tuple[Diagnostic, ...] = ()
    except InputError as error:
        faults = tuple(error.diagnostics)
    assert [(fault.line, fault.column) for fault in faults] == [row[:2] for row in expected]
    for fault, (_, _, message) in zip(faults, expected, strict=True):
        assert message in fault.message
        assert fault.hint


def test_trees_have_names_in_any_script():
    """Groot accepts them, and editors mark the root."""
    text = with_part('<SubTree ID="预处理"/>', ONE, "").replace("part", "预处理")
    text = text.replace('"m"', '"Größe"').replace("<root ", '<root project_name="p" ')
    mission = load(document_of(text))
    assert (mission.name, list(mission.trees)) == ("Größe", ["预处理"])
    assert mission_xml(document_of(text)).count('ID="预处理"') == 2


def test_ports_without_a_declaration_are_named_with_it():
    """As it is to be written."""
    (fault,) = faults_of(with_part(f'{SET_X}<SubTree ID="part" _autoremap="1"/>', SET_X, ""))
    port = '<output_port name="x" type="..."/>'
    assert fault[3] == f'write under TreeNodesModel: <SubTree ID="part">{port}</SubTree>'
