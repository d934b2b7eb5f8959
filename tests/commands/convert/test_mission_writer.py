"""What XML cannot say is an error at its place in the YAML file; what it can say, it says so."""

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.mission_writer import mission_xml
from bt_mission.sessions.load import load
from tests.support.missions import meaning


def xml_of(text, file="m.yaml"):
    """Return a mission as XML."""
    return mission_xml(read_text(text, file))


def test_a_short_mission_is_xml_that_groot_shows():
    """The head, the tree, and the models of the trees and leaves in use."""
    text = (
        "mission: hop\ndescription: Up & down\nworld: nav_arena\nseed: 4\n"
        "inputs: {speed: 0.2, rounds: 2, quiet: false, who: Ann, home: [0.5, 0, 'x']}\n"
        "tree:\n  repeat: {count: $rounds}\n  do: {log: 'hi $who'}\n"
    )
    assert xml_of(text) == (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<root BTCPP_format="4" main_tree_to_execute="hop">\n'
        '  <BehaviorTree ID="hop" _description="Up &amp; down">\n'
        '    <Repeat num_cycles="{rounds}">\n'
        '      <log message="hi $who"/>\n'
        "    </Repeat>\n"
        "  </BehaviorTree>\n"
        "  <TreeNodesModel>\n"
        '    <SubTree ID="hop">\n'
        '      <input_port name="speed" type="double" default="0.2"/>\n'
        '      <input_port name="rounds" type="int" default="2"/>\n'
        '      <input_port name="quiet" type="bool" default="false"/>\n'
        '      <input_port name="who" type="std::string" default="Ann"/>\n'
        '      <input_port name="home" type="list" default="[0.5, 0, x]"/>\n'
        "      <MetadataFields>\n"
        '        <Metadata world="nav_arena" seed="4"/>\n'
        "      </MetadataFields>\n"
        "    </SubTree>\n"
        '    <Action ID="log">\n'
        '      <input_port name="message"/>\n'
        "    </Action>\n"
        "  </TreeNodesModel>\n"
        "</root>\n"
    )


def test_limits_at_the_head_go_to_the_leaves():
    """The mission means the same, so it is the same once loaded."""
    text = (
        "mission: m\nlimits: {timeout: 60}\n"
        "servers: {/turn: {acceptance_timeout: 9, timeout: 30}}\n"
        "tree:\n  sequence:\n    - turn: {angle: 1}\n    - turn: {angle: 2}\n      timeout: 5\n"
        "    - move: {secs: 1}\n"
    )
    xml = xml_of(text)
    assert '<turn angle="1" timeout="30.0" acceptance_timeout="9.0"/>' in xml
    assert '<move secs="1" timeout="60.0"/>' in xml
    there = load(document_of(xml))
    assert meaning(there) == meaning(load(text))


def test_included_trees_are_written_into_the_file(tmp_path):
    """XML files take in no others."""
    (tmp_path / "lib.yaml").write_text("trees: {say: {needs: {w: text}, do: {log: $w}}}\n")
    path = tmp_path / "m.yaml"
    text = "mission: m\ninclude: [lib.yaml]\ntree: {tree: {name: say, inputs: {w: \"'hi'\"}}}\n"
    path.write_text(text, encoding="utf-8")
    xml = xml_of(text, str(path))
    assert '<SubTree ID="say" w="hi"/>' in xml
    there = load(document_of(xml))
    assert meaning(there) == meaning(load(path))


@pytest.mark.parametrize(
    ("name", "main"), [("two words", "MainTree"), ("t", "MainTree2"), ("m-1", "m-1")]
)
def test_the_main_tree_has_the_name_of_the_mission_where_it_can(name, main):
    """Else the name stands in its metadata."""
    trees = "t: {do: {log: a}}" + (", MainTree: {do: {log: b}}" if name == "t" else "")
    xml = xml_of(f"mission: {name}\ntrees: {{{trees}}}\ntree: {{log: a}}\n")
    assert f'main_tree_to_execute="{main}"' in xml
    there = load(document_of(xml))
    assert there.name == name


def test_what_is_live_only_in_btcpp_is_not_written():
    """An input that the tree writes itself keeps its value here."""
    part = "{needs: {n: number}, outputs: {k: number}, do: {set: {k: n + 1}}}"
    text = (
        f"mission: m\ntrees:\n  next: {part}\ntree:\n  sequence: [set: {{x: 1}},\n"
        "    {tree: {name: next, inputs: {n: $x}}, outputs: {k: x}}]\n"
    )
    with pytest.raises(InputError) as caught:
        xml_of(text)
    (fault,) = caught.value.diagnostics
    assert (fault.code, fault.line, fault.column) == ("BT-1205", 6, 56)
    assert fault.message == (
        "'n' and 'k' of the tree 'next' are the one variable 'x': in BehaviorTree.CPP one changes "
        "with the other"
    )
