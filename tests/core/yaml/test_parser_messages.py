"""The YAML parser's complaints, in our words and at the most telling place."""

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.core.yaml.composer import compose


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a: [1,2\n\n", "1:4: error: this '[' has no closing ']'"),
        ("b: {x: 1\n", "1:4: error: this '{' has no closing '}'"),
        ("a: 'x\n", "1:4: error: this quote is never closed"),
        ("a: b: c", "1:5: error: a second ':' in a line; quote the text: a: 'b: c'"),
        ("- a: it's: c # d", "1:10: error: a second ':' in a line; quote the text: a: 'it''s: c'"),
        ("key: @x", "1:6: error: a value cannot start with '@'; put it in quotes"),
        ("a: %x", "1:4: error: a value cannot start with '%'; put it in quotes"),
        ("{", "1:2: error: expected a value here"),
        (
            'a: "\\q"',
            "1:5: error: an unknown escape in a double-quoted text; write '\\\\' for a backslash",
        ),
        (
            "- a\nb: 1",
            "2:1: error: expected '- ', an item of the list of line 1, or less indentation",
        ),
        (
            "a: 1\n- b",
            "2:1: error: expected 'key: value' of the mapping of line 1, or another indentation",
        ),
        ("a\nb: 1", "2:2: error: unexpected ':'; check the indentation, or quote"),
        ("a: 1\nb\n", "2:2: error: expected ':' after a key"),
        ("%", "1:2: error: invalid YAML: could not find expected directive name"),
        ("a: !x!y 1", "1:4: error: a tag is not allowed"),
    ],
)
def test_complaints_are_plain_and_located(text, fault):
    """No word of scanners, tokens or flow sequences; a bracket left open is shown itself."""
    with pytest.raises(InputError) as caught:
        compose(text, "a.yaml")
    assert str(caught.value).splitlines()[0].startswith(f"a.yaml:{fault}")
