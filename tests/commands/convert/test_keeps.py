"""What a mission has is kept in XML: places, units, nodes, requirements, its observation, texts."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml  # type: ignore[import-untyped]

import bt_mission
from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.cli import main
from bt_mission.commands.convert.document import document_of, mission_yaml
from bt_mission.commands.convert.mission_writer import mission_xml
from bt_mission.scenarios.coverage.places import places
from bt_mission.sessions.load import convert, load
from tests.support.hostile import HOSTILE, MARK, escape_nothing, leaks, markup_leaks
from tests.support.hostile_mission import SOUND, yaml_of
from tests.support.project import ROOT

PLACES = (
    "mission: m\nworld: nav_arena\ninputs: {home: zone B, route: [A, dock]}\n"
    "places: {dock: [50 cm, 0, 180 deg], door: {x: 1.0, y: 0.5}}\n"
)
CODE = ROOT / "docs" / "tutorials" / "code"
REQUIREMENTS = """\
mission: rest
requirements:
  is slow: always speed < 0.3
  stands: {whenever: 'running("wait") or time > 1', then: speed < 0.1, within: 2}
  "<is> & 'quiet'": {formula: never open_goals > 1, on_violation: halt}
tree: {wait: 1}
"""


def test_places_come_back_from_xml(tmp_path: Path) -> None:
    """The names in goals stay names."""
    text = f"{PLACES}tree:\n  navigate_to_pose: {{pose: dock}}\n  timeout: 60 s\n"
    xml = mission_xml(read_text(text))
    first, again = load(read_text(text)), load(document_of(xml))
    assert again.places == first.places == {"dock": (0.5, 0, 180), "door": (1, 0.5, 0)}
    goals: list[Any] = [again.tree, first.tree]
    assert goals[0].sent == goals[1].sent
    path = tmp_path / "m.xml"
    path.write_text(xml, encoding="utf-8")
    assert "pose: dock" in mission_yaml(path)


def test_units_come_back_from_xml(tmp_path: Path) -> None:
    """What XML cannot say is a number there; the two missions mean the same."""
    text = (
        "mission: m\ninputs: {angle: 90 deg, gap: 50 cm}\ntree:\n  sequence:\n"
        "    - wait: 500 ms\n    - timeout: 3 s\n      do: {wait: 1}\n"
        "    - turn: {angle: -20 deg}\n      timeout: 20 s\n    - check: gap < 60 cm\n"
    )
    path = tmp_path / "m.xml"
    path.write_text(mission_xml(read_text(text)), encoding="utf-8")
    first: Any = load(text)
    again: Any = load(path)
    assert again.inputs == first.inputs
    wait, timeout, turn, check = first.tree.below
    wait_again, timeout_again, turn_again, check_again = again.tree.below
    assert (wait_again.seconds, timeout_again.seconds) == (wait.seconds, timeout.seconds)
    assert (turn_again.sent, turn_again.timeout) == (turn.sent, turn.timeout)
    assert check_again.condition == check.condition


def test_xml_keeps_them(tmp_path: Path) -> None:
    """In the metadata of the main tree."""
    shutil.copytree(CODE, tmp_path / "code")
    path = tmp_path / "code" / "numbers_in_simulation.yaml"
    xml = path.with_suffix(".xml")
    xml.write_text(convert(path), encoding="utf-8")
    assert load(xml).nodes == load(path).nodes


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


SLOW = "mission: rest\nrequirements:\n  is slow: always speed < 1\ntree:\n  wait: 1\n"


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
    file.write_text(SLOW)
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


def test_the_package_converts(tmp_path: Path) -> None:
    """By its public name."""
    file = tmp_path / "square.yaml"
    file.write_text("mission: square\ntree: {wait: 1}\n")
    back = tmp_path / "square.xml"
    back.write_text(bt_mission.convert(file))
    assert "mission: square" in bt_mission.convert(back)


def test_an_observation_is_kept(tmp_path: Path) -> None:
    """In seconds."""
    file = tmp_path / "it.yaml"
    file.write_text("mission: it\nobserve: 2.5\ntree: {wait: 1}\n")
    (tmp_path / "it.xml").write_text(convert(file))
    assert load(tmp_path / "it.xml").observe == 2.5


def test_no_two_nodes_of_xml_stand_in_one_place() -> None:
    """The place in the file, together with the kind, stands for the node."""
    everything = load(ROOT / "tests/commands/convert/everything.xml")
    keys = [(document.file, place.key) for document, _, place in places(everything)]
    assert len(set(keys)) == len(keys) > 20


@pytest.fixture
def converted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfdbinary: Any) -> Any:
    """Convert the hostile mission, or a text of a name; return the output."""
    monkeypatch.chdir(tmp_path)

    def convert_it(text: str = yaml_of(SOUND), name: str = "m.yaml") -> str:
        Path(name).write_text(text, encoding="utf-8")
        main(["convert", name])
        written = capfdbinary.readouterr()
        return str((written.out + written.err).decode())

    return convert_it


def test_nothing_of_a_hostile_text_is_lost_on_the_way_to_xml_and_back(converted: Any) -> None:
    """It is escaped in both forms, and the XML is well-formed."""
    xml = converted()
    assert leaks(xml) == markup_leaks(xml) == []
    ET.fromstring(xml)  # noqa: S314 - our own
    assert xml.count(MARK) > 5
    back = converted(xml, "m.xml")
    assert leaks(back) == []
    read = yaml.safe_load(back)
    logs = [node["log"] for node in read["tree"]["sequence"] if "log" in node]
    assert logs == [HOSTILE.replace("$", "")]


def test_xml_can_leak(converted: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(converted())
