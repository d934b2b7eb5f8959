"""The pages of the mission language: their examples run, and they are complete."""

import random
import re
from typing import Any

import pytest

from bt_mission.base.yaml.document import read_text
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.parser import RESERVED
from bt_mission.language.expressions.values import show
from bt_mission.language.file import MissionFile
from bt_mission.language.nodes.registry import KINDS
from bt_mission.sessions.check import examine
from tests.support.project import LANGUAGE_PAGES, ROOT

TEXT = LANGUAGE_PAGES
EXAMPLES = re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL)
ROWS = re.findall(r"^\| `([^`]+)` \| `([^`]+)` \|$", TEXT, re.MULTILINE)
HEAD = "mission: example\ninputs: {speed: 0.2, legs: 4}\ntree:\n  sequence:\n"


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_is_a_sound_mission(example, monkeypatch):
    """A whole mission, or nodes of one; without warnings, unread inputs apart."""
    monkeypatch.chdir(ROOT / "docs" / "tutorials" / "code")  # where leaves of one's own are
    whole = example.startswith("mission:")
    indented = "".join(f"    {line}\n" for line in example.splitlines())
    mission, diagnostics = examine(read_text(example if whole else HEAD + indented, "example.yaml"))
    assert mission is not None
    unread = [fault for fault in diagnostics if fault.message.startswith("the input '")]
    assert diagnostics == (() if whole else tuple(unread))


@pytest.mark.parametrize(("text", "value"), ROWS)
def test_a_row_of_the_table_is_true(text, value):
    """The expression has that value, whole numbers told from others."""
    names: dict[str, Any] = {"places": ["A", "B", "C"]}
    result = Expression(text).evaluate(names, random.Random(0))
    assert (show(result) if isinstance(result, bool) else repr(result)) == value


def test_every_kind_modifier_and_word_is_described():
    """In an example or a table."""
    code = "".join(re.findall(r"`[^`]*`|```.*?```", TEXT, re.DOTALL))
    words = set(re.findall(r"[A-Za-z_0-9]+", code))
    modifiers = {name for model in KINDS.values() for name in model.keys}
    assert modifiers | set(KINDS) | set(MissionFile.model_fields) | RESERVED <= words


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_and_modifier_has_an_example(kind):
    """Someone who copies from the page finds it in use."""
    examples = "".join(EXAMPLES)
    for name in KINDS[kind].keys:
        assert re.search(rf"\b{name}:", examples), f"no example of {name}"


def test_there_are_examples_and_rows():
    """The page has not changed its form under this test."""
    assert len(EXAMPLES) >= 15
    assert len(ROWS) >= 25
