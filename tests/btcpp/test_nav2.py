"""Nodes of Nav2 are read where they mean something here."""

import json

import pytest

from bt_mission.btcpp.document import document_of
from bt_mission.core.diagnostics import InputError
from bt_mission.language.checks.mission import type_faults
from bt_mission.language.loader import draft
from bt_mission.ros.interface_types import shapes

ALL = {"time_allowance": 10.0}


def tree_of(node):
    """Return the tree of a file with one tree, which has no ID."""
    return document_of(f'<root BTCPP_format="4"><BehaviorTree>{node}</BehaviorTree></root>').data[
        "tree"
    ]


@pytest.mark.parametrize(
    ("xml", "node"),
    [
        ("<Spin/>", {"spin": {"target_yaw": 1.57, **ALL}}),
        (
            (
                '<Spin name="back" spin_dist="{yaw}" time_allowance="5" is_recovery="false" '
                'server_name="/r2/spin" server_timeout="500" error_code_id="{code}" '
                'error_msg="{why}"/>'
            ),
            {
                "action": {
                    "name": "/r2/spin",
                    "type": "nav2_msgs/action/Spin",
                    "goal": {"target_yaw": "$yaw", "time_allowance": 5},
                },
                "name": "back",
                "acceptance_timeout": 0.5,
                "outputs": {"error_code": "code", "error_msg": "why"},
            },
        ),
        (
            '<BackUp backup_dist="0.3" backup_speed="0.1" disable_collision_checks="false"/>',
            {"back_up": {"target": {"x": 0.3}, "speed": 0.1, **ALL}},
        ),
        ('<BackUp server_name="backup"/>', tree_of("<BackUp/>")),
        (
            '<DriveOnHeading dist_to_travel="2"/>',
            {"drive_on_heading": {"target": {"x": 2}, "speed": 0.025, **ALL}},
        ),
        (
            '<Wait wait_duration="-5.0"/>',
            {"action": {"name": "wait", "type": "nav2_msgs/action/Wait", "goal": {"time": 5.0}}},
        ),
        (
            '<NavigateToPose goal="{home}" behavior_tree="a.xml"/>',
            {"navigate_to_pose": {"pose": "$home", "behavior_tree": "a.xml"}},
        ),
        (
            '<ClearEntireCostmap service_name="local/clear" server_timeout="2000"/>',
            {
                "service": {"name": "local/clear", "type": "nav2_msgs/srv/ClearEntireCostmap"},
                "timeout": 2.0,
            },
        ),
        (
            "<AsyncSequence><AsyncFallback><AlwaysSuccess/></AsyncFallback></AsyncSequence>",
            {"sequence": [{"fallback": [{"check": True}]}]},
        ),
        (
            "<KeepRunningUntilFailure><AlwaysFailure/></KeepRunningUntilFailure>",
            {"repeat": {"while": True}, "do": {"check": False}},
        ),
        ('<SetBlackboard output_key="x" value="2.5"/>', {"set": {"x": 2.5}}),
        ('<SetBlackboard output_key="x" value="{y}"/>', {"set": {"x": "$y"}}),
        ('<SetBlackboard output_key="x" value="a b"/>', {"set": {"x": "'a b'"}}),
    ],
)
def test_a_node_becomes_the_node_that_says_the_same(xml, node):
    """With the defaults of Nav2, which differ from those of the type."""
    assert tree_of(xml) == node


def test_goals_of_nav2_fit_the_types():
    """Every field is one that the type has, of the type that it has."""
    xml = '<Spin/><BackUp/><DriveOnHeading/><Wait/><NavigateToPose goal="{home}"/>'
    data = {
        "mission": "m",
        "inputs": {"home": [1, 0.5, 90]},
        "tree": tree_of(f"<Sequence>{xml}</Sequence>"),
    }
    head = '<SubTree ID="m"><input_port name="home" type="list" default="[1, 0.5, 90]"/></SubTree>'
    file = (
        f'<root BTCPP_format="4"><BehaviorTree ID="m"><Sequence>{xml}</Sequence></BehaviorTree>'
        f"<TreeNodesModel>{head}</TreeNodesModel></root>"
    )
    document = document_of(file)
    assert document.data == data
    mission = draft(document).mission
    assert mission is not None
    assert list(type_faults(mission, shapes)) == []


@pytest.mark.parametrize(
    ("xml", "message"),
    [
        (
            '<Spin disable_collision_checks="true"/>',
            "expected false, got 'true': obstacles are always looked at",
        ),
        (
            '<NavigateToPose goal="0;map;1;2"/>',
            (
                "expected a variable such as '{goal}' with a list [x m, y m, yaw deg], "
                "got '0;map;1;2'"
            ),
        ),
        ("<NavigateToPose/>", "the attribute 'goal' is missing"),
        ('<Spin error_code_id="7"/>', "expected a variable such as '{name}', got '7'"),
        ("<RecoveryNode><AlwaysSuccess/></RecoveryNode>", "expected 2 nodes in <RecoveryNode>"),
        ('<SetBlackboard output_key="{x}" value="1"/>', "expected the name of a variable"),
        ("<RoundRobin><AlwaysSuccess/></RoundRobin>", "it goes on where it ended the last time"),
        ("<PipelineSequence><AlwaysSuccess/></PipelineSequence>", "it ticks children again"),
        ('<RateController hz="1"><AlwaysSuccess/></RateController>', "it starts a child that has"),
        ('<FollowPath path="{path}"/>', "variables hold no paths"),
    ],
)
def test_what_has_no_meaning_here_is_refused_with_the_reason(xml, message):
    """A node or a value of one."""
    with pytest.raises(InputError) as caught:
        tree_of(xml)
    assert message in str(caught.value)


LEAF = '<action action="/{0}" type="bt_mission_interfaces/action/Turn" timeout="99"/>'


@pytest.mark.parametrize(
    ("retries", "ends", "goals", "status"),
    [
        (1, "+", "a", "SUCCESS"),
        (1, "-++", "aba", "SUCCESS"),
        (1, "--", "ab", "FAILURE"),
        (1, "-+-", "aba", "FAILURE"),
        (2, "-+-+-", "ababa", "FAILURE"),
        (2, "-+-++", "ababa", "SUCCESS"),
        (2, "-+--", "abab", "FAILURE"),
        (0, "-", "a", "FAILURE"),
    ],
)
def test_a_recovery_node_sends_the_goals_that_nav2_sends(play, retries, ends, goals, status):
    """The second child after each failure of the first, and no more often than it says."""
    leaves = "".join(LEAF.format(name) for name in "ab")
    xml = f'<RecoveryNode number_of_retries="{retries}">{leaves}</RecoveryNode>'
    story = play(f"  {json.dumps(tree_of(xml))}")
    sent = ""
    for end in ends:
        story.tick(2)
        (name,) = (
            name for name, one in story.servers.items() if len(one.goals) > sent.count(name[1:])
        )
        sent += name[1:]
        story.servers[name].accept()
        story.servers[name].goal.on_result(4 if end == "+" else 6, None)
    story.tick(2)
    assert sent == goals
    assert sum(len(one.goals) for one in story.servers.values()) == len(goals)
    assert story.root.status.value == status


def test_recovery_nodes_within_each_other_count_for_themselves(play):
    """Each has variables of its own."""
    inner = f"<RecoveryNode>{''.join(LEAF.format(name) for name in 'ab')}</RecoveryNode>"
    story = play(f"  {json.dumps(tree_of(f'<RecoveryNode>{inner}{inner}</RecoveryNode>'))}")
    for name in ("a", "b", "a", "a"):
        story.tick(2)
        server = story.servers[f"/{name}"]
        server.accept()
        server.goal.on_result(4 if name == "b" or len(server.goals) == 3 else 6, None)
    story.tick(2)
    assert [len(story.servers[f"/{name}"].goals) for name in "ab"] == [4, 1]
