"""Mission files become frozen steps."""

import dataclasses

import pytest

from bt_mission.core.diagnostics import MOST_DIAGNOSTICS, InputError
from bt_mission.core.yaml.document import read_text
from bt_mission.language.expressions.expression import Expression, Template, Text
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.composites import FallbackNode, ParallelNode, SequenceNode
from bt_mission.language.nodes.decorators import RepeatNode, RetryNode
from bt_mission.language.nodes.leaves import LogNode, WaitNode
from bt_mission.sessions.load import load

HEAD = "mission: test\ninputs: {speed: 0.2, legs: 3}\ntree:\n"


def tree(text):
    """Return the tree of a mission whose tree is this text, indented by two."""
    return load(HEAD + "".join(f"  {line}\n" for line in text.splitlines())).tree


def messages(text, **options):
    """Return (line, message) of every fault in a mission."""
    with pytest.raises(InputError) as caught:
        load(text, **options)
    return [(fault.line, fault.message) for fault in caught.value.diagnostics]


def test_the_head_of_a_mission():
    """All that stands beside the tree, with its defaults."""
    mission = load(
        read_text(
            "mission: m\ndescription: d\nworld: w\nrobot: burger\nseed: 7\ninputs: {a: [1, x]}\n"
            "tree: {wait: 1.0}",
            "m.yaml",
        )
    )
    assert (mission.name, mission.description, mission.world) == ("m", "d", "w")
    assert (mission.robot, mission.seed, mission.inputs) == ("burger", 7, {"a": [1, "x"]})
    assert mission.file == "m.yaml"
    plain = load("mission: m\ntree: {wait: 1.0}")
    assert (plain.world, plain.robot, plain.seed, plain.inputs) == (None, "waffle", 0, {})
    with pytest.raises(dataclasses.FrozenInstanceError):
        plain.seed = 1  # type: ignore[misc]


@pytest.mark.parametrize(("kind", "step"), [("sequence", SequenceNode), ("fallback", FallbackNode)])
def test_sequences_and_fallbacks(kind, step):
    """Children in order; memory unless said otherwise."""
    result = tree(f"{kind}:\n  - wait: 1\n  - wait: 2\nmemory: false\nname: both")
    assert isinstance(result, step)
    assert [child.seconds for child in result.children] == [1, 2]
    assert result.memory is False
    assert result.name == "both"
    assert tree(f"{kind}: [{{wait: 1}}]").memory is True


def test_parallel():
    """All must succeed, unless any will do."""
    result = tree("parallel: [{wait: 1}, {wait: 2}]\nsucceed_when: any")
    assert isinstance(result, ParallelNode)
    assert (len(result.children), result.succeed_when) == (2, "any")
    assert tree("parallel: [{wait: 1}]").succeed_when == "all"


def test_repeat_and_retry():
    """Numbers may be expressions; a retry pauses only when told to."""
    result = tree("repeat: {count: $legs}\ndo: {wait: 1}")
    assert isinstance(result, RepeatNode)
    assert result.settings.count == Expression("$legs")
    assert isinstance(result.child, WaitNode)
    again = tree("retry: {attempts: 3, pause: 2.0}\ndo: {wait: 1}")
    assert isinstance(again, RetryNode)
    assert (again.settings.attempts, again.settings.pause) == (3, 2.0)
    assert tree("retry: {attempts: 3}\ndo: {wait: 1}").settings.pause == 0.0


def test_wait_and_log():
    """Seconds, and a text with holes."""
    assert tree("wait: 0.5").seconds == 0.5
    assert tree("wait: 2 * speed").seconds == Expression("2 * speed")
    result = tree("log: at $speed m/s")
    assert isinstance(result, LogNode)
    assert result.message == Template("at $speed m/s")


def test_an_action_by_its_short_name():
    """Name and type follow from the kind; texts in the goal wait for their fields."""
    result = tree(
        "turn: {angle: $legs * 30}\nname: around\ntimeout: 30\ncancel_when: current_angle > 9\n"
        "on_cancel: success\noutputs: {angle_turned: turned}\nfeedback_timeout: 1"
    )
    assert isinstance(result, GoalNode)
    assert (result.kind, result.name, result.line, result.column) == ("action", "around", 4, 3)
    assert (result.ros_name, result.type) == ("turn", "bt_mission_interfaces/action/Turn")
    assert result.sent == {"angle": Text("$legs * 30")}
    assert (result.timeout, result.feedback_timeout) == (30, 1)
    assert (result.cancel_when, result.on_cancel) == (Expression("current_angle > 9"), "success")
    assert result.outputs == {"angle_turned": "turned"}
    assert (result.server_timeout, result.acceptance_timeout, result.cancel_timeout) == (
        5.0,
        2.0,
        3.0,
    )


def test_limits_of_an_action_have_defaults():
    """5 s for the server, 2 s for its answer, 3 s for a cancel; the rest is open."""
    result = tree("turn: {angle: 90}")
    assert (result.server_timeout, result.acceptance_timeout, result.cancel_timeout) == (
        5.0,
        2.0,
        3.0,
    )
    assert (result.timeout, result.feedback_timeout, result.cancel_when) == (None, None, None)
    assert (result.on_cancel, result.outputs) == ("failure", {})
    assert tree("turn: {angle: 90}\nserver_timeout: 60").server_timeout == 60.0


def test_an_action_by_name_and_type():
    """Any action of the graph; goals may nest."""
    result = tree(
        "action:\n  name: dock/run\n  type: my_robot/action/Dock\n"
        "  goal: {pose: {x: 1, tags: [a, $speed]}}"
    )
    assert (result.ros_name, result.type) == ("dock/run", "my_robot/action/Dock")
    assert result.sent == {"pose": {"x": 1, "tags": (Text("a"), Text("$speed"))}}
    assert tree("action: {name: /go, type: my_robot/action/Go}").sent == {}


def test_steps_know_where_they_stand():
    """Line and column of the node's first key; the walk follows the file."""
    result = tree("sequence:\n  - wait: 1\n  - sequence:\n      - name: x\n        wait: 2")
    assert [(step.kind, step.line, step.column) for step in result.walk()] == [
        ("sequence", 4, 3),
        ("wait", 5, 7),
        ("sequence", 6, 7),
        ("wait", 7, 11),
    ]


def test_aliases_are_a_way_to_say_the_same_twice():
    """Both uses become steps."""
    result = tree("sequence:\n  - &once {turn: {angle: 90}, timeout: 9}\n  - *once")
    first, second = result.children
    assert first.sent == second.sent == {"angle": 90}


def test_a_file_is_loaded_by_its_path(tmp_path):
    """The shipped missions are, and one that is not there is refused."""
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ntree: {wait: 1}\n", encoding="utf-8")
    assert load(path).name == "m"
    with pytest.raises(InputError, match="no such file"):
        load(tmp_path / "n.yaml")


def test_the_command_line_has_the_last_word():
    """Inputs, seed, world and robot of the file are replaced."""
    mission = load(
        HEAD + "  wait: $speed",
        set={"speed": "0.5"},
        seed=9,
        world="arena",
        robot="burger",
    )
    assert mission.inputs == {"speed": 0.5, "legs": 3}
    assert (mission.seed, mission.world, mission.robot) == (9, "arena", "burger")


def test_an_input_from_outside_is_checked_where_it_is_used():
    """The mission is checked as it will run."""
    text = HEAD + "  repeat: {count: $legs}\n  do: {wait: $speed}"
    message = "expected an integer of at least 1, got the number 0"
    assert messages(text, set={"legs": "0"}) == [(4, message)]


def test_faults_of_all_nodes_come_together():
    """A fault in one node hides none in another, above or below, before or behind it."""
    results = messages(
        "mission: m\nseed: x\ntree:\n  sequence:\n    - repeat: {count: 0}\n      do: {wat: 1}\n"
        "    - turn: {angle: $angl}\n      timeout: 0\n  memroy: true\n"
    )
    assert [line for line, _ in results] == [2, 5, 6, 7, 8, 9]


def test_outputs_of_a_node_with_a_fault_still_have_a_writer():
    """One fault is told, and nothing that follows from it."""
    results = messages(
        "mission: m\ntree:\n  sequence:\n"
        "    - trun: {}\n      outputs: {angle: a}\n"
        "    - turn: {}\n      timout: 1\n      outputs: {angle_turned: b}\n"
        "    - log: $a $b $c\n"
    )
    assert [line for line, _ in results] == [4, 7, 9]
    assert results[2][1].startswith("'$c' is an undefined variable (defined: a, b)")


def test_after_many_faults_no_more_are_looked_for():
    """A file of a thousand broken nodes is refused as quickly as one of two hundred."""
    text = "mission: m\ntree:\n  sequence:\n" + "    - wait: -1\n" * 1000
    assert len(messages(text)) == MOST_DIAGNOSTICS
    assert len(messages(text.replace("-1", "$x"))) == MOST_DIAGNOSTICS
