"""Mutations of real missions: whatever is done to a file, its author gets located words."""

import random
import re

from hypothesis import given, settings
from hypothesis import strategies as st

from bt_mission.core.diagnostics import InputError
from bt_mission.core.yaml.document import read_text
from bt_mission.language.expressions.expression import names_in, resolve
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.interfaces import ServiceNode
from bt_mission.ros.interface_types import action_type, fill, service_type
from bt_mission.sessions.check import examine
from tests.support.project import ROOT

CORPUS = [
    path.read_text(encoding="utf-8", errors="replace")
    for folder in ("missions", "missions/sources", "tests/language/broken")
    for path in sorted((ROOT / folder).glob("*.yaml"))
]
WORDS = (
    "$ ${ } { [ ] : - & * ! | > # ' \" \\ % @ ` ? --- ... ~ = == 1e999 .nan -1 2**99 true null "
    "sin( uniform(0,1) choice() x.y $speed cancel_when turn wait do repeat retry log sequence "
    "name outputs timeout tree inputs service wait_for until ((( ))) [[[ {{{ , é 前 😀"
)
BLANKS = ("\n", "  ", "\t", "\x00", "\u2028", "\ufeff", "\r", "\x85", "- ", ": ")
PIECES = (*WORDS.split(), *BLANKS, "9" * 400)


def mutated(text, rng):
    """Return a text with a few pieces put in, cut out, doubled, swapped or moved."""
    for _ in range(rng.randint(1, 4)):
        start = rng.randrange(len(text) + 1)
        stop = min(len(text), start + rng.randint(0, 30))
        lines = text.split("\n")
        words = [match.span() for match in re.finditer(r"[A-Za-z_$.0-9]+", text)]
        match rng.randrange(6):
            case 0:
                text = text[:start] + rng.choice(PIECES) + text[start:]
            case 1:
                text = text[:start] + text[stop:]
            case 2:
                text = text[:start] + text[start:stop] * 3 + text[stop:]
            case 3 if words:
                (a, b), (c, d) = rng.choice(words), rng.choice(words)
                text = text[:a] + rng.choice([text[c:d], rng.choice(PIECES)]) + text[b:]
            case 4:
                i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
                lines[i], lines[j] = lines[j], lines[i]
                text = "\n".join(lines)
            case _:
                i = rng.randrange(len(lines))
                lines[i] = " " * rng.randint(0, 6) + lines[i].lstrip()
                text = "\n".join(lines)
    return text


@settings(max_examples=500)
@given(st.integers(0, 2**32))
def test_whatever_is_done_to_a_mission_every_fault_has_a_place(seed):
    """Never another exception, and never a fault without line and column."""
    rng = random.Random(seed)
    text = mutated(rng.choice(CORPUS), rng)
    try:
        mission, faults = examine(read_text(text, "m.yaml"))
    except InputError as error:
        mission, faults = None, error.faults
    if mission is not None:
        constant_goals_can_be_sent(mission)
    for fault in faults:
        assert fault.line >= 1
        assert fault.column >= 1
        assert str(fault).startswith(f"m.yaml:{fault.line}:{fault.column}: {fault.severity}: ")


def constant_goals_can_be_sent(mission):
    """What the check lets pass does not fail for a reason that it could have seen."""
    for step in mission.tree.walk():
        if isinstance(step, GoalNode) and names_in(step.sent) <= mission.inputs.keys():
            goal = resolve(step.sent, mission.inputs, random.Random(0))
            fill(action_type(step.type).Goal(), goal)
        if isinstance(step, ServiceNode) and names_in(step.sent) <= mission.inputs.keys():
            request = resolve(step.sent, mission.inputs, random.Random(0))
            fill(service_type(step.type).Request(), request)
