"""Mutations of XML missions: whatever is done to a file, its author gets located words."""

import random
import re
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from bt_mission.btcpp.document import document_of
from bt_mission.btcpp.mission_writer import mission_xml
from bt_mission.btcpp.yaml_text import yaml_text
from bt_mission.core.diagnostics import InputError
from bt_mission.core.yaml.document import read
from bt_mission.language.loader import read_mission
from bt_mission.sessions.load import load
from tests.support.missions import meaning
from tests.support.project import MISSIONS

EVERYTHING = (Path(__file__).parent / "everything.xml").read_text(encoding="utf-8")
CORPUS = [
    *(mission_xml(read(path)) for path in MISSIONS),
    *[EVERYTHING] * 10,
]
WORDS = (
    "< > / = \" ' & &amp; &#0; &#10; <!-- --> <![CDATA[ ]]> <?pi?> <a/> </a> { } {x} [ ] $x ${ -1 "
    '1e999 true name="" ID="turn" _skipIf="x" <Sequence> </Sequence> <Action <SubTree := ; ! && '
    "|| 'x' é 前 😀"
)
PIECES = (
    *WORDS.split(),
    "<!DOCTYPE x>",
    "9" * 400,
    "\x00",
    "\ufffe",
    "\u2028",
    "\r",
    "\t",
    "\n",
    "",
)


def mutated(text, rng):
    """Return a text with a few pieces put in, cut out, doubled, swapped or replaced."""
    for _ in range(rng.randint(1, 3)):
        start = rng.randrange(len(text) + 1)
        stop = min(len(text), start + rng.randint(0, 30))
        spans = [match.span() for match in re.finditer(r'"[^"]*"|[A-Za-z_]+', text)]
        match rng.randrange(5):
            case 0:
                text = text[:start] + rng.choice(PIECES) + text[start:]
            case 1:
                text = text[:start] + text[stop:]
            case 2:
                text = text[:start] + text[start:stop] * 3 + text[stop:]
            case 3 if spans:
                (a, b), (c, d) = rng.choice(spans), rng.choice(spans)
                text = text[:a] + text[c:d] + text[b:]
            case _ if spans:
                a, b = rng.choice(spans)
                quote = '"' if text[a] == '"' else ""
                text = text[:a] + quote + rng.choice(PIECES) + quote + text[b:]
    return text


@settings(max_examples=500)
@given(st.integers(0, 2**32))
def test_whatever_is_done_to_a_file_every_fault_has_a_place(seed):
    """Never another exception; and what is still a mission can be written as YAML and as XML."""
    rng = random.Random(seed)
    text = mutated(rng.choice(CORPUS), rng)
    try:
        document = document_of(text, "m.xml")
    except InputError as error:
        faults = error.faults
    else:
        mission, faults = read_mission(document)
        if mission is not None:
            again = load(yaml_text(document.data))
            assert meaning(again) == meaning(mission)
            faults = ()
    assert len(faults) <= 400
    for fault in faults:
        assert fault.line >= 1
        assert fault.column >= 1
        assert str(fault).startswith(f"m.xml:{fault.line}:{fault.column}: error: ")
