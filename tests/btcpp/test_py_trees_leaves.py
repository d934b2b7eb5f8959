"""py_trees' own XML loader makes our leaves, wires their ports, and they do what they always do."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import py_trees
import pytest
from bt_mission_interfaces.action import Turn
from py_trees.parsers.behaviour_tree_xml import parse_behaviour_tree_xml

from bt_mission import port_leaves
from bt_mission.btcpp.py_trees_leaves import leaf_classes
from bt_mission.core.diagnostics import InputError
from bt_mission.executive.executive import Executive
from bt_mission.ros.interface_types import shapes


@pytest.fixture(autouse=True)
def _blackboard() -> Iterator[None]:
    """py_trees keeps one for the whole process."""
    yield
    py_trees.blackboard.Blackboard.clear()


@pytest.fixture
def load(tmp_path: Path, play: Any) -> Any:
    """Load a tree of these elements: ``load(nodes)`` gives a story that has set it up."""

    def start(nodes: str, seed: int = 0) -> Any:
        path = tmp_path / "tree.xml"
        tree = f'<BehaviorTree ID="main">{nodes}</BehaviorTree>'
        path.write_text(f'<root main_tree_to_execute="main">{tree}</root>', encoding="utf-8")
        story = play("  check: true")
        story.root = parse_behaviour_tree_xml(str(path), node_registry=leaf_classes(shapes, seed))
        story.executive = Executive(story.root, story, story.trace)
        return story

    return start


def test_a_tree_is_loaded_wired_and_ticked(load: Any) -> None:
    """The result of one goal is the field of the next, by way of the blackboard."""
    story = load(
        """
        <Sequence name="root">
          <turn name="first" angle="30 * 3" timeout="9" out_angle_turned="{turned}"/>
          <turn name="second" angle="{turned}" timeout="9"/>
          <log name="say" message="{turned}"/>
        </Sequence>"""
    )
    assert story.tick() == "RRII"
    assert story.turn.requests[0]["angle"].as_value() == 90
    story.turn.accept()
    story.turn.succeed(Turn.Result(angle_turned=88.5))
    assert story.tick() == "RSRI"
    assert story.turn.requests[1]["angle"].as_value() == 88.5
    story.turn.accept()
    story.turn.succeed(Turn.Result())
    assert story.tick() == "SSSS"
    assert story.said == ["88.5"]
    assert story.status == "success"
    assert story.executive.goals_left_behind == ()


def test_conditions_and_limits_hold(load: Any) -> None:
    """``cancel_when`` cancels the goal, and ``on_cancel`` says how the leaf ends."""
    story = load(
        '<turn name="t" angle="90" timeout="9" cancel_when="current_angle &gt; 45" '
        'on_cancel="success"/>'
    )
    story.tick()
    story.turn.accept()
    story.turn.feed(Turn.Feedback(current_angle=50.0))
    assert story.tick() == "R"
    assert story.turn.cancels == [story.turn.goal]
    story.turn.cancel(Turn.Result())
    assert story.tick() == "S"


def test_a_halted_leaf_gives_its_goal_to_the_ledger(load: Any) -> None:
    """As in a mission: the goal is cancelled in the tick that halts the leaf."""
    story = load(
        '<Parallel name="p" policy="success_on_one"><turn name="t" angle="90" timeout="9"/>'
        '<wait name="w" seconds="0.1"/></Parallel>'
    )
    story.tick()
    story.turn.accept()
    assert story.tick(2) == "SIS"
    assert story.turn.cancels == [story.turn.goal]
    story.turn.cancel(Turn.Result())
    story.tick()
    assert (story.status, story.executive.goals_left_behind) == ("success", ())


def test_ports_of_a_subtree_reach_the_leaves(load: Any, tmp_path: Path) -> None:
    """py_trees maps them, constants as well as keys."""
    story = load(
        '<SubTree ID="twice" name="here" what="{word}" pause="0.05"/></BehaviorTree>'
        '<BehaviorTree ID="twice"><Sequence name="s"><wait name="w" seconds="{pause}"/>'
        '<log name="l" message="{what}"/></Sequence>'
    )
    py_trees.blackboard.Blackboard.set("/word", "hello")
    assert story.tick() == "RRI"
    assert story.tick() == "SSS"
    assert story.said == ["hello"]


def test_every_goal_draws_its_own_numbers_from_the_seed(load: Any) -> None:
    """Two leaves differ, two runs do not."""

    def drawn(seed: int) -> list[float]:
        leaf = '<log name="{}" message="${{uniform(0, 1)}}"/>'
        with pytest.raises(ValueError, match="Malformed key reference"):
            load(leaf.format("braces"), seed)  # py_trees takes every brace for a key
        turn = '<turn name="{}" angle="uniform(0, 90)" timeout="9"/>'
        nodes = "".join(turn.format(name) for name in "ab")
        story = load(f'<Parallel name="p" policy="success_on_all">{nodes}</Parallel>', seed)
        story.tick()
        return [request["angle"].as_value() for request in story.turn.requests]

    first, second = drawn(3)
    assert first != second
    assert drawn(3) == [first, second]
    assert drawn(4) != [first, second]


@pytest.mark.parametrize(
    ("leaf", "words"),
    [
        ('<turn name="t" angle="90 +"/>', "expected a number, a name or a '(', got the end"),
        ('<turn name="t" timeout="0"/>', "expected seconds above 0, got the number 0"),
        ('<log name="l"/>', "the attribute 'message' is missing"),
        ('<log name="l" message="x" mesage="y"/>', "no attribute 'mesage' for log"),
        ('<wait name="w" seconds="$x"/>', "'$x' is an undefined variable"),
    ],
)
def test_what_is_wrong_with_a_constant_is_told_before_the_first_tick(
    load: Any, leaf: str, words: str
) -> None:
    """In the words of missions, with the name of the leaf."""
    with pytest.raises(InputError) as caught:
        load(leaf)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"{leaf[leaf.index('name=') + 6]}: error: ")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "has no data available"),
        (-1.0, "expected seconds, 0 or more, got the number -1.0"),
        ({}, "is not of type"),
    ],
)
def test_what_is_wrong_on_the_blackboard_ends_the_mission(
    load: Any, value: Any, words: str
) -> None:
    """Only the run can tell."""
    story = load('<wait name="w" seconds="{pause}"/>')
    if value is not None:
        py_trees.blackboard.Blackboard.set("/pause", value)
    story.tick(2)
    assert story.status == "failure"
    assert story.executive.reason.startswith("'w' cannot start: ")
    assert words in story.executive.reason


def test_services_topics_and_other_actions_take_constants(load: Any) -> None:
    """Their fields are not known beforehand, so they have no ports."""
    story = load(
        """
        <Sequence name="root">
          <service name="s" service="stop" type="std_srvs/srv/SetBool" request__data="true"/>
          <publish name="p" topic="lamp" type="std_msgs/msg/Bool" message__data="false"/>
          <wait_for name="f" topic="go" type="std_msgs/msg/Bool" until="data" timeout="5"/>
          <action name="a" action="/turn" type="bt_mission_interfaces/action/Turn"
                  goal__angle="45" timeout="9"/>
        </Sequence>"""
    )
    story.tick()
    assert story.services["stop"].requests == [{"data": True}]
    story.services["stop"].answer(success=True)
    story.tick()
    assert story.speeches["lamp"].published == [{"data": False}]
    story.topics["go"].publish(data=True)
    assert story.tick() == "RSSSR"
    assert story.turn.requests == [{"angle": 45}]


def test_an_attribute_of_another_action_cannot_be_wired(load: Any) -> None:
    """py_trees itself says so."""
    with pytest.raises(ValueError, match="not supported for non-port attributes"):
        load('<action name="a" action="/turn" type="p/action/T" goal__angle="{x}" timeout="9"/>')


def test_an_output_is_written_only_where_there_was_a_result(load: Any) -> None:
    """A goal that is rejected at its second try leaves the key as it was."""
    story = load(
        '<Repeat name="r" num_success="2"><turn name="t" angle="9" timeout="9" '
        'out_angle_turned="{turned}"/></Repeat>'
    )
    story.tick()
    story.turn.accept()
    story.turn.succeed(Turn.Result(angle_turned=8.5))
    story.tick()
    assert py_trees.blackboard.Blackboard.get("/turned") == 8.5
    py_trees.blackboard.Blackboard.set("/turned", 1.0)
    story.tick()
    story.turn.reject()
    assert story.tick() == "FF"
    assert py_trees.blackboard.Blackboard.get("/turned") == 1.0


def test_the_public_leaves_have_the_ports_of_the_installed_types() -> None:
    """Nothing has to be handed over, which only our own packages could name."""
    assert {"angle", "timeout"} <= set(port_leaves()["turn"].INPUT_PORTS)
    assert "out_angle_turned" in port_leaves()["turn"].OUTPUT_PORTS
