"""Names: who knows what where, and of what type."""

from typing import Any

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.language.checks.scope import names_read, walk
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

EXPLORE = "explore_forward: {}\n      outputs: {closest_obstacle_angle: obstacle}"


def faults(*nodes, inputs="{n: 2, word: hello}"):
    """Return (line, column, message) of the faults in a sequence of nodes."""
    text = f"mission: m\ninputs: {inputs}\ntree:\n  sequence:\n"
    text += "".join(f"    - {node}\n" for node in nodes)
    try:
        load(text)
    except InputError as error:
        return [(fault.line, fault.column, fault.message) for fault in error.diagnostics]
    return []


def test_an_output_is_known_after_its_node():
    """In the order of the file."""
    assert faults(EXPLORE, "log: $obstacle") == []
    ((line, column, message),) = faults("log: to $obstacle", EXPLORE)
    assert (line, column) == (5, 15)
    assert message == "'$obstacle' is used before assignment, in line 6"


def test_an_output_is_not_known_in_its_own_node():
    """The result comes after the goal."""
    ((_, _, message),) = faults("turn: {angle: $turned}\n      outputs: {angle_turned: turned}")
    assert message == "'$turned' is used before assignment, in line 5"


def test_a_loop_in_a_loop_of_the_same_name_is_refused():
    """And the outer one keeps its variable behind the inner one."""
    loop = (
        "for_each: {p: [1]}\n      do: {sequence: [{for_each: {p: [2]}, do: {wait: 1}}, {log: $p}]}"
    )
    assert faults(loop) == [(6, 35, "'p' is already a variable; choose another name")]


def test_a_body_that_repeats_reads_what_stands_before():
    """Not what only the next round would know."""
    before = (
        "repeat: {count: 2}\n      do:\n        sequence:\n          - explore_forward: {}\n"
        "            outputs: {closest_obstacle: gap}\n          - log: $gap"
    )
    assert faults(before) == []
    after = (
        "repeat: {count: 2}\n      do:\n        sequence:\n          - log: $gap\n"
        "          - explore_forward: {}\n            outputs: {closest_obstacle: gap}"
    )
    assert faults(after) == [(8, 18, "'$gap' is used before assignment, in line 9")]


LOOP = "repeat: {{{0}}}\n      do: {{set: {{sum: n + 1}}}}"


def test_until_reads_what_its_rounds_write():
    """It is asked behind them; `while` is asked before the first."""
    assert faults(LOOP.format("until: sum > 3")) == []
    assert faults(LOOP.format("while: sum < 3")) == [
        (5, 23, "'sum' is used before assignment, in line 6")
    ]
    assert faults(LOOP.format("until: sam > 3")) == [
        (5, 23, "'sam' is an undefined variable (defined: n, word, sum)")
    ]
    assert faults(LOOP.format("until: sum + 3")) == [(5, 27, "expected a boolean, got an integer")]
    assert faults(LOOP.format("count: 3, while: word > 3")) == [
        (5, 38, "cannot compare a string with an integer")
    ]


@pytest.mark.parametrize(
    ("loop", "key"),
    [("until: n > 5", "until"), ("while: n < 5, count: 9", "while"), ("until: sum > 5", "")],
)
def test_a_loop_that_no_round_ends_is_suspicious(loop, key):
    """Nothing below it assigns what its condition reads."""
    head = "mission: m\ninputs: {n: 2}\ntree:\n  sequence:\n    - log: $n\n    - "
    warnings = [
        warning for warning in load(head + LOOP.format(loop)).warnings if "round" in warning.message
    ]
    assert [(warning.line, warning.message) for warning in warnings] == [
        (6, "no round changes this condition: nothing below 'do' assigns 'n'") for _ in [key] if key
    ]


FOLLOW = "mission: m\nfollow: {topic: b, type: std_msgs/msg/Float64, field: data, as: b}\n"


def test_a_loop_may_wait_for_a_topic():
    """A variable that follows one changes without the loop."""
    text = f"{FOLLOW}tree:\n  repeat: {{while: b > 2, count: 9}}\n  do: {{wait: 1}}\n"
    assert load(text).warnings == ()


def test_a_condition_on_a_goal_may_read_nothing_but_a_topic():
    """Where inputs alone would be refused: they never change."""
    _, faults = examine(
        f"{FOLLOW}tree:\n  turn: {{angle: 90}}\n  timeout: 9\n  cancel_when: b > 2\n"
    )
    assert faults == ()


def test_the_field_gives_the_type_of_what_follows_it():
    """It is known from the interface."""
    _, diagnostics = examine(
        f"{FOLLOW}tree:\n  sequence:\n    - check: b\n    - repeat: {{count: b}}\n"
        "      do: {log: '${b + 1}'}\n"
    )
    assert [(diagnostic.line, diagnostic.message) for diagnostic in diagnostics] == [
        (5, "expected a boolean, got a number"),
        (6, "expected an integer, got a number"),
    ]


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


def test_a_loop_may_wait_for_a_branch_beside_it():
    """A `parallel` around it has other nodes that write."""
    text = (
        "mission: m\ntree:\n  sequence:\n    - set: {n: 0}\n    - parallel:\n"
        "        - {set: {n: 3}}\n        - {repeat: {until: n > 2}, do: {wait: 1}}\n"
    )
    assert load(text).warnings == ()


@pytest.mark.parametrize(
    ("loop", "rest"),
    [
        ("{repeat: {while: true}, do: {wait: 1}}", "succeeds"),
        ("{repeat: {until: false}, do: {wait: 1}}", "succeeds"),
        ("{repeat: {until: sum > 3}, do: {set: {sum: 4}}}", ""),
        ("{invert: {repeat: {while: n < 3}, do: {wait: 1}}}", "succeeds"),
        ("{repeat: {until: sum > 3, count: 2}, do: {set: {sum: 4}}}", ""),
    ],
)
def test_behind_a_loop_that_never_ends_nothing_is_reached(loop, rest):
    """Or one that can only end the other way."""
    text = f"mission: m\ninputs: {{n: 2}}\ntree:\n  sequence:\n    - {loop}\n    - log: $n\n"
    warnings = [warning for warning in load(text).warnings if "never reached" in warning.message]
    assert [warning.message for warning in warnings] == [
        f"never reached: the node before it, in line 5, never {rest}" for _ in [rest] if rest
    ]


@pytest.mark.parametrize(
    ("before", "warned"),
    [
        ("log: $n", ["'gap' has no value if 'do' is halted before it is written"]),
        ("set: {gap: n}", []),
    ],
)
def test_a_clean_up_reads_what_is_sure_to_be_there(before, warned):
    """Its node may be halted at any time."""
    text = (
        f"mission: m\ninputs: {{n: 2}}\ntree:\n  sequence:\n    - {before}\n"
        "    - finally: {timeout: 5}\n      do: {sequence: [{wait: 1}, {set: {gap: n}}]}\n"
        "      then: {log: $gap}\n"
    )
    warnings = [warning for warning in load(text).warnings if "halted" in warning.message]
    assert [warning.message for warning in warnings] == warned


@pytest.mark.parametrize(
    ("node", "is_reached"),
    [
        ("{wait: 1}, then: {log: $n}", True),
        ("{check: false}, then: {log: $n}", False),
        ("{wait: 1}, then: {check: false}", False),
    ],
)
def test_a_finally_ends_as_its_node_and_its_clean_up_can(node, is_reached):
    """Behind one that never succeeds nothing is reached."""
    text = "mission: m\ninputs: {n: 2}\ntree:\n  sequence:\n"
    text += f"    - {{finally: {{timeout: 5}}, do: {node}}}\n    - log: $n\n"
    warned = [warning for warning in load(text).warnings if "never reached" in warning.message]
    assert bool(warned) is not is_reached


def test_a_finally_needs_its_parts():
    """The time of its clean-up, too: without it an end could take for ever."""
    assert faults("{finally: {}, do: {wait: 1}, then: {wait: 1}}") == [
        (5, 17, "'timeout' is missing")
    ]
    assert faults("{finally: {timeout: 5}, do: {wait: 1}}") == [(5, 7, "'then' is missing")]
    assert faults("{finally: {timeout: 0}, do: {wait: 1}, then: {wait: 1}}") == [
        (5, 27, "expected seconds above 0, got the number 0")
    ]


def test_a_loose_word_is_measured_by_what_stands_there():
    """It is more likely a mistake than a variable."""
    ((line, column, message),) = faults("wait: long")
    assert (line, column) == (5, 13)
    assert message.startswith("expected seconds, 0 or more, got 'long', which is an undefined ")


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ("wait: n - 3", "expected seconds, 0 or more, got the number -1"),
        ("wait: word", "expected seconds, 0 or more, got string 'hello'"),
        ("wait: n > 1", "expected seconds, 0 or more, got true"),
        ("wait: 1 / (n - 2)", "division by zero"),
        ("wait: uniform(0, word)", "expected a number, got a string"),
        ("wait: uniform(0, 1) > 2", "expected a number, got a boolean"),
        ("log: ${word + 1}", "expected a number, got a string"),
    ],
)
def test_what_inputs_decide_is_decided_at_once(node, message):
    """Inputs never change, so their expressions are computed when the mission is loaded."""
    assert [fault for _, _, fault in faults(node)] == [message]


def test_bare_names_of_conditions_and_goals_wait_for_the_types():
    """They may be feedback fields, or words of a text field."""
    assert faults("turn: {angle: what}\n      cancel_when: what > 3") == []
    results = faults("turn: {angle: $what}\n      cancel_when: x > $what")
    assert [(line, column) for line, column, _ in results] == [(5, 21), (6, 24)]


def test_types_of_outputs_come_from_the_one_who_knows_them():
    """A variable that two nodes write differently has no type."""
    mission = load(
        "mission: m\ninputs: {n: 2}\ntree:\n  sequence:\n"
        "    - turn: {}\n      outputs: {a: x, b: y}\n"
        "    - turn: {}\n      outputs: {b: x, a: z}\n"
        "    - log: end\n"
    )
    kinds: dict[str, Any] = {"a": "number", "b": "text"}
    *_, (_, variables, _) = walk(mission.main, lambda _, field: kinds[field])
    assert variables.types == {"n": "integer", "x": None, "y": "text", "z": "number"}


def test_names_read_are_those_of_every_part():
    """Goal, limits, condition, message, counts."""
    mission = load(
        "mission: m\ninputs: {a: 1, b: 2, c: 3, d: 4, e: 5}\ntree:\n"
        "  retry: {attempts: $e, pause: 0.0}\n  do:\n    turn: {angle: $a}\n    timeout: $b\n"
        "    feedback_timeout: $c\n    cancel_when: x > $d"
    )
    read = frozenset().union(*(names_read(step) for step in mission.tree.walk()))
    assert read == {"a", "b", "c", "d", "e", "x"}


def test_services_and_topics_read_and_write_too():
    """Requests, conditions and limits; fields of the response and of the message."""
    ask = "service: {name: a, type: a/srv/B, request: {b: $%s}}\n      outputs: {c: said}"
    wait = (
        "wait_for: {topic: a, type: a/msg/B, until: x > $%s}\n"
        "      timeout: n\n      outputs: {y: seen}"
    )
    assert faults(ask % "n", wait % "said", "log: $seen $said") == []
    results = faults(ask % "seen", wait % "what", "log: $seen", inputs="{n: 2, said: 1}")
    assert [(line, message.partition(" (")[0]) for line, _, message in results] == [
        (5, "'$seen' is used before assignment, in line 7"),
        (6, "'said' is an input, and inputs never change; choose another name"),
        (7, "'$what' is an undefined variable"),
    ]
    mission = load(
        "mission: m\ninputs: {a: 1, b: 2, c: 3}\ntree:\n  sequence:\n"
        "    - {service: {name: s, type: a/srv/B, request: {x: $a}}, timeout: $b}\n"
        "    - {wait_for: {topic: t, type: a/msg/B, until: y > $c}, timeout: 1}\n"
    )
    read = frozenset().union(*(names_read(step) for step in mission.tree.walk()))
    assert read == {"a", "b", "c", "y"}
