"""Requirements as they are written: what is refused, where, and what to write instead."""

from __future__ import annotations

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.requirements.language.formula import Formula, root_of
from bt_mission.requirements.language.syntax import Implies, Temporal, TimeWindow
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
    ("then", "text"),
    [
        ("speed < 1", "speed < 1"),
        ("running('a') or x > 2", "running('a') or x > 2"),
        ("x > 0 until y > 0 within 1 s", "(x > 0 until y > 0 within 1 s)"),
        (
            "running('a') implies x > 0 until y > 0 within 1 s",
            "(running('a') implies x > 0 until y > 0 within 1 s)",
        ),
    ],
)
def test_a_mapping_is_one_sentence(then: str, text: str) -> None:
    """Recordings hold requirements as texts; a window stays with what it belongs to."""
    form = f'{{whenever: speed > 0.5, then: "{then}", within: 0.5}}'
    mission = load(f"mission: it\nrequirements:\n  one: {form}\ntree: {{wait: 1, name: a}}\n")
    (requirement,) = mission.requirements
    assert requirement.text == f"whenever speed > 0.5: {text} within 0.5 s"
    match root_of(requirement):
        case Temporal(word="always", operands=(Implies(right=Temporal() as right),)):
            assert (right.word, right.window) == ("eventually", TimeWindow(0.0, 0.5))
        case other:
            pytest.fail(f"{other}")


def test_the_hint_of_a_name_without_quotes_quotes_that_name() -> None:
    """It can be copied."""
    with pytest.raises(ExpressionError) as caught:
        Formula("always running(drive)")
    assert caught.value.hint == "quote names: 'drive'"
