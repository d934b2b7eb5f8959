"""Another version of a recorded mission: what of it cannot change while its tree runs."""

from __future__ import annotations

import pytest

from bt_mission.commands.fork.edit import frame_change
from bt_mission.sessions.load import load

MISSION = """\
mission: m
inputs: {a: 1}
follow: {topic: /battery_state, type: sensor_msgs/msg/BatteryState, \
field: percentage, initial: 1.0, as: charge}
trees:
  t:
    inputs: {x: 1}
    outputs: {y: number}
    do: {set: {y: x}}
tree:
  sequence:
    - turn: {angle: 90}
      timeout: 5
      outputs: {angle_rotated: done}
    - {service: {name: /reset, type: std_srvs/srv/Trigger}, timeout: 1}
    - {publish: {topic: /said, type: std_msgs/msg/String, message: {data: a}}, readers: 0}
    - {wait_for: {topic: /heard, type: std_msgs/msg/Int32, until: data > 0}, timeout: 1}
    - {repeat: {count: 2}, do: {wait: 0.1}}
    - {retry: {attempts: 2}, do: {check: $a > 0}}
    - {timeout: 1, do: {guard: $a > 0, do: {log: hello}}}
    - {for_each: {one: [1, 2]}, do: {invert: {force: failure, do: {wait: 0.1}}}}
    - {finally: {timeout: 1}, do: {wait: 0.1}, then: {wait: 0.1}}
    - {choose: [{wait: 0.1}, {wait: 0.2}], weights: [1, 2]}
    - {when: $a > 0, do: {wait: 0.1}, else: {wait: 0.2}}
    - {parallel: [{wait: 0.1}, {wait: 0.2}], succeed_when: any}
    - {tree: {name: t, inputs: {x: 2}}, outputs: {y: z}}
"""

MAY_CHANGE = [
    ("angle: 90", "angle: 45"),
    ("timeout: 5", "timeout: 6"),
    ("{angle_rotated: done}", "{angle_rotated: other}"),
    ("message: {data: a}", "message: {data: b}"),
    ("readers: 0", "readers: 1"),
    ("data > 0", "data > 1"),
    ("count: 2", "count: 3"),
    ("attempts: 2", "attempts: 3"),
    ("check: $a > 0", "check: $a > 1"),
    ("{timeout: 1, do: {guard", "{timeout: 2, do: {guard"),
    ("guard: $a > 0", "guard: $a > -1"),
    ("log: hello", "log: bye"),
    ("one: [1, 2]", "one: [1]"),
    ("finally: {timeout: 1}", "finally: {timeout: 2}"),
    ("weights: [1, 2]", "weights: [2, 1]"),
    ("when: $a > 0", "when: $a > 1"),
    ("inputs: {x: 2}", "inputs: {x: 3}"),
    ("set: {y: x}", "set: {y: x + 1}"),
    ("{a: 1}", "{a: 2}"),
]
MAY_NOT = [
    ("turn: {angle: 90}", "spin: {angle: 90}"),
    ("name: /reset", "name: /other"),
    ("topic: /said", "topic: /other"),
    ("std_msgs/msg/Int32", "std_msgs/msg/Int64"),
    ("repeat: {count: 2}", "repeat: {count: 2, while: $a > 0}"),
    ("{wait: 0.1}, else: {wait: 0.2}", "{wait: 0.1}"),
    ("succeed_when: any", "succeed_when: all"),
    ("{one: [1, 2]}", "{other: [1, 2]}"),
    ("force: failure", "force: success"),
    ("  sequence:", "  fallback:"),
    ("  sequence:", "  memory: false\n  sequence:"),
    ("inputs: {x: 1}", "inputs: {x: 2}"),
    ("outputs: {y: z}", "outputs: {y: w}"),
    ("initial: 1.0", "initial: 2.0"),
    ("log: hello}", "log: hello, name: greeting}"),
    ("- turn:", "- wait: 1\n    - turn:"),
]


@pytest.mark.parametrize(("old", "new"), MAY_CHANGE)
def test_what_is_read_when_a_node_begins_may_change(old: str, new: str) -> None:
    """The tree is the same one."""
    assert MISSION.count(old) == 1
    before, after = load(MISSION), load(MISSION.replace(old, new))
    assert before.tree != after.tree or before.trees != after.trees or before.inputs != after.inputs
    assert frame_change(before, after) is None


@pytest.mark.parametrize(("old", "new"), MAY_NOT)
def test_what_a_tree_is_built_of_is_fixed(old: str, new: str) -> None:
    """The first place at which it is another one is told."""
    assert MISSION.count(old) == 1
    change = frame_change(load(MISSION), load(MISSION.replace(old, new)))
    assert change is not None
    assert change.line > 0


TWO = "mission: m\ntree:\n  sequence:\n    - wait: 1\n    - log: a\n"
NAMED = "mission: m\ntrees: {t: {do: {wait: 1}}}\ntree: {tree: t}\n"


@pytest.mark.parametrize(
    ("before", "after", "line", "words"),
    [
        (TWO, f"{TWO}    - wait: 2\n", 6, "an additional node"),
        (TWO, TWO.replace("    - log: a\n", ""), 3, "the node 'log' is missing"),
        (TWO, TWO.replace("- wait: 1", "- check: true"), 4, "a node other than 'wait'"),
        (NAMED, "mission: m\ntree: {wait: 1}\n", 2, "a node other than 't'"),
    ],
)
def test_the_first_place_is_told(before: str, after: str, line: int, words: str) -> None:
    """Of a node more, one less, another one, and a tree that is gone."""
    change = frame_change(load(before), load(after))
    assert change is not None
    assert (change.line, words in change.message) == (line, True)
