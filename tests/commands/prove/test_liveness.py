"""A variable that may still be read is a part of the state; one that nothing reads is not."""

from __future__ import annotations

import textwrap

import pytest

from bt_mission.commands.prove.answers import parse_answers
from bt_mission.commands.prove.proof import ProofOptions, prove
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load

BAD = "{when: x > 1, do: {log: high, name: high}, else: {log: low, name: low}}"
EACH = "{when: x == 2, do: {log: high, name: high}}, {when: x == 1, do: {log: low, name: low}}"
"""Where `x` has another value before."""
DRAW = "{set: {x: 'choice(1, 2)'}}"
PART = """\
trees:
  part:
    inputs: {given: 0}
    outputs: {made: integer}
    do:
      sequence:
        - {wait: 0.2}
        - {when: given > 1, do: {log: high, name: high}, else: {log: low, name: low}}
        - {set: {made: given}}
        - {wait: 0.2}
"""
READ = {
    "later": f"sequence: [{DRAW}, {{wait: 0.2}}, {BAD}]",
    "behind a failure": f"""
        sequence:
          - {DRAW}
          - fallback: [{{sequence: [{{wait: 0.2}}, {{check: false}}]}}, {BAD}]
        """,
    "behind a forced end": f"""
        sequence:
          - {DRAW}
          - {{force: success, do: {{sequence: [{{wait: 0.2}}, {{check: false}}]}}}}
          - {BAD}
        """,
    "behind an inverted end": f"""
        sequence:
          - {DRAW}
          - fallback: [{{invert: {{wait: 0.2}}}}, {BAD}]
        """,
    "behind a timeout": f"""
        sequence:
          - {DRAW}
          - fallback: [{{timeout: 0.2, do: {{wait: 1}}}}, {BAD}]
        """,
    "behind a timeout of what succeeds": f"""
        sequence:
          - {DRAW}
          - fallback: [{{timeout: 0.2, do: {{force: success, do: {{wait: 1}}}}}}, {BAD}]
        """,
    "in a guard": """
        fallback:
          - guard: x < 2
            do: {sequence: [{set: {x: 'choice(1, 2)'}}, {wait: 0.2}, {log: low, name: low}]}
          - {log: high, name: high}
        """,
    "in a clean-up": f"""
        finally: {{timeout: 1}}
        do: {{sequence: [{DRAW}, {{wait: 0.2}}]}}
        then: {BAD}
        """,
    "in a clean-up behind a halt": f"""
        parallel:
          - finally: {{timeout: 1}}
            do: {{sequence: [{DRAW}, {{wait: 1}}]}}
            then: {{sequence: [{{wait: 0.2}}, {BAD}]}}
          - {{wait: 0.2}}
        succeed_when: any
        """,
    "in the next round": f"""
        repeat: {{count: 2}}
        do: {{sequence: [{EACH}, {DRAW}, {{wait: 0.2}}]}}
        """,
    "by the end of a loop": """
        sequence:
          - repeat: {until: x > 1, count: 1}
            do: {sequence: [{set: {x: 'choice(1, 2)'}}, {wait: 0.2}]}
          - {log: high, name: high}
        """,
    "in the next attempt": f"""
        retry: {{attempts: 2, pause: 0.3}}
        do: {{sequence: [{EACH}, {DRAW}, {{wait: 0.2}}, {{check: false}}]}}
        """,
    "beside it": f"""
        parallel:
          - sequence: [{DRAW}, {{wait: 0.2}}, {{set: {{x: 1}}}}]
          - sequence: [{{wait: 0.1}}, {BAD}]
        """,
    "in every tick": f"""
        sequence: [{EACH}, {{sequence: [{DRAW}, {{wait: 0.2}}]}}]
        memory: false
        """,
    "for each element": f"""
        for_each: {{y: [1, 2]}}
        do: {{sequence: [{EACH}, {DRAW}, {{wait: 0.2}}]}}
        """,
    "by a named tree": f"""
        sequence: [{DRAW}, {{tree: {{name: part, inputs: {{given: $x}}}}}}]
        """,
    "as the output of a named tree": f"""
        sequence:
          - set: {{z: 'choice(1, 2)'}}
          - {{tree: {{name: part, inputs: {{given: $z}}}}, outputs: {{made: x}}}}
          - {{wait: 0.2}}
          - {BAD.replace("high}", "top}").replace("low}", "flat}")}
        """,
    "as a limit from the beginning": """
        sequence:
          - set: {x: 'choice(0.3, 2)'}
          - fallback:
              - parallel:
                  - {turn: {angle: 90}, timeout: $x}
                  - sequence: [{wait: 1}, {log: high, name: high}]
                succeed_when: any
                fail_when: any
              - {log: low, name: low}
        """,
}


def mission_of(tree: str) -> Mission:
    """A mission with a variable that its tree may write and read."""
    inner = textwrap.indent(textwrap.dedent(tree).strip(), "      ").strip()
    trees = PART if "part" in tree else ""
    head = "mission: m\n" + trees + "tree:\n  sequence:\n    - set: {x: 0}\n    - "
    return load(f"{head}{inner}\n")


@pytest.mark.parametrize("where", READ)
def test_a_variable_counts_as_long_as_it_may_be_read(where: str) -> None:
    """Both of its values are read, wherever that is."""
    assert prove(mission_of(READ[where]), ProofOptions(faults=1)).never_entered == ()


@pytest.mark.parametrize("values", ["0.3, 3", "3, 0.3"])
def test_a_limit_has_the_value_of_its_variable_at_entry(values: str) -> None:
    """Although the variable has another one before the limit begins."""
    tree = f"""
        sequence:
          - set: {{x: 'choice({values})'}}
          - parallel:
              - {{turn: {{angle: 90}}, timeout: $x, name: slow}}
              - sequence: [{{set: {{x: 1}}}}, {{wait: 1}}, {{log: late, name: late}}]
            succeed_when: any
        """
    faults = ("reject", "no_server", "abort", "no_answer", "server_lost")
    usual = parse_answers(",".join(["usual", *(f"*:{fault}" for fault in faults)]))
    proof = prove(mission_of(tree), ProofOptions(faults=1, answers=usual))
    assert "'slow' canceled by timeout: not done within 0.3 s" in proof.failures
    assert proof.never_entered == ()


UNREAD = {
    "never read again": (f"sequence: [{DRAW}, {{wait: 0.2}}]", 3),
    "written first": (f"sequence: [{DRAW}, {{wait: 0.2}}, {{set: {{x: 1}}}}, {BAD}]", 3),
    "read before": (f"sequence: [{DRAW}, {BAD}, {{wait: 0.2}}]", 3),
    "read later": (f"sequence: [{DRAW}, {{wait: 0.2}}, {BAD}]", 5),
}


@pytest.mark.parametrize("where", UNREAD)
def test_states_that_differ_in_what_nobody_reads_are_one(where: str) -> None:
    """That which waits, its last tick apart, and the end."""
    tree, states = UNREAD[where]
    proof = prove(mission_of(tree))
    assert (proof.exhaustive, proof.states) == (True, states)


def test_a_lost_goal_is_named_at_the_end_but_tells_no_states_apart() -> None:
    """The reason is found, on the way with the lost goal and only there."""
    tree = """
      sequence:
        - fallback: [{turn: {angle: 90}, timeout: 1}, {log: no}]
        - {wait: 30}
    """
    proof = prove(load(f"mission: m\ntree:{tree}"), ProofOptions(faults=1))
    assert "orphaned goals: /turn goal of 'turn'" in proof.failures
    tree += "    - {check: false, name: bad}\n"
    proof = prove(load(f"mission: m\ntree:{tree}"), ProofOptions(faults=1))
    assert not any("orphaned" in reason for reason in proof.failures)
