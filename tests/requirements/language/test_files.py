"""Requirements in files of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.requirements.checks import with_requirements
from bt_mission.sessions.load import convert, load

MISSION = "mission: rest\nrequirements:\n  is slow: always speed < 1\ntree:\n  wait: 1\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "requirements:\n  is slow: always speed < 2\n",
            "'is slow' already exists",
        ),
        ("requirements:\n  a: always sped < 2\n", "unknown signal 'sped'"),
        ('requirements:\n  a: never failed("drive")\n', "unknown node: 'drive'"),
        ("a: always speed < 2\n", "unknown key 'a'"),
        ("- always speed < 2\n", "expected a mapping"),
        ("", "the file is empty"),
    ],
)
def test_a_fault_in_such_a_file_has_its_place(tmp_path: Path, text: str, message: str) -> None:
    """It names that file, not the mission's."""
    file = tmp_path / "extra.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as refused:
        with_requirements(load(MISSION), [file])
    assert any(message in fault.message for fault in refused.value.diagnostics)
    assert {fault.file for fault in refused.value.diagnostics} == {str(file)}


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    """By its name."""
    with pytest.raises(InputError, match=r"nowhere\.yaml"):
        with_requirements(load(MISSION), [tmp_path / "nowhere.yaml"])


REQUIREMENTS = """\
mission: rest
requirements:
  is slow: always speed < 0.3
  stands: {whenever: 'running("wait") or time > 1', then: speed < 0.1, within: 2}
  "<is> & 'quiet'": {formula: never open_goals > 1, on_violation: halt}
tree: {wait: 1}
"""


def test_xml_keeps_requirements(tmp_path: Path) -> None:
    """Each with its name, its formula and what is done; from there to YAML, too."""
    there, back = tmp_path / "rest.xml", tmp_path / "back.yaml"
    file = tmp_path / "rest.yaml"
    file.write_text(REQUIREMENTS)
    there.write_text(convert(file))
    back.write_text(convert(there))
    wanted = load(file).requirements
    for requirements in (there, back):
        assert [(r.name, r.text, r.on_violation) for r in load(requirements).requirements] == [
            (r.name, r.text, r.on_violation) for r in wanted
        ]


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        ('requirement="a" formula="always sped &gt; 1"', "sped"),
        ('requirement="a"', "the attribute 'formula' is missing"),
        ('requirement="a" formula="never collisions &gt; 0" on_violation="shout"', "on_violation"),
        ('requirement="a" formula="never collisions &gt; 0" then="b"', "then"),
    ],
)
def test_requirements_in_xml_are_checked(tmp_path: Path, metadata: str, message: str) -> None:
    """At the place of what is wrong."""
    file = tmp_path / "rest.yaml"
    file.write_text(MISSION)
    text = convert(file)
    xml = tmp_path / "rest.xml"
    old = 'requirement="is slow" formula="always speed &lt; 1"'
    assert old in text
    xml.write_text(text.replace(old, metadata))
    line = text[: text.index(old)].count("\n") + 1
    with pytest.raises(InputError) as refused:
        load(xml)
    (fault,) = refused.value.diagnostics
    assert fault.line == line
    assert message in str(fault)
