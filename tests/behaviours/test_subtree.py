"""Named trees: variables of their own, and what goes in and out."""

from __future__ import annotations

from typing import Any

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
