"""Named trees: variables of their own, and what goes in and out."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.action import Turn

HEAD = """\
mission: t
seed: 3
inputs: {far: 5}
trees:
  visit:
    needs: {place: number}
    inputs: {speed: 0.5}
    outputs: {turned: number, note: text}
    do:
      sequence:
        - turn: {angle: $place}
          timeout: 9
          outputs: {angle_turned: turned}
        - log: at $place with $speed, turned $turned
        - set: {note: "'been there'"}
"""


def result(angle: float) -> Any:
    """What /turn gives back."""
    return Turn.Result(angle_turned=angle)


def test_inputs_go_in_and_outputs_come_out(play: Any) -> None:
    """The tree sees its own variables, the caller what it asked for."""
    run = play(
        "  sequence:\n"
        "    - tree: {name: visit, inputs: {place: far * 2}}\n"
        "      outputs: {turned: t, note: n}\n"
        "    - log: $t, $n",
        HEAD,
    )
    assert run.tick() == "RRRRII" + "I"
    (request,) = run.turn.requests
    assert request["angle"].as_value() == 10
    run.turn.accept()
    run.turn.succeed(result(9.5))
    assert run.tick() == "SSSSSSS"
    assert run.logged == ["at 10 with 0.5, turned 9.5", "9.5, been there"]
    assert run.scope.values == {"far": 5, "t": 9.5, "n": "been there"}


def test_a_tree_is_given_what_it_wants_or_the_mission_ends(play: Any) -> None:
    """What only the run can tell is compared with its type where it goes in."""
    head = HEAD.replace("{far: 5}", "{places: [1, true]}")
    run = play(
        "  for_each: {one: $places}\n  do: {tree: {name: visit, inputs: {place: $one}}}", head
    )
    run.tick()
    run.turn.accept()
    run.turn.succeed(result(1.0))
    run.tick(2)
    assert run.status == "failure"
    assert run.executive.reason == (
        "<text>:19:7: 'visit' cannot start: 'place': expected a number, got true [BT-913]"
    )


def test_a_halted_tree_hands_out_nothing_and_its_goals_are_cancelled(play: Any) -> None:
    """Halting goes through it as through any node."""
    run = play(
        "  parallel:\n"
        "    - {tree: {name: visit, inputs: {place: 1}}, outputs: {turned: t}}\n"
        "    - wait: 0.1\n"
        "  succeed_when: any",
        HEAD,
    )
    run.tick()
    run.turn.accept()
    assert run.tick(2)[0] == "S"
    assert run.turn.cancels == [run.turn.goal]
    assert "t" not in run.scope.values


LATER = "wait: 0.1, set: {alarm: true}, wait: 9"
ALARM = """\
mission: t
trees:
  watch:
    needs: {stop: bool}
    do:
      guard: not stop
      do: {wait: 9}
  twice:
    needs: {halt: bool}
    do: {tree: {name: watch, inputs: {stop: $halt}}}
  ring:
    outputs: {loud: bool}
    do:
      sequence: [wait: 0.1, set: {loud: true}, wait: 9]
"""


@pytest.mark.parametrize(
    "nodes",
    [
        "{tree: ring, outputs: {loud: alarm}}, {guard: not alarm, do: {wait: 9}}",
        f"sequence: [{LATER}], tree: {{name: watch, inputs: {{stop: $alarm}}}}",
        "{tree: ring, outputs: {loud: alarm}}, tree: {name: twice, inputs: {halt: $alarm}}",
    ],
    ids=["an output is seen", "an input changes", "through two trees"],
)
def test_variables_of_the_caller_are_live(play: Any, nodes: str) -> None:
    """In the very tick of the change, as the ports of BehaviorTree.CPP."""
    run = play(f"  sequence: [set: {{alarm: false}}, parallel: [{nodes}]]", ALARM)
    assert [run.tick()[0], run.tick()[0], run.tick()[0]] == ["R", "R", "F"]
    assert run.scope.values == {"alarm": True}


def test_a_live_input_has_the_type_of_its_tree_or_the_mission_ends(play: Any) -> None:
    """Also where it changes later."""
    run = play(
        "  sequence:\n    - set: {a: false}\n    - parallel:\n"
        "        - tree: {name: watch, inputs: {stop: $a}}\n"
        "        - for_each: {x: [false, 5]}\n          do: {set: {a: $x}}\n",
        ALARM,
    )
    run.tick(2)
    assert run.status == "running"
    run.tick()
    assert run.executive.reason == (
        "<text>:20:11: 'watch' cannot continue: 'stop': expected a boolean, got the number 5"
        " [BT-913]"
    )


def test_a_live_input_is_seen_in_a_pause(play: Any) -> None:
    """A topic that the mission follows changes it while no node is ticked."""
    head = (
        "mission: t\nfollow: {topic: /stop, type: std_msgs/msg/Bool, field: data, as: a, "
        "initial: false}\ntrees:\n  drive:\n    needs: {stop: bool}\n    do:\n"
        "      turn: {angle: 9}\n      timeout: 9\n      cancel_when: $stop\n"
    )
    run = play("  tree: {name: drive, inputs: {stop: $a}}\n", head)
    run.tick()
    run.turn.accept()
    run.executive.pause("looked at")
    run.topics["/stop"].publish(data=True)
    run.tick()
    assert run.turn.cancels == [run.turn.goal]


def test_an_input_that_the_tree_writes_itself_keeps_its_value(play: Any) -> None:
    """By an output to the same variable."""
    head = (
        "mission: t\ntrees:\n  next:\n    needs: {n: number}\n    outputs: {m: number}\n"
        "    do:\n      sequence: [set: {m: n + 1}, wait: 0.1, log: $n to $m]\n"
    )
    use = "{tree: {name: next, inputs: {n: $x}}, outputs: {m: x}}"
    run = play(f"  sequence: [set: {{x: 1}}, {use}, {use}]\n", head)
    run.tick(3)
    assert run.scope.values == {"x": 3}
    run.tick(2)
    assert run.logged == ["1 to 2", "2 to 3"]
