"""What of YAML is taken, and what is refused where."""

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.composer import MAX_VALUES, compose
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.base.yaml.parser_messages import MAX_DEPTH, TOO_DEEP

SEPARATOR = "a line separator (U+{}), which looks like no end of a line"


def at(place, *path):
    """Return line and column of a part, or None where there is none."""
    for key in path:
        place = place.child(key)
    return place and (place.line, place.column)


def refused(text):
    """Return (line, column, message) of every fault in a text."""
    with pytest.raises(InputError) as caught:
        compose(text, "a.yaml")
    return [(fault.line, fault.column, fault.message) for fault in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x: 1", 1),
        ("x: -12", -12),
        ("x: 0x1f", 31),
        ("x: 0o17", 15),
        ("x: 1.5", 1.5),
        ("x: .5e3", 500.0),
        ("x: 3.", 3.0),
        ("x: true", True),
        ("x: False", False),
        ("x: ~", None),
        ("x:", None),
        ("x: 'true'", "true"),
        ('x: "1"', "1"),
        ("x: yes", "yes"),
        ("x: off", "off"),
        ("x: 1:30", "1:30"),
        ("x: 1_000", "1_000"),
        ("x: 2026-01-01", "2026-01-01"),
        ("x: -a", "-a"),
        ("x: $speed", "$speed"),
        ("x: |\n  two\n  lines\n", "two\nlines\n"),
        ("\ufeffx: 1", 1),
    ],
)
def test_plain_scalars_mean_what_the_core_schema_says(text, value):
    """YAML 1.2: yes and off are texts, and no number hides in a time or a date."""
    data, _ = compose(text, "a.yaml")
    assert data["x"] == value
    assert type(data["x"]) is type(value)


def test_every_part_has_its_place():
    """Lines and columns count from 1; keys and values have places of their own."""
    data, place = compose("a: 1\nb:\n  - x\n  - {c: d}\n", "a.yaml")
    assert data == {"a": 1, "b": ["x", {"c": "d"}]}
    assert place.keys == {"a": (1, 1), "b": (2, 1)}
    assert at(place, "b", 1) == (4, 5)
    assert at(place, "b", 1, "c") == (4, 9)
    assert at(place, "b", 1, "d") is None
    assert at(place, "b", 2) is None
    assert at(place, "a", 0) is None


def test_an_anchored_value_stands_after_its_anchor():
    """The caret points at the value, not at '&name'."""
    _, place = compose("a: &here  {b: 1}", "a.yaml")
    assert at(place, "a") == (1, 11)


def test_aliases_are_followed():
    """An alias is the value that its anchor names, with that value's place."""
    data, place = compose("a: &x [1, 2]\nb: *x\nc: &y 3\nd: *y\n", "a.yaml")
    assert data == {"a": [1, 2], "b": [1, 2], "c": 3, "d": 3}
    assert at(place, "b") == (1, 7)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("", (1, 1, "the file is empty")),
        ("# nothing\n", (1, 1, "the file is empty")),
        ("null", (1, 1, "the file is empty")),
        ("a:\n\t- b", (2, 1, "a tab in the indentation; YAML requires spaces")),
        ("a: [1,\n  \t2]", (2, 3, "a tab in the indentation; YAML requires spaces")),
        ("a: \t@", (1, 5, "a value cannot start with '@'; put it in quotes")),
        ("a: 1\n\x00", (2, 1, "a control character (U+0000); this is not text")),
        (
            "a: 1 # x\x85b: 2",
            (1, 9, SEPARATOR.format("0085")),
        ),
        (
            "a: 1 # x\u2028b: 2",
            (1, 9, SEPARATOR.format("2028")),
        ),
        ("a: 'x\u2029y'", (1, 6, SEPARATOR.format("2029"))),
        ("# \u202e\na: 1", (1, 3, "a character that cannot be seen (U+202E)")),
        ("é: '\u202e'\nb: x\u2066y", (2, 5, "a character that cannot be seen (U+2066)")),
        ("'a': \"\u200d\" # \u200b", (1, 12, "a character that cannot be seen (U+200B)")),
        ("a: &x # \u200b\n  'y'", (1, 9, "a character that cannot be seen (U+200B)")),
        ("a: |\n  x\ufe0f\u200by", (2, 5, "a character that cannot be seen (U+200B)")),
        ("a\u3164: 1", (1, 2, "a character that cannot be seen (U+3164)")),
        ("a: 1\n---\nb: 2", (2, 1, "a second document; expected one per file")),
        ("a: !!int 3", (1, 4, "the tag 'tag:yaml.org,2002:int' is not allowed")),
        ("a: 1\na: 2", (2, 1, "duplicate key 'a' (first in line 1)")),
        ("1: 2", (1, 1, "expected a name as key, got 1")),
        ("~: 2", (1, 1, "expected a name as key, got ~")),
        ("? \n: 2", (1, 2, "expected a name as key, got nothing")),
        ("? [a]\n: 2", (1, 3, "expected a name as key, got a list or a mapping")),
        ("a: &x 1\n*x : 2", (2, 1, "expected a name as key, got an alias")),
        ("a: .nan", (1, 4, "expected a finite number, got .nan")),
        ("a: -.inf", (1, 4, "expected a finite number, got -.inf")),
        ("a: 1e999", (1, 4, "the number '1e999' is too large")),
        ("a: 18446744073709551617", (1, 4, "the number '18446744073709551617' is too large")),
        ("- *x", (1, 3, "this alias has no anchor '&x' before it")),
        ("&a [*a]", (1, 5, "the alias '*a' contains itself")),
    ],
)
def test_what_has_no_business_in_our_files_is_refused(text, fault):
    """Each fault stands at the character it is about."""
    assert refused(text) == [fault]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a: [1,2\n\n", (1, 4, "this '[' has no closing ']'")),
        ("b: {x: 1\n", (1, 4, "this '{' has no closing '}'")),
        ("a: 'x\n", (1, 4, "this quote is never closed")),
        ("a: b: c", (1, 5, "a second ':' in a line; quote the text: a: 'b: c'")),
        ("- a: it's: c # d", (1, 10, "a second ':' in a line; quote the text: a: 'it''s: c'")),
        ("key: @x", (1, 6, "a value cannot start with '@'; put it in quotes")),
        ("a: %x", (1, 4, "a value cannot start with '%'; put it in quotes")),
        ("{", (1, 2, "expected a value here")),
        (
            'a: "\\q"',
            (1, 5, "an unknown escape in a double-quoted text; write '\\\\' for a backslash"),
        ),
        ("- a\nb: 1", (2, 1, "expected '- ', an item of the list of line 1, or less indentation")),
        (
            "a: 1\n- b",
            (2, 1, "expected 'key: value' of the mapping of line 1, or another indentation"),
        ),
        (
            "a\nb: 1",
            (2, 2, "unexpected ':'; check the indentation, or quote the text that contains it"),
        ),
        ("a: 1\nb\n", (2, 2, "expected ':' after a key")),
        ("%", (1, 2, "invalid YAML: could not find expected directive name")),
        ("a: !x!y 1", (1, 4, "a tag is not allowed")),
    ],
)
def test_complaints_of_the_parser_are_plain_and_located(text, fault):
    """No word of scanners, tokens or flow sequences; a bracket left open is shown itself."""
    (line, column, message), *_ = refused(text)
    assert (line, column, message) == fault


def test_a_number_of_a_million_digits_is_refused_unread():
    """Python would take minutes to read it."""
    ((_, _, message),) = refused("a: " + "9" * 900_000)
    assert message == f"the number '{'9' * 57}...' is too large"


def test_several_faults_are_told_at_once():
    """The reader continues after a mistake that it can skip."""
    assert [line for line, _, _ in refused("a: .nan\na: 1\n3: !t x\n")] == [1, 2, 3, 3]


def test_nesting_is_bounded():
    """Deep nesting is refused at the level that is too deep, aliases followed."""
    assert TOO_DEEP == "nested too deeply; the limit is 200 levels"
    assert refused("[" * 900) == [(1, MAX_DEPTH + 1, TOO_DEEP)]
    # libyaml 0.2.6 refuses this before it gives the first level.
    ((line, _, message),) = refused("[" * 10_000)
    assert (line, message) == (1, TOO_DEEP)
    half = MAX_DEPTH // 2 + 1
    text = f"a: &x {'[' * half}{']' * half}\nb: {'[' * half}*x{']' * half}\n"
    assert refused(text)[0][0] == 2


def test_an_alias_bomb_is_refused_before_it_grows():
    """Ten levels of nine aliases would be 3.5 billion values; sharing them is no excuse."""
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 10)]
    ((line, _, message),) = refused("\n".join(lines))
    assert line == 6
    assert message.startswith(
        f"with aliases expanded, the file exceeds the limit of {MAX_VALUES:,}"
    )


def test_a_text_that_aliases_repeat_counts_by_its_length():
    """Ten characters are a value; once, a text is one value of any length."""
    text = f"a: &a {'x' * 50_000}\nb:\n" + "  - *a\n" * 40
    ((line, _, message),) = refused(text)
    assert line == 22
    assert message.startswith(
        f"with aliases expanded, the file exceeds the limit of {MAX_VALUES:,}"
    )
    data, _ = compose(f"a: {'x' * 900_000}\n", "a.yaml")
    assert len(data["a"]) == 900_000


def test_too_many_values_are_refused_without_aliases_too():
    """A megabyte can hold half a million numbers."""
    ((_, _, message),) = refused("[" + "1," * MAX_VALUES + "1]")
    assert message.startswith(f"the file exceeds the limit of {MAX_VALUES:,} values")


@pytest.mark.parametrize("hidden", "\u200b\u200c\u200d\u202a\u202e\u2066\u2069\u00ad\u3164\ufe0f")
def test_a_quoted_text_keeps_characters_that_cannot_be_seen(hidden):
    """Some scripts and emoji need them; they are escaped wherever the text is shown."""
    text = f"é{hidden}x"
    assert compose(f"a: '{text}'\n\"{text}\": 1", "a.yaml")[0] == {"a": text, text: 1}


@pytest.mark.parametrize("hidden", "\x85\u2028\u2029\u200b\u202e\u3164")
def test_what_is_written_can_be_read(hidden):
    """Writers quote such texts, as keys and as values."""
    data = {"a": f"x{hidden}y", f"b{hidden}": ["c", hidden, f"x{hidden}\ny"]}
    assert compose(to_yaml(data), "a.yaml")[0] == data
