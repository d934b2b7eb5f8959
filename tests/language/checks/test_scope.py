"""Variables that follow topics, and what is read; other names are in transcripts/scopes.txt."""

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

FOLLOW = "mission: m\nfollow: {topic: b, type: std_msgs/msg/Float64, field: data, as: b}\n"


@pytest.mark.parametrize(
    ("tree", "expected"),
    [
        ("repeat: {while: b > 2, count: 9}\n  do: {wait: 1}", []),
        ("turn: {angle: 90}\n  timeout: 9\n  cancel_when: b > 2", []),
        ("check: b", [(4, "expected a boolean, got a number")]),
        ("repeat: {count: b}\n  do: {log: '${b + 1}'}", [(4, "expected an integer, got a number")]),
    ],
    ids=[
        "a loop may wait for it",
        "so may a goal",
        "its type in a condition",
        "its type in a count",
    ],
)
def test_a_variable_that_follows_a_topic(tree, expected):
    """It changes without any node; its type is known from the interface."""
    _, diagnostics = examine(f"{FOLLOW}tree:\n  {tree}\n")
    assert [(each.line, each.message) for each in diagnostics] == expected


def test_a_named_tree_does_not_see_what_its_mission_follows():
    """It takes the value of the moment as an input, or follows the topic itself."""
    tree = "trees: {t: {do: {check: b > 1}}}\ntree: {sequence: [{tree: t}, {log: $b}]}\n"
    with pytest.raises(InputError, match="'b' is an undefined variable"):
        load(FOLLOW + tree)
    follow = FOLLOW.partition("follow: ")[2].strip()
    assert load(FOLLOW + tree.replace("{do:", f"{{follow: {follow}, do:")).warnings == ()


def test_an_included_tree_follows_topics(tmp_path):
    """Its file says so, and is named where that is wrong."""
    library = tmp_path / "lib.yaml"
    entry = "{topic: b, type: std_msgs/msg/Bool, field: data, as: b}"
    library.write_text(f"trees:\n  t:\n    follow: {entry}\n    do: {{check: b}}\n")
    mission = tmp_path / "m.yaml"
    mission.write_text("mission: m\ninclude: [lib.yaml]\ntree: {tree: t}\n")
    assert examine(str(mission))[1] == ()
    library.write_text(library.read_text().replace("data", "date"))
    (fault,) = examine(str(mission))[1]
    assert (fault.file, fault.line, fault.column) == (str(library), 3, 56)


def test_an_input_is_read_in_any_part_of_a_node():
    """Goal, request, limits, condition, counts; one that is read nowhere is warned of."""
    mission = load(
        "mission: m\ninputs: {a: 1, b: 2, c: 3, d: 4, e: 5, f: 6, g: 7, h: 8, i: 9, idle: 10}\n"
        "tree:\n  sequence:\n"
        "    - retry: {attempts: $e, pause: 0.0}\n      do:\n        turn: {angle: $a}\n"
        "        timeout: $b\n        feedback_timeout: $c\n        cancel_when: x > $d\n"
        "    - {service: {name: s, type: a/srv/B, request: {x: $f}}, timeout: $g}\n"
        "    - {wait_for: {topic: t, type: a/msg/B, until: y > $h}, timeout: 1}\n"
        "    - turn: {angle: a word $i}\n      timeout: 9\n"
    )
    assert [(each.line, each.column, each.message) for each in mission.warnings] == [
        (2, 64, "the input 'idle' is never read")
    ]
