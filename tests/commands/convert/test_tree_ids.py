"""BehaviorTree.CPP takes what we write: no tree has the name of a node, every port is declared."""

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read, read_text
from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.mission_writer import mission_palette, mission_xml
from bt_mission.commands.convert.palette import palette_xml
from bt_mission.commands.convert.table import REGISTERED, leaf_kinds
from bt_mission.ros.interface_types import shapes
from bt_mission.sessions.load import load
from tests.commands.convert.btcpp_rules import CHILDREN, models, refusals, type_refusals
from tests.support.missions import meaning
from tests.support.project import MISSIONS, ROOT
from tests.support.thorough import sample

SHIPPED = sorted(path.relative_to(ROOT) for path in MISSIONS)

TREES_LIKE_NODES = """\
mission: Sequence
inputs: {far: 2}
trees:
  turn: {needs: {by: number}, do: {turn: {angle: $by}, timeout: 9}}
  turn_tree: {do: {log: hi}}
  Sleep: {do: {tree: {name: turn, inputs: {by: 5.0}}}}
tree:
  sequence: [{tree: Sleep}, {tree: turn_tree}, {tree: {name: turn, inputs: {by: $far}}}]
"""


@pytest.mark.parametrize("path", sample(SHIPPED, 5), ids=str)
def test_behaviortree_cpp_takes_a_shipped_mission(path):
    """With the leaves registered as the palette of that mission has them."""
    document = read(ROOT / path)
    leaves = models(mission_palette(document, shapes))
    assert list(leaves) == list(leaf_kinds())
    xml = mission_xml(document, shapes)
    assert list(refusals(xml, leaves)) == []
    assert list(type_refusals(xml)) == []


COMPUTED = """\
mission: m
inputs: {far: 2, often: 3}
trees:
  inner: {needs: {by: number}, do: {turn: {angle: $by}, timeout: 9}}
tree:
  repeat: {count: $often}
  do:
    sequence:
      - turn: {angle: "uniform(60, 120)", angular_velocity: 0.5}
        timeout: 9
      - turn: {angle: 90}
        timeout: 9
      - tree: {name: inner, inputs: {by: $far}}
"""


def test_what_a_mission_computes_has_no_type_and_its_inputs_have_that_of_the_ports():
    """BehaviorTree.CPP refuses an expression at a `double`, and an `int` there."""
    xml = mission_xml(read_text(COMPUTED, "m.yaml"), shapes)
    assert list(type_refusals(xml)) == []
    assert '<input_port name="angle"/>' in xml
    assert '<input_port name="angular_velocity" type="double"/>' in xml
    assert '<input_port name="far" type="double" default="2.0"/>' in xml
    assert '<input_port name="often" type="int" default="3"/>' in xml


def test_only_leaves_for_any_type_need_a_mission_for_their_ports():
    """The palette alone does for all others."""
    leaves = models(palette_xml(shapes))
    refused = {
        (path.stem, why)
        for path in SHIPPED
        for why in refusals(mission_xml(read(ROOT / path), shapes), leaves)
    }
    gripper = ("goal__command__max_effort", "goal__command__position", "out_stalled")
    assert refused == {
        ("recoveries", "no ports ['goal__time'] of <action>"),
        ("patrol", "no ports ['message__speed_limit'] of <publish>"),
        (
            "fetch",
            "no ports ['goal__trajectory__joint_names', 'goal__trajectory__points'] of <action>",
        ),
        ("fetch", f"no ports {list(gripper)} of <action>"),
        ("fetch", "no ports ['set_driven'] of <set>"),
    }


def test_a_mission_with_the_name_of_a_leaf_has_another_id():
    """Its name is in its metadata, and comes back."""
    xml = mission_xml(read_text("mission: turn\ntree: {wait: 1}\n", "m.yaml"))
    assert '<BehaviorTree ID="MainTree">' in xml
    assert '<Metadata mission="turn"/>' in xml
    assert document_of(xml).data["mission"] == "turn"


def test_trees_with_names_of_nodes_have_other_ids_and_come_back():
    """Each under its own name, also where the other ID would be taken."""
    document = read_text(TREES_LIKE_NODES, "m.yaml")
    xml = mission_xml(document, shapes)
    assert list(refusals(xml, models(xml))) == []
    assert [line.split('"')[1] for line in xml.splitlines() if "<BehaviorTree" in line] == [
        *("MainTree", "turn_tree1", "turn_tree", "Sleep_tree")
    ]
    there, here = load(document_of(xml)), load(document)
    assert meaning(there) == meaning(here)


def test_two_trees_with_one_name_are_refused():
    """Whichever of them has the name as its ID."""
    model = (
        '<TreeNodesModel><SubTree ID="b"><MetadataFields><Metadata tree="a"/></MetadataFields>'
        "</SubTree></TreeNodesModel>"
    )
    trees = "".join(f'<BehaviorTree ID="{name}"><AlwaysSuccess/></BehaviorTree>' for name in "mab")
    with pytest.raises(InputError, match="the tree 'a' already exists"):
        document_of(f'<root BTCPP_format="4" main_tree_to_execute="m">{trees}{model}</root>')


def test_the_names_of_all_registered_nodes_are_known():
    """Those whose children are known as well."""
    assert set(CHILDREN) == REGISTERED
