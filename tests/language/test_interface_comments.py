"""Comments of interface files, split into headings, units and words."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.language.interface_comments import (
    FieldComment,
    NamedValue,
    field_comment,
    read_interface,
)
from tests.support.project import ROOT


@pytest.mark.parametrize(
    ("comment", "unit", "text"),
    [
        ("deg, how far to turn", "deg", "how far to turn"),
        ("m/s, forward speed; above zero", "m/s", "forward speed; above zero"),
        ("minimum range value [m]", "", "minimum range value [m]"),
        ("The speed in meters per second", "", "The speed in meters per second"),
        ("m and quaternion, where to go", "", "m and quaternion, where to go"),
        ("s and ns, after which it gives up", "", "s and ns, after which it gives up"),
        ("number of images", "", "number of images"),
        ("a name", "", "a name"),
        ("", "", ""),
    ],
)
def test_a_unit_begins_a_comment(comment: str, unit: str, text: str) -> None:
    """With a comma behind it; other comments have none."""
    assert field_comment(comment) == FieldComment(unit, text)


def test_headings_do_not_belong_to_the_first_field() -> None:
    """A comment behind a field is about it; else the one above, and indented ones below."""
    interface = read_interface(
        "# Turn on the spot,\n# by an angle.\n\n# Goal\nfloat32 angle  # deg, how far\n"
        "# which way\nint8 way 3\n"
        "float32 speed      # how fast,\n                   # at most\n"
        "---\n# about nothing\n\nstring said\nstring mark='#'  # a sign\n"
    )
    assert interface.text == "Turn on the spot, by an angle."
    goal, result = interface.sections
    assert goal.remarks == {
        "angle": FieldComment("deg", "how far"),
        "way": FieldComment("", "which way"),
        "speed": FieldComment("", "how fast, at most"),
    }
    assert result.remarks == {"said": FieldComment()}
    assert result.constants == [NamedValue("string", "mark", "'#'", "a sign")]
    assert interface.section(7).remarks == {}


def test_a_code_is_named_where_only_one_constant_can_be_meant() -> None:
    """Of the field's own type and value, and only for fields that hold codes."""
    (section,) = read_interface(
        "uint16 NONE=0\nuint16 BLOCKED = 906 # in the way\nuint8 SMALL=0\n"
        "uint16 error_code\nuint16 ticks\nuint8 error_code_8\n"
    ).sections
    assert section.name_of("error_code", 906) == "BLOCKED"
    assert section.name_of("error_code", 0) == "NONE"
    assert section.name_of("error_code", 5) == ""
    assert section.name_of("ticks", 0) == ""


COPIES = ("control_msgs",)
"""Packages whose definitions stand here word by word as they are published."""


@pytest.mark.parametrize(
    "path",
    sorted(
        path
        for path in ROOT.glob("interfaces/*/action/*.action")
        if path.parent.parent.name not in COPIES
    ),
)
def test_every_field_of_our_actions_has_a_remark(path: Path) -> None:
    """What is not read, nobody is shown."""
    interface = read_interface(path.read_text(encoding="utf-8"))
    assert interface.text
    assert len(interface.sections) == 3
    for section in interface.sections:
        assert section.remarks.keys() == section.types.keys()
        assert all(remark.text for remark in section.remarks.values())


@pytest.mark.parametrize("text", ["", "---", "\x00\x1b[31m#", "garbage", "int8", "int8 a b c\n# x"])
def test_no_text_is_too_odd(text: str) -> None:
    """What cannot be read is left out."""
    read_interface(text)


def test_a_title_says_nothing() -> None:
    """Many files begin with one."""
    interface = read_interface("#goal definition\nint32 order\n---\n#result definition\nint32 x\n")
    assert interface.text == ""
    assert interface.sections[0].remarks == {"order": FieldComment()}
