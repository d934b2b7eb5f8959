"""Mission files become frozen steps."""

import pytest

from bt_mission.base.diagnostics import MOST_DIAGNOSTICS, InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.sessions.load import load

HEAD = "mission: test\ninputs: {speed: 0.2, legs: 3}\ntree:\n"


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


def test_nodes_know_where_they_stand():
    """Line and column of the node's first key; the walk follows the file, aliases too."""
    mission = load(
        HEAD + "  sequence:\n    - wait: 1\n    - repeat: {count: 2}\n"
        "      do: &once {fallback: [{name: x, wait: 2}]}\n    - *once\n"
    )
    assert [(node.kind, node.line, node.column) for node in mission.tree.walk()] == [
        ("sequence", 4, 3),
        ("wait", 5, 7),
        ("repeat", 6, 7),
        ("fallback", 7, 17),
        ("wait", 7, 29),
        ("fallback", 7, 17),
        ("wait", 7, 29),
    ]


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
        set={"speed": "0.5", "legs": 4},
        seed=9,
        world="arena",
        robot="burger",
    )
    assert mission.inputs == {"speed": 0.5, "legs": 4}
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
        "    - trun: {}\n      outputs: {angle: a, other: [x]}\n"
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
