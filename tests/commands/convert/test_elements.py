"""XML is read with places, and what is no XML, or dangerous, is refused at its place."""

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.commands.convert.elements import MAX_DEPTH, parse


def fault_of(text):
    """Return the one fault of a text: line, column, message, hint."""
    with pytest.raises(InputError) as caught:
        parse(text, "m.xml")
    (fault,) = caught.value.diagnostics
    return fault.line, fault.column, fault.message, fault.hint


def test_names_and_values_know_their_places():
    """Lines and columns count characters, from 1; a value stands where its quote does."""
    text = (
        "\ufeff<root>\n  <!-- é -->\r\n  é <a one = 'é'\n     two=\"&lt;x>\"/></root>".removeprefix(
            "\ufeff"
        )
    )
    root = parse(text, "m.xml").root
    (child,) = root.children
    assert (root.tag, root.at, root.text) == ("root", (1, 2), "é")
    assert (child.tag, child.at) == ("a", (3, 6))
    first, second = child.attributes.values()
    assert (first.value, first.at, first.value_at) == ("é", (3, 8), (3, 14))
    assert (second.value, second.at, second.value_at) == ("<x>", (4, 6), (4, 10))


def test_a_document_type_is_refused_before_any_entity_is_read():
    """So no entity can explode, and none can read a file."""
    bomb = "<!DOCTYPE a [<!ENTITY x 'ha'><!ENTITY y '&x;&x;&x;'>]>\n<a>&y;</a>"
    _, _, message, hint = fault_of(bomb)
    assert message == "a document type ('a') is not allowed"
    assert hint == "remove '<!DOCTYPE ...>'"


def test_depth_and_size_have_limits():
    """Deep nesting is refused at the first element too many, a large file unread."""
    deep = "<a>" * (MAX_DEPTH + 1) + "</a>" * (MAX_DEPTH + 1)
    assert fault_of(deep)[:3] == (1, 302, "nested too deeply; the limit is 100 levels")
    parse("<a>" * MAX_DEPTH + "</a>" * MAX_DEPTH, "m.xml")
    large = "<a>" + " " * 1_000_000 + "</a>"
    message = "the file is too large: 1,000,007 bytes, the limit is 1,000,000"
    assert fault_of(large) == (0, 0, message, None)


def test_a_long_line_of_many_elements_is_read_in_linear_time():
    """Places in a line that is not ASCII are counted on from the last one."""
    text = "<é>" + "<a b=''/>" * 80_000 + "</é>"
    assert parse(text, "m.xml").root.children[-1].at[1] == 5 + 9 * 79_999
