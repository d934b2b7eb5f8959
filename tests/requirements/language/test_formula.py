"""Requirements as they are written: what is refused, where, and what to write instead."""

from __future__ import annotations

import re

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.requirements.language.formula import Formula, root_of
from bt_mission.sessions.load import load

MISSION = """\
mission: tour
inputs: {{most: 0.2}}
requirements:
  {}
tree:
  sequence:
    - turn: {{angle: 90}}
      name: look around
    - wait: 1
      name: visit A
"""


def test_a_colon_in_a_requirement_wants_quotes() -> None:
    """As for any reader of YAML; the error has the line to write."""
    line = 'gets on: eventually within 60 s: succeeded("visit A")'
    with pytest.raises(InputError) as refused:
        load(MISSION.format(f"{line}  # soon"))
    written = "gets on: 'eventually within 60 s: succeeded(\"visit A\")'"
    assert f"quote the text: {written}" in refused.value.diagnostics[0].headline
    (requirement,) = load(MISSION.format(f"{written}  # soon")).requirements
    assert (requirement.name, requirement.text) == (
        "gets on",
        'eventually within 60 s: succeeded("visit A")',
    )


def test_a_requirement_in_parts_is_one_formula() -> None:
    """The keys of a mapping come to the same as the sentence."""
    form = "a: {whenever: age('scan') > 0.5, then: speed < 0.01, within: 0.6, on_violation: halt}"
    (requirement,) = load(MISSION.format(form)).requirements
    assert requirement.text == "whenever age('scan') > 0.5: speed < 0.01 within 0.6 s"
    assert requirement.on_violation == "halt"


@pytest.mark.parametrize(
    "then", ["speed < 1", "a or b", "x > 0 until y > 0", "running('a') implies x > 0 until y > 0"]
)
def test_a_mapping_reads_back_from_its_text(then: str) -> None:
    """Recordings hold requirements as texts; a window stays with what it belongs to."""
    then = then.replace("a or b", "running('a') or x > 2")
    text = f'{{whenever: speed > 0.5, then: "{then}", within: 0.5}}'
    if "until" in then:
        text = text.replace("y > 0", "y > 0 within 1 s")
    mission = load(f"mission: it\nrequirements:\n  one: {text}\ntree: {{wait: 1, name: a}}\n")
    (requirement,) = mission.requirements
    again = Formula(requirement.text).root
    columns = re.compile(r"column=\d+|(?<=[<>=]', )\d+")
    assert columns.sub("", repr(again)) == columns.sub("", repr(root_of(requirement)))


def test_the_hint_of_a_name_without_quotes_quotes_that_name() -> None:
    """It can be copied."""
    with pytest.raises(ExpressionError) as caught:
        Formula("always running(drive)")
    assert caught.value.hint == "quote names: 'drive'"
