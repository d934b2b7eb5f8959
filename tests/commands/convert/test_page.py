"""docs/how-to/groot.md: its two examples are one mission, and it leaves no element out."""

import re

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.convert.attributes import LABELS
from bt_mission.commands.convert.document import HEAD, document_of
from bt_mission.commands.convert.mission_writer import mission_xml
from bt_mission.commands.convert.table import ELEMENTS, leaf_kinds, rows_of
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.file import GoalLimits
from bt_mission.ros.interface_types import shapes
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load
from tests.support.missions import meaning
from tests.support.project import ROOT

PAGE = ROOT / "docs" / "how-to" / "groot.md"
TEXT = PAGE.read_text(encoding="utf-8")
((YAML,), (XML,)) = (
    re.findall(rf"```{kind}\n(.*?)```", TEXT, re.DOTALL) for kind in ("yaml", "xml")
)

LIMITS = {*GoalLimits.model_fields, "readers"}
"""Modifiers that the page has under "the modifiers of the kind"."""


def test_the_examples_are_one_mission():
    """Sound, without warnings, and converted into each other."""
    here = load(YAML)
    document = document_of(XML, "m.xml")
    there = load(document)
    assert examine(YAML)[1] == ()
    assert meaning(there) == meaning(here)
    converted = load(document_of(mission_xml(read_text(YAML), shapes)))
    assert meaning(converted) == meaning(here)


def test_every_element_and_attribute_is_described():
    """In a table or an example."""
    code = "".join(re.findall(r"`[^`]*`|```.*?```", TEXT, re.DOTALL))
    words = set(re.findall(r"[A-Za-z_0-9:]+", code))
    ours = {kind for kind in leaf_kinds() if kind not in ACTION_NAMES}
    rows = [row for name in (*ELEMENTS, *ours) for row in rows_of(name)]
    attributes = {name for row in rows for name in row.takes if name.islower() and " " not in name}
    assert {*ELEMENTS, *(attributes - LIMITS), *ours, *HEAD, *LABELS.values()} <= words
