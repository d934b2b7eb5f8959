"""`proved` is said only where no value, instant or order that a run may have was left out."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import NamedTuple

import pytest

from bt_mission.commands.prove.answers import parse_answers
from bt_mission.commands.prove.proof import Proof, ProofOptions, prove
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load
from tests.commands.prove.brute_force import small_mission
from tests.support.thorough import sample

FORWARD = "{explore_forward: {fwd_velocity: 0.1, stopping_distance: 0.5}, timeout: 9, outputs: OUT}"
GAP = FORWARD.replace("OUT", "{closest_obstacle: gap}")
TURN = "{turn: {angle: 90}, timeout: 9, outputs: {angle_turned: turned}}"
SWEEP = (
    "{camera_sweep: {sweep_angle: 90, image_count: 2}, timeout: 9, outputs: {image_paths: paths}}"
)
BATTERY = "topic: /battery_state, type: sensor_msgs/msg/BatteryState"
AWAITED = f"{{wait_for: {{{BATTERY}, until: percentage < 90}}, timeout: 9, outputs: OUT}}"


class Case(NamedTuple):
    """A mission of which something is not proved.

    Attributes:
        head: What stands above the tree.
        tree: The tree.
        failure: A part of a reason for which it may fail; "" where none is expected.
        why: A part of why the exploration is not exhaustive; "" where it is.
    """

    head: str
    tree: str
    failure: str = ""
    why: str = ""


NAN = "NaN, infinite or beyond 1e12 of /battery_state"
"""Why no mission that follows a number is explored as a whole without a fault."""


def when(condition: str, before: str = GAP, head: str = "", why: str = "") -> Case:
    """A mission that fails where a condition holds."""
    tree = f"sequence:\n  - {before}\n  - when: {condition}\n    do: {{check: false, name: bad}}"
    return Case(head, tree, "'bad'", why)


def follow(*fields: str, more: str = "") -> str:
    """Variables that follow fields of one topic."""
    lines = [f"  - {{{BATTERY}, field: {name}, as: {name}{more}}}" for name in fields]
    return "\n".join(["follow:", *lines, ""])


FAILING = {
    "between two constants": when("gap > 0.5 and gap < 1.0"),
    "between two neighbours of float32": when("gap > 0.5 and gap < 0.50000007"),
    "at a border": when("gap == 0.25"),
    "a product": when("2 * gap > 1 and 3 * gap < 1.6"),
    "a magnitude": when("abs(gap) < 0.25 and gap < 0"),
    "a root": when("sqrt(abs(gap)) > 3 and gap < 10"),
    "a square": when("gap * gap > 4 and gap < 2"),
    "a reciprocal": when("gap > 0 and 1 / gap > 100"),
    "the least of two": when("min(gap, 3) > 2.5 and gap < 2.75"),
    "an integer": when("code > 3 and code < 5", FORWARD.replace("OUT", "{error_code: code}")),
    "a value passed on": Case(
        "",
        f"sequence:\n  - {GAP}\n  - set: {{near: gap - 1}}\n  - set: {{much: near * 4}}\n"
        "  - when: much > 1 and much < 1.5\n    do: {check: false, name: bad}",
        "'bad'",
    ),
    "a root of what is negative": Case(
        "", f"sequence:\n  - {GAP}\n  - log: ${{sqrt(gap)}}", "not a number"
    ),
    "a wait of what is negative": Case(
        "", f"sequence:\n  - {GAP}\n  - wait: gap", "seconds, 0 or", "lengths and counts"
    ),
    "a message that is awaited": when(
        "voltage > 50 and voltage < 51",
        AWAITED.replace("OUT", "{voltage: voltage}"),
    ),
    "the field of a condition": when(
        "left > 49 and left < 50",
        AWAITED.replace("OUT", "{percentage: left}"),
    ),
    "two fields of one topic": when(
        "percentage > 50 and voltage < 10", "{wait: 1}", follow("percentage", "voltage"), NAN
    ),
    "a topic that is awaited and followed": when(
        "percentage > 95",
        AWAITED.replace("OUT", "{}"),
        follow("percentage"),
        NAN,
    ),
    "an initial value": Case(
        follow("percentage", more=", initial: 10"), "{check: percentage > 50}", "does not hold", NAN
    ),
    "a message before the first tick": Case(
        follow("percentage", more=", initial: 80"), "{check: percentage > 50}", "does not hold", NAN
    ),
    "an empty list": Case(
        "",
        f"sequence:\n  - {SWEEP}\n  - log: ${{paths[0]}}",
        "none at 0",
        "lists of 0, 1, 2, 3",
    ),
    "a list of several": Case(
        "",
        f"sequence:\n  - {SWEEP}\n"
        "  - for_each: {path: $paths}\n    do: {check: false, name: bad}",
        "'bad'",
        "lists of 0, 1, 2, 3",
    ),
    "a draw between two constants": when("x > 2 and x < 4", "{set: {x: 'uniform(1, 5)'}}"),
    "a draw in a condition": when("uniform(0, 1) > 0.9", "{wait: 1}"),
    "the last of six": when("x == 6", "{set: {x: 'choice(1, 2, 3, 4, 5, 6)'}}"),
    "a draw of a time": Case(
        "",
        "timeout: 4\ndo: {wait: 'uniform(1, 5)'}",
        "not done within 4 s",
        "lengths and counts",
    ),
}


def mission_of(case: Case) -> Mission:
    """Return a mission."""
    tree = textwrap.indent(case.tree, "  ")
    return load(f"mission: m\n{case.head}tree:\n{tree}\n")


def proof_of(case: Case, faults: int = 0) -> Proof:
    """Prove a mission."""
    return prove(mission_of(case), ProofOptions(faults=faults))


@pytest.mark.parametrize("case", FAILING.values(), ids=list(FAILING))
def test_a_value_that_a_run_may_have_is_tried(case: Case) -> None:
    """The failure that it leads to is found without a fault."""
    proof = proof_of(case)
    assert any(case.failure in reason for reason in proof.failures)
    assert proof.exhaustive is not bool(case.why)
    assert any(case.why in why for why in proof.why_not) is bool(case.why)


PASSING = {
    "no number": when("gap > 1 and gap < 1"),
    "no integer": when("code > 3 and code < 4", FORWARD.replace("OUT", "{error_code: code}")),
    "no float32": when("gap > 0.5 and gap < 0.50000003"),
    "no draw": when("x > 5", "{set: {x: 'uniform(1, 5)'}}"),
    "none of six": when("x > 6", "{set: {x: 'choice(1, 2, 3, 4, 5, 6)'}}"),
}


@pytest.mark.parametrize("case", PASSING.values(), ids=list(PASSING))
def test_a_value_that_no_run_has_is_not_tried(case: Case) -> None:
    """The exploration is exhaustive, so that what it shows is proved."""
    proof = proof_of(case)
    assert proof.exhaustive
    assert not any(case.failure in reason for reason in proof.failures)
    assert "goals_accounted" in proof.proved


UNFOLLOWED = {
    "two values": f"sequence: [{GAP}, {TURN}, {{check: gap > turned}}]",
    "a remainder": f"sequence: [{GAP}, {{check: gap % 2 > 1}}]",
    "a wave": f"sequence: [{GAP}, {{check: sin(gap) > 0.9}}]",
    "a sum of itself": (
        f"sequence: [{{set: {{total: 0}}}}, {GAP}, {{set: {{total: gap + total}}}},"
        " {check: total > 3}]"
    ),
}


@pytest.mark.parametrize("tree", UNFOLLOWED.values(), ids=list(UNFOLLOWED))
def test_what_cannot_be_followed_is_named(tree: str) -> None:
    """With the expression and its line; nothing is proved."""
    proof = proof_of(Case("", tree))
    assert (proof.exhaustive, proof.proved) == (False, ())
    assert proof.why_not[0].startswith("not all values are tried: 'gap' in '")
    assert "(<text>:" in proof.why_not[0]


def test_an_extreme_number_is_a_fault() -> None:
    """NaN, infinite numbers and those beyond all that is usual."""
    case = Case("", f"sequence:\n  - {GAP}\n  - log: ${{round(gap)}}")
    assert proof_of(case).failures == ()
    assert any("cannot convert float" in reason for reason in proof_of(case, faults=1).failures)


def verdicts(requirement: str, tree: str, faults: int) -> str:
    """Return the verdict on a requirement."""
    case = Case(f"requirements: {{wanted: {requirement!r}}}\n", tree)
    return proof_of(case, faults).requirements[0].verdict


EITHER = f"fallback:\n  - {TURN}\n  - {{move: {{secs: 1, linear_velocity: 0.1}}, timeout: 9}}"
MONOTONE = (
    'whenever running("move"): accepted("turn")',
    'never failed("m") and not accepted("turn")',
    'never accepted("turn") and running("move")',
    'never outcome("turn") == "aborted" and accepted("turn")',
)


@pytest.mark.parametrize("requirement", sample(MONOTONE, 4))
def test_more_faults_never_prove_more(requirement: str) -> None:
    """What is violated with some faults is violated with more."""
    are_violated = [verdicts(requirement, EITHER, faults) == "violated" for faults in range(4)]
    assert are_violated == sorted(are_violated)
    assert are_violated[-1]


@pytest.mark.parametrize("seed", sample(range(12), 4))
def test_more_faults_find_more(seed: int) -> None:
    """Among the findings with two faults are those with one."""
    broken = []
    for faults in (0, 1, 2):
        proof = prove(small_mission(seed), ProofOptions(faults=faults))
        broken.append({entry.property for entry in proof.findings} - {"dead_node"})
    assert broken[0] <= broken[1] <= broken[2]


GUARDED = """\
parallel:
  - sequence:
      - guard: percentage > 20
        do: {turn: {angle: 90}, timeout: 9}
  - wait: 60
succeed_when: any
"""


def test_an_answer_may_be_slow() -> None:
    """The tree halts a goal that is not accepted yet; its server accepts it later."""
    head = follow("percentage", more=", initial: 90")
    requirement = 'requirements:\n  stays: \'never accepted("turn") and failed("turn")\'\n'
    tree = f"fallback:\n  - guard: percentage > 20\n    do: {TURN}\n  - wait: 1"
    proof = proof_of(Case(head + requirement.replace("failed", "running"), tree))
    steps = [entry.steps for entry in proof.findings if entry.property == "requirement"]
    assert steps
    recalled = Case(head, "fallback:\n  - guard: percentage > 20\n    do: TURN\n  - wait: 1")
    proof = proof_of(recalled._replace(tree=recalled.tree.replace("TURN", TURN)))
    assert any("check" in reason or reason for reason in proof.failures) is bool(proof.failures)


INSTANTS = """\
parallel:
  - sequence:
      - {turn: {angle: 90}, timeout: 10}
      - wait: 1
      - set: {turned: true}
  - sequence:
      - wait: 3
      - set: {early: $turned}
      - wait: 0.5
      - set: {late: $turned}
"""


def test_instants_between_those_that_are_taken_are_not_proved() -> None:
    """The turn is over between two waits if its result comes 2 s to 2.5 s behind its beginning."""
    requirement = "requirements:\n  no: never $late and not $early\n"
    tree = textwrap.indent(INSTANTS, "    ").lstrip()
    first = "sequence:\n  - set: {turned: false, early: true, late: false}\n  - "
    proof = proof_of(Case(requirement, first + tree))
    (verdict,) = proof.requirements
    assert verdict.verdict == "not violated"
    assert proof.why_not == (
        "not all instants are taken: of answers that come while 'wait' is running",
    )
    assert "goals_accounted" in proof.proved
    assert "ends" in proof.not_violated


def test_what_holds_in_all_orders_of_instants_is_proved() -> None:
    """A second exploration lets every limit be over at any tick."""
    requirement = "requirements:\n  one: never open_goals > 1\n"
    tree = f"parallel:\n  - sequence: [{TURN}, {TURN}]\n  - {{wait: 5}}\nsucceed_when: any"
    proof = proof_of(Case(requirement, tree))
    assert not proof.exhaustive
    assert [entry.verdict for entry in proof.requirements] == ["proved"]


SENT = "{turn: {angle: $gap}, timeout: 9}"
MOST = "NaN, infinite or beyond 1e12 of /explore_forward"


@pytest.mark.parametrize("angle", ["$gap", "2 * gap", "sqrt(gap * gap)"])
def test_a_number_that_cannot_be_sent_is_tried(angle: str) -> None:
    """It takes a fault; where none is left, what it breaks is not proved."""
    case = Case("", f"sequence: [{GAP}, {SENT.replace('$gap', angle)}]")
    proof = proof_of(case)
    assert "unhandled" in proof.not_violated
    assert {"goals_accounted", "one_goal_at_the_base"} <= set(proof.proved)
    assert any(MOST in why for why in proof.why_not)
    assert any("angle: expected a finite" in why for why in proof_of(case, faults=1).failures)
    without = ProofOptions(answers=parse_answers("usual,explore_forward:extreme"))
    assert "unhandled" in prove(mission_of(case), without).proved


@pytest.mark.parametrize(
    ("more", "is_proved"), [("", False), (", default: 0.0", True)], ids=["none", "a default"]
)
def test_a_followed_field_may_be_nan(more: str, is_proved: bool) -> None:  # noqa: FBT001
    """As batteries publish it: it is no value. This is no fault of a run that has none left."""
    case = Case(
        follow("percentage", more=more), f"sequence: [{{wait: 1}}, {TURN}, {{log: $percentage}}]"
    )
    proof = proof_of(case)
    assert ("unset_variable" in proof.proved, "cleanup" in proof.proved) == (is_proved, True)
    assert any(NAN in why for why in proof.why_not)


def test_a_number_outside_a_field_is_tried() -> None:
    """An unsigned integer of 16 bits is sent as a signed one of 8."""
    code = FORWARD.replace("OUT", "{error_code: code}")
    topic = "{publish: {topic: /code, type: std_msgs/msg/Int8, message: {data: $code}}}"
    proof = proof_of(Case("", f"sequence: [{code}, {topic}]"))
    assert any("outside int8" in reason for reason in proof.failures)


@pytest.mark.parametrize(
    ("angle", "is_finite"),
    [
        ("copysign(90, -gap)", True),
        ("copysign(uniform(60, 120), -gap)", True),
        ("gap - copysign(uniform(60, 120), gap)", False),
        ("gap * uniform(1, 2)", False),
    ],
)
def test_what_a_field_always_takes_is_followed(angle: str, is_finite: bool) -> None:  # noqa: FBT001
    """Its sign makes no difference, nor do others with which it is computed, if it is usual."""
    proof = proof_of(Case("", f"sequence: [{GAP}, {{turn: {{angle: '{angle}'}}, timeout: 9}}]"))
    assert proof.states == 7
    assert proof.exhaustive is is_finite
    assert all(MOST in why for why in proof.why_not)


def test_an_acceptance_may_come_after_the_goal_is_given_up() -> None:
    """Where `cancel_timeout` is less than `acceptance_timeout`."""
    turn = "{turn: {angle: 90}, timeout: 1, cancel_timeout: LIMIT}"
    move = "{move: {secs: 1, linear_velocity: 0.1}, timeout: 1}"
    either = f"{{parallel: [{turn}, {{wait: 0.2}}], succeed_when: any}}"
    for limit, is_given_up in (("0.1", True), ("3", False)):
        tree = f"sequence: [{either.replace('LIMIT', limit)}, {move}]"
        proof = proof_of(Case("", tree))
        broken = [entry.property for entry in proof.findings]
        assert broken == ["one_goal_at_the_base"] * is_given_up
        assert ("one_goal_at_the_base" in proof.proved) is not is_given_up


def test_an_answer_may_be_missing_while_many_other_things_happen() -> None:
    """More of them than an exploration with times takes: what that shows is not proved."""
    past = "previously $on"
    for value in ("not $on", "$on", "not $on"):
        past = f"previously ({value} and {past})"
    requirement = f'never $on and {past} and not accepted("turn")'
    topic = "{topic: on, type: std_msgs/msg/Bool, field: data, as: on}"
    head = f"follow: [{topic}]\nrequirements:\n  soon: '{requirement}'\n"
    proof = proof_of(Case(head, TURN))
    assert [entry.verdict for entry in proof.requirements] == ["not violated"]
    assert any("of answers of /turn behind 2 other events" in why for why in proof.why_not)


def test_a_cancel_by_a_condition_is_none_by_a_limit() -> None:
    """Both wait for the same answer, and the leaf ends in another way."""
    tree = "explore_forward: {fwd_velocity: 0.1, stopping_distance: 0.5}\ntimeout: 9\n"
    tree += "cancel_when: current_distance_travelled > 1\non_cancel: success"
    proof = proof_of(Case("", tree), faults=1)
    assert any("canceled by timeout" in reason for reason in proof.failures)


LOOP = "{repeat: {ROUNDS}, do: {wait: 1}}"
BESIDE = f"{{parallel: [{{turn: {{angle: 90}}}}, {LOOP}], succeed_when: any}}"
ENDLESS = {
    "feedback": ("", "{turn: {angle: 90}, feedback_timeout: 1}", "finding"),
    "messages": (
        follow("percentage", more=", initial: 10, timeout: 3"),
        "{turn: {angle: 90}}",
        "finding",
    ),
    "a loop beside it": (
        "",
        BESIDE.replace("ROUNDS", "until: 1 > 2"),
        "finding",
    ),
    "a loop that ends": (
        "",
        "{parallel: [{turn: {angle: 90}}, {repeat: {count: 3}, do: {wait: 1}}], succeed_when: any}",
        "",
    ),
    "a loop of many rounds": (
        "",
        BESIDE.replace("ROUNDS", "count: 100"),
        "",
    ),
    "a limit above it": ("", "{timeout: 9, do: {turn: {angle: 90}, feedback_timeout: 1}}", ""),
    "a limit": ("", "{turn: {angle: 90}, timeout: 9}", "proved"),
}


@pytest.mark.parametrize(("head", "tree", "shown"), ENDLESS.values(), ids=list(ENDLESS))
def test_a_goal_without_a_limit_never_ends(head: str, tree: str, shown: str) -> None:
    """Though the limits of others run, and begin again for ever."""
    proof = proof_of(Case(head, tree), faults=1)
    ends = [entry.node for entry in proof.findings if entry.property == "ends"]
    assert ends == ["turn"] * (shown == "finding")
    assert ("ends" in proof.proved) is (shown == "proved")


def test_limits_that_end_together_are_no_endless_run() -> None:
    """Of a server that is back so late that its goal, accepted, cannot be done in time."""
    grip = "action: {name: grip, type: control_msgs/action/GripperCommand}, timeout: 5"
    tree = f"finally: {{timeout: 10}}\ndo: {{{grip}, name: close}}\nthen: {{{grip}, name: open}}"
    proof = proof_of(Case("", tree), faults=1)
    assert [entry.text for entry in proof.findings] == []


def test_an_output_of_a_class_has_the_type_of_its_attribute(tmp_path: Path) -> None:
    """A truth value, a text and an integer."""
    (tmp_path / "door.py").write_text(
        "from py_trees.behaviour import Behaviour\n\n\n"
        "class Door(Behaviour):\n    is_open, colour, count = False, 'red', 0\n"
    )
    (tmp_path / "m.yaml").write_text(
        "mission: m\ntree:\n  sequence:\n"
        "    - python: door.py:Door\n      name: door\n"
        "      outputs: {is_open: is_open, colour: colour, count: count}\n"
        "    - check: is_open or colour == 'blue' or count == 3\n"
    )
    proof = prove(load(tmp_path / "m.yaml"), ProofOptions(faults=0))
    assert proof.exhaustive
    values = {line for step in proof.failures for line in step.split("(")[-1:]}
    assert any("colour = blue" in value or "colour" in value for value in values)
