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


def test_each_use_begins_afresh(play: Any) -> None:
    """What one use has written, the next does not see; nor does the same one, when run again."""
    head = (
        "mission: t\ntrees:\n  count:\n    inputs: {n: 1}\n    outputs: {m: integer}\n"
        "    do:\n      sequence: [{set: {m: n + 1}}, {log: $m}]\n"
    )
    run = play(
        "  repeat: {count: 2}\n  do:\n    sequence:\n"
        "      - {tree: count, outputs: {m: a}}\n"
        "      - {tree: {name: count, inputs: {n: $a}}, outputs: {m: b}}\n",
        head,
    )
    run.tick(2)
    assert run.logged == ["2", "3", "2", "3"]
    assert run.status == "success"


def test_a_failed_tree_hands_out_what_it_wrote(play: Any) -> None:
    """As an action that was aborted does."""
    head = (
        "mission: t\ntrees:\n  half:\n    outputs: {m: integer, k: integer}\n"
        "    do:\n      sequence: [{set: {m: 1}}, {check: m > 1}, {set: {k: 2}}]\n"
    )
    run = play("  fallback:\n    - {tree: half, outputs: {m: a, k: b}}\n    - log: $a\n", head)
    run.tick()
    assert run.logged == ["1"]
    assert run.scope.values == {"a": 1}


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


def test_two_uses_draw_from_generators_of_their_own(play: Any) -> None:
    """What is random follows from the place of the node, in every use another one."""
    head = "mission: t\ntrees:\n  lot:\n    do: {log: '${uniform(0, 1)}'}\n"
    tree = "  sequence: [{tree: lot}, {tree: lot}]"
    runs = []
    for _ in range(2):
        run = play(tree, head)
        run.tick()
        runs.append(run.logged)
    assert runs[0] == runs[1]
    assert len(set(runs[0])) == 2


def test_trees_may_use_trees(play: Any) -> None:
    """Each with variables of its own."""
    head = (
        "mission: t\ntrees:\n"
        "  inner:\n    needs: {x: number}\n    outputs: {y: number}\n    do: {set: {y: x * 2}}\n"
        "  outer:\n    inputs: {x: 1}\n    outputs: {z: number}\n    do:\n      sequence:\n"
        "        - {tree: {name: inner, inputs: {x: x + 1}}, outputs: {y: z}}\n"
    )
    run = play("  sequence:\n    - {tree: outer, outputs: {z: w}}\n    - log: $w", head)
    assert run.tick() == "SSSSSS"
    assert run.logged == ["4"]
