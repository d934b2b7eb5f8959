"""Groot 2 learns every leaf of ours, with its ports."""

import re

from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.palette import palette_xml
from bt_mission.commands.convert.table import leaf_kinds
from bt_mission.ros.interface_types import shapes


def test_the_palette_has_every_leaf_with_its_ports():
    """Fields of the goal, modifiers, and fields of the result as outputs, with their types."""
    xml = palette_xml(shapes)
    assert re.findall(r'<(?:Action|Condition) ID="(\w+)"/?>', xml) == list(leaf_kinds())
    (turn,) = re.findall(r'<Action ID="turn">\n(.*?)</Action>', xml, re.DOTALL)
    assert [line.strip() for line in turn.splitlines() if line.strip()] == [
        '<input_port name="angle" type="double"/>',
        '<input_port name="angular_velocity" type="double"/>',
        '<input_port name="timeout"/>',
        '<input_port name="cancel_when"/>',
        '<input_port name="on_cancel"/>',
        '<input_port name="server_timeout"/>',
        '<input_port name="acceptance_timeout"/>',
        '<input_port name="feedback_timeout"/>',
        '<input_port name="cancel_timeout"/>',
        '<input_port name="uses"/>',
        '<output_port name="out_angle_turned" type="double"/>',
        '<output_port name="out_error_code" type="int"/>',
        '<output_port name="out_error_msg" type="std::string"/>',
    ]


def ports_of(xml, kind):
    """Return the lines of the model of a leaf."""
    (model,) = re.findall(rf'<\w+ ID="{kind}">\n(.*?)</\w+>\n    <', xml, re.DOTALL)
    return [line.strip() for line in model.splitlines() if line.strip()]


def test_fields_within_fields_are_ports_as_well():
    """Of the goal and of the result, each by the attribute that a mission is written with."""
    xml = palette_xml(shapes)
    goal = ports_of(xml, "navigate_to_pose")
    assert '<input_port name="pose__header__frame_id" type="std::string"/>' in goal
    assert '<input_port name="pose__pose__position__x" type="double"/>' in goal
    result = ports_of(xml, "back_up")
    assert '<output_port name="out_total_elapsed_time"/>' in result
    assert '<output_port name="out_total_elapsed_time__sec" type="int"/>' in result


def test_services_and_topics_have_the_ports_of_common_types():
    """Those of std_srvs and std_msgs; a port for what is sent, and one for what comes back."""
    xml = palette_xml(shapes)
    assert ports_of(xml, "service") == [
        '<input_port name="service"/>',
        '<input_port name="type"/>',
        '<input_port name="request__data"/>',
        '<input_port name="timeout"/>',
        '<input_port name="server_timeout"/>',
        '<output_port name="out_success"/>',
        '<output_port name="out_message"/>',
    ]
    assert '<input_port name="message__data"/>' in ports_of(xml, "publish")
    assert '<output_port name="out_data"/>' in ports_of(xml, "wait_for")


def test_without_ros_the_ports_are_those_that_need_no_types():
    """The fields of goals are then left out, unless a mission uses them."""
    xml = palette_xml()
    assert '<input_port name="angle"' not in xml
    assert '<input_port name="cancel_when"/>' in xml


def test_a_file_with_a_palette_is_a_sound_mission():
    """Models of leaves say nothing that a mission does not know."""
    palette = palette_xml(shapes)
    tree = '<BehaviorTree ID="m"><AlwaysSuccess/></BehaviorTree>'
    document = document_of(palette.replace("</root>", f"{tree}</root>"))
    assert document.data == {"mission": "m", "tree": {"check": True}}
