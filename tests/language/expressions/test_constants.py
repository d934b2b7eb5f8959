"""What is the same in every run is computed before the first one."""

import pytest

from bt_mission.base.yaml.document import read_text
from bt_mission.sessions.check import examine

HEAD = """\
mission: m
inputs: {zero: 0, one: 1, items: [1, 2]}
tree:
  sequence:
    - turn: {angle: 1}
      timeout: 9
      outputs: {angle_turned: turned}
"""


def messages(node):
    """Return what is said of a node that stands behind one with an output, `turned`."""
    _, diagnostics = examine(read_text(f"{HEAD}    - {node}\n", "m.yaml"))
    faults = [fault for fault in diagnostics if "never read" not in fault.message]
    return [f"{fault.column}: {fault.message}" for fault in faults]


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ("check: 1 / zero > 2", "16: division by zero"),
        ("check: turned > 1 // 0", "25: division by zero"),
        ("check: turned / zero > 2", "21: division by zero"),
        ("check: turned % 0 == 1", "21: division by zero"),
        ("log: at ${sqrt(-one)} m", "17: sqrt: the result is not a number"),
        ("set: {x: 2 ** 63 * 4}", "24: the result is too large"),
        ("when: turned > 0 and len(items) / zero > 1\n      do: {wait: 1}", "39: division by zero"),
        ("guard: 1 / zero > turned\n      do: {wait: 1}", "16: division by zero"),
        ("wait: uniform(0, 1) + 1 / zero", "31: division by zero"),
        ("wait: max(turned, 1 / zero)", "27: division by zero"),
        ("log: $turned ${turned + 1 / zero}", "33: division by zero"),
        ("for_each: {x: 2 ** one}\n      do: {log: $x}", "23: expected a list, got 2"),
    ],
)
def test_what_must_fail_is_refused(node, message):
    """Wherever it stands in an expression; the rest of it may be unknown."""
    assert messages(node) == [message]


@pytest.mark.parametrize(
    "node",
    [
        "check: zero != 0 and 1 / zero > 2",
        "check: zero == 0 or turned / zero > 2",
        "check: turned > zero / one",
        "check: one / turned > 2",
        "wait: one / uniform(1, 2)",
        "turn: {angle: 2}\n      timeout: 9\n      cancel_when: current_angle > zero / one",
    ],
)
def test_what_may_succeed_is_not(node):
    """Neither what `and` and `or` do not look at, nor what depends on the run."""
    assert messages(node) == []


def test_a_field_is_no_input_of_the_same_name():
    """A bare name in a condition on messages is the field."""
    text = (
        "mission: m\ninputs: {data: 0}\ntree:\n"
        "  wait_for: {topic: t, type: std_msgs/msg/Int32, until: data > 1 / %s}\n  timeout: 9\n"
    )
    assert examine(text % "data")[1] == ()
    (fault,) = examine(text % "$data")[1]
    assert fault.message == "division by zero"
